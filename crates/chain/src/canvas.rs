//! Draws smooth lines and dots on a picture.
//!
//! A pixel's coverage is the depth of its center inside the shape, clamped to one pixel. This takes
//! one distance per pixel and no supersampling. Shapes are combined before they are inked, so a
//! translucent line is not darker at its joints.

use image::{Rgb, RgbImage};

/// A picture to draw on. Pixel centers have integer coordinates, as everywhere in lariat.
#[derive(Debug)]
pub struct Canvas {
    /// The picture with everything that has been inked.
    pub picture: RgbImage,
    /// Strokes that the next call of [`ink`](Self::ink) draws.
    shape: Vec<Stroke>,
}

/// All points within `radius` of a segment.
#[derive(Debug, Clone, Copy)]
struct Stroke {
    ends: [[f64; 2]; 2],
    radius: f64,
}

/// A rectangle of pixels. `right` and `bottom` are exclusive.
#[derive(Clone, Copy)]
struct Area {
    left: usize,
    top: usize,
    right: usize,
    bottom: usize,
}

impl Canvas {
    /// Creates a canvas that shows the picture.
    pub fn on(picture: RgbImage) -> Self {
        Self {
            picture,
            shape: Vec::new(),
        }
    }

    /// Adds a line through `path`, `width_px` wide, with round ends and joints.
    pub fn line(&mut self, path: &[[f64; 2]], width_px: f64) -> &mut Self {
        let radius = 0.5 * width_px;
        let pairs = path.windows(2);
        self.shape.extend(pairs.map(|pair| Stroke {
            ends: [pair[0], pair[1]],
            radius,
        }));
        self
    }

    /// Adds a dot at each of `centers`.
    pub fn dots(&mut self, centers: &[[f64; 2]], diameter_px: f64) -> &mut Self {
        let radius = 0.5 * diameter_px;
        self.shape.extend(centers.iter().map(|&center| Stroke {
            ends: [center; 2],
            radius,
        }));
        self
    }

    /// Adds an arrowhead at the end of a line.
    pub fn head(&mut self, line: &[[f64; 2]], size_px: f64, width_px: f64) {
        let [.., before, tip] = line else {
            return;
        };
        let along = [tip[0] - before[0], tip[1] - before[1]];
        let length = along[0].hypot(along[1]);
        if length <= 0.0 {
            return;
        }
        let [x, y] = along.map(|c| c / length * size_px);
        for side in [-0.6, 0.6] {
            let barb = [tip[0] - x + side * y, tip[1] - y - side * x];
            self.line(&[*tip, barb], width_px);
        }
    }

    /// Inks all shapes added since the last call. `opacity` runs from 0 (invisible) to 1.
    pub fn ink(&mut self, rgb: [u8; 3], opacity: f64) {
        let strokes = std::mem::take(&mut self.shape);
        let Some(whole) = self.around(&strokes) else {
            return;
        };
        let stride = whole.right - whole.left;
        let mut coverage = vec![0u8; stride * (whole.bottom - whole.top)];
        for stroke in &strokes {
            let Some(area) = self.around(std::slice::from_ref(stroke)) else {
                continue;
            };
            for y in area.top..area.bottom {
                let row = &mut coverage[(y - whole.top) * stride..][..stride];
                for x in area.left..area.right {
                    let distance = distance_to(stroke.ends, [x as f64, y as f64]);
                    let covered = (stroke.radius + 0.5 - distance).clamp(0.0, 1.0);
                    let pixel = &mut row[x - whole.left];
                    *pixel = (*pixel).max((255.0 * covered) as u8);
                }
            }
        }
        for (index, &covered) in coverage.iter().enumerate() {
            if covered > 0 {
                let (x, y) = (whole.left + index % stride, whole.top + index / stride);
                let share = opacity * f64::from(covered) / 255.0;
                let Rgb(pixel) = self.picture.get_pixel_mut(x as u32, y as u32);
                for (under, over) in pixel.iter_mut().zip(rgb) {
                    let blended = f64::from(*under) * (1.0 - share) + f64::from(over) * share;
                    *under = blended.round() as u8;
                }
            }
        }
    }

    /// Returns the pixels that the strokes could cover, if any.
    fn around(&self, strokes: &[Stroke]) -> Option<Area> {
        let size = [self.picture.width(), self.picture.height()];
        let mut bounds = [[0usize; 2]; 2];
        for axis in 0..2 {
            let ends = || {
                strokes
                    .iter()
                    .flat_map(|stroke| stroke.ends.map(|end| (end[axis], stroke.radius)))
            };
            let low = ends()
                .map(|(at, radius)| at - radius)
                .fold(f64::INFINITY, f64::min)
                - 1.0;
            let high = ends()
                .map(|(at, radius)| at + radius)
                .fold(f64::NEG_INFINITY, f64::max)
                + 2.0;
            // A cast from float saturates, so a point far outside is clamped to the border.
            bounds[axis] = [
                low.max(0.0) as usize,
                (high.max(0.0) as usize).min(size[axis] as usize),
            ];
            if bounds[axis][0] >= bounds[axis][1] {
                return None;
            }
        }
        Some(Area {
            left: bounds[0][0],
            right: bounds[0][1],
            top: bounds[1][0],
            bottom: bounds[1][1],
        })
    }
}

/// Returns the distance of `p` from the segment.
fn distance_to([a, b]: [[f64; 2]; 2], p: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let from_a = [p[0] - a[0], p[1] - a[1]];
    let length2 = along[0] * along[0] + along[1] * along[1];
    let share = if length2 > 0.0 {
        ((from_a[0] * along[0] + from_a[1] * along[1]) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (from_a[0] - share * along[0]).hypot(from_a[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: [u8; 3] = [255, 0, 0];

    fn black(width: u32, height: u32) -> Canvas {
        Canvas::on(RgbImage::new(width, height))
    }

    fn redness(canvas: &Canvas, x: u32, y: u32) -> u8 {
        canvas.picture.get_pixel(x, y).0[0]
    }

    #[test]
    fn a_line_three_wide_covers_three_rows_and_fades_at_half_pixels() {
        let mut canvas = black(20, 9);
        canvas.line(&[[2.0, 4.0], [17.0, 4.0]], 3.0).ink(RED, 1.0);
        assert_eq!(
            [2, 3, 4, 5, 6].map(|y| redness(&canvas, 10, y)),
            [0, 255, 255, 255, 0]
        );
        let mut canvas = black(20, 9);
        canvas.line(&[[2.0, 4.5], [17.0, 4.5]], 2.0).ink(RED, 1.0);
        assert_eq!(
            [3, 4, 5, 6].map(|y| redness(&canvas, 10, y)),
            [0, 255, 255, 0]
        );
        let mut canvas = black(20, 9);
        canvas.line(&[[2.0, 4.0], [17.0, 4.0]], 2.0).ink(RED, 1.0);
        assert_eq!(
            [2, 3, 4, 5, 6].map(|y| redness(&canvas, 10, y)),
            [0, 127, 255, 127, 0]
        );
    }

    #[test]
    fn a_translucent_line_is_not_darker_where_it_meets_itself() {
        let mut canvas = black(20, 20);
        canvas.line(&[[2.0, 10.0], [17.0, 10.0], [10.0, 2.0], [10.0, 18.0]], 3.0);
        canvas.ink(RED, 0.5);
        assert_eq!(redness(&canvas, 10, 10), redness(&canvas, 4, 10));
    }

    #[test]
    fn what_lies_outside_is_cut_off() {
        let mut canvas = black(4, 4);
        canvas
            .line(&[[-1e12, -1e12], [1e12, 1e12]], 1.0)
            .ink(RED, 1.0);
        canvas
            .dots(&[[-50.0, 2.0], [f64::NAN, 1.0], [1e300, 1.0]], 3.0)
            .ink(RED, 1.0);
        canvas.line(&[], 3.0).ink(RED, 1.0);
        assert_eq!(redness(&canvas, 2, 2), 255);
        assert_eq!(redness(&canvas, 0, 3), 0);
    }

    #[test]
    fn what_was_inked_is_not_inked_again() {
        let mut canvas = black(20, 9);
        canvas.line(&[[2.0, 4.0], [17.0, 4.0]], 3.0).ink(RED, 1.0);
        let before = canvas.picture.clone();
        canvas.ink([9; 3], 1.0);
        assert_eq!(canvas.picture, before);
    }
}

//! Drawing on a small picture, with smooth edges.

/// A picture that is drawn upon: shapes first [cover](Canvas::line) pixels, and are [inked](Canvas::ink) together, so
/// that those of one color do not show where they meet.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Canvas {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<[u8; 3]>,
    /// How much of each pixel is covered, 0 to 1; empty before the first shape.
    covered: Vec<f32>,
}

impl Canvas {
    pub(super) fn new(width: usize, height: usize, color: [u8; 3]) -> Self {
        Self {
            width,
            height,
            pixels: vec![color; width * height],
            covered: Vec::new(),
        }
    }

    /// Of an image of red, green and blue: squares of `scale` pixels become the mean of theirs.
    pub(super) fn averaged(rgb: &[u8], [width, height]: [usize; 2], scale: usize) -> Self {
        let mut canvas = Self::new(width / scale, height / scale, [0; 3]);
        let area = (scale * scale) as u32;
        for (i, pixel) in canvas.pixels.iter_mut().enumerate() {
            let (x, y) = (i % canvas.width * scale, i / canvas.width * scale);
            let mut sums = [area / 2; 3];
            for row in y..y + scale {
                let from = 3 * (row * width + x);
                for rgb in rgb[from..from + 3 * scale].chunks_exact(3) {
                    (0..3).for_each(|k| sums[k] += u32::from(rgb[k]));
                }
            }
            *pixel = sums.map(|sum| (sum / area) as u8);
        }
        canvas
    }

    /// Covers what is within half a width of a line.
    pub(super) fn line(&mut self, points: &[[f64; 2]], width_px: f64) {
        for ends in points.windows(2) {
            self.cover(ends[0], ends[1], width_px / 2.0);
        }
    }

    /// Covers a disc.
    pub(super) fn dot(&mut self, at: [f64; 2], radius_px: f64) {
        self.cover(at, at, radius_px);
    }

    /// Covers the head of an arrow at a line's end.
    pub(super) fn head(&mut self, line: &[[f64; 2]], size_px: f64, width_px: f64) {
        let [.., before, tip] = line else {
            return;
        };
        let along = [tip[0] - before[0], tip[1] - before[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        if length <= 0.0 {
            return;
        }
        let [x, y] = along.map(|c| c / length * size_px);
        for side in [-0.6, 0.6] {
            let barb = [tip[0] - x + side * y, tip[1] - y - side * x];
            self.cover(*tip, barb, width_px / 2.0);
        }
    }

    /// Covers what is within a radius of a segment; a pixel on the edge in part.
    fn cover(&mut self, a: [f64; 2], b: [f64; 2], radius_px: f64) {
        if a.iter().chain(&b).any(|c| !c.is_finite()) {
            return;
        }
        self.covered.resize(self.pixels.len(), 0.0);
        let span = |k: usize, end: usize| {
            let low = (a[k].min(b[k]) - radius_px - 1.0).ceil().max(0.0);
            let high = (a[k].max(b[k]) + radius_px + 1.0).floor() + 1.0;
            low as usize..(high.max(0.0) as usize).min(end)
        };
        for y in span(1, self.height) {
            for x in span(0, self.width) {
                let away = from_segment([x as f64, y as f64], a, b);
                let share = (radius_px + 0.5 - away).clamp(0.0, 1.0) as f32;
                let covered = &mut self.covered[y * self.width + x];
                *covered = covered.max(share);
            }
        }
    }

    /// Paints what is covered, and uncovers it.
    pub(super) fn ink(&mut self, color: [u8; 3]) {
        for (pixel, covered) in self.pixels.iter_mut().zip(&mut self.covered) {
            let share = std::mem::take(covered);
            if share > 0.0 {
                *pixel = [0, 1, 2].map(|k| {
                    let (old, new) = (f32::from(pixel[k]), f32::from(color[k]));
                    (old + share * (new - old)).round() as u8
                });
            }
        }
    }
}

fn from_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (along, from) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length2 = along[0] * along[0] + along[1] * along[1];
    let share = if length2 > 0.0 {
        ((from[0] * along[0] + from[1] * along[1]) / length2).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let [x, y] = [0, 1].map(|k| from[k] - share * along[k]);
    (x * x + y * y).sqrt()
}

/// A line in pieces: so long each, and so far apart.
pub(super) fn dashes(line: &[[f64; 2]], [on_px, off_px]: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut all = Vec::new();
    let mut dash: Vec<[f64; 2]> = line.first().copied().into_iter().collect();
    let (mut is_on, mut left) = (true, on_px);
    for ends in line.windows(2) {
        let (a, b) = (ends[0], ends[1]);
        let length = ((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)).sqrt();
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let p = [0, 1].map(|k| a[k] + done / length * (b[k] - a[k]));
            if is_on {
                dash.push(p);
                all.push(std::mem::take(&mut dash));
            } else {
                dash = vec![p];
            }
            is_on = !is_on;
            left = if is_on { on_px } else { off_px };
        }
        left -= length - done;
        if is_on {
            dash.push(b);
        }
    }
    if dash.len() > 1 {
        all.push(dash);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_covers_as_much_as_it_is_wide() {
        let mut canvas = Canvas::new(40, 20, [0; 3]);
        canvas.line(&[[-10.0, 9.3], [60.0, 9.3]], 3.0);
        canvas.ink([200, 100, 0]);
        let column: u32 = (0..20)
            .map(|y| u32::from(canvas.pixels[y * 40 + 7][0]))
            .sum();
        assert!(column.abs_diff(600) < 3, "{column}");
        // Nothing is left that the next ink would show.
        let before = canvas.clone();
        canvas.ink([9; 3]);
        assert_eq!(canvas, before);
    }

    #[test]
    fn dashes_are_as_long_as_they_should_be() {
        let line = [[0.0, 0.0], [7.0, 0.0], [7.0, 20.0]];
        let pieces = dashes(&line, [6.0, 4.0]);
        assert_eq!(pieces[0], [[0.0, 0.0], [6.0, 0.0]]);
        assert_eq!(pieces[1], [[7.0, 3.0], [7.0, 9.0]]);
        assert_eq!(pieces.len(), 3);
        assert_eq!(pieces[2], [[7.0, 13.0], [7.0, 19.0]]);
        assert!(dashes(&[], [6.0, 4.0]).is_empty());
    }

    #[test]
    fn what_is_no_place_is_not_drawn() {
        let mut canvas = Canvas::new(8, 8, [7; 3]);
        let before = canvas.clone();
        canvas.line(&[[f64::NAN, 1.0], [3.0, f64::INFINITY]], 2.0);
        canvas.line(&[[-1e300, -1e300], [-1e299, -1e299]], 2.0);
        canvas.ink([0; 3]);
        assert_eq!(canvas.pixels, before.pixels);
    }
}

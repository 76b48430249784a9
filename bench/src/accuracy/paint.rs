//! Discs and lines on a picture, twice as large as the photograph, so that half a pixel shows.

use image::{Rgb, RgbImage, imageops};

/// Pixels of the canvas for one of the photograph, along each side.
pub(super) const SCALE: u32 = 2;

/// A photograph to draw on. Positions are the photograph's: pixel centres are whole numbers.
pub(super) struct Canvas {
    pub(super) picture: RgbImage,
}

impl Canvas {
    /// The photograph, enlarged and darkened to `share` of its light.
    pub(super) fn darkened(photo: &RgbImage, share: f32) -> Self {
        let (width, height) = (SCALE * photo.width(), SCALE * photo.height());
        let mut picture = imageops::resize(photo, width, height, imageops::FilterType::Nearest);
        for value in picture.iter_mut() {
            *value = (f32::from(*value) * share) as u8;
        }
        Self { picture }
    }

    /// Fills what is within `radius_px` of `at`, in the canvas's pixels; a pixel at least.
    pub(super) fn disc(&mut self, at: [f64; 2], radius_px: f64, color: [u8; 3]) {
        // The photograph's pixel (0, 0) covers the canvas's pixels 0 to SCALE - 1.
        let scale = f64::from(SCALE);
        let [x, y] = at.map(|v| (v + 0.5) * scale - 0.5);
        let around = |v: f64| (v - radius_px).round() as i64..=(v + radius_px).round() as i64;
        for py in around(y) {
            for px in around(x) {
                let off = (px as f64 - x).hypot(py as f64 - y);
                let inside = (0..i64::from(self.picture.width())).contains(&px)
                    && (0..i64::from(self.picture.height())).contains(&py);
                if inside && off <= radius_px.max(0.71) {
                    self.picture.put_pixel(px as u32, py as u32, Rgb(color));
                }
            }
        }
    }

    /// A line from `from` to `to`, twice `radius_px` wide.
    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], radius_px: f64, color: [u8; 3]) {
        let along = [to[0] - from[0], to[1] - from[1]];
        let steps = (2.0 * f64::from(SCALE) * along[0].hypot(along[1]))
            .ceil()
            .max(1.0);
        for step in 0..=steps as usize {
            let share = step as f64 / steps;
            self.disc([0, 1].map(|i| from[i] + share * along[i]), radius_px, color);
        }
    }
}

/// Red, yellow, green, blue, violet: along a rope from its first tip (0) to its last (1).
pub(super) fn hue(rho: f64) -> [u8; 3] {
    let sixth = 5.0 * rho.clamp(0.0, 1.0);
    [5.0, 3.0, 1.0].map(|offset| {
        let k = (offset + sixth) % 6.0;
        (255.0 * (1.0 - k.min(4.0 - k).clamp(0.0, 1.0))) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_of_the_photograph_is_drawn_where_it_is() {
        let mut canvas = Canvas::darkened(&RgbImage::from_pixel(8, 6, Rgb([200; 3])), 0.5);
        assert_eq!(canvas.picture.get_pixel(15, 11).0, [100; 3]);
        canvas.disc([3.0, 2.0], 0.71, [255, 0, 0]);
        for (x, y, pixel) in canvas.picture.enumerate_pixels() {
            let is_red = x / SCALE == 3 && y / SCALE == 2;
            assert_eq!(pixel.0[1] == 0, is_red, "{x} {y}");
        }
        canvas.line([-50.0, 2.0], [50.0, 2.0], 1.0, [0; 3]);
    }

    #[test]
    fn the_colours_run_from_red_to_violet() {
        assert_eq!(hue(0.0), [255, 0, 0]);
        assert_eq!(hue(0.4), [0, 255, 0]);
        assert_eq!(hue(0.8), [0, 0, 255]);
        assert_eq!(hue(1.0), [255, 0, 255]);
    }
}

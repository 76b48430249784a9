//! An enlarged picture to draw on, so that half a pixel is visible.

use image::{RgbImage, imageops};
use lariat_chain::canvas::Canvas;

/// An enlarged picture. Positions are in pixels of the original picture, with pixel centers at
/// integers. Widths are in pixels of the canvas.
#[derive(Debug)]
pub(crate) struct Enlarged {
    pub(crate) canvas: Canvas,
    zoom: u32,
}

impl Enlarged {
    /// Enlarges the picture by `zoom`.
    pub(crate) fn new(picture: &RgbImage, zoom: u32) -> Self {
        let [width, height] = [picture.width(), picture.height()].map(|side| zoom * side);
        let nearest = imageops::FilterType::Nearest;
        let canvas = Canvas::on(imageops::resize(picture, width, height, nearest));
        Self { canvas, zoom }
    }

    /// Scales every pixel's brightness by `share`.
    pub(crate) fn darken(&mut self, share: f32) {
        for value in self.canvas.picture.iter_mut() {
            *value = (f32::from(*value) * share) as u8;
        }
    }

    /// Draws a line.
    pub(crate) fn line(&mut self, path: &[[f64; 2]], width_px: f64, color: [u8; 3]) {
        let path = self.places(path);
        self.canvas.line(&path, width_px).ink(color, 1.0);
    }

    /// Draws a dot at each position.
    pub(crate) fn dots(&mut self, centers: &[[f64; 2]], diameter_px: f64, color: [u8; 3]) {
        let centers = self.places(centers);
        self.canvas.dots(&centers, diameter_px).ink(color, 1.0);
    }

    /// Maps positions to the canvas. The picture's pixel (0, 0) covers the canvas's pixels 0 to
    /// `zoom` - 1 along each side.
    fn places(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let zoom = f64::from(self.zoom);
        let place = |at: &[f64; 2]| at.map(|v| (v + 0.5) * zoom - 0.5);
        points.iter().map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn a_pixel_of_the_picture_is_drawn_where_it_is() {
        let mut enlarged = Enlarged::new(&RgbImage::from_pixel(8, 6, Rgb([200; 3])), 2);
        enlarged.darken(0.5);
        assert_eq!(enlarged.canvas.picture.get_pixel(15, 11).0, [100; 3]);
        enlarged.dots(&[[3.0, 2.0]], 2.0, [255, 0, 0]);
        for (x, y, pixel) in enlarged.canvas.picture.enumerate_pixels() {
            let is_drawn = pixel.0 != [100; 3];
            assert_eq!(is_drawn, x / 2 == 3 && y / 2 == 2, "{x} {y}");
        }
    }
}

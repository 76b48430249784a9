//! The pixels of a mask, as runs along the rows and as two lists of coordinates.

use crate::image::{Image, PixelFormat};
use crate::mask::MaskError;

/// Pixels of one row, side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Which row.
    pub y: u16,
    /// The first pixel.
    pub from: u16,
    /// Behind the last pixel.
    pub to: u16,
}

/// The pixels of a mask in the order of rows; (0, 0) is the middle of the top left one.
#[derive(Clone, Debug, Default)]
pub struct Pixels {
    runs: Vec<Run>,
    xs: Vec<f32>,
    ys: Vec<f32>,
}

impl Pixels {
    /// The pixels of `mask`, `Gray8`, that are 128 or more.
    ///
    /// # Errors
    /// When the mask has another format.
    pub fn of_mask(mask: &Image) -> Result<Self, MaskError> {
        if mask.format() != PixelFormat::Gray8 {
            return Err(MaskError::Format(mask.format()));
        }
        let mut pixels = Self::default();
        for y in 0..mask.height() {
            let row = &mask.row(y)[..mask.width()];
            let mut x = 0;
            while let Some(skip) = row[x..].iter().position(|&value| value >= 128) {
                let from = x + skip;
                let length = row[from..]
                    .iter()
                    .take_while(|&&value| value >= 128)
                    .count();
                x = from + length;
                // An image has at most 16,384 pixels a side.
                pixels.push(Run {
                    y: y as u16,
                    from: from as u16,
                    to: x as u16,
                });
            }
        }
        Ok(pixels)
    }

    /// Forgets all pixels, keeping the memory.
    pub fn clear(&mut self) {
        self.runs.clear();
        self.xs.clear();
        self.ys.clear();
    }

    /// Adds a run that lies behind all others, in the order of rows.
    pub fn push(&mut self, run: Run) {
        let many = usize::from(run.to - run.from);
        self.runs.push(run);
        self.xs.extend((run.from..run.to).map(f32::from));
        self.ys.resize(self.ys.len() + many, f32::from(run.y));
    }

    /// The runs, in the order of rows.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Each pixel's column.
    pub fn xs(&self) -> &[f32] {
        &self.xs
    }

    /// Each pixel's row.
    pub fn ys(&self) -> &[f32] {
        &self.ys
    }

    /// How many pixels there are.
    pub fn len(&self) -> usize {
        self.xs.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.xs.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixels_of_a_mask_are_its_runs_row_by_row() {
        let bytes = [0, 200, 255, 0, 128, 127, 0, 0, 0, 0, 255, 255];
        let mask = Image::new(&bytes, 6, 2, 6, PixelFormat::Gray8).expect("an image of 6 × 2");
        let pixels = Pixels::of_mask(&mask).expect("a gray mask");
        let run = |y, from, to| Run { y, from, to };
        assert_eq!(pixels.runs(), [run(0, 1, 3), run(0, 4, 5), run(1, 4, 6)]);
        assert_eq!(pixels.xs(), [1.0, 2.0, 4.0, 4.0, 5.0]);
        assert_eq!(pixels.ys(), [0.0, 0.0, 0.0, 1.0, 1.0]);
    }

    #[test]
    fn a_mask_of_colors_is_refused() {
        let mask = Image::new(&[0; 6], 2, 1, 6, PixelFormat::Rgb8).expect("an image of 2 × 1");
        assert!(Pixels::of_mask(&mask).is_err());
    }
}

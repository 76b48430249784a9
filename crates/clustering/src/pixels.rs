//! The pixels of a mask, as runs along the rows and as two lists of coordinates.

/// Adjacent pixels of one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The row.
    pub y: u16,
    /// The first pixel.
    pub from: u16,
    /// The column after the last pixel.
    pub to: u16,
}

/// The pixels of a mask in row order. The middle of the top left pixel is (0, 0).
#[derive(Clone, Debug, Default)]
pub struct Pixels {
    runs: Vec<Run>,
    xs: Vec<f32>,
    ys: Vec<f32>,
}

impl Pixels {
    /// Collects the pixels with a value of at least 128 from a mask's rows, one byte per pixel.
    /// Sides are at most 65,535 pixels long.
    pub fn of_rows<'a>(rows: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut pixels = Self::default();
        for (y, row) in rows.into_iter().enumerate() {
            let mut x = 0;
            while let Some(skip) = row[x..].iter().position(|&value| value >= 128) {
                let from = x + skip;
                let length = row[from..]
                    .iter()
                    .take_while(|&&value| value >= 128)
                    .count();
                x = from + length;
                pixels.push(Run {
                    y: y as u16,
                    from: from as u16,
                    to: x as u16,
                });
            }
        }
        pixels
    }

    /// Removes all pixels but keeps the memory.
    pub fn clear(&mut self) {
        self.runs.clear();
        self.xs.clear();
        self.ys.clear();
    }

    /// Appends a run, which must come after all others in row order.
    pub fn push(&mut self, run: Run) {
        let many = usize::from(run.to - run.from);
        self.runs.push(run);
        self.xs.extend((run.from..run.to).map(f32::from));
        self.ys.resize(self.ys.len() + many, f32::from(run.y));
    }

    /// The runs in row order.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Column of each pixel.
    pub fn xs(&self) -> &[f32] {
        &self.xs
    }

    /// Row of each pixel.
    pub fn ys(&self) -> &[f32] {
        &self.ys
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.xs.len()
    }

    /// Returns whether there are no pixels.
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
        let pixels = Pixels::of_rows(bytes.chunks(6));
        let run = |y, from, to| Run { y, from, to };
        assert_eq!(pixels.runs(), [run(0, 1, 3), run(0, 4, 5), run(1, 4, 6)]);
        assert_eq!(pixels.xs(), [1.0, 2.0, 4.0, 4.0, 5.0]);
        assert_eq!(pixels.ys(), [0.0, 0.0, 0.0, 1.0, 1.0]);
    }
}

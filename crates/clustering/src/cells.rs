//! The cells of centers in a mask: for each center, the pixels nearest to it.

use lariat_portable::{Arch, Simd, WithSimd};

use super::Pixels;
use super::blocks::Blocks;
use super::nearest::Nearest;

/// Adjacent pixels of one row with the same nearest center.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// The row.
    pub y: u16,
    /// The first pixel.
    pub from: u16,
    /// The column after the last pixel.
    pub to: u16,
    /// Index of the center.
    pub center: u16,
}

/// The memory of an assignment, and its result.
#[derive(Debug, Default)]
pub struct Cells {
    blocks: Blocks,
    nearest: Nearest,
    /// Parts of each piece that belong to one center, block by block: the end column, and the
    /// center.
    parts: Vec<(u16, u16)>,
    /// First and last (exclusive) part of each piece.
    of_piece: Vec<[u32; 2]>,
    cells: Vec<Cell>,
}

impl Cells {
    /// Finds the cells of `centers`, which must be finite and at most 65,536. Without centers there
    /// are no cells.
    pub fn assign(&mut self, pixels: &Pixels, centers: &[[f32; 2]]) {
        self.cells.clear();
        if centers.is_empty() {
            return;
        }
        self.blocks.take(pixels);
        self.nearest.take(centers);
        Arch::new().dispatch(Listing(self));
        self.gather(pixels);
    }

    /// The cells' runs in row order. Together they cover the runs of the mask.
    pub fn runs(&self) -> &[Cell] {
        &self.cells
    }

    /// Sorts the parts of all pieces into the order of runs.
    fn gather(&mut self, pixels: &Pixels) {
        let mut pieces = self.of_piece.iter();
        for run in pixels.runs() {
            let mut from = run.from;
            while from < run.to {
                // The pieces cover the runs, so there is one for each pixel.
                let Some(&[first, end]) = pieces.next() else {
                    return;
                };
                let begins_run = from == run.from;
                for (i, &(to, center)) in
                    self.parts[first as usize..end as usize].iter().enumerate()
                {
                    match self.cells.last_mut() {
                        Some(last) if i == 0 && !begins_run && last.center == center => {
                            last.to = to
                        }
                        _ => self.cells.push(Cell {
                            y: run.y,
                            from,
                            to,
                            center,
                        }),
                    }
                    from = to;
                }
            }
        }
    }
}

/// Lists the parts of all pieces.
struct Listing<'a>(&'a mut Cells);

impl WithSimd for Listing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Cells {
            blocks,
            nearest,
            parts,
            of_piece,
            ..
        } = self.0;
        parts.clear();
        of_piece.clear();
        of_piece.resize(blocks.pieces as usize, [0; 2]);
        for block in &blocks.blocks {
            let count = nearest.cut(simd, block);
            for lane in 0..block.count {
                let first = parts.len();
                let mut from = block.from[lane];
                // If three centers are equidistant, rounding may assign a pixel to none of them.
                let mut rank = nearest.near.first().map_or(0, |near| near.rank);
                for (i, near) in nearest.near[..count].iter().enumerate() {
                    let (begin, end) = (nearest.begins[i][lane], nearest.ends[i][lane]);
                    if begin < end {
                        rank = near.rank;
                        parts.push((end as u16, nearest.order[rank as usize] as u16));
                        from = end;
                    }
                }
                if from < block.to[lane] {
                    let center = nearest.order[rank as usize] as u16;
                    parts.push((block.to[lane] as u16, center));
                }
                of_piece[block.pieces[lane] as usize] = [first as u32, parts.len() as u32];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Run;
    use proptest::prelude::*;

    /// Creates runs from pairs of a gap and a length.
    fn pixels(rows: &[Vec<(u16, u16)>]) -> Pixels {
        let mut pixels = Pixels::default();
        for (y, row) in rows.iter().enumerate() {
            let mut x = 0;
            for (gap, length) in row {
                let (from, to) = (x + gap, x + gap + length);
                pixels.push(Run {
                    y: 3 * y as u16,
                    from,
                    to,
                });
                x = to;
            }
        }
        pixels
    }

    /// Compares the cells with the distances of every pixel from every center.
    fn check(pixels: &Pixels, centers: &[[f32; 2]]) -> Result<(), TestCaseError> {
        let mut cells = Cells::default();
        cells.assign(pixels, centers);
        let mut places = pixels.xs().iter().zip(pixels.ys());
        for cell in cells.runs() {
            prop_assert!(cell.from < cell.to);
            for x in cell.from..cell.to {
                prop_assert_eq!(places.next(), Some((&f32::from(x), &f32::from(cell.y))));
                let off = |c: &[f32; 2]| {
                    let off = [
                        f64::from(c[0]) - f64::from(x),
                        f64::from(c[1]) - f64::from(cell.y),
                    ];
                    off[0].hypot(off[1])
                };
                let least = centers.iter().map(off).fold(f64::INFINITY, f64::min);
                let found = off(&centers[usize::from(cell.center)]);
                // The columns where cells end are accurate to 1e-4 pixels.
                prop_assert!(
                    found <= least + 2e-4,
                    "({}, {}): {} {}",
                    x,
                    cell.y,
                    found,
                    least
                );
            }
        }
        prop_assert_eq!(places.next(), None);
        let pairs = cells.runs().windows(2);
        for (a, b) in pairs.map(|pair| (pair[0], pair[1])) {
            // Adjacent cells of one run have different centers.
            if a.y == b.y && a.to == b.from && a.center == b.center {
                let apart = pixels
                    .runs()
                    .iter()
                    .any(|run| run.y == b.y && run.from == b.from);
                prop_assert!(apart);
            }
        }
        Ok(())
    }

    fn rows() -> impl Strategy<Value = Vec<Vec<(u16, u16)>>> {
        let run = (0u16..90, prop_oneof![1u16..20, 1u16..200]);
        proptest::collection::vec(proptest::collection::vec(run, 0..4), 0..40)
    }

    proptest! {
        #[test]
        fn every_pixel_is_in_the_cell_of_its_nearest_center(
            rows in rows(),
            centers in proptest::collection::vec([-20f32..500.0, -20f32..140.0], 1..140),
        ) {
            check(&pixels(&rows), &centers)?;
        }

        #[test]
        fn nor_do_centers_in_rows_and_columns_or_on_one_place_leave_a_pixel_out(
            rows in rows(),
            centers in proptest::collection::vec([0u8..60, 0u8..12], 1..80),
        ) {
            let centers: Vec<_> = centers.iter().map(|c| c.map(|c| 8.0 * f32::from(c))).collect();
            check(&pixels(&rows), &centers)?;
        }
    }

    #[test]
    fn of_centers_on_one_place_the_first_has_all() {
        let pixels = pixels(&[vec![(3, 100)]]);
        let mut cells = Cells::default();
        cells.assign(&pixels, &[[50.0, 0.0], [20.0, 9.0], [20.0, 9.0]]);
        let centers: Vec<_> = cells.runs().iter().map(|cell| cell.center).collect();
        assert_eq!(centers, [1, 0]);
    }

    #[test]
    fn without_centers_there_are_no_cells() {
        let mut cells = Cells::default();
        cells.assign(&pixels(&[vec![(3, 100)]]), &[]);
        assert_eq!(cells.runs(), []);
    }
}

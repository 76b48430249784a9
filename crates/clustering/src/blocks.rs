//! Groups the runs of a mask into blocks: pieces of runs that are close together occupy the lanes
//! of a vector.

use super::Pixels;

/// Pieces per block: the lanes of the widest register.
pub(super) const LANES: usize = 16;
/// One number per piece.
pub(super) type Lanes = [f32; LANES];

/// Size of the tiles whose pieces form blocks. Ropes are about 5 to 40 pixels wide. With 120
/// centers along a rope, the nearest ten are at most about 100 pixels away. Few centers therefore
/// matter to a block.
const TILE_WIDTH: u32 = 32;
const TILE_HEIGHT: u16 = 16;
/// Runs longer than this are cut where tile columns end. Most runs across a rope stay whole.
const LONGEST: u32 = 48;

/// Pieces of runs that are close together.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// Rows of the pieces.
    pub(super) y: Lanes,
    /// Their first columns, and the columns after their last. In unused lanes the two are equal.
    pub(super) from: Lanes,
    pub(super) to: Lanes,
    /// Their indices in the order of runs.
    pub(super) pieces: [u32; LANES],
    /// Number of pieces.
    pub(super) count: usize,
    /// Minimum and maximum column, and row, of their pixels.
    pub(super) columns: [f32; 2],
    pub(super) rows: [f32; 2],
}

/// All pieces of a mask.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    pub(super) blocks: Vec<Block>,
    /// Number of pieces.
    pub(super) pieces: u32,
    /// For each column of tiles: the current row of tiles, counted from 1, and the block that
    /// receives its pieces.
    open: Vec<(u32, u32)>,
}

impl Blocks {
    /// Replaces the contents by the runs of `pixels`.
    pub(super) fn take(&mut self, pixels: &Pixels) {
        self.blocks.clear();
        self.pieces = 0;
        self.open.clear();
        for run in pixels.runs() {
            let (mut from, end) = (u32::from(run.from), u32::from(run.to));
            let row = 1 + u32::from(run.y / TILE_HEIGHT);
            while from < end {
                let to = match end - from {
                    ..=LONGEST => end,
                    _ => (from / TILE_WIDTH + 1) * TILE_WIDTH,
                };
                self.push((row, from.midpoint(to) / TILE_WIDTH), run.y, from, to);
                from = to;
            }
        }
    }

    #[inline]
    fn push(&mut self, (row, column): (u32, u32), y: u16, from: u32, to: u32) {
        let column = column as usize;
        if column >= self.open.len() {
            self.open.resize(column + 1, (0, 0));
        }
        let (open_row, open) = self.open[column];
        let (y, from, to) = (f32::from(y), from as f32, to as f32);
        let piece = self.pieces;
        self.pieces += 1;
        if open_row == row
            && let Some(block) = self.blocks.get_mut(open as usize)
            && block.count < LANES
        {
            let lane = block.count;
            (block.y[lane], block.from[lane], block.to[lane]) = (y, from, to);
            block.pieces[lane] = piece;
            block.count += 1;
            block.columns[0] = block.columns[0].min(from);
            block.columns[1] = block.columns[1].max(to - 1.0);
            block.rows[1] = y;
            return;
        }
        self.open[column] = (row, self.blocks.len() as u32);
        let mut block = Block {
            y: [y; LANES],
            from: [from; LANES],
            to: [from; LANES],
            pieces: [piece; LANES],
            count: 1,
            columns: [from, to - 1.0],
            rows: [y, y],
        };
        block.to[0] = to;
        self.blocks.push(block);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Run;

    #[test]
    fn every_pixel_is_in_one_piece_and_pieces_are_in_the_order_of_runs() {
        let mut pixels = Pixels::default();
        for y in 3..200u16 {
            for (from, to) in [(y % 7, 90 + y), (300, 301), (302, 350), (65_000, 65_535)] {
                pixels.push(Run { y, from, to });
            }
        }
        let mut blocks = Blocks::default();
        blocks.take(&pixels);
        let mut pieces = vec![(0, 0, 0); blocks.pieces as usize];
        for block in &blocks.blocks {
            for lane in 0..block.count {
                let (y, from, to) = (block.y[lane], block.from[lane], block.to[lane]);
                assert!(from < to && to - from <= LONGEST as f32);
                assert!(block.columns[0] <= from && to - 1.0 <= block.columns[1]);
                assert!(block.rows[0] <= y && y <= block.rows[1]);
                pieces[block.pieces[lane] as usize] = (y as u16, from as u16, to as u16);
            }
            let rest = block.from[block.count..].iter();
            assert!(rest.eq(&block.to[block.count..]));
        }
        let listed = pieces
            .iter()
            .flat_map(|&(y, from, to)| (from..to).map(move |x| (f32::from(x), f32::from(y))));
        assert!(listed.eq(pixels.xs().iter().copied().zip(pixels.ys().iter().copied())));
    }
}

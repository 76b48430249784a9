//! Opening of a bit plane whose blocks are close together. All steps run on data that fits in one
//! cache.
//!
//! A rope fills few of a picture's blocks. They are gathered into tiles, the runs of a strip one
//! after the other, with an empty gap in between. Each tile stores the places of its left and right
//! neighbors. Pixels outside the picture are set during erosion and unset during dilation.

use super::neighbors::{Around, Rule, apply_to_tile};
use super::octagon::{Cross, Square, ToBottomRight, is_square};
use super::strips::{BLOCK, Blocks, Strips, block, block_mut};

/// Places of an empty tile and of a full one. The words around each have the same value.
const NOTHING: usize = BLOCK;
const ALL: usize = 4 * BLOCK;
/// Number of words that the empty and the full tile take.
const FIRST: usize = 6 * BLOCK;

/// Memory of the opening.
#[derive(Debug, Default)]
pub(crate) struct Tiles {
    tiles: Vec<Tile>,
    words: Vec<u64>,
    next: Vec<u64>,
    /// For each block of the picture, the place of its tile, or 0 if it is not in any. The index is
    /// the block's first word in `Strips` divided by `BLOCK`.
    at: Vec<u32>,
    held: Blocks,
    /// Places of gaps that stand for the outside.
    outside: Vec<u32>,
}

/// Places of a block's words in the tiles and in the picture, and of the tiles to its left and
/// right.
#[derive(Clone, Copy, Debug)]
struct Tile {
    at: u32,
    word: u32,
    left: u32,
    right: u32,
}

impl Tiles {
    /// Reserves memory for planes of this one's shape.
    pub(crate) fn reserve(&mut self, plane: &Strips) {
        let blocks = plane.shape.words() / BLOCK;
        self.at.clear();
        self.at.resize(blocks, 0);
        self.tiles.clear();
        self.tiles.reserve(blocks);
        for words in [&mut self.words, &mut self.next] {
            words.clear();
            // In the worst case, every other block of a strip has a gap on both sides.
            words.reserve(FIRST + 2 * BLOCK * blocks);
        }
        self.held.resize(&plane.shape);
        self.outside.clear();
        self.outside.reserve(2 * plane.shape.strips() + 1);
    }

    /// Keeps only what a disc `across` pixels wide covers while it stays inside the set pixels.
    pub(crate) fn open(&mut self, plane: &mut Strips, across: usize) {
        if self.at.len() != plane.shape.words() / BLOCK {
            self.reserve(plane);
        }
        lariat_portable::Arch::new().dispatch(Open {
            tiles: self,
            plane,
            across,
        });
    }

    /// Gathers the blocks of `plane`, with everything outside it set.
    #[inline(always)]
    fn gather(&mut self, plane: &Strips) {
        let shape = &plane.shape;
        let mut held = std::mem::take(&mut self.held);
        held.holding(plane);
        self.tiles.clear();
        self.outside.clear();
        self.words.clear();
        self.words.resize(ALL - BLOCK, 0);
        self.words.resize(FIRST, u64::MAX);
        let mut end = 0;
        for (word, count) in held.runs(shape) {
            let (strip, y) = shape.place(word);
            if word == end {
                // The run continues. It was split at the end of a word of blocks.
                self.words.truncate(self.words.len() - BLOCK);
            } else {
                self.push_gap(y == 0);
            }
            end = word + count;
            let outside = !shape.inside(strip);
            for word in (word..end).step_by(BLOCK) {
                self.at[word / BLOCK] = self.words.len() as u32;
                self.tiles.push(Tile {
                    at: self.words.len() as u32,
                    word: word as u32,
                    left: 0,
                    right: 0,
                });
                let mut rows = *block(&plane.words, word);
                rows.iter_mut().for_each(|row| *row |= outside);
                self.words.extend_from_slice(&rows);
            }
            let beyond = (y + count).saturating_sub(shape.height());
            let len = self.words.len();
            self.words[len - beyond..].fill(u64::MAX);
            self.push_gap(y + count >= shape.height());
        }
        self.held = held;
        let (stride, last) = (shape.stride / BLOCK, shape.strips() - 1);
        for tile in &mut self.tiles {
            let block = tile.word as usize / BLOCK;
            let (strip, _) = shape.place(tile.word as usize);
            let at = |block: usize| match self.at[block] {
                0 => NOTHING as u32,
                at => at,
            };
            tile.left = if strip == 0 {
                ALL as u32
            } else {
                at(block - stride)
            };
            tile.right = if strip == last {
                ALL as u32
            } else {
                at(block + stride)
            };
        }
        self.next.clear();
        self.next.extend_from_slice(&self.words);
    }

    /// Separates two runs, or a run from the outside.
    #[inline(always)]
    fn push_gap(&mut self, is_outside: bool) {
        let at = self.words.len();
        if is_outside {
            self.outside.push(at as u32);
        }
        self.words
            .resize(at + BLOCK, if is_outside { u64::MAX } else { 0 });
    }

    /// Applies `rule` to each tile.
    #[inline(always)]
    fn step(&mut self, rule: impl Rule) {
        let words = &self.words[..];
        for tile in &self.tiles {
            let Tile {
                at, left, right, ..
            } = *tile;
            let new = apply_to_tile(&rule, words, [left, at, right].map(|at| at as usize));
            *block_mut(&mut self.next, at as usize) = new;
        }
        std::mem::swap(&mut self.words, &mut self.next);
    }

    /// Clears everything outside the picture.
    #[inline(always)]
    fn clear_outside(&mut self, plane: &Strips) {
        let shape = &plane.shape;
        for words in [&mut self.words, &mut self.next] {
            words[ALL - BLOCK..FIRST].fill(0);
            for &at in &self.outside {
                words[at as usize..][..BLOCK].fill(0);
            }
        }
        for tile in &self.tiles {
            let (strip, y) = shape.place(tile.word as usize);
            let rows = block_mut(&mut self.words, tile.at as usize);
            let inside = shape.inside(strip);
            rows.iter_mut().for_each(|row| *row &= inside);
            let own = (shape.height() - y).min(BLOCK);
            rows[own..].fill(0);
        }
    }

    /// Writes the part of the tiles that is in the picture.
    #[inline(always)]
    fn put(&mut self, plane: &mut Strips) {
        let shape = plane.shape;
        for tile in &self.tiles {
            let (strip, y) = shape.place(tile.word as usize);
            let inside = shape.inside(strip);
            let mut rows = *block(&self.words, tile.at as usize);
            rows.iter_mut().for_each(|row| *row &= inside);
            let own = (shape.height() - y).min(BLOCK);
            rows[own..].fill(0);
            *block_mut(&mut plane.words, tile.word as usize) = rows;
            self.at[tile.word as usize / BLOCK] = 0;
        }
    }
}

/// The opening, compiled for each kind of machine.
struct Open<'a> {
    tiles: &'a mut Tiles,
    plane: &'a mut Strips,
    across: usize,
}

impl lariat_portable::NullaryFnOnce for Open<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (tiles, radius) = (self.tiles, self.across.saturating_sub(1) / 2);
        let is_even = self.across > 0 && self.across.is_multiple_of(2);
        tiles.gather(self.plane);
        for i in 0..radius {
            if is_square(i) {
                tiles.step(Eroded(Square));
            } else {
                tiles.step(Eroded(Cross));
            }
        }
        if is_even {
            tiles.step(FromBottomRight);
        }
        tiles.clear_outside(self.plane);
        if is_even {
            tiles.step(ToBottomRight);
        }
        for i in 0..radius {
            if is_square(i) {
                tiles.step(Square);
            } else {
                tiles.step(Cross);
            }
        }
        tiles.put(self.plane);
    }
}

/// Erosion that corresponds to the symmetric dilation `R`.
struct Eroded<R>(R);

impl<R: Rule> Rule for Eroded<R> {
    #[inline(always)]
    fn word(&self, around: &Around) -> u64 {
        let &Around {
            here,
            n,
            s,
            w,
            e,
            nw,
            ne,
            sw,
            se,
        } = around;
        !self.0.word(&Around {
            here: !here,
            n: !n,
            s: !s,
            w: !w,
            e: !e,
            nw: !nw,
            ne: !ne,
            sw: !sw,
            se: !se,
        })
    }
}

/// Erosion by the 2×2 square of [`ToBottomRight`], turned around. The two together shift nothing.
struct FromBottomRight;

impl Rule for FromBottomRight {
    #[inline(always)]
    fn word(&self, around: &Around) -> u64 {
        let Around { here, s, e, se, .. } = around;
        here & s & e & se
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bitmap::bits::BitPlane;
    use crate::bitmap::morphology::Morphology;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn gathered_blocks_open_as_they_do_where_they_lie(
            width in 1usize..330, height in 1usize..1100,
            bars in proptest::collection::vec((0usize..330, 0usize..1100, 1usize..60, 1usize..90), 1..16),
            across in 0usize..16,
        ) {
            let mut plane = BitPlane::default();
            plane.resize(width, height);
            for &(x, y, wide, high) in &bars {
                let (x, y) = (x % width, y % height);
                (y..(y + high).min(height)).for_each(|y| plane.fill(y, x, (x + wide).min(width), true));
            }
            let (mut tiles, mut morphology) = (Tiles::default(), Morphology::default());
            let (mut by_tiles, mut in_place) = <(Strips, Strips)>::default();
            // The second round reuses the memory of the first.
            for _ in 0..2 {
                by_tiles.take(&plane);
                tiles.open(&mut by_tiles, across);
                in_place.take(&plane);
                morphology.open_in_place(&mut in_place, across);
                prop_assert_eq!(by_tiles.plane(), in_place.plane());
            }
        }
    }
}

//! A picture of one bit a pixel in strips, for kernels that look at a pixel's neighbors.
//!
//! A strip is 64 pixels wide and as high as the picture, one word a row, and its rows lie one after the other. So the
//! neighbors above and below a word stand beside it in memory, those to its left and right a fixed distance off, and a
//! stretch of rope is a run of words in one or two strips: plain loops over slices, which fill the widest registers,
//! whichever way the rope runs. Eight rows of a strip are a block; a kernel visits the blocks that hold something.

use crate::bits::BitPlane;

/// Rows in a block: as many words as the widest register holds.
pub(crate) const BLOCK: usize = 8;
/// Blocks in a word of `Blocks`.
const GROUP: usize = 64;

/// How a picture is cut into strips and blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shape {
    width: usize,
    height: usize,
    /// Words from one strip to the next: its rows in whole blocks, and one block of which nothing is ever set.
    pub(crate) stride: usize,
    strips: usize,
    /// Words of `Blocks` to a strip.
    groups: usize,
}

impl Shape {
    pub(crate) fn of(plane: &BitPlane) -> Self {
        let blocks = plane.height().div_ceil(BLOCK);
        Self {
            width: plane.width(),
            height: plane.height(),
            stride: (blocks + 1) * BLOCK,
            strips: plane.words_per_row(),
            groups: blocks.div_ceil(GROUP),
        }
    }

    /// Where the word of strip `strip` and row `y` lies. Before the first strip and behind the last lies an empty one.
    pub(crate) fn index(&self, strip: usize, y: usize) -> usize {
        (strip + 1) * self.stride + BLOCK + y
    }

    fn words(&self) -> usize {
        (self.strips + 2) * self.stride + BLOCK
    }
}

/// The words of a picture in strips.
#[derive(Clone, Debug, Default)]
pub(crate) struct Strips {
    pub(crate) words: Vec<u64>,
}

impl Strips {
    /// Takes this shape, all pixels 0.
    pub(crate) fn resize(&mut self, shape: &Shape) {
        self.words.clear();
        self.words.resize(shape.words(), 0);
    }

    /// Sets the blocks of `what` to 0.
    pub(crate) fn clear(&mut self, shape: &Shape, what: &Blocks) {
        what.for_each_run(shape, |at, count| self.words[at..][..count].fill(0));
    }

    /// Takes the pixels of `plane` into an empty picture, and notes in `used` the blocks that hold any.
    pub(crate) fn fill(&mut self, shape: &Shape, plane: &BitPlane, used: &mut Blocks) {
        used.resize(shape);
        for y in 0..shape.height {
            let (group, block) = (y / BLOCK / GROUP, y / BLOCK % GROUP);
            for (strip, &word) in plane.row(y).iter().enumerate() {
                if word != 0 {
                    self.words[shape.index(strip, y)] = word;
                    used.bits[strip * shape.groups + group] |= 1 << block;
                }
            }
        }
    }

    /// Puts the pixels of the blocks of `used` into `plane`.
    pub(crate) fn put(&self, shape: &Shape, used: &Blocks, plane: &mut BitPlane) {
        used.for_each_run(shape, |at, count| {
            let strip = at / shape.stride - 1;
            let from = at - shape.index(strip, 0);
            for y in from..(from + count).min(shape.height) {
                plane.row_mut(y)[strip] = self.words[shape.index(strip, y)];
            }
        });
    }
}

/// A set of blocks: a bit each, strip by strip.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks {
    pub(crate) bits: Vec<u64>,
}

impl Blocks {
    /// No block of a picture of this shape.
    pub(crate) fn resize(&mut self, shape: &Shape) {
        self.bits.clear();
        self.bits.resize(shape.strips * shape.groups, 0);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bits.iter().all(|&bits| bits == 0)
    }

    /// Calls `visit(index of the first word, count of words)` for each stretch of blocks.
    #[inline(always)]
    pub(crate) fn for_each_run(&self, shape: &Shape, mut visit: impl FnMut(usize, usize)) {
        for strip in 0..shape.strips {
            for group in 0..shape.groups {
                let mut bits = self.bits[strip * shape.groups + group];
                while bits != 0 {
                    let from = bits.trailing_zeros();
                    let count = (!(bits >> from)).trailing_zeros();
                    let block = group * GROUP + from as usize;
                    visit(shape.index(strip, BLOCK * block), BLOCK * count as usize);
                    bits &= !(u64::MAX >> (GROUP as u32 - count) << from);
                }
            }
        }
    }

    /// Adds the blocks that the words from `at` on, `count` of them, lie in: a run as it was visited.
    #[inline(always)]
    pub(crate) fn add_run(&mut self, shape: &Shape, at: usize, count: usize) {
        let strip = at / shape.stride - 1;
        let block = (at - shape.index(strip, 0)) / BLOCK;
        let bits = u64::MAX >> (GROUP - count / BLOCK) << (block % GROUP);
        self.bits[strip * shape.groups + block / GROUP] |= bits;
    }

    /// Makes this the blocks of `used` that lie in or beside a block of `a` or of `b`.
    pub(crate) fn around(&mut self, shape: &Shape, used: &Blocks, a: &Blocks, b: &Blocks) {
        let groups = shape.groups;
        for strip in 0..shape.strips {
            for group in 0..groups {
                let at = |group: usize| {
                    let of = |strip: usize| {
                        a.bits[strip * groups + group] | b.bits[strip * groups + group]
                    };
                    let left = if strip > 0 { of(strip - 1) } else { 0 };
                    let right = if strip + 1 < shape.strips {
                        of(strip + 1)
                    } else {
                        0
                    };
                    left | of(strip) | right
                };
                let mut near = at(group);
                near |= near << 1 | near >> 1;
                if group > 0 {
                    near |= at(group - 1) >> (GROUP - 1);
                }
                if group + 1 < groups {
                    near |= at(group + 1) << (GROUP - 1);
                }
                self.bits[strip * groups + group] = near & used.bits[strip * groups + group];
            }
        }
    }
}

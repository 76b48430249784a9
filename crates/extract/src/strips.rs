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

    pub(crate) fn height(&self) -> usize {
        self.height
    }

    pub(crate) fn strips(&self) -> usize {
        self.strips
    }

    /// Where the word of strip `strip` and row `y` lies. Before the first strip and behind the last lies an empty one.
    #[inline(always)]
    pub(crate) fn index(&self, strip: usize, y: usize) -> usize {
        (strip + 1) * self.stride + BLOCK + y
    }

    /// All words, empty ones around the picture included.
    pub(crate) fn words(&self) -> usize {
        (self.strips + 2) * self.stride + BLOCK
    }

    /// The strip of a word, and its row.
    #[inline(always)]
    pub(crate) fn place(&self, at: usize) -> (usize, usize) {
        let strip = at / self.stride - 1;
        (strip, at - self.index(strip, 0))
    }

    /// The pixels of a word of this strip that lie in the picture.
    pub(crate) fn inside(&self, strip: usize) -> u64 {
        match self.width - 64 * strip {
            0..64 => (1 << (self.width % 64)) - 1,
            _ => u64::MAX,
        }
    }
}

/// The words of a picture in strips.
#[derive(Clone, Debug, Default)]
pub(crate) struct Strips {
    pub(crate) shape: Shape,
    pub(crate) words: Vec<u64>,
    /// Blocks that may hold something: all others are 0.
    pub(crate) used: Blocks,
}

impl Strips {
    /// Takes this shape, all pixels 0.
    pub(crate) fn resize(&mut self, shape: &Shape) {
        if self.shape == *shape {
            for (at, count) in self.used.runs(shape) {
                self.words[at..][..count].fill(0);
            }
        } else {
            self.shape = *shape;
            self.words.clear();
            self.words.resize(shape.words(), 0);
        }
        self.used.resize(shape);
    }

    /// Takes the pixels of `plane`.
    pub(crate) fn take(&mut self, plane: &BitPlane) {
        let shape = Shape::of(plane);
        self.resize(&shape);
        // Most words hold nothing: eight at a time are passed over.
        for (i, words) in plane.words().chunks(BLOCK).enumerate() {
            if words.iter().fold(0, |all, word| all | word) == 0 {
                continue;
            }
            let (mut y, mut strip) = (BLOCK * i / shape.strips, BLOCK * i % shape.strips);
            for &word in words {
                if word != 0 {
                    self.words[shape.index(strip, y)] = word;
                    self.used.add(&shape, strip, y);
                }
                strip += 1;
                if strip == shape.strips {
                    (y, strip) = (y + 1, 0);
                }
            }
        }
    }
}

#[cfg(test)]
impl Strips {
    /// The same pixels row by row.
    pub(crate) fn plane(&self) -> BitPlane {
        let mut plane = BitPlane::default();
        plane.resize(self.shape.width, self.shape.height);
        for y in 0..self.shape.height {
            for strip in 0..self.shape.strips {
                plane.row_mut(y)[strip] = self.words[self.shape.index(strip, y)];
            }
        }
        plane
    }
}

/// A set of blocks: a bit each, strip by strip.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks {
    bits: Vec<u64>,
}

impl Blocks {
    /// No block of a picture of this shape.
    pub(crate) fn resize(&mut self, shape: &Shape) {
        self.bits.clear();
        self.bits.resize(shape.strips * shape.groups, 0);
    }

    pub(crate) fn copy_from(&mut self, other: &Blocks) {
        self.bits.clone_from(&other.bits);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bits.iter().all(|&bits| bits == 0)
    }

    /// Whether block `block` of a strip is in the set.
    #[inline(always)]
    pub(crate) fn holds(&self, shape: &Shape, strip: usize, block: usize) -> bool {
        self.bits[strip * shape.groups + block / GROUP] >> (block % GROUP) & 1 == 1
    }

    /// Adds the block of row `y` of a strip.
    #[inline(always)]
    pub(crate) fn add(&mut self, shape: &Shape, strip: usize, y: usize) {
        let block = y / BLOCK;
        self.bits[strip * shape.groups + block / GROUP] |= 1 << (block % GROUP);
    }

    /// Each stretch of blocks: the index of its first word, and how many words it has.
    #[inline(always)]
    pub(crate) fn runs(&self, shape: &Shape) -> Runs<'_> {
        Runs {
            bits: &self.bits,
            shape: *shape,
            group: 0,
            rest: self.bits.first().copied().unwrap_or(0),
        }
    }

    /// Adds the blocks of a run as it was visited.
    #[inline(always)]
    pub(crate) fn add_run(&mut self, shape: &Shape, at: usize, count: usize) {
        let (strip, y) = shape.place(at);
        let bits = u64::MAX >> (GROUP - count / BLOCK) << (y / BLOCK % GROUP);
        self.bits[strip * shape.groups + y / BLOCK / GROUP] |= bits;
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

/// The stretches of blocks of a set: see [`Blocks::runs`].
pub(crate) struct Runs<'a> {
    bits: &'a [u64],
    shape: Shape,
    /// The word of bits that is looked at, and those of its bits that are still to come.
    group: usize,
    rest: u64,
}

impl Iterator for Runs<'_> {
    type Item = (usize, usize);

    // Closures and iterators within a dispatched kernel are inlined, or they are compiled for the baseline.
    #[inline(always)]
    fn next(&mut self) -> Option<(usize, usize)> {
        while self.rest == 0 {
            self.group += 1;
            self.rest = *self.bits.get(self.group)?;
        }
        let from = self.rest.trailing_zeros();
        let count = (!(self.rest >> from)).trailing_zeros();
        self.rest &= !(u64::MAX >> (GROUP as u32 - count) << from);
        let (strip, group) = (
            self.group / self.shape.groups,
            self.group % self.shape.groups,
        );
        let block = group * GROUP + from as usize;
        Some((
            self.shape.index(strip, BLOCK * block),
            BLOCK * count as usize,
        ))
    }
}

/// The words of a block from `at` on, or as many a row or a strip beside it.
#[inline(always)]
pub(crate) fn block(words: &[u64], at: usize) -> &[u64; BLOCK] {
    words[at..]
        .first_chunk()
        .expect("empty blocks lie all around the picture")
}

/// The same, to be written.
#[inline(always)]
pub(crate) fn block_mut(words: &mut [u64], at: usize) -> &mut [u64; BLOCK] {
    words[at..].first_chunk_mut().expect("blocks are whole")
}

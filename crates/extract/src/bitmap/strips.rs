//! A picture of one bit per pixel in strips, for kernels that read a pixel's neighbors.
//!
//! A strip is 64 pixels wide and as high as the picture. It has one word per row, and its rows
//! follow each other in memory. The neighbors above and below a word are next to it, and those to
//! its left and right are at a fixed distance. A stretch of rope is a run of words in one or two
//! strips, whichever way the rope runs. Kernels are therefore plain loops over slices, which fill
//! the widest registers.
//!
//! Eight rows of a strip are a block. Kernels visit only the blocks that are marked as used. All
//! other pixels are the ground: either all set or all unset.

use super::bits::BitPlane;

/// Rows in a block: as many words as the widest register holds.
pub(crate) const BLOCK: usize = 8;
/// Blocks in a word of `Blocks`.
const GROUP: usize = 64;
/// Binary places of the stride's inverse. Multiplying by it divides numbers of words. The result is
/// exact: a picture of 65 536 by 65 536 pixels has fewer than 2²⁷ words and strides below 2¹⁷.
const INVERSE: u32 = 44;

/// Division of a picture into strips and blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shape {
    width: usize,
    height: usize,
    /// Words from one strip to the next: its rows in whole blocks, plus one block that is always
    /// empty.
    pub(crate) stride: usize,
    /// `2^INVERSE / stride`, rounded up.
    inverse: u64,
    strips: usize,
    /// Words of `Blocks` per strip.
    groups: usize,
}

impl Shape {
    pub(crate) fn of(plane: &BitPlane) -> Self {
        let blocks = plane.height().div_ceil(BLOCK);
        let stride = (blocks + 1) * BLOCK;
        Self {
            width: plane.width(),
            height: plane.height(),
            stride,
            inverse: (1u64 << INVERSE).div_ceil(stride as u64),
            strips: plane.words_per_row(),
            groups: blocks.div_ceil(GROUP),
        }
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    pub(crate) fn height(&self) -> usize {
        self.height
    }

    pub(crate) fn strips(&self) -> usize {
        self.strips
    }

    /// Index of the first word of the first block in word `i` of a set of blocks.
    #[inline(always)]
    pub(crate) fn first_of(&self, i: usize) -> usize {
        // Few pictures are high enough for more than one word of blocks per strip.
        match self.groups {
            1 => self.index(i, 0),
            groups => self.index(i / groups, BLOCK * GROUP * (i % groups)),
        }
    }

    /// Index of the word at strip `strip` and row `y`. An empty strip precedes the first and
    /// another follows the last.
    #[inline(always)]
    pub(crate) fn index(&self, strip: usize, y: usize) -> usize {
        (strip + 1) * self.stride + BLOCK + y
    }

    /// Number of words, including the empty ones around the picture.
    pub(crate) fn words(&self) -> usize {
        (self.strips + 2) * self.stride + BLOCK
    }

    /// Strip and row of a word.
    #[inline(always)]
    pub(crate) fn place(&self, at: usize) -> (usize, usize) {
        let strip = ((at as u64 * self.inverse) >> INVERSE) as usize - 1;
        (strip, at - self.index(strip, 0))
    }

    /// Mask of the pixels of this strip's words that are in the picture.
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
    /// Blocks that may differ from the ground.
    pub(crate) used: Blocks,
    /// True if the pixels of all other blocks are set.
    ground: bool,
}

impl Strips {
    /// A picture whose ground is set.
    pub(crate) fn of_ground() -> Self {
        Self {
            ground: true,
            ..Self::default()
        }
    }

    /// Sets the shape and resets all pixels to the ground.
    pub(crate) fn resize(&mut self, shape: &Shape) {
        if self.shape != *shape {
            self.shape = *shape;
            self.words.clear();
            self.words.resize(shape.words(), 0);
            self.used.resize(shape);
            if self.ground {
                for strip in 0..shape.strips {
                    self.words[shape.index(strip, 0)..][..shape.height].fill(shape.inside(strip));
                }
            }
            return;
        }
        for (at, count) in self.used.runs(shape) {
            let words = &mut self.words[at..][..count];
            if self.ground {
                let (strip, y) = shape.place(at);
                let rows = count.min(shape.height - y);
                words[..rows].fill(shape.inside(strip));
            } else {
                words.fill(0);
            }
        }
        self.used.clear();
    }

    /// Copies the pixels of a picture on the same ground.
    pub(crate) fn copy_from(&mut self, other: &Strips) {
        self.resize(&other.shape);
        self.used.copy_from(&other.used);
        for (at, count) in other.used.runs(&other.shape) {
            self.words[at..][..count].copy_from_slice(&other.words[at..][..count]);
        }
    }

    /// Copies the pixels of `other` within these blocks. The ground of both must be unset.
    pub(crate) fn take_within(&mut self, other: &Strips, blocks: &Blocks) {
        self.resize(&other.shape);
        self.used.copy_from(blocks);
        for (at, count) in blocks.runs(&other.shape) {
            self.words[at..][..count].copy_from_slice(&other.words[at..][..count]);
        }
    }

    /// Adds the pixels of `other`. The ground of both must be unset.
    pub(crate) fn add(&mut self, other: &Strips) {
        self.used.add_all(&other.used);
        for (at, count) in other.used.runs(&other.shape) {
            let words = self.words[at..][..count].iter_mut();
            words
                .zip(&other.words[at..][..count])
                .for_each(|(word, other)| *word |= other);
        }
    }

    /// Copies the inverted pixels of `other`, whose ground is the opposite.
    pub(crate) fn complement(&mut self, other: &Strips) {
        self.resize(&other.shape);
        self.used.copy_from(&other.used);
        let shape = &self.shape;
        for (at, count) in other.used.runs(shape) {
            let (strip, y) = shape.place(at);
            let (inside, rows) = (shape.inside(strip), count.min(shape.height - y));
            let words = self.words[at..][..rows].iter_mut();
            words
                .zip(&other.words[at..][..rows])
                .for_each(|(word, other)| *word = !other & inside);
        }
    }

    /// Replaces each word by `rule` of this word and the words of `a` and `b`.
    ///
    /// All three have the same shape and an unset ground, and `rule` maps zeros to zero.
    pub(crate) fn zip(&mut self, a: &Strips, b: &Strips, rule: impl Fn(u64, u64, u64) -> u64) {
        self.used.add_all(&a.used);
        self.used.add_all(&b.used);
        self.zip_within(a, b, rule);
    }

    /// As [`zip`](Self::zip), but only within the used blocks of this picture.
    pub(crate) fn zip_within(
        &mut self,
        a: &Strips,
        b: &Strips,
        rule: impl Fn(u64, u64, u64) -> u64,
    ) {
        for (at, count) in self.used.runs(&self.shape) {
            let words = self.words[at..][..count].iter_mut();
            let others = a.words[at..][..count].iter().zip(&b.words[at..][..count]);
            for (word, (&a, &b)) in words.zip(others) {
                *word = rule(*word, a, b);
            }
        }
    }

    /// Calls `visit` with the row, the strip and the value of each word in the used blocks.
    pub(crate) fn for_each_word(&self, mut visit: impl FnMut(usize, usize, u64)) {
        for (at, count) in self.used.runs(&self.shape) {
            let (strip, y) = self.shape.place(at);
            for k in 0..count.min(self.shape.height - y) {
                visit(y + k, strip, self.words[at + k]);
            }
        }
    }

    /// Writes the used blocks into `plane`, which has the same size and equals the ground
    /// elsewhere.
    pub(crate) fn put(&self, plane: &mut BitPlane) {
        self.for_each_word(|y, strip, word| plane.row_mut(y)[strip] = word);
    }

    /// Removes empty blocks from the used ones. The ground must be unset.
    pub(crate) fn tighten(&mut self) {
        for at in 0..self.used.bits.len() {
            let mut bits = self.used.bits[at];
            while bits != 0 {
                let from = bits & bits.wrapping_neg();
                bits ^= from;
                let block = at % self.shape.groups * GROUP + from.trailing_zeros() as usize;
                let word = self.shape.index(at / self.shape.groups, BLOCK * block);
                if *self::block(&self.words, word) == [0; BLOCK] {
                    self.used.bits[at] ^= from;
                }
            }
        }
    }

    /// Number of set pixels in the used blocks.
    pub(crate) fn count(&self) -> usize {
        lariat_portable::Arch::new().dispatch(Count(self))
    }

    /// Returns whether pixel (x, y) is set. Pixels outside the picture are not.
    pub(crate) fn get(&self, x: usize, y: usize) -> bool {
        let (strip, height) = (x / 64, self.shape.height);
        strip < self.shape.strips
            && y < height
            && self.words[self.shape.index(strip, y)] >> (x % 64) & 1 == 1
    }

    /// Copies the pixels of `plane`.
    pub(crate) fn take(&mut self, plane: &BitPlane) {
        let shape = Shape::of(plane);
        self.resize(&shape);
        lariat_portable::Arch::new().dispatch(Take {
            strips: self,
            plane,
        });
    }
}

/// Copies a picture; compiled for each kind of machine.
struct Take<'a> {
    strips: &'a mut Strips,
    plane: &'a BitPlane,
}

impl lariat_portable::NullaryFnOnce for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Strips {
            shape, words, used, ..
        } = self.strips;
        let (strips, rows) = (shape.strips, self.plane.words());
        for (top, rows) in rows.chunks(BLOCK * strips).enumerate() {
            for from in (0..strips).step_by(BLOCK) {
                // Most blocks are empty, so eight at a time are skipped.
                let count = BLOCK.min(strips - from);
                let mut any = [0; BLOCK];
                for row in rows.chunks_exact(strips) {
                    let row = &row[from..from + count];
                    if let Some(row) = row.first_chunk::<BLOCK>() {
                        for k in 0..BLOCK {
                            any[k] |= row[k];
                        }
                    } else {
                        any.iter_mut().zip(row).for_each(|(any, word)| *any |= word);
                    }
                }
                if any == [0; BLOCK] {
                    continue;
                }
                for strip in (from..from + count).filter(|strip| any[strip - from] != 0) {
                    let at = shape.index(strip, BLOCK * top);
                    let words = words[at..].iter_mut();
                    for (word, row) in words.zip(rows.chunks_exact(strips)) {
                        *word = row[strip];
                    }
                    used.add(shape, strip, BLOCK * top);
                }
            }
        }
    }
}

impl Strips {
    /// Number of consecutive set pixels to the left and to the right of set pixel (x, y), up to
    /// `most`. `most` is at most the number of pixels in two words.
    #[inline(always)]
    pub(crate) fn reach_along_row(&self, [x, y]: [usize; 2], most: usize) -> (usize, usize) {
        let (at, stride) = (self.shape.index(x / 64, y), self.shape.stride);
        let bit = x % 64;
        let (mut left, mut word) = (0, at);
        let mut unset = !self.words[at] << (63 - bit);
        let mut seen = bit + 1;
        while unset == 0 && left + seen <= most && word > stride {
            (left, word) = (left + seen, word - stride);
            (unset, seen) = (!self.words[word], 64);
        }
        left += (unset.leading_zeros() as usize).min(seen);
        let (mut right, mut word) = (0, at);
        let mut unset = !self.words[at] >> bit;
        let mut seen = 64 - bit;
        while unset == 0 && right + seen <= most && word + stride < self.words.len() {
            (right, word) = (right + seen, word + stride);
            (unset, seen) = (!self.words[word], 64);
        }
        right += (unset.trailing_zeros() as usize).min(seen);
        // The pixel itself was counted.
        (
            left.saturating_sub(1).min(most),
            right.saturating_sub(1).min(most),
        )
    }

    /// Number of consecutive set pixels above and below pixel (x, y) within 64 rows, and whether
    /// both runs end within them.
    #[inline(always)]
    pub(crate) fn column(&self, [x, y]: [usize; 2]) -> (usize, usize, bool) {
        const ABOVE: usize = 32;
        let at = self.shape.index(x / 64, y);
        // Strips are separated by empty rows, so no run continues from one to the next.
        let rows = at
            .checked_sub(ABOVE)
            .and_then(|from| self.words.get(from..));
        let Some(rows) = rows.and_then(|rows| rows.first_chunk::<64>()) else {
            return (0, 0, false);
        };
        let mut column = 0;
        for (k, word) in rows.iter().enumerate() {
            column |= (word >> (x % 64) & 1) << k;
        }
        let up = (!(column as u32)).leading_zeros() as usize;
        let down = (!(column >> (ABOVE + 1))).trailing_zeros() as usize;
        (up, down, up < ABOVE && down < 63 - ABOVE)
    }

    /// Number of consecutive set pixels below pixel (x, y), up to `most`.
    #[inline(always)]
    pub(crate) fn reach_down(&self, [x, y]: [usize; 2], most: usize) -> usize {
        let (at, bit) = (self.shape.index(x / 64, y), x % 64);
        // Below the picture is an empty block.
        let below = self.words[at + 1..].iter().take(most);
        below.take_while(|&&word| word >> bit & 1 == 1).count()
    }

    /// Number of consecutive set pixels above pixel (x, y), up to `most`.
    #[inline(always)]
    pub(crate) fn reach_up(&self, [x, y]: [usize; 2], most: usize) -> usize {
        let (at, bit) = (self.shape.index(x / 64, y), x % 64);
        let above = self.words[..at].iter().rev().take(most);
        above.take_while(|&&word| word >> bit & 1 == 1).count()
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

/// A set of blocks: one bit per block, strip by strip.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Blocks {
    bits: Vec<u64>,
}

impl Blocks {
    /// Sets the size for a picture of this shape and empties the set.
    pub(crate) fn resize(&mut self, shape: &Shape) {
        self.bits.clear();
        self.bits.resize(shape.strips * shape.groups, 0);
    }

    pub(crate) fn clear(&mut self) {
        self.bits.fill(0);
    }

    pub(crate) fn add_all(&mut self, other: &Blocks) {
        let bits = self.bits.iter_mut().zip(&other.bits);
        bits.for_each(|(bits, other)| *bits |= other);
    }

    pub(crate) fn copy_from(&mut self, other: &Blocks) {
        self.bits.clone_from(&other.bits);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bits.iter().all(|&bits| bits == 0)
    }

    /// Returns whether block `block` of a strip is in the set. A block below the picture is not.
    #[inline(always)]
    pub(crate) fn holds(&self, shape: &Shape, strip: usize, block: usize) -> bool {
        block < shape.groups * GROUP
            && self.bits[strip * shape.groups + block / GROUP] >> (block % GROUP) & 1 == 1
    }

    /// Adds the block of row `y` of a strip.
    #[inline(always)]
    pub(crate) fn add(&mut self, shape: &Shape, strip: usize, y: usize) {
        let block = y / BLOCK;
        self.bits[strip * shape.groups + block / GROUP] |= 1 << (block % GROUP);
    }

    /// Iterates over the runs of blocks: the index of the first word, and the number of words.
    #[inline(always)]
    pub(crate) fn runs(&self, shape: &Shape) -> Runs<'_> {
        Runs {
            bits: &self.bits,
            shape: *shape,
            first: shape.index(0, 0),
            group: 0,
            of_strip: 0,
            rest: self.bits.first().copied().unwrap_or(0),
        }
    }

    /// The blocks of each strip in order, 64 to a word, the strip's first in the lowest bit.
    #[inline(always)]
    pub(crate) fn words(&self) -> &[u64] {
        &self.bits
    }

    /// As [`words`](Self::words), but mutable.
    #[inline(always)]
    pub(crate) fn words_mut(&mut self) -> &mut [u64] {
        &mut self.bits
    }

    /// Sets this to the blocks of `used` that are in or next to a block of `a` or `b`.
    #[inline(always)]
    pub(crate) fn around(&mut self, shape: &Shape, used: &Blocks, a: &Blocks, b: &Blocks) {
        for strip in 0..shape.strips {
            for group in 0..shape.groups {
                let i = strip * shape.groups + group;
                self.bits[i] = near(shape, strip, group, |i| a.bits[i] | b.bits[i]) & used.bits[i];
            }
        }
    }

    /// Sets this to the blocks of `of` that have a set pixel, and the blocks in a corner between
    /// two of them: above or below one, and next to the other. The ground of `of` must be unset.
    #[inline(always)]
    pub(crate) fn holding(&mut self, of: &Strips) {
        let shape = &of.shape;
        self.resize(shape);
        for (at, count) in of.used.runs(shape) {
            let (strip, y) = shape.place(at);
            let (mut bits, mut bit) = (0, 1 << (y / BLOCK % GROUP));
            for at in (at..at + count).step_by(BLOCK) {
                let any = block(&of.words, at).iter().fold(0, |any, word| any | word);
                bits |= if any == 0 { 0 } else { bit };
                bit <<= 1;
            }
            self.bits[strip * shape.groups + y / BLOCK / GROUP] |= bits;
        }
        // The corner of an added block may be added as well, which does no harm.
        for strip in 0..shape.strips {
            for group in 0..shape.groups {
                let i = strip * shape.groups + group;
                let of = |strip: usize| of_group(&self.bits, shape, strip, group);
                let (own, sides) = (self.bits[i], of(strip.wrapping_sub(1)) | of(strip + 1));
                let mut ends = own << 1 | own >> 1;
                if group > 0 {
                    ends |= self.bits[i - 1] >> (GROUP - 1);
                }
                if group + 1 < shape.groups {
                    ends |= self.bits[i + 1] << (GROUP - 1);
                }
                self.bits[i] |= ends & sides;
            }
        }
    }

    /// Sets this to the blocks with a pixel within `reach` of a set pixel of `of`, along the row
    /// and along the column. The ground of `of` must be unset.
    pub(crate) fn near(&mut self, of: &Strips, reach: usize) {
        let shape = &of.shape;
        self.resize(shape);
        let last = [shape.width - 1, shape.height - 1];
        let span = |from: usize, to: usize, last: usize, side: usize| {
            from.saturating_sub(reach) / side..=(to + reach).min(last) / side
        };
        for (at, count) in of.used.runs(shape) {
            for at in (at..at + count).step_by(BLOCK) {
                let words = block(&of.words, at);
                let any = words.iter().fold(0, |any, word| any | word);
                if any == 0 {
                    continue;
                }
                let (strip, y) = shape.place(at);
                let (left, right) = (any.trailing_zeros(), 63 - any.leading_zeros());
                let [left, right] = [left, right].map(|bit| 64 * strip + bit as usize);
                for strip in span(left, right, last[0], 64) {
                    for block in span(y, y + BLOCK - 1, last[1], BLOCK) {
                        self.add(shape, strip, BLOCK * block);
                    }
                }
            }
        }
    }

    /// Sets this to the blocks in or next to those of `of`.
    pub(crate) fn beside(&mut self, shape: &Shape, of: &Blocks) {
        self.resize(shape);
        let blocks = shape.stride / BLOCK - 1;
        for strip in 0..shape.strips {
            for group in 0..shape.groups {
                let inside = u64::MAX >> (GROUP - (blocks - GROUP * group).min(GROUP));
                self.bits[strip * shape.groups + group] =
                    near(shape, strip, group, |i| of.bits[i]) & inside;
            }
        }
    }
}

/// One group of a strip's blocks; 0 outside the picture.
#[inline(always)]
fn of_group(bits: &[u64], shape: &Shape, strip: usize, group: usize) -> u64 {
    let groups = bits.get(strip.wrapping_mul(shape.groups)..);
    groups
        .and_then(|groups| groups.get(group))
        .copied()
        .unwrap_or(0)
}

/// The blocks of one word that are in or next to blocks of the set that `bits` returns word by
/// word.
#[inline(always)]
fn near(shape: &Shape, strip: usize, group: usize, bits: impl Fn(usize) -> u64) -> u64 {
    let groups = shape.groups;
    let across = |group: usize| {
        let of = |strip: usize| bits(strip * groups + group);
        let left = if strip > 0 { of(strip - 1) } else { 0 };
        let right = if strip + 1 < shape.strips {
            of(strip + 1)
        } else {
            0
        };
        left | of(strip) | right
    };
    let mut near = across(group);
    near |= near << 1 | near >> 1;
    if group > 0 {
        near |= across(group - 1) >> (GROUP - 1);
    }
    if group + 1 < groups {
        near |= across(group + 1) << (GROUP - 1);
    }
    near
}

/// Counts pixels; compiled for each kind of machine.
struct Count<'a>(&'a Strips);

impl lariat_portable::NullaryFnOnce for Count<'_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        let mut count = 0;
        for (at, words) in self.0.used.runs(&self.0.shape) {
            for word in &self.0.words[at..][..words] {
                count += u64::from(word.count_ones());
            }
        }
        count as usize
    }
}

/// Iterator over the runs of a set of blocks; see [`Blocks::runs`].
pub(crate) struct Runs<'a> {
    bits: &'a [u64],
    shape: Shape,
    /// Index of the current strip's first word.
    first: usize,
    /// Index of the current word of bits, its index within its strip, and those of its bits that
    /// are still to come.
    group: usize,
    of_strip: usize,
    rest: u64,
}

impl Iterator for Runs<'_> {
    type Item = (usize, usize);

    // Closures and iterators within a dispatched kernel must be inlined, or they are compiled for
    // the baseline.
    #[inline(always)]
    fn next(&mut self) -> Option<(usize, usize)> {
        while self.rest == 0 {
            self.group += 1;
            self.of_strip += 1;
            if self.of_strip == self.shape.groups {
                self.of_strip = 0;
                self.first += self.shape.stride;
            }
            self.rest = *self.bits.get(self.group)?;
        }
        let from = self.rest.trailing_zeros();
        let count = (!(self.rest >> from)).trailing_zeros();
        self.rest &= !(u64::MAX >> (GROUP as u32 - count) << from);
        let block = self.of_strip * GROUP + from as usize;
        Some((self.first + BLOCK * block, BLOCK * count as usize))
    }
}

/// The words of the block at `at`. `at` may be shifted by a row or a strip.
#[inline(always)]
pub(crate) fn block(words: &[u64], at: usize) -> &[u64; BLOCK] {
    words[at..]
        .first_chunk()
        .expect("empty blocks lie all around the picture")
}

/// As [`block`], but mutable.
#[inline(always)]
pub(crate) fn block_mut(words: &mut [u64], at: usize) -> &mut [u64; BLOCK] {
    words[at..].first_chunk_mut().expect("blocks are whole")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_lie_where_division_says() {
        for [width, height] in [[1, 1], [64, 511], [70, 1030], [640, 480], [20_000, 65_000]] {
            let blocks = usize::div_ceil(height, BLOCK);
            let mut plane = BitPlane::default();
            plane.resize(width, height);
            let shape = Shape::of(&plane);
            assert_eq!(shape.stride, (blocks + 1) * BLOCK);
            for strip in 0..shape.strips() {
                for y in [0, 1, height / 2, height - 1, BLOCK * blocks - 1] {
                    assert_eq!(shape.place(shape.index(strip, y)), (strip, y));
                }
            }
        }
    }
}

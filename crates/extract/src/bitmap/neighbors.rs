//! Kernels over the eight neighbors of each pixel, 64 pixels to a word and a block of words at a
//! time.

use super::strips::{BLOCK, Blocks, Shape, Strips, block_mut};

/// 64 pixels and their neighbors, each neighbor at its pixel's bit.
#[derive(Clone, Copy)]
pub(crate) struct Around {
    pub(crate) here: u64,
    pub(crate) n: u64,
    pub(crate) s: u64,
    pub(crate) w: u64,
    pub(crate) e: u64,
    pub(crate) nw: u64,
    pub(crate) ne: u64,
    pub(crate) sw: u64,
    pub(crate) se: u64,
}

/// A rule that gives a pixel's new value from the pixel and its neighbors.
pub(crate) trait Rule {
    /// Computes the new values of 64 pixels.
    fn word(&self, around: &Around) -> u64;
}

/// Applies `rule` to the block at `at`.
#[inline(always)]
pub(crate) fn apply_to_block<R: Rule>(
    rule: &R,
    words: &[u64],
    at: usize,
    stride: usize,
) -> [u64; BLOCK] {
    apply_to_tile(rule, words, [at - stride, at, at + stride])
}

/// As [`apply_to_block`], with explicit places for the words left of the block, its own, and those
/// right of it.
#[inline(always)]
pub(crate) fn apply_to_tile<R: Rule>(
    rule: &R,
    words: &[u64],
    [left, own, right]: [usize; 3],
) -> [u64; BLOCK] {
    let [left, own, right] = [
        three_rows(words, left),
        three_rows(words, own),
        three_rows(words, right),
    ];
    // A local value rather than a place in memory, so that the compiler knows that no input is
    // overwritten.
    let mut new = [0; BLOCK];
    for k in 0..BLOCK {
        let west = |row: usize| own[row][k] << 1 | left[row][k] >> 63;
        let east = |row: usize| own[row][k] >> 1 | right[row][k] << 63;
        new[k] = rule.word(&Around {
            here: own[1][k],
            n: own[0][k],
            s: own[2][k],
            w: west(1),
            e: east(1),
            nw: west(0),
            ne: east(0),
            sw: west(2),
            se: east(2),
        });
    }
    new
}

/// Rows of the block at `at`, shifted up by one, in place, and shifted down by one.
#[inline(always)]
fn three_rows(words: &[u64], at: usize) -> [&[u64; BLOCK]; 3] {
    let rows: &[u64; BLOCK + 2] = words[at - 1..]
        .first_chunk()
        .expect("empty blocks lie all around the picture");
    let from = |first: usize| {
        let rows = rows[first..].first_chunk();
        rows.expect("two rows more were taken")
    };
    [from(0), from(1), from(2)]
}

/// Applies `rule` to the used blocks of `plane`. `next` is scratch memory on the same ground.
pub(crate) fn step(rule: impl Rule, plane: &mut Strips, next: &mut Strips) {
    if next.shape != plane.shape || next.used != plane.used {
        next.resize(&plane.shape);
        next.used.copy_from(&plane.used);
    }
    apply(rule, plane, &plane.used, next);
    std::mem::swap(plane, next);
}

/// Applies `rule` to the blocks `over` of `from` and writes the result to `to`. In all other
/// blocks, the two must be equal.
fn apply<R: Rule>(rule: R, from: &Strips, over: &Blocks, to: &mut Strips) {
    let shape = &from.shape;
    lariat_portable::Arch::new().dispatch(Apply {
        rule,
        shape,
        from: &from.words,
        over,
        to: &mut to.words,
    });
}

/// Arguments of [`apply`], which is compiled for each kind of machine.
struct Apply<'a, R> {
    rule: R,
    shape: &'a Shape,
    from: &'a [u64],
    over: &'a Blocks,
    to: &'a mut [u64],
}

impl<R: Rule> lariat_portable::NullaryFnOnce for Apply<'_, R> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let shape = self.shape;
        for (at, count) in self.over.runs(shape) {
            let (strip, y) = shape.place(at);
            let inside = shape.inside(strip);
            for at in (at..at + count).step_by(BLOCK) {
                let mut new = apply_to_block(&self.rule, self.from, at, shape.stride);
                for word in &mut new {
                    *word &= inside;
                }
                *block_mut(self.to, at) = new;
            }
            // The last block extends below the picture.
            let beyond = (y + count).saturating_sub(shape.height());
            self.to[at + count - beyond..][..beyond].fill(0);
        }
    }
}

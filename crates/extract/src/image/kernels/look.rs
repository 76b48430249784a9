//! Where some rows are not just the table: a plain loop, of which the compiler makes vectors for any registers.

use super::Look;
use lariat_portable::{Arch, Simd, WithSimd};

/// Bytes that are looked at together: what comes from memory at once.
const LANES: usize = 64;

/// See [`Look`].
pub(super) fn look(look: Look) {
    Arch::new().dispatch(look);
}

impl WithSimd for Look<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let strip = 64 * self.bytes;
        let side = Self::SIDE * self.bytes;
        let (even, odd) = (self.least[0], self.least[1]);
        let least: [u8; LANES] = std::array::from_fn(|k| if k % 2 == 0 { even } else { odd });
        let rows = Rows {
            bytes: self.rows,
            stride: self.stride,
            table: self.table,
            least,
        };
        for (k, hit) in self.hits.iter_mut().enumerate() {
            let (from, to) = (strip * k, (strip * (k + 1)).min(self.row));
            let mut off = [0; 64 * 3];
            for (x, off) in (from..to).step_by(LANES).zip(off.as_chunks_mut().0) {
                *off = if x + LANES <= to {
                    rows.far(x, |bytes| *bytes.first_chunk().unwrap_or(&[0; LANES]))
                } else {
                    rows.far(x, |bytes| some(&bytes[..to - x]))
                };
            }
            let off = &off[..strip];
            let any = |off: &[u8]| off.iter().fold(0, |any, off| any | off);
            let [left, right] = [&off[..side], &off[strip - side..]].map(any);
            *hit = (any(off) & Self::ANY) + (left & Self::LEFT) + (right & Self::RIGHT);
        }
    }
}

/// What is looked at, of [`Look`], with how far off each lane's byte has to be.
struct Rows<'a> {
    bytes: &'a [u8],
    stride: usize,
    table: &'a [u8],
    least: [u8; LANES],
}

impl Rows<'_> {
    /// Which bytes from `x` on are far off the table in any row: all ones where they are.
    ///
    /// The table is the same for all rows: the largest and the smallest of each column of bytes tell.
    #[inline(always)]
    fn far(&self, x: usize, load: impl Fn(&[u8]) -> [u8; LANES]) -> [u8; LANES] {
        let [mut most, mut fewest] = [[0; LANES], [u8::MAX; LANES]];
        for row in self.bytes[x..].chunks(self.stride) {
            let bytes = load(row);
            for k in 0..LANES {
                most[k] = bytes[k].max(most[k]);
                fewest[k] = bytes[k].min(fewest[k]);
            }
        }
        let table = load(&self.table[x..]);
        std::array::from_fn(|k| {
            let above = most[k].saturating_sub(table[k]);
            let below = table[k].saturating_sub(fewest[k]);
            let is_far = above.max(below) >= self.least[k];
            if is_far { u8::MAX } else { 0 }
        })
    }
}

/// Fewer bytes, and zeros.
#[inline(always)]
fn some(bytes: &[u8]) -> [u8; LANES] {
    let mut padded = [0; LANES];
    padded[..bytes.len()].copy_from_slice(bytes);
    padded
}

//! Searches rows for anything other than the table. A plain loop, which the compiler vectorizes for
//! any registers.

use super::{BLOCK, Rows};
use lariat_portable::{Arch, Simd, WithSimd};

/// Runs a [`Rows`].
pub(super) fn look(look: Rows) {
    Arch::new().dispatch(look);
}

impl WithSimd for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        match self.bytes {
            1 => run::<64>(self),
            2 => run::<128>(self),
            _ => run::<192>(self),
        }
    }
}

/// Searches strips of `N` bytes per row.
#[inline(always)]
fn run<const N: usize>(look: Rows) {
    let mut least = [0; N];
    least.as_chunks_mut().0.fill(look.least);
    // Repeat the last row if there are fewer rows.
    let last = (look.rows.len() - look.row) / look.stride;
    let mut rows = [&look.rows[..look.row]; BLOCK];
    for (k, row) in rows.iter_mut().enumerate() {
        *row = &look.rows[look.stride * last.min(k)..][..look.row];
    }
    for (k, hit) in look.hits.iter_mut().enumerate() {
        let from = N * k;
        let off = if from + N <= look.row {
            far_off(&rows, &look.table[from..from + N], from, &least)
        } else {
            // A `map` over all rows, here or in `far_off`, would not be compiled for the machine's
            // registers.
            let mut padded = [[0; N]; BLOCK + 1];
            let all = rows.iter().chain([&look.table]);
            for (padded, bytes) in padded.iter_mut().zip(all) {
                let width = look.row - from;
                padded[..width].copy_from_slice(&bytes[from..look.row]);
            }
            let [rows @ .., table] = &padded;
            let mut slices = [&rows[0][..]; BLOCK];
            for (slice, row) in slices.iter_mut().zip(rows) {
                *slice = row;
            }
            far_off(&slices, table, 0, &least)
        };
        *hit = 0;
        if is_any(&off) {
            let side = Rows::SIDE * N / 64;
            let flag = |off: &[u8], flag: u8| if is_any(off) { flag } else { 0 };
            let sides = flag(&off[..side], Rows::LEFT) + flag(&off[N - side..], Rows::RIGHT);
            *hit = Rows::ANY + sides;
        }
    }
}

/// Returns, for each byte of a strip, all ones if it is far from the table in any row.
///
/// The table is the same for all rows, so the maximum and minimum of each column of bytes suffice.
#[inline(always)]
fn far_off<const N: usize>(
    rows: &[&[u8]; BLOCK],
    table: &[u8],
    from: usize,
    least: &[u8; N],
) -> [u8; N] {
    let [a, b, c, d, e, f, g, h] = *rows;
    let [a, b, c, d] = [a, b, c, d].map(|row| &row[from..from + N]);
    let [e, f, g, h] = [e, f, g, h].map(|row| &row[from..from + N]);
    let mut off = [0; N];
    for k in 0..N {
        let most = a[k].max(b[k]).max(c[k].max(d[k]));
        let most = most.max(e[k].max(f[k]).max(g[k].max(h[k])));
        let fewest = a[k].min(b[k]).min(c[k].min(d[k]));
        let fewest = fewest.min(e[k].min(f[k]).min(g[k].min(h[k])));
        let above = most.saturating_sub(table[k]);
        let below = table[k].saturating_sub(fewest);
        off[k] = if above.max(below) >= least[k] {
            u8::MAX
        } else {
            0
        };
    }
    off
}

/// Returns whether any byte is not 0. The number of bytes is a multiple of eight.
#[inline(always)]
fn is_any(off: &[u8]) -> bool {
    let mut any = 0;
    for bytes in off.as_chunks().0 {
        any |= u64::from_ne_bytes(*bytes);
    }
    any != 0
}

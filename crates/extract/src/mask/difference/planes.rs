//! Difference of a row in the formats whose bytes need no sorting: one channel, or U and V next to
//! Y.
//!
//! These are plain loops over blocks of 64 pixels, compiled for the widest registers that the
//! machine has. The end of a row, and a row of less than a block, are processed pixel by pixel.

use lariat_portable::{Arch, Simd, WithSimd};

const BLOCK: usize = 64;

/// Writes the difference between each byte of `row` and that of `table` to `out`.
pub(super) fn gray(row: &[u8], table: &[u8], out: &mut [u8]) {
    Arch::new().dispatch(Gray { row, table, out });
}

/// Writes the largest difference among Y, U and V to `out`, for two pixels in Y₀ U Y₁ V.
pub(super) fn yuyv(row: &[u8], table: &[u8], out: &mut [u8]) {
    Arch::new().dispatch(Pairs::<0> { row, table, out });
}

/// As [`yuyv`], for two pixels in U Y₀ V Y₁.
pub(super) fn uyvy(row: &[u8], table: &[u8], out: &mut [u8]) {
    Arch::new().dispatch(Pairs::<1> { row, table, out });
}

/// As [`yuyv`], for Y in one row and U V pairs in another.
pub(super) fn nv12(row: [&[u8]; 2], table: [&[u8]; 2], out: &mut [u8]) {
    Arch::new().dispatch(Nv12 { row, table, out });
}

struct Gray<'a> {
    row: &'a [u8],
    table: &'a [u8],
    out: &'a mut [u8],
}

impl WithSimd for Gray<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((d, &p), &t) in self.out.iter_mut().zip(self.row).zip(self.table) {
            *d = p.abs_diff(t);
        }
    }
}

/// Two pixels in four bytes. `LIGHT` is the place of the first Y: 0 or 1.
struct Pairs<'a, const LIGHT: usize> {
    row: &'a [u8],
    table: &'a [u8],
    out: &'a mut [u8],
}

impl<const LIGHT: usize> WithSimd for Pairs<'_, LIGHT> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let blocks = self.row.as_chunks::<{ 2 * BLOCK }>().0.iter();
        let blocks = blocks.zip(self.table.as_chunks::<{ 2 * BLOCK }>().0);
        let (out, last) = self.out.as_chunks_mut::<BLOCK>();
        let mut done = 0;
        for (out, (row, table)) in out.iter_mut().zip(blocks) {
            let (mut light, mut color) = ([0u8; BLOCK], [0u8; BLOCK]);
            for k in 0..BLOCK {
                let [y, c] = [2 * k + LIGHT, 2 * k + 1 - LIGHT];
                light[k] = row[y].abs_diff(table[y]);
                color[k] = twice(row[c], table[c]);
            }
            for k in 0..BLOCK {
                out[k] = light[k].max(color[k].max(color[k ^ 1]));
            }
            done += 2 * BLOCK;
        }
        plain_pairs::<LIGHT>(&self.row[done..], &self.table[done..], last);
    }
}

struct Nv12<'a> {
    row: [&'a [u8]; 2],
    table: [&'a [u8]; 2],
    out: &'a mut [u8],
}

impl WithSimd for Nv12<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [light, color] = self.row;
        let [light_table, color_table] = self.table;
        let (out, last) = self.out.as_chunks_mut::<BLOCK>();
        let blocks = light.as_chunks::<BLOCK>().0.iter();
        let blocks = blocks.zip(color.as_chunks::<BLOCK>().0);
        let tables = light_table.as_chunks::<BLOCK>().0.iter();
        let tables = tables.zip(color_table.as_chunks::<BLOCK>().0);
        let mut done = 0;
        for ((out, (light, color)), (light_table, color_table)) in
            out.iter_mut().zip(blocks).zip(tables)
        {
            let mut colors = [0u8; BLOCK];
            for k in 0..BLOCK {
                colors[k] = twice(color[k], color_table[k]);
            }
            for k in 0..BLOCK {
                let light = light[k].abs_diff(light_table[k]);
                out[k] = light.max(colors[k].max(colors[k ^ 1]));
            }
            done += BLOCK;
        }
        plain_nv12(
            [&light[done..], &color[done..]],
            [&light_table[done..], &color_table[done..]],
            last,
        );
    }
}

#[inline(always)]
fn twice(p: u8, t: u8) -> u8 {
    let off = p.abs_diff(t);
    off.saturating_add(off)
}

#[inline(always)]
fn plain_pairs<const LIGHT: usize>(row: &[u8], table: &[u8], out: &mut [u8]) {
    let pixels = row.chunks_exact(4).zip(table.chunks_exact(4));
    for (d, (p, t)) in out.chunks_mut(2).zip(pixels) {
        let light = |k: usize| p[2 * k + LIGHT].abs_diff(t[2 * k + LIGHT]);
        let color = [1 - LIGHT, 3 - LIGHT].map(|c| twice(p[c], t[c]));
        let color = color[0].max(color[1]);
        d[0] = light(0).max(color);
        if let Some(second) = d.get_mut(1) {
            *second = light(1).max(color);
        }
    }
}

#[inline(always)]
fn plain_nv12([row, uv]: [&[u8]; 2], [light, chroma]: [&[u8]; 2], out: &mut [u8]) {
    let colors = uv.chunks_exact(2).zip(chroma.chunks_exact(2));
    let lights = row.chunks_exact(2).zip(light.chunks_exact(2));
    for ((d, (p, t)), (c, k)) in out.chunks_mut(2).zip(lights).zip(colors) {
        let color = twice(c[0], k[0]).max(twice(c[1], k[1]));
        d[0] = p[0].abs_diff(t[0]).max(color);
        if let Some(second) = d.get_mut(1) {
            *second = p[1].abs_diff(t[1]).max(color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A row, its table, and the number of its pixels to compare.
    fn rows(bytes_a_pair: usize) -> impl Strategy<Value = (Vec<u8>, Vec<u8>, usize)> {
        (1..300usize).prop_flat_map(move |pixels| {
            let bytes = pixels.div_ceil(2) * bytes_a_pair;
            let row = || prop::collection::vec(any::<u8>(), bytes);
            // The table is laid in whole blocks and extends past the row.
            let table = prop::collection::vec(any::<u8>(), bytes.next_multiple_of(256));
            (row(), table, Just(pixels))
        })
    }

    proptest! {
        #[test]
        fn rows_of_pairs_differ_as_the_plain_loop_says((row, table, pixels) in rows(4)) {
            let (mut found, mut expected) = (vec![0; pixels], vec![0; pixels]);
            yuyv(&row, &table, &mut found);
            plain_pairs::<0>(&row, &table, &mut expected);
            prop_assert_eq!(&found, &expected);
            uyvy(&row, &table, &mut found);
            plain_pairs::<1>(&row, &table, &mut expected);
            prop_assert_eq!(&found, &expected);
        }

        #[test]
        fn rows_of_nv12_differ_as_the_plain_loop_says(
            (row, table, pixels) in rows(2), (uv, chroma, other) in rows(2),
        ) {
            let pixels = pixels.min(other);
            let (mut found, mut expected) = (vec![0; pixels], vec![0; pixels]);
            nv12([&row, &uv], [&table, &chroma], &mut found);
            plain_nv12([&row, &uv], [&table, &chroma], &mut expected);
            prop_assert_eq!(found, expected);
        }
    }
}

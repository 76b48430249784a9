//! Differences from the table along a chord, for sixteen pixels of a row or a column at a time.
//!
//! A chord has a few dozen pixels. Down a column, each is in a cache line of its own, so loading
//! them is the main cost. With AVX-512, they are gathered into one register ([`x86`]). Otherwise
//! plain loops do it, which define the result.

#[cfg(target_arch = "x86_64")]
mod x86;

use crate::image::{Image, PixelFormat};
use crate::mask::difference::Differencer;

/// Maximum number of pixels read at once: a word of bits.
pub(super) const WORD: usize = 64;
/// Number of pixels read together.
pub(super) const BLOCK: usize = 16;

/// Consecutive pixels along a row or down a column, all inside the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch<'a> {
    pub(super) image: &'a Image<'a>,
    /// The first pixel. Its coordinate along the stretch is even, as two pixels share their color
    /// in some formats.
    pub(super) from: [usize; 2],
    /// 0 along a row, 1 down a column.
    pub(super) axis: usize,
    /// Number of pixels, a multiple of [`BLOCK`] and at most [`WORD`].
    pub(super) count: usize,
    /// Color of the table in whole levels, as the bytes of a word, for each block of a row. A
    /// column has a single one.
    pub(super) tables: [u32; WORD / BLOCK],
    /// Minimum difference that is rope.
    pub(super) cut: u8,
}

/// A method of reading stretches.
pub(super) trait Lanes: Copy {
    /// Writes the difference of each pixel from the table. Returns a bit for each, set if it is
    /// rope.
    fn read(self, stretch: &Stretch, out: &mut [u8; WORD]) -> u64;

    /// Sum of the differences from the first index to just before the second, which must not be
    /// smaller.
    fn sum(self, differences: &[u8; WORD], from_to: [u32; 2]) -> u32;
}

/// Work on stretches. It is one function, so that all of it is compiled for the same registers.
pub(super) trait Work {
    fn run<L: Lanes>(self, lanes: L);
}

/// Runs the work with the widest registers of this machine.
pub(super) fn dispatch<W: Work>(work: W) {
    #[cfg(target_arch = "x86_64")]
    if let Some(wide) = x86::Wide::detect() {
        return wide.dispatch(work);
    }
    struct Op<W>(W);
    impl<W: Work> lariat_portable::NullaryFnOnce for Op<W> {
        type Output = ();
        #[inline(always)]
        fn call(self) {
            self.0.run(Plain);
        }
    }
    lariat_portable::Arch::new().dispatch(Op(work));
}

/// The portable version, for registers of unknown width.
#[derive(Clone, Copy, Debug)]
struct Plain;

impl Lanes for Plain {
    #[inline(always)]
    fn read(self, stretch: &Stretch, out: &mut [u8; WORD]) -> u64 {
        let out = &mut out[..stretch.count];
        if stretch.axis == 0 {
            across(stretch, out);
        } else {
            Differencer::down(stretch.image, levels(stretch.tables[0]), stretch.from, out);
        }
        let mut set = 0;
        for (k, block) in out.as_chunks::<BLOCK>().0.iter().enumerate() {
            let bits = (block.iter().enumerate())
                .fold(0, |bits, (i, &d)| bits | u64::from(d >= stretch.cut) << i);
            set |= bits << (BLOCK * k);
        }
        set
    }

    #[inline(always)]
    fn sum(self, differences: &[u8; WORD], [from, to]: [u32; 2]) -> u32 {
        (differences.iter().zip(0u32..))
            .map(|(&d, i)| if (from..to).contains(&i) { d.into() } else { 0 })
            .sum()
    }
}

/// The three bytes of a color.
#[inline(always)]
fn levels(word: u32) -> [u8; 3] {
    let [a, b, c, _] = word.to_le_bytes();
    [a, b, c]
}

/// Differences along a row.
#[inline(always)]
fn across(stretch: &Stretch, out: &mut [u8]) {
    let (image, [x, y]) = (stretch.image, stretch.from);
    let row = image.row(y);
    for (k, out) in out.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
        let ([a, b, c], x) = (levels(stretch.tables[k]), x + BLOCK * k);
        let pairs = out.as_chunks_mut::<2>().0.iter_mut();
        match image.format() {
            PixelFormat::Gray8 => {
                for (d, &p) in out.iter_mut().zip(&row[x..]) {
                    *d = p.abs_diff(a);
                }
            }
            PixelFormat::Rgb8 => triples(&row[3 * x..], [a, b, c], out),
            PixelFormat::Bgr8 => triples(&row[3 * x..], [c, b, a], out),
            PixelFormat::Yuyv => {
                for (d, &[first, u, second, v]) in pairs.zip(row[2 * x..].as_chunks().0) {
                    *d = pair([first, second], [u, v], [a, b, c]);
                }
            }
            PixelFormat::Uyvy => {
                for (d, &[u, first, v, second]) in pairs.zip(row[2 * x..].as_chunks().0) {
                    *d = pair([first, second], [u, v], [a, b, c]);
                }
            }
            PixelFormat::Nv12 => {
                let light = row[x..].as_chunks().0;
                let color = image.chroma_row(y)[x..].as_chunks().0;
                for (d, (&light, &color)) in pairs.zip(light.iter().zip(color)) {
                    *d = pair(light, color, [a, b, c]);
                }
            }
            // Other formats are unpacked earlier.
            _ => {}
        }
    }
}

/// Differences of pixels of three bytes.
#[inline(always)]
fn triples(row: &[u8], [a, b, c]: [u8; 3], out: &mut [u8; BLOCK]) {
    for (d, &[p, q, r]) in out.iter_mut().zip(row.as_chunks().0) {
        *d = p.abs_diff(a).max(q.abs_diff(b)).max(r.abs_diff(c));
    }
}

/// Differences of two pixels that share their U and V, which count double.
#[inline(always)]
fn pair(light: [u8; 2], [u, v]: [u8; 2], [a, b, c]: [u8; 3]) -> [u8; 2] {
    let color = u.abs_diff(b).max(v.abs_diff(c)).saturating_mul(2);
    [
        light[0].abs_diff(a).max(color),
        light[1].abs_diff(a).max(color),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::color;
    use proptest::prelude::*;

    /// The differences and bits of a stretch, and the sum over a part of it.
    type Found = (Vec<u8>, u64, u32);

    struct SumStretch<'a> {
        stretch: Stretch<'a>,
        part: [u32; 2],
        found: &'a mut Found,
    }

    impl Work for SumStretch<'_> {
        fn run<L: Lanes>(self, lanes: L) {
            let mut out = [0; WORD];
            let set = lanes.read(&self.stretch, &mut out);
            let sum = lanes.sum(&out, self.part);
            *self.found = (out[..self.stretch.count].to_vec(), set, sum);
        }
    }

    proptest! {
        #[test]
        fn stretches_read_as_the_plain_loops_say(
            bytes in prop::collection::vec(any::<u8>(), 20_000),
            format in prop::sample::select(&PixelFormat::DIRECT[..]),
            size in (17..80usize, 17..80usize), padding in 0..9usize,
            axis in 0..2usize, blocks in 1..=4usize, place in (any::<u16>(), any::<u16>()),
            tables: [[u8; 3]; 4], cut in 1..=255u8, part in (0..=16u32, 0..=16u32),
        ) {
            let (width, height) = size;
            let bytes_a_row = match format {
                PixelFormat::Gray8 => width,
                PixelFormat::Nv12 => width.next_multiple_of(2),
                PixelFormat::Yuyv | PixelFormat::Uyvy => 2 * width.next_multiple_of(2),
                _ => 3 * width,
            };
            let stride = bytes_a_row + padding;
            let rows = if format == PixelFormat::Nv12 { height + height.div_ceil(2) } else { height };
            // Exactly the bytes that the image needs, so that its end is within the reach of a
            // register.
            let bytes = &bytes[..stride * (rows - 1) + bytes_a_row];
            let image = Image::new(bytes, width, height, stride, format).expect("a whole image");
            let side = [width, height][axis];
            let count = (BLOCK * blocks).min(side / BLOCK * BLOCK);
            let mut from = [usize::from(place.0) % width, usize::from(place.1) % height];
            from[axis] = (from[axis] % (side - count + 1)) & !1;
            // For gray, the color is one value repeated three times.
            let gray = format == PixelFormat::Gray8;
            let tables = tables.map(|[a, b, c]| if gray { [a; 3] } else { [a, b, c] });
            let tables = tables.map(|[a, b, c]| u32::from_le_bytes([a, b, c, 0]));
            let tables = if axis == 0 { tables } else { [tables[0]; 4] };
            let stretch = Stretch { image: &image, from, axis, count, tables, cut };
            let (mut expected, mut found) = (Found::default(), Found::default());
            let part = [part.0.min(part.1), part.0.max(part.1)];
            SumStretch { stretch, part, found: &mut expected }.run(Plain);
            dispatch(SumStretch { stretch, part, found: &mut found });
            prop_assert_eq!(&found, &expected);
            for (k, &difference) in found.0.iter().enumerate() {
                let mut at = from;
                at[axis] += k;
                let (pixel, table) = (color::native(&image, at[0], at[1]), levels(tables[k / BLOCK]));
                let [pixel, table] = [pixel, table].map(|color| color.map(f32::from));
                let yuv = color::is_yuv(format);
                let exact = color::distance(pixel, table, yuv).min(255.0);
                prop_assert_eq!(f32::from(difference), exact);
            }
        }
    }
}

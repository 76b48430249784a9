//! Repeats one level per block of pixels in the byte order of the image.

use super::BLOCK;
use crate::image::PixelFormat;

/// Repeats each channel's level for each block. Writes bytes in the order of the first plane of
/// `format` to `luma`, and of the second to `chroma`.
pub(super) fn spread(
    format: PixelFormat,
    [a, b, c]: [&[u8]; 3],
    luma: &mut [u8],
    chroma: &mut [u8],
) {
    let colors = a.iter().zip(b).zip(c).map(|((&a, &b), &c)| [a, b, c]);
    match format {
        PixelFormat::Gray8 => fill(colors, luma, |[a, _, _]| [a; BLOCK]),
        PixelFormat::Rgb8 => fill(colors, luma, triples),
        PixelFormat::Bgr8 => fill(colors, luma, |[r, g, b]| triples([b, g, r])),
        PixelFormat::Yuyv => fill(colors, luma, |[y, u, v]| {
            repeated::<{ 2 * BLOCK }>([y, u, y, v])
        }),
        PixelFormat::Uyvy => fill(colors, luma, |[y, u, v]| {
            repeated::<{ 2 * BLOCK }>([u, y, v, y])
        }),
        PixelFormat::Nv12 => {
            fill(colors.clone(), luma, |[y, _, _]| [y; BLOCK]);
            fill(colors, chroma, |[_, u, v]| repeated::<BLOCK>([u, v, u, v]));
        }
        // Other formats were unpacked earlier.
        _ => {}
    }
}

/// Fills `out` with the bytes of each block.
#[inline(always)]
fn fill<const N: usize>(
    colors: impl Iterator<Item = [u8; 3]>,
    out: &mut [u8],
    bytes: impl Fn([u8; 3]) -> [u8; N],
) {
    for (out, color) in out.as_chunks_mut::<N>().0.iter_mut().zip(colors) {
        *out = bytes(color);
    }
}

/// Repeats three bytes eight times, built as three words.
#[inline(always)]
fn triples([a, b, c]: [u8; 3]) -> [u8; 3 * BLOCK] {
    let v = u64::from_le_bytes([a, b, c, 0, 0, 0, 0, 0]);
    let words = [
        v | v << 24 | v << 48,
        v >> 16 | v << 8 | v << 32 | v << 56,
        v >> 8 | v << 16 | v << 40,
    ];
    let mut bytes = [0; 3 * BLOCK];
    for (bytes, word) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(words) {
        *bytes = word.to_le_bytes();
    }
    bytes
}

/// Repeats four bytes, built as words.
#[inline(always)]
fn repeated<const N: usize>(four: [u8; 4]) -> [u8; N] {
    let word = u64::from(u32::from_le_bytes(four)) * 0x1_0000_0001;
    let mut bytes = [0; N];
    for bytes in bytes.as_chunks_mut::<8>().0 {
        *bytes = word.to_le_bytes();
    }
    bytes
}

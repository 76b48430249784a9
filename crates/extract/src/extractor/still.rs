//! Recognizes an image with the same pixels as the last one, such as a file that is shown for a
//! while. The result is then also the same.
//!
//! Camera noise shows in the first samples, so this check costs next to nothing in a film. The
//! image is only hashed if all samples agree, and after a full extraction, which reads every pixel
//! anyway.

use crate::image::{Image, PixelFormat};

/// Number of samples along each side of the image.
const SIDE: usize = 16;
/// Number of words hashed side by side, so that no multiplication waits for the one before.
const LANES: usize = 8;
/// The constants of FNV-1a (Fowler, Noll, Vo) of 64 bits.
const OFFSET: u64 = 0xCBF2_9CE4_8422_2325;
const PRIME: u64 = 0x0100_0000_01B3;

/// The part of the last image with which the next one is compared.
#[derive(Debug, Default)]
pub(super) struct Still {
    layout: Option<(usize, usize, PixelFormat)>,
    samples: Vec<u8>,
    /// The hash of all pixels, if the image was hashed.
    hash: Option<u64>,
}

/// Result of comparing an image with the last one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Comparison {
    /// True if the pixels are known to be the same.
    pub(super) is_same: bool,
    hash: Option<u64>,
}

impl Still {
    /// Forgets the last image, so that the next one is different.
    pub(super) fn forget(&mut self) {
        self.layout = None;
    }

    /// Compares an image with the last one.
    pub(super) fn compare(&self, image: &Image) -> Comparison {
        if layout(image) != self.layout || !self.samples.iter().copied().eq(samples(image)) {
            return Comparison::default();
        }
        let hash = Some(hash(image));
        Comparison {
            is_same: hash == self.hash,
            hash,
        }
    }

    /// Stores this image, which was compared before, as the last one. It is hashed after a full
    /// extraction.
    pub(super) fn remember(&mut self, image: &Image, compared: Comparison, is_full: bool) {
        self.layout = layout(image);
        self.samples.clear();
        self.samples.extend(samples(image));
        self.hash = compared.hash.or_else(|| is_full.then(|| hash(image)));
    }
}

fn layout(image: &Image) -> Option<(usize, usize, PixelFormat)> {
    Some((image.width(), image.height(), image.format()))
}

/// Bytes from all over the image.
fn samples(image: &Image) -> impl Iterator<Item = u8> {
    let height = image.height();
    (0..SIDE).flat_map(move |i| {
        let row = image.row((2 * i + 1) * height / (2 * SIDE));
        (0..SIDE).map(move |k| row[(2 * k + 1) * row.len() / (2 * SIDE)])
    })
}

/// A hash of all pixels, without the padding between rows: lanes of FNV-1a with 64-bit words. Each
/// lane is rotated so that no bit is lost at the upper end.
fn hash(image: &Image) -> u64 {
    let mut lanes = [OFFSET; LANES];
    (0..image.height()).for_each(|y| add(&mut lanes, image.row(y)));
    if image.format() == PixelFormat::Nv12 {
        let rows = (0..image.height()).step_by(2);
        rows.for_each(|y| add(&mut lanes, image.chroma_row(y)));
    }
    lanes.iter().fold(OFFSET, |hash, &lane| mixed(hash, lane))
}

fn add(lanes: &mut [u64; LANES], row: &[u8]) {
    let (blocks, rest) = row.as_chunks::<{ 8 * LANES }>();
    let mut last = [0; 8 * LANES];
    last[..rest.len()].copy_from_slice(rest);
    for block in blocks.iter().chain([&last]) {
        let words = block.as_chunks::<8>().0;
        for (lane, word) in lanes.iter_mut().zip(words) {
            *lane = mixed(*lane, u64::from_le_bytes(*word));
        }
    }
}

#[inline(always)]
fn mixed(lane: u64, word: u64) -> u64 {
    (lane ^ word).wrapping_mul(PRIME).rotate_left(29)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [70, 40];

    fn is_again(still: &mut Still, pixels: &[u8]) -> bool {
        let image = Image::new(pixels, SIZE[0], SIZE[1], 3 * SIZE[0], PixelFormat::Rgb8).unwrap();
        let compared = still.compare(&image);
        still.remember(&image, compared, true);
        compared.is_same
    }

    #[test]
    fn only_the_same_pixels_are_the_same_image() {
        let mut still = Still::default();
        let mut pixels: Vec<u8> = (0..3 * SIZE[0] * SIZE[1])
            .map(|i| (i * i % 251) as u8)
            .collect();
        assert!(!is_again(&mut still, &pixels));
        assert!(is_again(&mut still, &pixels));
        for at in [0, 1, 3 * SIZE[0] * SIZE[1] / 2, 3 * SIZE[0] * SIZE[1] - 1] {
            pixels[at] ^= 0x80;
            assert!(!is_again(&mut still, &pixels), "{at}");
            assert!(is_again(&mut still, &pixels), "{at}");
        }
        still.forget();
        assert!(!is_again(&mut still, &pixels));
    }

    #[test]
    fn bytes_between_the_rows_do_not_count() {
        let mut still = Still::default();
        let mut bytes = vec![7; 80 * SIZE[1]];
        for (round, is_expected) in [(0, false), (1, true)] {
            bytes[75] = round;
            let image = Image::new(&bytes, SIZE[0], SIZE[1], 80, PixelFormat::Gray8).unwrap();
            let compared = still.compare(&image);
            assert_eq!(compared.is_same, is_expected);
            still.remember(&image, compared, true);
        }
    }
}

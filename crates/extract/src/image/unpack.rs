//! Converts pictures in formats that the steps do not read, once per image: `Bgra8` and the Bayer
//! patterns to `Rgb8`, `Gray16` to `Gray8`.
//!
//! A Bayer pattern is filled in bilinearly. Each color that a pixel lacks is the mean of its
//! nearest samples, two next to it or four around it. These surround the pixel evenly, so edges
//! stay where they are. The other simple way, one pixel per 2 × 2 samples, moves each color by half
//! a pixel or more, each in another direction.
//!
//! Sharpening by the other colors' slopes (Malvar, He and Cutler 2004) overshoots next to edges.
//! With it, followed ropes were nearer to the truth, but sometimes lost up to 4 px at their ends.
//!
//! [`color::native`](crate::image::color::native) defines the result, pixel by pixel.

use super::kernels::Kernels;
use super::{Image, PixelFormat};
use lariat_portable::Arch;

/// Memory for an image.
#[derive(Debug, Default)]
pub(crate) struct Unpacker {
    kernels: Kernels,
    pixels: Vec<u8>,
    /// A row as blue, green, red and an unused byte.
    row: Vec<[u8; 4]>,
}

impl Unpacker {
    /// Returns the image as the steps read it: unchanged if they read its format.
    pub(crate) fn unpack<'a>(&'a mut self, image: &'a Image<'a>) -> Image<'a> {
        let (width, height) = (image.width(), image.height());
        let format = match image.format() {
            PixelFormat::Gray16 => PixelFormat::Gray8,
            PixelFormat::Bgra8 => PixelFormat::Rgb8,
            format if format.red().is_some() => PixelFormat::Rgb8,
            _ => return *image,
        };
        let stride = format.row_bytes(width);
        self.pixels.resize(stride * height, 0);
        for (y, out) in self.pixels.chunks_exact_mut(stride).enumerate() {
            match (image.format(), image.format().red()) {
                (_, Some(red)) => {
                    self.row.resize(width, [0; 4]);
                    fill_in(image, red, y, &mut self.row);
                    (self.kernels.pack)(&self.row, out);
                }
                (PixelFormat::Bgra8, _) => {
                    (self.kernels.pack)(image.row(y).as_chunks().0, out);
                }
                _ => Arch::new().dispatch(|| levels(image.row(y), out)),
            }
        }
        Image::new(&self.pixels, width, height, stride, format).unwrap_or(*image)
    }
}

/// Nearest of 256 levels to one of 65,536: 65535 becomes 255.
#[inline(always)]
pub(crate) fn level(two: [u8; 2]) -> u8 {
    // Divides by 257 and rounds, without a division.
    ((u32::from(u16::from_ne_bytes(two)) * 255 + 32_895) >> 16) as u8
}

#[inline(always)]
fn levels(row: &[u8], out: &mut [u8]) {
    for (out, two) in out.iter_mut().zip(row.as_chunks().0) {
        *out = level(*two);
    }
}

/// Distance to the samples that a pixel of a Bayer pattern takes its colors from, in pixels.
const REACH: usize = 1;

/// A pixel of a Bayer pattern as red, green and blue. Past its edges, the picture is mirrored about
/// the outermost pixels, which continues the pattern.
pub(crate) fn demosaiced(image: &Image, x: usize, y: usize) -> [u8; 3] {
    let columns = around(x, image.width());
    let rows = around(y, image.height()).map(|y| columns.map(|x| image.row(y)[x]));
    let [red_x, red_y] = image.format().red().unwrap_or_default();
    let in_red_row = y % 2 == red_y;
    let is_green = (x % 2 == red_x) != in_red_row;
    let [first, green, second] = mixed(rows, is_green);
    if in_red_row {
        [first, green, second]
    } else {
        [second, green, first]
    }
}

/// Positions around `at` on a side of `side` pixels, mirrored at both ends.
fn around(at: usize, side: usize) -> [usize; 2 * REACH + 1] {
    let last = side as isize - 1;
    std::array::from_fn(|k| {
        let place = (at + k) as isize - REACH as isize;
        // A side of one pixel has nothing to mirror.
        (last - (last - place.abs()).abs()).clamp(0, last) as usize
    })
}

/// Colors of the middle one of nine samples. The first is the color that shares the row with green,
/// the second is green, and then comes the third color.
fn mixed([above, own, below]: [[u8; 3]; 3], is_green: bool) -> [u8; 3] {
    if is_green {
        [two(own[0], own[2]), own[1], two(above[1], below[1])]
    } else {
        let sides = four(own[0], own[2], above[1], below[1]);
        let corners = four(above[0], above[2], below[0], below[2]);
        [own[1], sides, corners]
    }
}

/// The mean of two.
#[inline(always)]
fn two(a: u8, b: u8) -> u8 {
    ((u16::from(a) + u16::from(b) + 1) >> 1) as u8
}

/// The mean of four.
#[inline(always)]
fn four(a: u8, b: u8, c: u8, d: u8) -> u8 {
    ((u16::from(a) + u16::from(b) + u16::from(c) + u16::from(d) + 2) >> 2) as u8
}

/// Fills in a row in blocks. The last block is moved back, to end one or two pixels before the
/// row's end. The outermost pixels are filled in one by one.
fn fill_in(image: &Image, [red_x, red_y]: [usize; 2], y: usize, out: &mut [[u8; 4]]) {
    let width = out.len();
    let alone = |x: usize| {
        let [r, g, b] = demosaiced(image, x, y);
        [b, g, r, 0]
    };
    let inner = width.saturating_sub(2 * REACH);
    if inner < BLOCK {
        (0..width).for_each(|x| out[x] = alone(x));
        return;
    }
    for x in [0, width - 2, width - 1] {
        out[x] = alone(x);
    }
    let rows = around(y, image.height()).map(|y| image.row(y));
    let in_red_row = y % 2 == red_y;
    // Blocks begin at odd columns.
    let first_is_green = (red_x == 1) != in_red_row;
    let last = (inner - BLOCK) & !1;
    Arch::new().dispatch(|| {
        for from in (0..last).step_by(BLOCK).chain([last]) {
            let Some(out) = out[REACH + from..].first_chunk_mut() else {
                return;
            };
            fill_block(rows, from, first_is_green, in_red_row, out);
        }
    });
}

/// Pixels that are filled in together.
const BLOCK: usize = 64;

/// Masks with all bits set in the first of every two pixels, and in the second.
const EVERY_OTHER: [[u8; BLOCK]; 2] = {
    let mut masks = [[0; BLOCK]; 2];
    let mut k = 0;
    while k < BLOCK {
        masks[k % 2][k] = 0xFF;
        k += 1;
    }
    masks
};

/// Fills in the pixels of the middle row from `from + 1` on. Computes all means for all pixels,
/// then selects those that each pixel needs.
///
/// These are loops over plain arrays, without closures or calls, because compilers vectorize such
/// loops.
#[inline(always)]
fn fill_block(
    [above, own, below]: [&[u8]; 3],
    from: usize,
    first_is_green: bool,
    in_red_row: bool,
    out: &mut [[u8; 4]; BLOCK],
) {
    let above = &above[from..][..BLOCK + 2];
    let own = &own[from..][..BLOCK + 2];
    let below = &below[from..][..BLOCK + 2];
    let (mut beside, mut over) = ([0; BLOCK], [0; BLOCK]);
    let (mut sides, mut corners) = ([0; BLOCK], [0; BLOCK]);
    for k in 0..BLOCK {
        beside[k] = two(own[k], own[k + 2]);
    }
    for k in 0..BLOCK {
        over[k] = two(above[k + 1], below[k + 1]);
    }
    for k in 0..BLOCK {
        sides[k] = four(own[k], own[k + 2], above[k + 1], below[k + 1]);
    }
    for k in 0..BLOCK {
        corners[k] = four(above[k], above[k + 2], below[k], below[k + 2]);
    }
    let is_green = &EVERY_OTHER[usize::from(!first_is_green)];
    let (mut first, mut green, mut second) = ([0; BLOCK], [0; BLOCK], [0; BLOCK]);
    for k in 0..BLOCK {
        let (own, is) = (own[k + 1], is_green[k]);
        first[k] = beside[k] & is | own & !is;
        green[k] = own & is | sides[k] & !is;
        second[k] = over[k] & is | corners[k] & !is;
    }
    let (red, blue) = match in_red_row {
        true => (&first, &second),
        false => (&second, &first),
    };
    for k in 0..BLOCK {
        let pixel = u32::from(blue[k]) | u32::from(green[k]) << 8 | u32::from(red[k]) << 16;
        out[k] = pixel.to_le_bytes();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::color;
    use proptest::prelude::*;

    const FORMATS: [PixelFormat; 6] = [
        PixelFormat::Bgra8,
        PixelFormat::Gray16,
        PixelFormat::BayerRggb8,
        PixelFormat::BayerBggr8,
        PixelFormat::BayerGrbg8,
        PixelFormat::BayerGbrg8,
    ];

    #[test]
    fn a_level_of_65536_is_the_nearest_of_256() {
        for wide in 0..=u16::MAX {
            let nearest = (f64::from(wide) / 257.0).round() as u8;
            assert_eq!(level(wide.to_ne_bytes()), nearest);
        }
    }

    proptest! {
        #[test]
        fn an_unpacked_image_has_the_pixels_that_it_is_made_of(
            bytes in prop::collection::vec(any::<u8>(), 8000), format in prop::sample::select(&FORMATS[..]),
            width in 1..150usize, height in 1..12usize, gap in 0..9usize,
        ) {
            let stride = format.row_bytes(width) + gap;
            let image = Image::new(&bytes, width, height, stride, format).expect("a whole image");
            let mut unpacker = Unpacker::default();
            let unpacked = unpacker.unpack(&image);
            prop_assert_ne!(unpacked.format(), format);
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                prop_assert_eq!(color::native(&unpacked, x, y), color::native(&image, x, y), "{} {}", x, y);
            }
        }

        /// On an even slope of brightness, the means are exact: no color is displaced.
        #[test]
        fn a_slope_behind_a_mosaic_is_the_slope(steps in prop::array::uniform2(0..6usize), place in 2..7usize) {
            let (width, height) = (12, 10);
            let level = |x: usize, y: usize| (2 * steps[0] * x + 2 * steps[1] * y) as u8;
            let bytes: Vec<u8> = (0..height).flat_map(|y| (0..width).map(move |x| level(x, y))).collect();
            for format in &FORMATS[2..] {
                let image = Image::new(&bytes, width, height, width, *format).expect("whole");
                prop_assert_eq!(color::native(&image, place, place), [level(place, place); 3]);
            }
        }
    }
}

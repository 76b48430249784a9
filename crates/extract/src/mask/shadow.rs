//! Finds pixels that may be the table in shadow: darker than the table there, and of its color.
//!
//! A shadow takes the same share of the light from every channel. The pixel is therefore the
//! table's color times a number below one (Horprasert, Harwood and Davis, "A statistical approach
//! for real-time robust background subtraction and shadow detection", 1999). A gray rope on a gray
//! table passes this test too, as does anything darker in an image without color.
//!
//! The pixels in question are scattered along the ropes' edges. They are gathered, and judged in
//! the widest registers.

use super::background::Background;
use crate::bitmap::bits::BitPlane;
use crate::image::{Image, PixelFormat, color};

/// Minimum share of the table's light that a shadow leaves. Anything darker is an object.
pub(crate) const DARKEST: f32 = 0.3;
/// Maximum deviation of a channel from the shaded table's: a multiple of the table's noise, and at
/// least this many levels.
const NOISES: f32 = 3.0;
const LEVELS: f32 = 6.0;
/// Pixels that are judged at once, and words that are searched at once.
const LANES: usize = 64;
const WORDS: usize = 8;
/// Words that are collected before their pixels are gathered.
const MOST_WORDS: usize = 128;

/// Clears pixels of `faint` that may be shadow and are not in `sure`, and sets those in `sure`. A
/// shadow leaves at least the share `darkest` of the light.
pub(crate) fn clear(
    image: &Image,
    background: &Background,
    darkest: f32,
    faint: &mut BitPlane,
    sure: &BitPlane,
) {
    let tolerance = (NOISES * background.noise).max(LEVELS);
    let clear = Clear {
        background,
        faint,
        sure,
        yuv: color::is_yuv(image.format()),
        darkest,
        tolerance,
        pixel: |x: usize, y: usize| color::native(image, x, y),
    };
    let arch = lariat_portable::Arch::new();
    match image.format() {
        PixelFormat::Rgb8 => arch.dispatch(clear.with(|x, y| three(image, x, y))),
        PixelFormat::Bgr8 => arch.dispatch(clear.with(|x, y| {
            let [b, g, r] = three(image, x, y);
            [r, g, b]
        })),
        _ => arch.dispatch(clear),
    }
}

/// The three bytes of a pixel.
#[inline(always)]
fn three(image: &Image, x: usize, y: usize) -> [u8; 3] {
    let bytes = image.bytes_from(3 * x, y);
    [bytes[0], bytes[1], bytes[2]]
}

/// The clearing, compiled for each kind of machine. `pixel` reads one pixel.
struct Clear<'a, P> {
    background: &'a Background,
    faint: &'a mut BitPlane,
    sure: &'a BitPlane,
    yuv: bool,
    darkest: f32,
    tolerance: f32,
    pixel: P,
}

impl<'a, P> Clear<'a, P> {
    fn with<Q: Fn(usize, usize) -> [u8; 3]>(self, pixel: Q) -> Clear<'a, Q> {
        Clear {
            background: self.background,
            faint: self.faint,
            sure: self.sure,
            yuv: self.yuv,
            darkest: self.darkest,
            tolerance: self.tolerance,
            pixel,
        }
    }
}

impl<P: Fn(usize, usize) -> [u8; 3]> lariat_portable::NullaryFnOnce for Clear<'_, P> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let (mut asked, mut gathered) = (Asked::default(), Gathered::default());
        let all = self.faint.words().len();
        for from in (0..all).step_by(WORDS) {
            let to = (from + WORDS).min(all);
            let (faint, sure) = (
                &mut self.faint.words_mut()[from..to],
                &self.sure.words()[from..to],
            );
            let mut own = [0; WORDS];
            if let (Some(faint), Some(sure)) = (
                faint.first_chunk_mut::<WORDS>(),
                sure.first_chunk::<WORDS>(),
            ) {
                for k in 0..WORDS {
                    own[k] = faint[k] & !sure[k];
                    faint[k] |= sure[k];
                }
            } else {
                for (own, (faint, sure)) in own.iter_mut().zip(faint.iter_mut().zip(sure)) {
                    *own = *faint & !sure;
                    *faint |= sure;
                }
            }
            if own != [0; WORDS] {
                asked.add(from as u32, own);
                if asked.is_full() {
                    self.gather(&mut asked, &mut gathered);
                }
            }
        }
        self.gather(&mut asked, &mut gathered);
        self.judge(&mut gathered);
    }
}

impl<P: Fn(usize, usize) -> [u8; 3]> Clear<'_, P> {
    /// Gathers the pixels of the collected words, judges them whenever they fill the lanes, and
    /// forgets the words.
    #[inline(always)]
    fn gather(&mut self, asked: &mut Asked, gathered: &mut Gathered) {
        let words_per_row = self.faint.words_per_row() as u64;
        // Division by a small number. It is exact below 2³² / words_per_row, which is beyond the
        // largest image.
        let inverse = (1u64 << 32).div_ceil(words_per_row);
        let words = &asked.words[..asked.count];
        let pixels: u32 = words.iter().map(|(word, _)| word.count_ones()).sum();
        let (mut i, (mut word, mut at)) = (0, asked.words[0]);
        for _ in 0..pixels {
            let bit = word.trailing_zeros();
            word &= word - 1;
            let y = (u64::from(at) * inverse) >> 32;
            let strip = u64::from(at) - y * words_per_row;
            let [x, y] = [64 * strip + u64::from(bit), y].map(|place| place as usize);
            if gathered.push(at, [x, y], (self.pixel)(x, y)) {
                self.judge(gathered);
            }
            // The number of pixels in a word is random, so a branch on it would be mispredicted.
            i += usize::from(word == 0);
            let next = asked.words[i % MOST_WORDS];
            (word, at) = (if word == 0 { next.0 } else { word }, next.1);
        }
        asked.count = 0;
    }

    /// Clears the gathered pixels that are shade, and forgets all gathered pixels.
    #[inline(always)]
    fn judge(&mut self, gathered: &mut Gathered) {
        let limits = (self.darkest, self.tolerance);
        let shade = if self.yuv {
            gathered.shade::<true>(self.background, limits)
        } else {
            gathered.shade::<false>(self.background, limits)
        };
        let words = self.faint.words_mut();
        let places = gathered.words.iter().zip(&gathered.x);
        for ((&at, x), shade) in places.zip(shade).take(gathered.count) {
            words[at as usize] &= !(u64::from(shade) << (x % 64));
        }
        gathered.count = 0;
    }
}

/// Words with pixels to judge, and their indices.
struct Asked {
    count: usize,
    words: [(u64, u32); MOST_WORDS],
}

impl Default for Asked {
    fn default() -> Self {
        Self {
            count: 0,
            words: [(0, 0); MOST_WORDS],
        }
    }
}

impl Asked {
    /// Adds the words, from index `from` on, in which anything is set.
    #[inline(always)]
    fn add(&mut self, from: u32, words: [u64; WORDS]) {
        for (at, word) in (from..).zip(words) {
            // Always written, but kept only if any bit is set. This is random, so a branch on it
            // would be mispredicted.
            self.words[self.count % MOST_WORDS] = (word, at);
            self.count += usize::from(word != 0);
        }
    }

    /// Returns true if there is not enough room for `WORDS` more and one after them.
    #[inline(always)]
    fn is_full(&self) -> bool {
        self.count + WORDS >= MOST_WORDS
    }
}

/// Some pixels that may be shade.
struct Gathered {
    count: usize,
    /// For each pixel, the index of its word, its position, and its channels, one byte each.
    words: [u32; LANES],
    x: [u32; LANES],
    y: [u32; LANES],
    colors: [u32; LANES],
}

impl Default for Gathered {
    fn default() -> Self {
        Self {
            count: 0,
            words: [0; LANES],
            x: [0; LANES],
            y: [0; LANES],
            colors: [0; LANES],
        }
    }
}

impl Gathered {
    /// Adds a pixel. Returns true if this was the last that fits.
    #[inline(always)]
    fn push(&mut self, word: u32, [x, y]: [usize; 2], [a, b, c]: [u8; 3]) -> bool {
        let i = self.count % LANES;
        self.words[i] = word;
        (self.x[i], self.y[i]) = (x as u32, y as u32);
        self.colors[i] = u32::from_le_bytes([a, b, c, 0]);
        self.count = i + 1;
        self.count == LANES
    }

    /// Returns which of the pixels are the table in less light.
    #[inline(always)]
    fn shade<const YUV: bool>(&self, background: &Background, limits: (f32, f32)) -> [u32; LANES] {
        let mut shade = [0; LANES];
        for (i, shade) in shade.iter_mut().enumerate() {
            let table = background.at_place([self.x[i] as f32, self.y[i] as f32]);
            let level = |c: u32| (self.colors[i] >> (8 * c) & 0xFF) as f32;
            let is_shade = is_shade::<YUV>([level(0), level(1), level(2)], table, limits);
            *shade = u32::from(is_shade);
        }
        shade
    }
}

/// Returns whether `pixel` is `table` in less light.
#[inline(always)]
fn is_shade<const YUV: bool>(
    pixel: [f32; 3],
    table: [f32; 3],
    (darkest, tolerance): (f32, f32),
) -> bool {
    let (own, all, off) = light::<YUV>(pixel, table);
    (own < all) & (own >= darkest * all) & (off <= tolerance)
}

/// Light of a pixel, light of the table there, and the pixel's distance in levels from the table at
/// the pixel's light.
#[inline(always)]
fn light<const YUV: bool>(pixel: [f32; 3], table: [f32; 3]) -> (f32, f32, f32) {
    let light = |[a, b, c]: [f32; 3]| if YUV { a } else { a + b + c };
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    let (own, all) = (light(pixel), larger(light(table), 1.0));
    let share = own / all;
    // U and V are measured from their middle and count double, as in `color::distance`.
    let (zero, weight) = if YUV { (128.0, 2.0) } else { (0.0, 1.0) };
    let off = |c: usize, zero: f32| (pixel[c] - (zero + share * (table[c] - zero))).abs();
    let far = larger(off(0, 0.0), weight * larger(off(1, zero), off(2, zero)));
    (own, all, far)
}

/// Share of the table's light that is left in pixel (x, y); `None` if the pixel does not have the
/// table's color.
pub(crate) fn light_left(
    image: &Image,
    background: &Background,
    [x, y]: [usize; 2],
) -> Option<f32> {
    let pixel = color::native(image, x, y).map(f32::from);
    let table = background.at(x, y);
    let (own, all, off) = match color::is_yuv(image.format()) {
        true => light::<true>(pixel, table),
        false => light::<false>(pixel, table),
    };
    (off <= (NOISES * background.noise).max(LEVELS)).then_some(own / all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn half_the_light_is_shade_and_another_color_is_not() {
        let table = [200.0, 190.0, 170.0];
        assert!(is_shade::<false>(
            [100.0, 95.0, 85.0],
            table,
            (DARKEST, 6.0)
        ));
        assert!(!is_shade::<false>(
            [100.0, 120.0, 85.0],
            table,
            (DARKEST, 6.0)
        ));
        assert!(!is_shade::<false>(
            [240.0, 228.0, 204.0],
            table,
            (DARKEST, 6.0)
        ));
        assert!(!is_shade::<false>(
            [20.0, 19.0, 17.0],
            table,
            (DARKEST, 6.0)
        ));
    }

    #[test]
    fn shade_takes_from_the_chroma_too() {
        let table = [180.0, 148.0, 118.0];
        assert!(is_shade::<true>(
            [90.0, 138.0, 123.0],
            table,
            (DARKEST, 6.0)
        ));
        assert!(!is_shade::<true>(
            [90.0, 148.0, 118.0],
            table,
            (DARKEST, 6.0)
        ));
    }

    /// Definition of `is_shade`, one pixel at a time.
    fn is_shade_plain(pixel: [f32; 3], table: [f32; 3], yuv: bool, tolerance: f32) -> bool {
        let light = |color: [f32; 3]| if yuv { color[0] } else { color.iter().sum() };
        let (own, all) = (light(pixel), light(table).max(1.0));
        if own >= all || own < DARKEST * all {
            return false;
        }
        let share = own / all;
        let zero = if yuv { [0.0, 128.0, 128.0] } else { [0.0; 3] };
        let shaded = std::array::from_fn(|c| zero[c] + share * (table[c] - zero[c]));
        color::distance(pixel, shaded, yuv) <= tolerance
    }

    proptest! {
        #[test]
        fn pixels_are_judged_as_one_by_one(
            width in 1usize..150, height in 1usize..12, seed: u64, density in 0u32..3,
        ) {
            use PixelFormat::*;
            let mut state = seed | 1;
            let mut next = move || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                state >> 33
            };
            let bytes: Vec<u8> = (0..4 * (width + 1) * 2 * height).map(|_| 90 + next() as u8 % 64).collect();
            let (mut faint, mut sure) = <(BitPlane, BitPlane)>::default();
            for plane in [&mut faint, &mut sure] {
                plane.resize(width, height);
                for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    plane.fill(y, x, x + 1, next() % (1 << (2 * density)) == 0);
                }
            }
            for format in [Gray8, Rgb8, Bgr8, Yuyv, Uyvy, Nv12] {
                let image = Image::new(&bytes, width, height, 4 * (width + 1), format).expect("whole");
                let mut background = Background::default();
                background.estimate(&image);
                let yuv = color::is_yuv(format);
                let tolerance = (NOISES * background.noise).max(LEVELS);
                let mut cleared = faint.clone();
                clear(&image, &background, DARKEST, &mut cleared, &sure);
                for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    let pixel = color::native(&image, x, y).map(f32::from);
                    let table = background.at(x, y);
                    let stays = sure.get(x as i32, y as i32) || faint.get(x as i32, y as i32)
                        && !is_shade_plain(pixel, table, yuv, tolerance);
                    prop_assert_eq!(cleared.get(x as i32, y as i32), stays, "{:?} {} {}", format, x, y);
                }
            }
        }
    }
}

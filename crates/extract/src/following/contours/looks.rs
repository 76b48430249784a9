//! Distance of a pixel's color from a rope's.
//!
//! A rope is round, shaded and twisted, and shows one color at many brightnesses. These lie along
//! one direction of the color space. In that direction, a difference counts less, depending on the
//! spread of the rope's own colors. A pixel's distance is the largest of three differences: in that
//! direction and in two others perpendicular to it. The measure is linear, so a pixel that is half
//! ground is half as far away as the ground.

use super::edge::WINDOW;
use crate::image::{Image, PixelFormat, color};

/// Spread, in levels, up to which a difference counts in full.
const SPREAD: f32 = 8.0;
/// Minimum weight of a difference.
const LEAST: f32 = 0.5;
/// Rounds of power iteration. Neighboring spreads with a ratio of at most nine tenths are separated
/// to a tenth.
const ROUNDS: usize = 16;
/// Fixed-point units per level, for integer sums.
const PARTS: f32 = 64.0;

/// Directions of the color space. The length of each is the weight of a difference along it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Looks {
    weights: [[i32; 3]; 3],
    /// Minimum distance of a pixel that is not the rope's.
    pub(super) strange: f32,
}

/// Color of the rope at a place, along these directions.
pub(super) type Middle = [i32; 3];

impl Looks {
    /// Directions for a rope whose colors differ by `offs` from their mean nearby.
    pub(super) fn of(offs: &[[f32; 3]], format: PixelFormat) -> Self {
        let chroma = color::chroma_weight(format);
        let scale = [1.0, chroma, chroma];
        let mut spread = [[0.0f32; 3]; 3];
        for off in offs {
            let off: [f32; 3] = std::array::from_fn(|c| scale[c] * off[c]);
            for (row, a) in spread.iter_mut().zip(off) {
                (row.iter_mut().zip(off)).for_each(|(sum, b)| *sum += a * b);
            }
        }
        let count = offs.len().max(1) as f32;
        let times = |v: [f32; 3]| -> [f32; 3] { spread.map(|row| dot(row, v) / count) };
        // Without other information, light varies along gray.
        let mut first = unit([1.0, 1.0 / chroma, 1.0 / chroma]).unwrap_or([1.0, 0.0, 0.0]);
        for _ in 0..ROUNDS {
            first = unit(times(first)).unwrap_or(first);
        }
        let least = (0..3).min_by(|&a, &b| first[a].abs().total_cmp(&first[b].abs()));
        let mut second = [0.0; 3];
        second[least.unwrap_or(0)] = 1.0;
        let along = dot(first, second);
        let second = unit(std::array::from_fn(|c| second[c] - along * first[c])).unwrap_or(second);
        let third = std::array::from_fn(|c| {
            let (d, e) = ((c + 1) % 3, (c + 2) % 3);
            first[d] * second[e] - first[e] * second[d]
        });
        let weights = [first, second, third].map(|axis| {
            let spread = dot(axis, times(axis)).max(0.0).sqrt();
            let counts = (SPREAD / spread.max(SPREAD)).max(LEAST);
            std::array::from_fn(|c| (PARTS * counts * axis[c] * scale[c]).round() as i32)
        });
        Self {
            weights,
            strange: 255.0,
        }
    }

    pub(super) fn middle(&self, color: [f32; 3]) -> Middle {
        (self.weights).map(|w| dot(w.map(|w| w as f32), color).round() as i32)
    }

    /// Distance of a color from the rope's at a place, in levels.
    pub(super) fn distance(&self, color: [f32; 3], middle: &Middle) -> f32 {
        let offs =
            self.weights.iter().zip(middle).map(|(w, &middle)| {
                (dot(w.map(|w| w as f32), color) - middle as f32).abs() / PARTS
            });
        offs.fold(0.0, f32::max)
    }

    /// Distance of each pixel of a window.
    #[inline(always)]
    pub(super) fn distances(&self, pixels: &[u32; WINDOW], middle: &Middle) -> [u8; WINDOW] {
        let mut all = [0i32; WINDOW];
        for axis in 0..3 {
            let ([a, b, c], middle) = (self.weights[axis], middle[axis]);
            for i in 0..WINDOW {
                let pixel = pixels[i];
                let [first, second, third] = [pixel & 0xFF, pixel >> 8 & 0xFF, pixel >> 16 & 0xFF];
                let sum = a * first as i32 + b * second as i32 + c * third as i32;
                let off = (sum - middle).abs();
                all[i] = if off > all[i] { off } else { all[i] };
            }
        }
        let mut levels = [0; WINDOW];
        for i in 0..WINDOW {
            let level = all[i] / PARTS as i32;
            levels[i] = if level < 255 { level as u8 } else { 255 };
        }
        levels
    }
}

/// Pixels of a window from a position on, along a row (axis 0) or down a column. All of them must
/// be inside the image.
#[inline(always)]
pub(super) fn pixels(image: &Image, from: [usize; 2], axis: usize) -> [u32; WINDOW] {
    let format = image.format();
    if matches!(format, PixelFormat::Rgb8 | PixelFormat::Bgr8)
        && let Some(words) = triples(image, from, axis)
    {
        return words;
    }
    let mut words = [0; WINDOW];
    if axis == 1 {
        color::down(image, from, WINDOW, |k, [a, b, c]| {
            words[k] = u32::from_le_bytes([a, b, c, 0]);
        });
        return words;
    }
    let [x, y] = from;
    if format == PixelFormat::Gray8 {
        for (word, &level) in words.iter_mut().zip(&image.row(y)[x..]) {
            *word = u32::from(level) * 0x0001_0101;
        }
    } else {
        let places: [usize; WINDOW] = std::array::from_fn(|k| x + k);
        color::at_places(image, y, places.iter().copied(), &mut words);
    }
    words
}

/// Same for three bytes per pixel. `None` if the fourth byte read would be outside of the image.
#[inline(always)]
fn triples(image: &Image, [x, y]: [usize; 2], axis: usize) -> Option<[u32; WINDOW]> {
    let step = if axis == 0 { 3 } else { image.stride() };
    let start = y * image.stride() + 3 * x;
    let bytes = image.bytes().get(start..)?.get(..(WINDOW - 1) * step + 4)?;
    let mut words = [0; WINDOW];
    for (k, word) in words.iter_mut().enumerate() {
        *word = u32::from_le_bytes(*bytes[k * step..].first_chunk()?);
    }
    let is_bgr = image.format() == PixelFormat::Bgr8;
    for word in &mut words {
        *word = if is_bgr {
            word.swap_bytes() >> 8
        } else {
            *word
        };
    }
    Some(words)
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let length = dot(v, v).sqrt();
    (length > 1e-6).then(|| v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn half_ground_is_half_as_far(rope: [u8; 3], ground: [u8; 3], light in 0.1f32..0.5) {
            let offs: Vec<_> = (-4..=4).map(|k| rope.map(|c| f32::from(c) * light * 0.25 * k as f32)).collect();
            let looks = Looks::of(&offs, PixelFormat::Rgb8);
            let [rope, ground] = [rope, ground].map(|color| color.map(f32::from));
            let middle = looks.middle(rope);
            let half = [0, 1, 2].map(|c| 0.5 * (rope[c] + ground[c]));
            let (near, far) = (looks.distance(half, &middle), looks.distance(ground, &middle));
            prop_assert!((2.0 * near - far).abs() < 0.1, "{near} {far}");
        }
    }

    #[test]
    fn another_light_counts_half_and_another_color_in_full() {
        let blue = [40.0, 90.0, 190.0];
        let offs: Vec<_> = (-4..=4).map(|k| blue.map(|c| 0.1 * c * k as f32)).collect();
        let looks = Looks::of(&offs, PixelFormat::Rgb8);
        let middle = looks.middle(blue);
        let far = |color: [f32; 3]| {
            let off: [f32; 3] = std::array::from_fn(|c| color[c] - blue[c]);
            looks.distance(color, &middle) / dot(off, off).sqrt()
        };
        let (darker, greener) = (far(blue.map(|c| 0.6 * c)), far([40.0, 160.0, 190.0]));
        assert!(darker < 0.51 && greener > 0.9, "{darker} {greener}");
    }
}

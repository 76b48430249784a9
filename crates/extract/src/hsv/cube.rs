//! The answer for every color there is: one bit for each of 256³ colors of the camera's own color space, so that a pixel
//! costs one look, whatever the ranges are and however a camera encodes its colors.
//!
//! Before it stand three small tables that a register holds: the colors are told apart into eight bands, and of each
//! channel's level, in steps of eight, it is known in which bands it occurs. A pixel whose three levels have no band in
//! common is none of the colors: most of a table's pixels, 64 at a time.

use crate::{HsvRange, color};

/// The steps of a channel that the bands are known by.
pub(super) const STEPS: usize = 32;
/// Levels in a step.
const STEP: usize = 256 / STEPS;
const BANDS: usize = 8;
/// Words of 64 colors that differ in the third channel only.
const ROW: usize = 256 / 64;

/// Which colors lie in some ranges.
#[derive(Debug, Default)]
pub(super) struct Cube {
    /// Bit `256 · (256 · c₀ + c₁) + c₂`.
    words: Vec<u64>,
    /// The bands, one bit each, of each channel's steps.
    pub(super) bands: [[u8; STEPS]; 3],
    ranges: Vec<HsvRange>,
    yuv: bool,
}

impl Cube {
    /// Whether it holds these ranges, in this color space.
    pub(super) fn is_of(&self, ranges: &[HsvRange], yuv: bool) -> bool {
        !self.words.is_empty() && self.yuv == yuv && self.ranges == ranges
    }

    /// Finds the answers.
    pub(super) fn fill(&mut self, ranges: &[HsvRange], yuv: bool) {
        self.yuv = yuv;
        self.ranges.clear();
        self.ranges.extend_from_slice(ranges);
        self.bands = [[0; STEPS]; 3];
        self.words.clear();
        self.words.resize(256 * 256 * ROW, 0);
        for (r, range) in ranges.iter().enumerate() {
            let banding = Banding::new(range, r, ranges.len());
            pulp::Arch::new().dispatch(Fill {
                words: &mut self.words,
                bands: &mut self.bands,
                range,
                yuv,
                banding: &banding,
            });
        }
    }

    /// The bits, unless there are none yet.
    #[cfg(target_arch = "x86_64")]
    pub(super) fn words(&self) -> Option<&[u64; 256 * 256 * ROW]> {
        self.words.as_slice().try_into().ok()
    }

    /// Whether a color lies in the ranges.
    #[inline(always)]
    pub(super) fn holds(&self, [a, b, c]: [u8; 3]) -> bool {
        let word = (usize::from(a) << 8 | usize::from(b)) * ROW + usize::from(c >> 6);
        self.words[word] >> (c & 63) & 1 == 1
    }

    /// The bands that the three levels of a color have in common: none, and it is not in the ranges.
    #[cfg(test)]
    fn common_bands(&self, color: [u8; 3]) -> u8 {
        let band = |c: usize| self.bands[c][usize::from(color[c]) / STEP];
        band(0) & band(1) & band(2)
    }
}

/// How the colors of one of several ranges are told apart into bands: each range has its own as long as they last, and
/// parts them by value, so that of each channel a band spans little.
struct Banding {
    first: usize,
    count: usize,
    low: f32,
    per_level: f32,
}

impl Banding {
    fn new(range: &HsvRange, number: usize, of: usize) -> Self {
        let count = (BANDS / of).max(1);
        let [low, high] = range.value.map(|value| 255.0 * value);
        Self {
            first: number * count % BANDS,
            count,
            low,
            per_level: count as f32 / (high - low + 1.0),
        }
    }

    /// The band, as a bit, of a color of this value (0 to 255).
    fn of(&self, value: u8) -> u8 {
        let part = ((f32::from(value) - self.low) * self.per_level) as usize;
        1 << (self.first + part.min(self.count - 1))
    }
}

/// What is done for one range. No closure: one as long as this would not be compiled for the wider registers.
struct Fill<'a> {
    words: &'a mut [u64],
    bands: &'a mut [[u8; STEPS]; 3],
    range: &'a HsvRange,
    yuv: bool,
    banding: &'a Banding,
}

impl pulp::NullaryFnOnce for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut row = Row::default();
        for (i, words) in self.words.chunks_exact_mut(ROW).enumerate() {
            let (a, b) = ((i / 256) as u8, (i % 256) as u8);
            row.color(a, b, self.yuv);
            if !row.judge(self.range) {
                continue;
            }
            for (c, _) in row.is_in.iter().enumerate().filter(|&(_, &is)| is != 0) {
                words[c / 64] |= 1 << (c % 64);
                let band = self.banding.of(row.value[c] as u8);
                for (bands, level) in self.bands.iter_mut().zip([a.into(), b.into(), c]) {
                    bands[level / STEP] |= band;
                }
            }
        }
    }
}

/// The colors of one first and one second channel.
struct Row {
    red: [f32; 256],
    green: [f32; 256],
    blue: [f32; 256],
    /// The largest of the three, 0 to 255.
    value: [f32; 256],
    is_in: [u32; 256],
}

impl Default for Row {
    fn default() -> Self {
        let zeros = [0.0; 256];
        Self {
            red: zeros,
            green: zeros,
            blue: zeros,
            value: zeros,
            is_in: [0; 256],
        }
    }
}

impl Row {
    /// Takes the colors of these two channels.
    #[inline(always)]
    fn color(&mut self, a: u8, b: u8, yuv: bool) {
        let (red, green, blue) = (&mut self.red, &mut self.green, &mut self.blue);
        let places = red.iter_mut().zip(green).zip(blue).enumerate();
        for (c, ((red, green), blue)) in places {
            let native = [a, b, c as u8];
            let rgb = if yuv {
                color::yuv_to_rgb(native)
            } else {
                native
            };
            [*red, *green, *blue] = rgb.map(f32::from);
        }
    }

    /// Which of the colors lie in the range; whether any does. The sums of [`super::contains`], in its order, without
    /// its branches: to the last bit the same.
    #[inline(always)]
    fn judge(&mut self, range: &HsvRange) -> bool {
        let ([from, to], saturations, values) = (range.hue_deg, range.saturation, range.value);
        let wraps = from > to;
        let mut any = 0;
        let colors = (self.red.iter().zip(&self.green)).zip(&self.blue);
        let answers = self.value.iter_mut().zip(&mut self.is_in);
        for (((&red, &green), &blue), (most, is_in)) in colors.zip(answers) {
            *most = larger(larger(red, green), blue);
            let (r, g, b) = (red / 255.0, green / 255.0, blue / 255.0);
            let value = larger(larger(r, g), b);
            let chroma = value - smaller(smaller(r, g), b);
            let (is_red, is_green) = (value == r, value == g);
            let apart = pick(is_red, g - b, pick(is_green, b - r, r - g)) / chroma;
            let turned = pick(apart < 0.0, 6.0, 0.0);
            let sextant = apart + pick(is_red, turned, pick(is_green, 2.0, 4.0));
            let gray = chroma == 0.0;
            let hue = pick(gray, 0.0, 60.0 * sextant);
            let saturation = pick(gray, 0.0, chroma / value);
            let (above, below) = (hue >= from, hue <= to);
            let fits = (above & below) | (wraps & (above | below));
            let within = |[low, high]: [f32; 2], v: f32| (low <= v) & (v <= high);
            *is_in = u32::from(fits & within(saturations, saturation) & within(values, value));
            any |= *is_in;
        }
        any != 0
    }
}

#[inline(always)]
fn pick(which: bool, a: f32, b: f32) -> f32 {
    if which { a } else { b }
}

/// `f32::max` of numbers that are none of them NaN: one instruction.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{contains, hsv};
    use super::*;
    use proptest::prelude::*;

    /// Ranges whose bounds often are the very numbers that colors have.
    pub(in super::super) fn range() -> impl Strategy<Value = HsvRange> {
        let bounds = |limit: f32| {
            let free = 0.0..=limit;
            let color = (any::<[u8; 3]>(), 0..3usize).prop_map(move |(rgb, which)| {
                let (hue, saturation, value) = hsv(rgb);
                let own = [hue, saturation, value][which];
                own.min(limit)
            });
            let whole = (0..=12u8).prop_map(move |part| limit * f32::from(part) / 12.0);
            let bound = prop_oneof![free, color, whole];
            (bound.clone(), bound).prop_map(|(a, b)| [a, b])
        };
        (bounds(360.0), bounds(1.0), bounds(1.0)).prop_map(|(hue_deg, saturation, value)| {
            let sorted = |[a, b]: [f32; 2]| [a.min(b), a.max(b)];
            HsvRange {
                hue_deg,
                saturation: sorted(saturation),
                value: sorted(value),
            }
        })
    }

    fn rgb_of(native: [u8; 3], yuv: bool) -> [u8; 3] {
        if yuv {
            color::yuv_to_rgb(native)
        } else {
            native
        }
    }

    proptest! {
        #[test]
        fn a_row_of_colors_is_judged_as_color_by_color(
            range in range(), a: u8, b: u8, yuv: bool,
        ) {
            let mut row = Row::default();
            pulp::Arch::new().dispatch(|| {
                row.color(a, b, yuv);
                row.judge(&range)
            });
            for c in 0..=255u8 {
                let rgb = rgb_of([a, b, c], yuv);
                prop_assert_eq!(row.is_in[usize::from(c)] == 1, contains(&[range], rgb), "{:?}", rgb);
            }
        }
    }

    /// Ranges as they are picked, one that wraps and one of grays; bounds on numbers that many colors have.
    pub(in super::super) fn examples() -> [Vec<HsvRange>; 3] {
        let range = |hue_deg, saturation, value| HsvRange {
            hue_deg,
            saturation,
            value,
        };
        [
            vec![range([200.0, 240.0], [0.4, 1.0], [0.25, 0.8])],
            vec![
                range([330.0, 30.0], [0.5, 1.0], [0.2, 1.0]),
                range([60.0, 120.0], [0.25, 0.75], [0.0, 0.6]),
                range([0.0, 360.0], [0.0, 0.1], [0.8, 1.0]),
            ],
            vec![range([0.0, 360.0], [0.0, 1.0], [0.0, 1.0]); 9],
        ]
    }

    fn check(ranges: &[HsvRange], yuv: bool, step: usize) {
        let mut cube = Cube::default();
        cube.fill(ranges, yuv);
        assert!(cube.is_of(ranges, yuv) && !cube.is_of(ranges, !yuv));
        for i in (0..1usize << 24).step_by(step) {
            let color = [(i >> 16) as u8, (i >> 8) as u8, i as u8];
            let is_in = contains(ranges, rgb_of(color, yuv));
            assert_eq!(cube.holds(color), is_in, "{color:?}, {yuv}");
            assert!(!is_in || cube.common_bands(color) != 0, "{color:?}, {yuv}");
        }
    }

    #[test]
    fn the_cube_holds_what_the_ranges_contain() {
        // A prime, so that all levels of all channels come up.
        for ranges in &examples()[..2] {
            check(ranges, false, 101);
            check(ranges, true, 101);
        }
    }

    #[test]
    #[ignore = "every color of every example: half a minute when optimized"]
    fn the_cube_holds_exactly_what_the_ranges_contain() {
        for ranges in examples() {
            check(&ranges, false, 1);
            check(&ranges, true, 1);
        }
    }
}

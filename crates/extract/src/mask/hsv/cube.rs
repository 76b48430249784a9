//! Answers for all colors: one bit for each of the 256³ colors of the camera's own color space. A
//! pixel then costs one lookup, whatever the ranges are and however a camera encodes its colors.
//!
//! Three small tables are consulted first, each held by one register. The colors are divided into
//! eight bands. For each channel's level, in steps of eight, a table lists the bands in which it
//! occurs. If no band is common to all three levels of a pixel, it cannot have any of the colors.
//! This is so for most of a table's pixels, and 64 are tested at a time. For red, green and blue,
//! which all vary with the light, the ranges' [outlines](Outline) tell more.

use super::outline::Outline;
use crate::options::HsvRange;

/// Number of steps into which the tables of bands divide a channel.
pub(super) const STEPS: usize = 32;
/// Levels in a step.
const STEP: usize = 256 / STEPS;
pub(super) const BANDS: usize = 8;
/// Number of words for the colors that differ only in the third channel, 64 to a word.
const ROW: usize = 256 / 64;
/// Levels of the third channel that are tested at once, and levels of the other channels along a
/// box of colors. The colors of a box are first tested together: most boxes are inside or outside a
/// range as a whole.
const LANES: usize = 16;
const SIDE: usize = 4;

type Lanes = [f32; LANES];

/// The set of colors in some ranges.
#[derive(Debug, Default)]
pub(super) struct Cube {
    /// Color (c₀, c₁, c₂) is bit `256 · (256 · c₀ + c₁) + c₂`.
    words: Vec<u64>,
    /// Bands of each channel's steps, one bit per band.
    pub(super) bands: [[u8; STEPS]; 3],
    /// Outlines of the ranges. Empty if the colors are YUV, or if there are more ranges than are
    /// tested one by one.
    pub(super) outlines: Vec<Outline>,
    ranges: Vec<HsvRange>,
    yuv: bool,
}

impl Cube {
    /// Returns whether the cube holds the answers for these ranges in this color space.
    pub(super) fn is_of(&self, ranges: &[HsvRange], yuv: bool) -> bool {
        !self.words.is_empty() && self.yuv == yuv && self.ranges == ranges
    }

    /// Computes the answers.
    pub(super) fn fill(&mut self, ranges: &[HsvRange], yuv: bool) {
        self.yuv = yuv;
        self.ranges.clear();
        self.ranges.extend_from_slice(ranges);
        self.bands = [[0; STEPS]; 3];
        self.outlines.clear();
        if !yuv && ranges.len() <= BANDS {
            self.outlines.extend(ranges.iter().map(Outline::of));
        }
        self.words.clear();
        self.words.resize(256 * 256 * ROW, 0);
        for (r, range) in ranges.iter().enumerate() {
            let banding = Banding::new(range, r, ranges.len());
            lariat_portable::Arch::new().dispatch(Fill {
                words: &mut self.words,
                bands: &mut self.bands,
                range,
                yuv,
                banding: &banding,
            });
        }
    }

    /// The bits; `None` before they are computed.
    #[cfg(target_arch = "x86_64")]
    pub(super) fn words(&self) -> Option<&[u64; 256 * 256 * ROW]> {
        self.words.as_slice().try_into().ok()
    }

    /// Returns whether a color is in the ranges.
    #[inline(always)]
    pub(super) fn holds(&self, [a, b, c]: [u8; 3]) -> bool {
        let word = (usize::from(a) << 8 | usize::from(b)) * ROW + usize::from(c >> 6);
        self.words[word] >> (c & 63) & 1 == 1
    }

    /// Bands that the three levels of a color have in common. A color without any is not in the
    /// ranges.
    #[cfg(test)]
    fn common_bands(&self, color: [u8; 3]) -> u8 {
        let band = |c: usize| self.bands[c][usize::from(color[c]) / STEP];
        band(0) & band(1) & band(2)
    }
}

/// Division of the colors of one range into bands. Each range has its own bands, as long as there
/// are enough, and divides its colors among them by value. A band then spans little of each
/// channel.
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

    /// Bands, as bits, of colors with values between these two (0 to 255).
    #[inline(always)]
    fn of(&self, from: f32, to: f32) -> u8 {
        let part = |value: f32| ((value - self.low) * self.per_level) as usize;
        let [from, to] = [part(from).min(self.count - 1), part(to).min(self.count - 1)];
        (((2u32 << to) - (1 << from)) << self.first) as u8
    }
}

/// Fills in one range. This is not a closure, because one as long as this would not be compiled for
/// the wider registers.
struct Fill<'a> {
    words: &'a mut [u64],
    bands: &'a mut [[u8; STEPS]; 3],
    range: &'a HsvRange,
    yuv: bool,
    banding: &'a Banding,
}

impl lariat_portable::NullaryFnOnce for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        if self.yuv {
            self.fill::<true>();
        } else {
            self.fill::<false>();
        }
    }
}

impl Fill<'_> {
    #[inline(always)]
    fn fill<const YUV: bool>(mut self) {
        let wedge = Wedge::of(self.range);
        for a in (0..256).step_by(SIDE) {
            for b in (0..256).step_by(SIDE) {
                let boxes = Boxes::of::<YUV>(a, b);
                let (may, sure) = boxes.judge(self.range, &wedge);
                for c in (0..LANES).filter(|c| may >> c & 1 == 1) {
                    let bands = self.banding.of(boxes.most[0][c], boxes.most[1][c]);
                    let first = [a, b, LANES * c];
                    let found = if sure >> c & 1 == 1 {
                        self.take_all(first)
                    } else {
                        self.ask_each::<YUV>(first)
                    };
                    self.add_bands(first, bands, found);
                }
            }
        }
    }

    /// Adds all colors of a box, and returns the levels of its third channel that have any.
    #[inline(always)]
    fn take_all(&mut self, [a, b, c]: [usize; 3]) -> u32 {
        let all = (1 << LANES) - 1;
        for (a, b) in (a..a + SIDE).flat_map(|a| (b..b + SIDE).map(move |b| (a, b))) {
            self.words[(a << 8 | b) * ROW + c / 64] |= all << (c % 64);
        }
        all as u32
    }

    /// As [`take_all`](Self::take_all), for the colors of a box that are in the range.
    #[inline(always)]
    fn ask_each<const YUV: bool>(&mut self, [a, b, c]: [usize; 3]) -> u32 {
        let mut any = 0;
        for (a, b) in (a..a + SIDE).flat_map(|a| (b..b + SIDE).map(move |b| (a, b))) {
            let is_in = Row::of::<YUV>([a, b, c]).judge(self.range);
            self.words[(a << 8 | b) * ROW + c / 64] |= u64::from(is_in) << (c % 64);
            any |= is_in;
        }
        any
    }

    /// Records the bands that a box's colors may be in, if some colors were `found`.
    #[inline(always)]
    fn add_bands(&mut self, [a, b, c]: [usize; 3], bands: u8, found: u32) {
        if found == 0 {
            return;
        }
        self.bands[0][a / STEP] |= bands;
        self.bands[1][b / STEP] |= bands;
        for step in (0..LANES).step_by(STEP) {
            if found >> step & ((1 << STEP) - 1) != 0 {
                self.bands[2][(c + step) / STEP] |= bands;
            }
        }
    }
}

/// Hues of a range, as a wedge around the axis of grays. It is made of two half-spaces, behind its
/// first hue and before its last. A color of the range is in both, or in at least one if the wedge
/// is wider than half of all hues.
struct Wedge {
    first: [f32; 3],
    last: [f32; 3],
    is_wide: bool,
    /// True for all hues, including that of the grays.
    is_all: bool,
}

impl Wedge {
    fn of(range: &HsvRange) -> Self {
        let [from, to] = range.hue_deg;
        let arc = if from <= to {
            to - from
        } else {
            to + 360.0 - from
        };
        // A plane that contains the grays and a hue's colors, facing the next hues.
        let plane = |hue: f32| {
            let level = |at: f32| {
                let off = (hue / 60.0 - at).rem_euclid(6.0);
                (2.0 - off.min(6.0 - off)).clamp(0.0, 1.0)
            };
            let [r, g, b] = [level(0.0), level(2.0), level(4.0)];
            [b - g, r - b, g - r]
        };
        Self {
            first: plane(from),
            last: plane(to),
            is_wide: arc > 180.0,
            is_all: from <= 0.0 && to >= 360.0,
        }
    }
}

/// Adjacent boxes of colors, each with `LANES` levels of the third channel and `SIDE` of the
/// others. The fields hold the minimum and maximum of red, green and blue, and of the largest and
/// the smallest of the three.
struct Boxes {
    rgb: [[Lanes; 2]; 3],
    most: [Lanes; 2],
    least: [Lanes; 2],
}

impl Boxes {
    #[inline(always)]
    fn of<const YUV: bool>(a: usize, b: usize) -> Self {
        let mut boxes = Self {
            rgb: [[[0.0; LANES]; 2]; 3],
            most: [[0.0; LANES]; 2],
            least: [[0.0; LANES]; 2],
        };
        let (a, b) = ([a, a + SIDE - 1], [b, b + SIDE - 1]);
        for end in 0..2 {
            for k in 0..LANES {
                let c = [LANES * k, LANES * k + LANES - 1];
                let [a, b, c] = [[a[0], a[1]], [b[0], b[1]], c];
                let float = |level: usize| level as f32;
                // Red, green and blue each rise or fall steadily with each native channel, even
                // when rounded.
                let [red, green, blue] = if YUV {
                    let red = to_rgb([float(a[end]), 0.0, float(c[end])]);
                    let green = to_rgb([float(a[end]), float(b[1 - end]), float(c[1 - end])]);
                    let blue = to_rgb([float(a[end]), float(b[end]), 0.0]);
                    [red[0], green[1], blue[2]]
                } else {
                    [float(a[end]), float(b[end]), float(c[end])]
                };
                boxes.rgb[0][end][k] = red;
                boxes.rgb[1][end][k] = green;
                boxes.rgb[2][end][k] = blue;
                boxes.most[end][k] = larger(larger(red, green), blue);
                boxes.least[end][k] = smaller(smaller(red, green), blue);
            }
        }
        boxes
    }

    /// Returns which boxes may have a color of the range, and which have only such colors.
    #[inline(always)]
    fn judge(&self, range: &HsvRange, wedge: &Wedge) -> (u32, u32) {
        /// Margins larger than the rounding errors of a saturation, and of levels next to a plane.
        const SATURATION_OFF: f32 = 1e-4;
        const LEVELS_OFF: f32 = 0.05;
        let ([dull, bright], [dark, light]) = (range.saturation, range.value);
        let (mut may, mut sure) = ([0u32; LANES], [0u32; LANES]);
        for k in 0..LANES {
            let [most, least] = [&self.most, &self.least].map(|ends| [ends[0][k], ends[1][k]]);
            // All values are rounded alike, so their order is kept.
            let values = [most[0] / 255.0, most[1] / 255.0];
            let may_value = (values[1] >= dark) & (values[0] <= light);
            let sure_value = (values[0] >= dark) & (values[1] <= light);
            // Saturation is undefined for black, so nothing is assumed about it.
            let is_black = most[0] <= 0.0;
            let dullest = pick(is_black, 0.0, 1.0 - least[1] / larger(most[0], 1.0));
            let brightest = pick(is_black, 1.0, 1.0 - least[0] / larger(most[1], 1.0));
            let may_saturation =
                (brightest >= dull - SATURATION_OFF) & (dullest <= bright + SATURATION_OFF);
            let sure_saturation = ((dull <= 0.0) | (dullest >= dull + SATURATION_OFF))
                & ((bright >= 1.0) | (brightest <= bright - SATURATION_OFF));
            // Distance by which the box extends to one side of a plane of the wedge.
            let reach = |plane: &[f32; 3], end: usize| {
                let mut sum = 0.0;
                for (factor, channel) in plane.iter().zip(&self.rgb) {
                    let ends = [factor * channel[0][k], factor * channel[1][k]];
                    sum += if end == 1 {
                        larger(ends[0], ends[1])
                    } else {
                        smaller(ends[0], ends[1])
                    };
                }
                sum
            };
            let may_ends = [
                reach(&wedge.first, 1) >= -LEVELS_OFF,
                reach(&wedge.last, 0) <= LEVELS_OFF,
            ];
            let sure_ends = [
                reach(&wedge.first, 0) >= LEVELS_OFF,
                reach(&wedge.last, 1) <= -LEVELS_OFF,
            ];
            let both_or_one = |[a, b]: [bool; 2]| (a & b) | (wedge.is_wide & (a | b));
            let has_gray = most[0] <= least[1];
            let may_hue = wedge.is_all | has_gray | both_or_one(may_ends);
            let sure_hue = wedge.is_all | (!has_gray & both_or_one(sure_ends));
            may[k] = u32::from(may_value & may_saturation & may_hue) << k;
            sure[k] = u32::from(sure_value & sure_saturation & sure_hue) << k;
        }
        let all = |bits: [u32; LANES]| bits.iter().fold(0, |all, bit| all | bit);
        (all(may), all(sure))
    }
}

/// Colors that differ only in the third channel.
struct Row {
    red: Lanes,
    green: Lanes,
    blue: Lanes,
}

impl Row {
    /// The `LANES` colors that begin with this one.
    #[inline(always)]
    fn of<const YUV: bool>([a, b, c]: [usize; 3]) -> Self {
        let mut row = Self {
            red: [0.0; LANES],
            green: [0.0; LANES],
            blue: [0.0; LANES],
        };
        for k in 0..LANES {
            let native = [a as f32, b as f32, (c + k) as f32];
            let rgb = if YUV { to_rgb(native) } else { native };
            (row.red[k], row.green[k], row.blue[k]) = (rgb[0], rgb[1], rgb[2]);
        }
        row
    }

    /// Returns which of the colors are in the range, one bit each. The operations are those of
    /// [`super::contains`] in the same order but without its branches, so the results are equal bit
    /// for bit.
    #[inline(always)]
    fn judge(&self, range: &HsvRange) -> u32 {
        let ([from, to], saturations, values) = (range.hue_deg, range.saturation, range.value);
        let wraps = from > to;
        let mut all = [0; LANES];
        for (k, bit) in all.iter_mut().enumerate() {
            let (red, green, blue) = (self.red[k], self.green[k], self.blue[k]);
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
            let is_in = fits & within(saturations, saturation) & within(values, value);
            *bit = u32::from(is_in) << k;
        }
        all.iter().fold(0, |all, bit| all | bit)
    }
}

/// `color::yuv_to_rgb` for levels held as floats, as in a kernel.
#[inline(always)]
fn to_rgb([y, u, v]: [f32; 3]) -> [f32; 3] {
    let (u, v) = (u - 128.0, v - 128.0);
    let level = |c: f32| smaller(larger(c + 0.5, 0.0), 255.0) as i32 as f32;
    [
        level(y + 1.402 * v),
        level(y - 0.344_136 * u - 0.714_136 * v),
        level(y + 1.772 * u),
    ]
}

#[inline(always)]
fn pick(which: bool, a: f32, b: f32) -> f32 {
    if which { a } else { b }
}

/// `f32::max` of numbers that are not NaN, in one instruction.
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
    use crate::image::color;
    use proptest::prelude::*;

    /// Ranges whose bounds are often exactly the numbers of some color.
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
            for c in (0..256).step_by(LANES) {
                let first = [a.into(), b.into(), c];
                let is_in = lariat_portable::Arch::new().dispatch(|| if yuv {
                    Row::of::<true>(first).judge(&range)
                } else {
                    Row::of::<false>(first).judge(&range)
                });
                for k in 0..LANES {
                    let rgb = rgb_of([a, b, (c + k) as u8], yuv);
                    prop_assert_eq!(is_in >> k & 1 == 1, contains(&[range], rgb), "{:?}", rgb);
                }
            }
        }

        #[test]
        fn a_box_that_is_judged_as_a_whole_is_judged_as_its_colors(
            range in range(), a in 0..64usize, b in 0..64usize, yuv: bool,
        ) {
            let (a, b) = (SIDE * a, SIDE * b);
            let boxes = if yuv { Boxes::of::<true>(a, b) } else { Boxes::of::<false>(a, b) };
            let (may, sure) = boxes.judge(&range, &Wedge::of(&range));
            for c in 0..256 {
                for (a, b) in (a..a + SIDE).flat_map(|a| (b..b + SIDE).map(move |b| (a, b))) {
                    let rgb = rgb_of([a, b, c].map(|level| level as u8), yuv);
                    let is_in = contains(&[range], rgb);
                    prop_assert!(!is_in || may >> (c / LANES) & 1 == 1, "{:?}", rgb);
                    prop_assert!(is_in || sure >> (c / LANES) & 1 == 0, "{:?}", rgb);
                }
            }
        }
    }

    /// Ranges as users pick them, with one that wraps and one of grays. Many colors lie exactly on
    /// their bounds.
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
        // The step is a prime, so that all levels of all channels occur.
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

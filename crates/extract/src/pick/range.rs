//! A box in hue, saturation and value that contains one class of pixels and excludes the others.
//!
//! Its six sides are moved in turn to the best agreement, until none moves. The agreement is the
//! rope within the box, divided by all rope plus all others within. This is coordinate ascent from
//! the box of the middle 98 % of the rope. Then each side moves outward as far as the agreement
//! allows, and half the way back. The margin is shared between rope and table, so that neither a
//! change of light nor noise breaks the mask at once.

use super::evidence::{Evidence, Label, has_hue};
use super::palette::Palette;
use crate::options::HsvRange;

/// Number of steps of saturation and of value.
const STEPS: usize = 100;
/// Number of steps of hue: degrees around the rope's own, from −180.
const HUES: usize = 360;
/// Share of the agreement that a wider box may cost: that of single stray pixels.
const COST: f32 = 0.002;
/// Distance by which the range of hues extends if nothing limits it, in degrees. A sixth of the
/// circle away is another color.
const FREE_HUE: usize = 20;
/// A rope without color that reaches below this value is dark: a fifth of the scale.
const DARK: usize = STEPS / 5;
/// Maximum number of rounds of the ascent. It settles after two or three.
const ROUNDS: usize = 6;

const HUE: usize = 0;
const SATURATION: usize = 1;
const VALUE: usize = 2;

/// A range, and how well it separates its class from the rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub(super) range: HsvRange,
    pub(super) agreement: f32,
}

/// A color in steps of each channel, and its number of rope and table pixels.
struct Color {
    at: [u16; 3],
    count: [f32; 2],
}

/// First and last step of each channel, inclusive.
type Box3 = [[usize; 2]; 3];

/// For each color, the number of pixels that are rope, and of those that are certainly not.
pub(super) type Counts = Vec<[f32; 2]>;

pub(super) fn counts(
    palette: &Palette,
    evidence: &Evidence,
    is_rope: impl Fn(&Label) -> bool,
) -> Counts {
    let mut counts = vec![[0.0f32; 2]; palette.colors.len()];
    for (label, &color) in evidence.labels().iter().zip(&palette.of) {
        if *label != Label::Unknown {
            counts[color as usize][usize::from(!is_rope(label))] += 1.0;
        }
    }
    counts
}

/// A range for each of the rope's two colors, if it has two distinct ones, and how well both
/// together separate it from the rest.
pub(super) fn fit_two(palette: &Palette, counts: &Counts) -> Option<(Vec<HsvRange>, f32)> {
    let is_second = halves(palette, counts);
    let part = |which: bool| -> Counts {
        let own = |(count, &second): (&[f32; 2], &bool)| match second == which {
            true => *count,
            // The rope's other color counts as neither rope nor table.
            false => [0.0, count[1]],
        };
        counts.iter().zip(&is_second).map(own).collect()
    };
    let ranges = vec![
        fit(palette, &part(false))?.range,
        fit(palette, &part(true))?.range,
    ];
    let held = palette.held(&ranges);
    let [mut rope, mut others, mut within] = [0.0; 3];
    for (&[own, table], held) in counts.iter().zip(held) {
        rope += own;
        if held {
            within += own;
            others += table;
        }
    }
    Some((ranges, within / (rope + others)))
}

/// Splits the rope's colors into two clusters by their means (Lloyd's algorithm). True for those in
/// the second.
fn halves(palette: &Palette, counts: &Counts) -> Vec<bool> {
    let mut is_second: Vec<bool> = Vec::new();
    let colors = || palette.levels.iter().zip(counts);
    let mean = |of: &dyn Fn(usize) -> bool| {
        let mut sum = [0.0f32; 4];
        for (i, (levels, [own, _])) in colors().enumerate() {
            if of(i) {
                (0..3).for_each(|c| sum[c] += own * levels[c]);
                sum[3] += own;
            }
        }
        [0, 1, 2].map(|c| sum[c] / sum[3].max(1.0))
    };
    let square =
        |a: [f32; 3], b: [f32; 3]| (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum::<f32>();
    let middle = mean(&|_| true);
    // The second cluster begins at the farthest color, weighted by its number of pixels.
    let weight = |levels: [f32; 3], own: f32| own * square(levels, middle);
    let farthest = colors()
        .max_by(|a, b| weight(*a.0, a.1[0]).total_cmp(&weight(*b.0, b.1[0])))
        .map_or(middle, |(levels, _)| *levels);
    let mut means = [middle, farthest];
    for _ in 0..ROUNDS {
        is_second = (palette.levels.iter())
            .map(|&levels| square(levels, means[1]) < square(levels, means[0]))
            .collect();
        means = [mean(&|i| !is_second[i]), mean(&|i| is_second[i])];
    }
    is_second
}

/// The range that contains the rope's colors and excludes the others, or `None` without rope
/// pixels.
pub(super) fn fit(palette: &Palette, counts: &Counts) -> Option<Fit> {
    let rope: f32 = counts.iter().map(|count| count[0]).sum();
    if rope == 0.0 {
        return None;
    }
    let middle = own_hue(palette, counts);
    let steps = |color: &[f32; 3]| steps(*color, middle.unwrap_or(0.0));
    let colors = palette.colors.iter().zip(counts);
    let search = Search {
        colors: (colors.filter(|(_, count)| count[0] + count[1] > 0.0))
            .map(|(color, &count)| Color {
                at: steps(color),
                count,
            })
            .collect(),
        has_hue: middle.is_some(),
        rope,
    };
    let sides = search.best_box();
    let agreement = search.agreement(&sides);
    Some(Fit {
        range: range(&sides, middle),
        agreement,
    })
}

/// Mean hue of the rope's pixels, weighted by chroma, or `None` for a rope without color.
fn own_hue(palette: &Palette, counts: &Counts) -> Option<f32> {
    let mut sum = [0.0f32; 2];
    for (&[hue, saturation, value], [rope, _]) in palette.colors.iter().zip(counts) {
        let (sin, cos) = libm::sincosf(hue.to_radians());
        sum[0] += rope * saturation * value * cos;
        sum[1] += rope * saturation * value * sin;
    }
    let has_hue = has_hue(median_color(palette, counts));
    has_hue.then(|| libm::atan2f(sum[1], sum[0]).to_degrees().rem_euclid(360.0))
}

/// Median of each channel of the rope's pixels.
fn median_color(palette: &Palette, counts: &Counts) -> [f32; 3] {
    std::array::from_fn(|channel| {
        let mut at = [0.0f32; 256];
        for (levels, [rope, _]) in palette.levels.iter().zip(counts) {
            at[(levels[channel] + 0.5) as usize] += rope;
        }
        let half = 0.5 * at.iter().sum::<f32>();
        let mut below = 0.0;
        let is_beyond = |&count: &f32| {
            below += count;
            below > half
        };
        at.iter().position(is_beyond).unwrap_or(0) as f32
    })
}

fn steps([hue, saturation, value]: [f32; 3], middle: f32) -> [u16; 3] {
    let turned = (hue - middle + 180.0).rem_euclid(360.0);
    // The end of a scale belongs to its last step.
    let step = |share: f32, steps: usize| ((share * steps as f32) as usize).min(steps - 1) as u16;
    [
        step(turned / 360.0, HUES),
        step(saturation, STEPS),
        step(value, STEPS),
    ]
}

/// Converts steps to the user's units. A free hue is the whole circle.
fn range(sides: &Box3, middle: Option<f32>) -> HsvRange {
    let share = |[low, high]: [usize; 2]| [low, high + 1].map(|s| s as f32 / STEPS as f32);
    let hue_deg = match middle {
        None => [0.0, 360.0],
        Some(middle) => {
            let [low, high] = sides[HUE];
            // Whole degrees, rounded outward by less than one.
            [
                (middle + low as f32 - 180.0).floor(),
                (middle + high as f32 - 179.0).ceil(),
            ]
            .map(|hue| hue.rem_euclid(360.0))
        }
    };
    HsvRange {
        hue_deg,
        saturation: share(sides[SATURATION]),
        value: share(sides[VALUE]),
    }
}

struct Search {
    colors: Vec<Color>,
    has_hue: bool,
    /// Number of rope pixels.
    rope: f32,
}

impl Search {
    fn best_box(&self) -> Box3 {
        let mut sides = self.middle_of_the_rope();
        for _ in 0..ROUNDS {
            let before = sides;
            for channel in [VALUE, SATURATION, HUE] {
                self.move_sides(channel, &mut sides, false);
            }
            if sides == before {
                break;
            }
        }
        for channel in [VALUE, SATURATION, HUE] {
            self.move_sides(channel, &mut sides, true);
        }
        sides
    }

    /// The box from the first to the last percentile of each channel.
    fn middle_of_the_rope(&self) -> Box3 {
        let mut sides = [[0, HUES - 1], [0, STEPS - 1], [0, STEPS - 1]];
        for (channel, side) in sides.iter_mut().enumerate() {
            if channel == HUE && !self.has_hue {
                continue;
            }
            let mut count = [0.0f32; HUES];
            for color in &self.colors {
                count[usize::from(color.at[channel])] += color.count[0];
            }
            let few = 0.01 * self.rope;
            let mut below = 0.0;
            let is_beyond = |&count: &f32| {
                below += count;
                below > few
            };
            side[0] = count.iter().position(is_beyond).unwrap_or(side[0]);
            let mut above = 0.0;
            let is_within = |&count: &f32| {
                above += count;
                above > few
            };
            side[1] = count.iter().rposition(is_within).unwrap_or(side[1]);
        }
        if !self.has_hue {
            sides[SATURATION][0] = 0;
        }
        sides
    }

    /// Moves both sides of a channel, with those of the other channels fixed: to the best
    /// agreement, or outward from there.
    fn move_sides(&self, channel: usize, sides: &mut Box3, outwards: bool) {
        if channel == HUE && !self.has_hue {
            return;
        }
        let counts = self.counts(channel, sides);
        let last = if channel == HUE { HUES } else { STEPS } - 1;
        // The upper side is the lower one of the scale read backward.
        let mut backwards = counts[..=last].to_vec();
        backwards.reverse();
        let [low, high] = &mut sides[channel];
        // For a rope without color, the minimum saturation stays 0.
        if channel != SATURATION || self.has_hue {
            *low = self.lower_side(&counts[..=last], *high, outwards, |best| match channel {
                HUE => best.saturating_sub(FREE_HUE),
                // A black rope in the shade is still black. A red one loses its hue there.
                VALUE if !self.has_hue && best < DARK => 0,
                _ => best / 2,
            });
        }
        let from = last - *low;
        *high = last
            - self.lower_side(&backwards, from, outwards, |best| match channel {
                HUE => best.saturating_sub(FREE_HUE),
                _ => 0,
            });
    }

    /// Rope and other pixels at each step of a channel, within the other channels' sides.
    fn counts(&self, channel: usize, sides: &Box3) -> [[f32; 2]; HUES] {
        let mut counts = [[0.0; 2]; HUES];
        for color in &self.colors {
            let is_within = |other: usize| {
                let at = usize::from(color.at[other]);
                other == channel || (sides[other][0]..=sides[other][1]).contains(&at)
            };
            if (0..3).all(is_within) {
                let sum = &mut counts[usize::from(color.at[channel])];
                *sum = [sum[0] + color.count[0], sum[1] + color.count[1]];
            }
        }
        counts
    }

    /// The best place of the lower side, if the upper side is at `high`. With `outwards`, the side
    /// moves from there as far as it costs nothing, then half the way back. `free` gives its place
    /// if nothing limits it.
    fn lower_side(
        &self,
        counts: &[[f32; 2]],
        high: usize,
        outwards: bool,
        free: impl Fn(usize) -> usize,
    ) -> usize {
        let mut agreement = vec![0.0f32; high + 1];
        let (mut rope, mut others) = (0.0, 0.0);
        for step in (0..=high).rev() {
            rope += counts[step][0];
            others += counts[step][1];
            agreement[step] = rope / (self.rope + others);
        }
        // Take the innermost of equally good places.
        let best = (0..=high)
            .max_by(|&a, &b| agreement[a].total_cmp(&agreement[b]))
            .unwrap_or(0);
        if !outwards {
            return best;
        }
        let enough = agreement[best] * (1.0 - COST);
        match (0..best).rev().find(|&step| agreement[step] < enough) {
            // The first step that costs too much agreement stays outside of the box.
            Some(costs) => (best + costs + 1).div_ceil(2),
            None => free(best),
        }
    }

    fn agreement(&self, sides: &Box3) -> f32 {
        let counts = self.counts(VALUE, sides);
        let within = counts.iter().skip(sides[VALUE][0]);
        let [mut rope, mut others] = [0.0; 2];
        for count in within.take(sides[VALUE][1] + 1 - sides[VALUE][0]) {
            rope += count[0];
            others += count[1];
        }
        rope / (self.rope + others)
    }
}

//! A box in hue, saturation and value that holds one class of pixels and keeps the others out.
//!
//! Its six sides are moved one after the other to where the agreement (rope within over rope and all others within) is
//! best, until none moves: coordinate ascent, from the box of the middle 98 % of the rope. Then each side goes out as
//! far as the agreement allows, and back half the way: the margin is shared between rope and table, so that neither a
//! change of light nor noise spoils it at once.

use super::evidence::{Evidence, Label, has_hue, median_color};
use crate::image::{Image, color};
use crate::mask::hsv;
use crate::options::HsvRange;

/// Steps of saturation and of value.
const STEPS: usize = 100;
/// Steps of hue: degrees around the rope's own, from −180.
const HUES: usize = 360;
/// How much of the agreement a wider box may cost: that of single odd pixels.
const COST: f32 = 0.002;
/// How far a hue goes on where nothing stops it, in degrees: a sixth of the circle is another colour.
const FREE_HUE: usize = 20;
/// A rope without colour that reaches below this value is a dark one: a fifth of the scale.
const DARK: usize = STEPS / 5;
/// Rounds of the ascent; it has come to rest after two or three.
const ROUNDS: usize = 6;

const HUE: usize = 0;
const SATURATION: usize = 1;
const VALUE: usize = 2;

/// The range, and how well it tells its class from the rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub(super) range: HsvRange,
    pub(super) agreement: f32,
}

/// A pixel in steps of each channel.
struct Pixel {
    at: [u16; 3],
    is_rope: bool,
}

/// First and last step of each channel, both within.
type Box3 = [[usize; 2]; 3];

/// The range of a class; `None` of one without a pixel.
pub(super) fn fit(image: &Image, evidence: &Evidence, class: usize) -> Option<Fit> {
    let width = image.width();
    let rgb = |i: usize| color::rgb(image, i % width, i / width);
    let is_rope = |label: &Label| matches!(label, Label::Rope(c) if usize::from(*c) == class);
    let labels = || evidence.labels().iter().enumerate();
    let own: Vec<[u8; 3]> = labels()
        .filter(|(_, label)| is_rope(label))
        .map(|(i, _)| rgb(i))
        .collect();
    if own.is_empty() {
        return None;
    }
    let middle = own_hue(&own);
    let pixels: Vec<Pixel> = labels()
        .filter(|(_, label)| **label != Label::Unknown)
        .map(|(i, label)| Pixel {
            at: steps(rgb(i), middle.unwrap_or(0.0)),
            is_rope: is_rope(label),
        })
        .collect();
    let search = Search {
        pixels,
        has_hue: middle.is_some(),
        rope: own.len() as f32,
    };
    let sides = search.best_box();
    let agreement = search.agreement(&sides);
    Some(Fit {
        range: range(&sides, middle),
        agreement,
    })
}

/// The hue that the rope's pixels have in the mean, each by its chroma; `None` of a rope without colour.
fn own_hue(own: &[[u8; 3]]) -> Option<f32> {
    let mut sum = [0.0f32; 2];
    for &rgb in own {
        let (hue, saturation, value) = hsv::hsv(rgb);
        let (sin, cos) = libm::sincosf(hue.to_radians());
        sum[0] += saturation * value * cos;
        sum[1] += saturation * value * sin;
    }
    has_hue(median_color(own)).then(|| libm::atan2f(sum[1], sum[0]).to_degrees().rem_euclid(360.0))
}

fn steps(rgb: [u8; 3], middle: f32) -> [u16; 3] {
    let (hue, saturation, value) = hsv::hsv(rgb);
    let turned = (hue - middle + 180.0).rem_euclid(360.0);
    // The end of a scale belongs to its last step.
    let step = |share: f32, steps: usize| ((share * steps as f32) as usize).min(steps - 1) as u16;
    [
        step(turned / 360.0, HUES),
        step(saturation, STEPS),
        step(value, STEPS),
    ]
}

/// From steps to the user's units. A hue that is free is the whole circle.
fn range(sides: &Box3, middle: Option<f32>) -> HsvRange {
    let share = |[low, high]: [usize; 2]| [low, high + 1].map(|s| s as f32 / STEPS as f32);
    let hue_deg = match middle {
        None => [0.0, 360.0],
        Some(middle) => {
            let [low, high] = sides[HUE];
            // Whole degrees, outwards by less than one.
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
    pixels: Vec<Pixel>,
    has_hue: bool,
    /// How many pixels are rope.
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

    /// From the first to the last percentile of each channel.
    fn middle_of_the_rope(&self) -> Box3 {
        let mut sides = [[0, HUES - 1], [0, STEPS - 1], [0, STEPS - 1]];
        for (channel, side) in sides.iter_mut().enumerate() {
            if channel == HUE && !self.has_hue {
                continue;
            }
            let mut count = [0.0f32; HUES];
            for pixel in self.pixels.iter().filter(|pixel| pixel.is_rope) {
                count[usize::from(pixel.at[channel])] += 1.0;
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

    /// Moves both sides of a channel, the others held: to the best agreement, or from there outwards.
    fn move_sides(&self, channel: usize, sides: &mut Box3, outwards: bool) {
        if channel == HUE && !self.has_hue {
            return;
        }
        let counts = self.counts(channel, sides);
        let last = if channel == HUE { HUES } else { STEPS } - 1;
        // The upper side is the lower one of the scale read backwards.
        let mut backwards = counts[..=last].to_vec();
        backwards.reverse();
        let [low, high] = &mut sides[channel];
        // A rope without colour has no least saturation.
        if channel != SATURATION || self.has_hue {
            *low = self.lower_side(&counts[..=last], *high, outwards, |best| match channel {
                HUE => best.saturating_sub(FREE_HUE),
                // A black rope in the shade is still black; a red one has no hue any more.
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

    /// Rope and others at each step of a channel, of the pixels within the other sides.
    fn counts(&self, channel: usize, sides: &Box3) -> [[f32; 2]; HUES] {
        let mut counts = [[0.0; 2]; HUES];
        for pixel in &self.pixels {
            let is_within = |other: usize| {
                let at = usize::from(pixel.at[other]);
                other == channel || (sides[other][0]..=sides[other][1]).contains(&at)
            };
            if (0..3).all(is_within) {
                counts[usize::from(pixel.at[channel])][usize::from(!pixel.is_rope)] += 1.0;
            }
        }
        counts
    }

    /// Where the lower side is best for an upper side at `high`. `outwards`: as far below that as costs nothing, and
    /// half the way back; `free`: where it then is if nothing stops it.
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
        // The innermost of equals.
        let best = (0..=high)
            .max_by(|&a, &b| agreement[a].total_cmp(&agreement[b]))
            .unwrap_or(0);
        if !outwards {
            return best;
        }
        let enough = agreement[best] * (1.0 - COST);
        match (0..best).rev().find(|&step| agreement[step] < enough) {
            // The step that costs is outside of the box.
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

//! A hand over the ropes: a forearm that comes in from below, and what it ends in.

use super::TrueRope;
use crate::rendered::portable::smoothstep;

const SKIN: [f64; 3] = [206.0, 158.0, 132.0];
/// It passes every so many seconds, and takes so many for it.
const EVERY_S: f64 = 6.0;
const PASSES_S: f64 = 3.0;

/// It comes to rest every so many seconds, and takes so many to come, stays for so many, and goes as it came.
const RESTS_EVERY_S: f64 = 5.0;
const COMES_S: f64 = 0.4;
const STAYS_S: f64 = 2.5;
/// Where it comes to rest, in turn, as shares of the picture's sides.
const RESTS: [[f64; 2]; 3] = [[0.5, 0.45], [0.36, 0.6], [0.64, 0.55]];

/// A hand at a moment: all that lies within a radius of a line.
#[derive(Debug)]
pub(super) struct Hand {
    ends: [[f64; 2]; 2],
    radius_px: f64,
}

impl Hand {
    /// Where a hand is that passes from one side to the other, if it is there.
    pub(super) fn passing(time_s: f64, size_px: [f64; 2], rope_px: f64) -> Option<Self> {
        let share = (time_s % EVERY_S - (EVERY_S - PASSES_S)) / PASSES_S;
        let radius_px = 3.0 * rope_px;
        (share > 0.0).then(|| {
            let x = share * (size_px[0] + 2.0 * radius_px) - radius_px;
            // In over the middle, and out again.
            let reach = smoothstep(4.0 * share.min(1.0 - share));
            let tip = [x, size_px[1] * (1.1 - 0.7 * reach)];
            Self {
                ends: [[x - 0.2 * size_px[0], 1.3 * size_px[1]], tip],
                radius_px,
            }
        })
    }

    /// Where a hand is that comes to rest at a place, if it is there.
    pub(super) fn resting(time_s: f64, size_px: [f64; 2], rope_px: f64) -> Option<Self> {
        let begun_s = time_s % RESTS_EVERY_S - (RESTS_EVERY_S - STAYS_S - 2.0 * COMES_S);
        let gone_s = STAYS_S + 2.0 * COMES_S - begun_s;
        let reach = smoothstep((begun_s.min(gone_s) / COMES_S).clamp(0.0, 1.0));
        let place = RESTS[(time_s / RESTS_EVERY_S) as usize % RESTS.len()];
        let below = [place[0] - 0.1, 1.3];
        let [tip, from] = [reach, -0.5].map(|reach| {
            [0, 1].map(|axis| size_px[axis] * (below[axis] + reach * (place[axis] - below[axis])))
        });
        (begun_s > 0.0).then_some(Self {
            ends: [from, tip],
            radius_px: 3.0 * rope_px,
        })
    }

    /// How far within it a place lies.
    fn within_px(&self, p: [f64; 2]) -> f64 {
        let [a, b] = self.ends;
        let along = [b[0] - a[0], b[1] - a[1]];
        let from = [p[0] - a[0], p[1] - a[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let share = ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0);
        let off = [from[0] - share * along[0], from[1] - share * along[1]];
        self.radius_px - (off[0] * off[0] + off[1] * off[1]).sqrt()
    }

    /// Draws it over a picture, and hides what is under it.
    pub(super) fn draw(&self, pixels: &mut [u8], width: usize, truth: &mut [TrueRope]) {
        for (i, pixel) in pixels.chunks_exact_mut(3).enumerate() {
            let within_px = self.within_px([(i % width) as f64, (i / width) as f64]);
            let share = (within_px + 0.5).clamp(0.0, 1.0);
            // Round, so that it darkens toward its rim.
            let light = 0.75 + 0.25 * smoothstep(within_px / self.radius_px);
            for (level, skin) in pixel.iter_mut().zip(SKIN) {
                let old = f64::from(*level);
                *level = (old + share * (light * skin - old)) as u8;
            }
        }
        for rope in truth {
            for (seen, &p) in rope.seen.iter_mut().zip(&rope.points) {
                *seen &= self.within_px(p) < 0.0;
            }
        }
    }
}

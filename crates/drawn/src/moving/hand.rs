//! A hand over the ropes: a forearm that comes in from below, with a round end.

use super::TrueRope;
use crate::rendered::portable::smoothstep;

/// Skin colors: light and dark.
const SKINS: [[f64; 3]; 2] = [[206.0, 158.0, 132.0], [120.0, 86.0, 66.0]];
/// Period of the passes, and duration of a pass.
const EVERY_S: f64 = 6.0;
const PASSES_S: f64 = 3.0;

/// Period of the visits at which the hand rests; time that the hand takes to come in, and again to
/// leave; and time for which it rests.
const RESTS_EVERY_S: f64 = 5.0;
const COMES_S: f64 = 0.4;
const STAYS_S: f64 = 2.5;
/// Resting places, in turn, as shares of the picture's sides.
const RESTS: [[f64; 2]; 3] = [[0.5, 0.45], [0.36, 0.6], [0.64, 0.55]];

/// Visits in a film from another source: period of the visits in frames, number of these frames
/// without a hand, and number of frames that the hand takes to come in and again to leave.
const VISITS_EVERY: u64 = 120;
const AWAY: u64 = 25;
const COMES: f64 = 8.0;
/// Positions of the fingertip in successive visits, as shares of the picture's sides; and half
/// widths of a finger and of an arm, in rope widths.
const VISITED: [[f64; 2]; 7] = [
    [0.5, 0.45],
    [0.36, 0.6],
    [0.64, 0.55],
    [0.25, 0.4],
    [0.45, 0.7],
    [0.6, 0.35],
    [0.75, 0.5],
];
const HALVES: [f64; 2] = [1.7, 3.0];

/// A hand at one moment: everything within a radius around a line segment.
#[derive(Debug)]
pub struct Hand {
    ends: [[f64; 2]; 2],
    radius_px: f64,
    skin: [f64; 3],
}

impl Hand {
    /// Position of a hand that passes from one side to the other, if it is in the picture.
    pub(super) fn passing(time_s: f64, size_px: [f64; 2], rope_px: f64) -> Option<Self> {
        let share = (time_s % EVERY_S - (EVERY_S - PASSES_S)) / PASSES_S;
        let radius_px = 3.0 * rope_px;
        (share > 0.0).then(|| {
            let x = share * (size_px[0] + 2.0 * radius_px) - radius_px;
            // It moves in over the middle and out again.
            let reach = smoothstep(4.0 * share.min(1.0 - share));
            let tip = [x, size_px[1] * (1.1 - 0.7 * reach)];
            Self {
                ends: [[x - 0.2 * size_px[0], 1.3 * size_px[1]], tip],
                radius_px,
                skin: SKINS[0],
            }
        })
    }

    /// Position of a hand that comes to rest at a place, if it is in the picture.
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
            skin: SKINS[0],
        })
    }

    /// Returns the hand in frame number `frame` of a film from another source, if there is one, for
    /// pictures of this size and a rope of this width. Hands come from above and from below, thin
    /// and wide, light and dark in turn. Films with other seeds begin with other visits.
    pub fn visiting(frame: u64, seed: u64, size_px: [f64; 2], rope_px: f64) -> Option<Self> {
        let visit = (frame / VISITS_EVERY + 7 * seed) as usize;
        let here = (frame % VISITS_EVERY).checked_sub(AWAY)? as f64;
        let left = (VISITS_EVERY - AWAY - 1) as f64 - here;
        let reach = (here.min(left) / COMES).clamp(0.0, 1.0);
        let place = VISITED[visit % VISITED.len()];
        let outside = match visit / 3 % 2 {
            0 => [place[0] - 0.1, 1.3],
            _ => [place[0] + 0.15, -0.3],
        };
        let [tip, from] = [reach, -0.5].map(|reach| {
            [0, 1].map(|c| size_px[c] * (outside[c] + reach * (place[c] - outside[c])))
        });
        (reach > 0.0).then_some(Self {
            ends: [from, tip],
            radius_px: HALVES[visit / VISITED.len() % 2] * rope_px,
            skin: SKINS[visit % 2],
        })
    }

    /// Depth of a point inside the hand.
    fn within_px(&self, p: [f64; 2]) -> f64 {
        let [a, b] = self.ends;
        let along = [b[0] - a[0], b[1] - a[1]];
        let from = [p[0] - a[0], p[1] - a[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let share = ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0);
        let off = [from[0] - share * along[0], from[1] - share * along[1]];
        self.radius_px - (off[0] * off[0] + off[1] * off[1]).sqrt()
    }

    /// Draws the hand over a picture (three bytes per pixel without padding) and marks the points
    /// under it as hidden.
    pub fn draw(&self, pixels: &mut [u8], width: usize, truth: &mut [TrueRope]) {
        for (i, pixel) in pixels.chunks_exact_mut(3).enumerate() {
            let within_px = self.within_px([(i % width) as f64, (i / width) as f64]);
            let share = (within_px + 0.5).clamp(0.0, 1.0);
            // A round surface darkens toward its rim.
            let light = 0.75 + 0.25 * smoothstep(within_px / self.radius_px);
            for (level, skin) in pixel.iter_mut().zip(self.skin) {
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

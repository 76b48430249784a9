//! What a depth image says of a rope's axis around each of its points.

use super::{DepthImage, RopeDepth, STEEPEST, SeenRope, THINNEST_PX, length, pixel};

/// Of a rope's half width, how much is read; and an edge's pixels, which see both sides of it, px.
const INNER: f64 = 0.8;
const EDGE_PX: f64 = 0.8;
/// Depth pixels across and along that are read at a point, at most.
const ACROSS: usize = 9;
const ALONG: usize = 8;
/// The share of pixels that are read by one sample alone: places a pixel apart along the rope fall on the same one here and there.
const READ_ONCE: f64 = 0.75;
/// Of the radius: how much of it is taken for wrong, as widths are.
const RADIUS_ERROR: f64 = 0.02;

/// How closely a depth image is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// A few pixels at each point, wherever they are within reach.
    Glance,
    /// All of the rope's inside.
    Whole,
}

/// The stretch of a rope around a point, in the depth image.
struct Stretch {
    /// Where the point is, and how far ahead of the depth camera.
    at: [f64; 2],
    ahead: f64,
    /// The way along the rope, of length 1; and how much farther ahead it is for each pixel along.
    along: [f64; 2],
    slope: f64,
    /// Half of the way to the next point, px; and from where to where it is read.
    half_step: f64,
    ends: [f64; 2],
    mm_per_px: f64,
    /// The rope's, mm.
    radius: f64,
    /// How far beside its axis it is read, px.
    inner: f64,
    /// Of the angle between the rope and the ray.
    sine: f64,
}

impl RopeDepth {
    /// Reads the depth image around each point, where it is known roughly.
    pub(super) fn read(&mut self, image: &DepthImage, rope: &SeenRope, reading: Reading) {
        let count = self.axes.len();
        for i in 0..count {
            let place = self.place(&self.axes[i], self.axes[i].depth);
            let axis = &mut self.axes[i];
            axis.ahead = place[2];
            // Outside of its image nothing is read.
            axis.at = self.camera.pixel(place).unwrap_or([-1e6; 2]);
        }
        for i in 0..count {
            let found = match rope.hidden[i] {
                true => None,
                false => self.around(image, rope, i, reading),
            };
            let axis = &mut self.axes[i];
            axis.is_measured = found.is_some();
            if let Some((ahead, variance)) = found {
                let turned = axis.turned[2];
                axis.depth = (ahead - self.camera.translation[2]) / turned;
                axis.variance = variance / (turned * turned);
            }
        }
    }

    /// The stretch of the rope around a point; `None` where it goes nowhere in the depth image, or is too thin there.
    fn stretch(&self, rope: &SeenRope, i: usize) -> Option<Stretch> {
        let count = self.axes.len();
        let [before, after] = match rope.closed {
            true => [(i + count - 1) % count, (i + 1) % count],
            false => [i.saturating_sub(1), (i + 1).min(count - 1)],
        };
        let (a, b, axis) = (&self.axes[before], &self.axes[after], &self.axes[i]);
        let way = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
        let far = length(way[0], way[1]);
        if !(far > 1e-3 && far < 1e3) {
            return None;
        }
        let steps = if before == i || after == i { 1.0 } else { 2.0 };
        let half_step = 0.5 * far / steps;
        let focal = self.camera.depth.focal_px();
        let mm_per_px = axis.ahead / (focal[0] * focal[1]).sqrt();
        let radius = axis.slim * axis.depth;
        let half = radius / mm_per_px;
        // At least the pixel on the axis; but of a rope that is no wider than that there is none without an edge.
        let inner = (INNER * half).min(half - EDGE_PX);
        if inner < 0.5 * (THINNEST_PX - 2.0 * EDGE_PX) - 0.5 || half < 0.5 * THINNEST_PX {
            return None;
        }
        // The rope goes as far ahead as it goes along: its direction against the ray.
        let (ahead_way, aside) = (b.ahead - a.ahead, far * mm_per_px);
        Some(Stretch {
            at: axis.at,
            ahead: axis.ahead,
            along: way.map(|c| c / far),
            slope: (b.ahead - a.ahead) / far,
            half_step,
            // At a tip only the rope's side is read.
            ends: match (rope.closed, i) {
                (false, 0) => [0.5, half_step + 1.0],
                (false, _) if i + 1 == count => [-half_step - 1.0, -0.5],
                _ => [-half_step, half_step],
            },
            mm_per_px,
            radius,
            inner: inner.max(0.5),
            sine: aside / length(ahead_way, aside),
        })
    }

    /// How far ahead of the depth camera the axis is at a point, by what is measured around it; and its variance.
    fn around(
        &mut self,
        image: &DepthImage,
        rope: &SeenRope,
        i: usize,
        reading: Reading,
    ) -> Option<(f64, f64)> {
        let Stretch {
            at,
            ahead: about,
            along,
            slope,
            half_step,
            ends: [first, last],
            mm_per_px,
            radius,
            inner,
            sine,
        } = self.stretch(rope, i)?;
        let sigma = length(self.camera.sigma_mm(about), image.rounding_mm());
        let gate = match reading {
            Reading::Glance => 6.0 * radius + 5.0 * sigma + STEEPEST * 3.0 * half_step * mm_per_px,
            Reading::Whole => radius + 5.0 * sigma,
        };
        let (across, lengthwise) = match reading {
            Reading::Glance => (1, 1),
            Reading::Whole => (
                (inner as usize).min(ACROSS / 2),
                (2.0 * half_step).round().clamp(1.0, ALONG as f64) as usize,
            ),
        };
        self.samples.clear();
        let mut previous = [isize::MIN; 2];
        for step in 0..lengthwise {
            let share = (step as f64 + 0.5) / lengthwise as f64;
            let on = first + share * (last - first);
            for beside in 0..=2 * across {
                let off = beside as f64 - across as f64;
                let wanted = [
                    at[0] + on * along[0] - off * along[1],
                    at[1] + on * along[1] + off * along[0],
                ];
                let pixel = wanted.map(pixel);
                if pixel == previous {
                    continue;
                }
                previous = pixel;
                let from = [0, 1].map(|k| pixel[k] as f64 - at[k]);
                let off = from[1] * along[0] - from[0] * along[1];
                let on = from[0] * along[0] + from[1] * along[1];
                if off.abs() > inner {
                    continue;
                }
                let Some(measured) = image.at(pixel[0], pixel[1]) else {
                    continue;
                };
                let beside_mm = off * mm_per_px;
                let rise = (radius * radius - beside_mm * beside_mm).max(0.0).sqrt() / sine;
                let ahead = measured + rise - slope * on;
                if (ahead - about).abs() < gate {
                    self.samples.push(ahead);
                }
            }
        }
        middle(&mut self.samples, sigma).map(|(ahead, variance)| {
            let off = RADIUS_ERROR * radius / sine;
            (ahead, variance + off * off)
        })
    }
}

/// The middle of what is measured, and its variance; none of nothing.
fn middle(samples: &mut [f64], sigma: f64) -> Option<(f64, f64)> {
    let count = samples.len();
    if count == 0 {
        return None;
    }
    let (_, &mut median, _) = samples.select_nth_unstable_by(count / 2, f64::total_cmp);
    let near = || {
        samples
            .iter()
            .filter(|&&s| (s - median).abs() < 2.5 * sigma)
    };
    let inside = near().count().max(1) as f64;
    let mean = near().sum::<f64>() / inside;
    let mean = if near().count() == 0 { median } else { mean };
    let spread = near().map(|s| (s - mean) * (s - mean)).sum::<f64>() / (inside - 1.0).max(1.0);
    Some((mean, spread.max(sigma * sigma) / (READ_ONCE * inside)))
}

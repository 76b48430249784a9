//! Bounds of a rope whose middle cannot be measured because strands are on or next to each other.
//! Each strand is still inside the area that shows rope.

use super::{Scene, is_bare};
use crate::centerline::line::Line;
use crate::centerline::section::Measure;
use crate::vec2;

/// Weight of a place that is only known to be within bounds.
const BOUNDED: f32 = 0.3;
/// Distance to either side in which bounds are sought, in half-widths.
const REACH: f32 = 2.5;
/// Minimum width of the rope area into which a place outside of it is moved, in half-widths.
const ROOM: f32 = 1.5;
/// Distance from an end, in half-widths, within which the rope itself ends.
const TIP: f32 = 1.5;

/// Moves each unmeasured sample, except at the tips, until half a rope fits on either side of it.
pub(super) fn hold(line: &mut Line, scene: &Scene, how: Measure) {
    let n = line.samples.len();
    let tip = (TIP * how.half_px / how.step_px) as usize + 1;
    let tip = if line.closed { 0 } else { tip };
    for i in tip..n.saturating_sub(tip) {
        if line.samples[i].weight > 0.0 {
            continue;
        }
        let slope = line.slope(i, how.tangent_reach());
        let normal = vec2::normal(vec2::unit_or(slope, [1.0, 0.0]));
        let sample = &mut line.samples[i];
        let is_rope = |px: f32| !is_bare(vec2::along(sample.at, normal, px), scene);
        if let Some(by_px) = off_px(is_rope, how.half_px) {
            sample.at = vec2::along(sample.at, normal, by_px);
            (sample.weight, sample.width_px) = (BOUNDED, 2.0 * how.half_px);
        }
    }
}

/// Movement along its normal that a place needs for half a rope to fit on either side. `is_rope`
/// returns whether a place on the normal shows rope. `None` if no movement is needed, or nothing
/// near has enough room.
fn off_px(is_rope: impl Fn(f32) -> bool, half_px: f32) -> Option<f32> {
    let [far, beyond] = [REACH, REACH + 2.0].map(|halves| (halves * half_px) as i32);
    let leaves = |from: i32, sign: i32| {
        let mut places = from..=beyond;
        let edge = places.find(|&k| !is_rope((sign * k) as f32));
        edge.unwrap_or(beyond + 1)
    };
    if is_rope(0.0) {
        let [left, right] = [-1, 1].map(|sign| leaves(1, sign) as f32 - 0.5 - half_px);
        return match (left < 0.0, right < 0.0) {
            (true, false) => Some(right.min(-left)),
            (false, true) => Some(-left.min(-right)),
            _ => None,
        };
    }
    let enters = |sign: i32| {
        let mut places = 1..=far;
        let edge = places.find(|&k| is_rope((sign * k) as f32))?;
        Some((edge, sign))
    };
    let (edge, sign) = [-1, 1].into_iter().filter_map(enters).min()?;
    let room_px = (leaves(edge, sign) - edge) as f32;
    let inward_px = edge as f32 - 0.5 + half_px.min(0.5 * room_px);
    (room_px >= ROOM * half_px).then_some(sign as f32 * inward_px)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_moved_until_half_a_rope_has_room_to_either_side() {
        // Two strands side by side, from -4.5 to 15.5 px, of a rope of 10 px.
        let strands = |px: f32| (-4.5..15.5).contains(&px);
        let seen_from = |at: f32| off_px(|px| strands(at + px), 5.0);
        for (at, to) in [
            (-2.0, 0.5),
            (-4.0, 0.5),
            (-9.0, 0.5),
            (14.0, 10.5),
            (19.0, 10.5),
        ] {
            let moved = at + seen_from(at).expect("it has no room there");
            assert!((moved - to).abs() <= 0.51, "from {at} to {moved}");
        }
        for at in [2.0, 5.0, 9.0, 40.0] {
            assert_eq!(seen_from(at), None, "from {at}");
        }
        // A sliver has no room for a rope.
        assert_eq!(off_px(|px| (3.0..8.0).contains(&px), 5.0), None);
    }
}

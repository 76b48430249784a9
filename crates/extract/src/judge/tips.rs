//! The surroundings of a curve's tips within the picture. Ropes end on the table. Fragments of a
//! rope end at a strand, before a gap, or in the middle of the network's rope.

use crate::image::gray::GrayPlane;
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Maximum distance of a tip from a strand's edge, in widths, for the tip to be at that strand.
const AT: f32 = 1.0;
/// Cosine of the maximum angle between a tip's direction and that of the nearest point of a strand,
/// for the tip to point at it: 60°. A rope that ends next to another one points past it.
const POINTS: f32 = 0.5;
/// Length of a curve next to its tip, in widths, that is always near the tip and does not count.
const OWN: f32 = 3.0;
/// Maximum distance of two tips of a torn rope, in widths.
const TORN: f32 = 8.0;
/// Cosine of the maximum angle at which the two tips of a torn rope point at each other.
const FACING: f32 = 0.8;
/// Length, in widths, over which the direction of a tip is taken.
const BACK: f32 = 1.5;
/// Distances beyond a tip, in widths, at which its own blur has ended.
const BEYOND: [f32; 3] = [1.5, 2.5, 3.5];

/// A tip, and the direction there, away from the curve.
#[derive(Clone, Copy)]
struct Tip {
    at: Vec2,
    out: Vec2,
}

/// A curve's tips within the picture, with the index of each end.
fn tips(curve: &Curve) -> impl Iterator<Item = (usize, Tip)> {
    let ends = (0..2).filter(|&end| !curve.closed && !curve.border[end]);
    ends.filter_map(|end| {
        let points = &curve.points;
        let last = points.len().checked_sub(1)?;
        let step_px = curve.spacing_px().max(0.1);
        let back = ((BACK * curve.width_px / step_px) as usize).clamp(1, last.max(1));
        let (at, before) = match end {
            0 => (points[0], *points.get(back)?),
            _ => (points[last], points[last.checked_sub(back)?]),
        };
        let out = vec2::unit_or(vec2::sub(at, before), [1.0, 0.0]);
        Some((end, Tip { at, out }))
    })
}

/// Share of a curve's two tips that point at the flank of a strand or are within it. The strand may
/// be another curve, or another place on the same one.
pub(super) fn met(curves: &[Curve], number: usize) -> f32 {
    let curve = &curves[number];
    let is_met = |&(end, tip): &(usize, Tip)| {
        let mut others = curves.iter().enumerate();
        others.any(|(other, strand)| {
            let flank_px = 0.5 * strand.width_px;
            let own_px = (other == number).then_some((OWN + AT) * curve.width_px + flank_px);
            is_at_flank(tip, strand, flank_px, AT * curve.width_px, |from_ends_px| {
                own_px.is_none_or(|own_px| from_ends_px[end] > own_px)
            })
        })
    };
    0.5 * tips(curve).filter(is_met).count() as f32
}

/// Returns whether a tip points at the flank of a strand that is at most `near_px` away, or is
/// within the strand. `counts` chooses the strand's points by their arc lengths to its two ends, in
/// pixels.
fn is_at_flank(
    tip: Tip,
    strand: &Curve,
    flank_px: f32,
    near_px: f32,
    counts: impl Fn([f32; 2]) -> bool,
) -> bool {
    let step_px = strand.spacing_px().max(0.1);
    let last = strand.points.len().saturating_sub(1);
    let (mut nearest, mut nearest_px) = (None, flank_px + near_px);
    let mut i = 0;
    while let Some(&point) = strand.points.get(i) {
        let off_px = vec2::distance(tip.at, point);
        if off_px <= nearest_px && counts([i, last - i].map(|steps| steps as f32 * step_px)) {
            (nearest, nearest_px) = (Some(i), off_px);
        }
        // A point nearer than the nearest one is at least this many steps away.
        i += (((off_px - nearest_px) / step_px) as usize).max(1);
    }
    nearest.is_some_and(|i| {
        let is_end = !strand.closed && (i == 0 || i == last);
        let ahead_px = vec2::dot(tip.out, vec2::sub(strand.points[i], tip.at));
        !is_end && (nearest_px <= flank_px || ahead_px >= POINTS * nearest_px)
    })
}

/// Returns how clearly one of a curve's tips continues at another tip beyond a gap: 1 without a
/// gap, 0 from [`TORN`] widths on.
pub(super) fn torn(curves: &[Curve], number: usize) -> f32 {
    let curve = &curves[number];
    let mut most = 0.0f32;
    for (end, tip) in tips(curve) {
        for (other, strand) in curves.iter().enumerate() {
            for (_, facing) in tips(strand).filter(|tip| (other, tip.0) != (number, end)) {
                let way = vec2::sub(facing.at, tip.at);
                let along = vec2::unit_or(way, tip.out);
                let faces = vec2::dot(tip.out, along).min(-vec2::dot(facing.out, along));
                if faces > FACING {
                    most = most.max(1.0 - vec2::norm(way) / (TORN * curve.width_px.max(1.0)));
                }
            }
        }
    }
    most
}

/// The network's output beyond a curve's tips, as the mean of both.
pub(super) fn beyond(likely: &GrayPlane, curve: &Curve) -> f32 {
    let seen = tips(curve).map(|(_, Tip { at, out })| {
        let beyond = likely.sample_each(at, out, BEYOND.map(|widths| widths * curve.width_px));
        beyond.into_iter().fold(0.0, f32::max)
    });
    0.5 * seen.sum::<f32>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight rope, 8 px wide, from one place to another.
    fn rope(from: Vec2, to: Vec2) -> Curve {
        let share = |k: usize| k as f32 / 50.0;
        let mut curve = Curve::default();
        let points = (0..=50).map(|k| vec2::along(from, vec2::sub(to, from), share(k)));
        curve.points.extend(points);
        curve.width_px = 8.0;
        curve.length_px = vec2::distance(from, to);
        curve
    }

    #[test]
    fn a_tip_at_a_strand_is_met_and_one_that_lies_free_is_not() {
        let strand = rope([0.0, 50.0], [200.0, 50.0]);
        let upright = |to: f32| rope([100.0, 180.0], [100.0, to]);
        for (to, expected) in [(50.0, 0.5), (61.0, 0.5), (70.0, 0.0), (20.0, 0.0)] {
            let curves = [strand.clone(), upright(to)];
            assert_eq!(met(&curves, 1), expected, "to {to}");
            assert_eq!(met(&curves, 0), 0.0);
        }
    }

    #[test]
    fn ropes_that_end_beside_others_are_not_met() {
        let strand = rope([0.0, 50.0], [200.0, 50.0]);
        for beside in [
            rope([30.0, 60.0], [170.0, 60.0]),
            rope([0.0, 60.0], [200.0, 60.0]),
            rope([208.0, 50.0], [400.0, 50.0]),
        ] {
            let curves = [strand.clone(), beside];
            assert_eq!([met(&curves, 0), met(&curves, 1)], [0.0; 2]);
        }
    }

    #[test]
    fn a_rope_that_comes_back_to_itself_is_met_there() {
        // Three sides of a square, with the last tip at the middle of the first side.
        let mut curve = Curve::default();
        let corners = [
            [20.0, 20.0],
            [180.0, 20.0],
            [180.0, 120.0],
            [100.0, 120.0],
            [100.0, 28.0],
        ];
        for side in corners.windows(2) {
            let way = vec2::sub(side[1], side[0]);
            let steps = (vec2::norm(way) / 4.0) as usize;
            let places = (0..steps).map(|k| vec2::along(side[0], way, k as f32 / steps as f32));
            curve.points.extend(places);
        }
        (curve.width_px, curve.length_px) = (8.0, 4.0 * (curve.points.len() - 1) as f32);
        assert_eq!(met(&[curve], 0), 0.5);
    }

    #[test]
    fn a_rope_torn_in_two_is_plainer_the_smaller_the_gap() {
        let at = |gap_px: f32| {
            let curves = [
                rope([0.0, 50.0], [90.0, 50.0]),
                rope([90.0 + gap_px, 50.0], [220.0, 50.0]),
            ];
            assert_eq!(torn(&curves, 0), torn(&curves, 1));
            torn(&curves, 0)
        };
        // Eight widths are 64 px.
        assert!((at(16.0) - 0.75).abs() < 1e-3 && (at(32.0) - 0.5).abs() < 1e-3);
        assert_eq!(at(70.0), 0.0);
        let across = [
            rope([0.0, 50.0], [90.0, 50.0]),
            rope([106.0, 50.0], [106.0, 180.0]),
        ];
        assert_eq!(torn(&across, 0), 0.0);
    }

    #[test]
    fn an_end_at_the_border_is_no_tip() {
        let mut curves = [
            rope([0.0, 50.0], [90.0, 50.0]),
            rope([100.0, 50.0], [220.0, 50.0]),
        ];
        assert!(torn(&curves, 0) > 0.8);
        curves[1].border[0] = true;
        assert_eq!(torn(&curves, 0), 0.0);
    }
}

//! Determines the points of a rope that another strand covers, where a depth image shows that
//! strand instead.

use lariat_wire::{Centerlines, Crossing, Curve, MAX_POINTS};

/// Margin next to the upper strand within which its depth may be read, px of the color image. The
/// edges of a depth image are mixed.
const MARGIN_PX: f32 = 3.0;
/// Minimum confidence in the order of a crossing. Below it, neither strand has depth there.
const SURE: f32 = 0.75;
/// Distance from the crossing within which strands are compared, in widths of the upper one.
const ALONG: f32 = 8.0;

/// Buffer for the result.
pub(super) struct Covered(Box<[bool; MAX_POINTS]>);

impl Default for Covered {
    fn default() -> Self {
        Self(Box::new([false; MAX_POINTS]))
    }
}

impl Covered {
    /// Returns for each point of the frame's `i`-th curve whether a strand covers it or extraction
    /// marked it as hidden.
    pub(super) fn of(&mut self, seen: &Centerlines, i: usize, curve: &Curve) -> &[bool] {
        let count = curve.points().len();
        let covered = &mut self.0[..count];
        for (k, covered) in covered.iter_mut().enumerate() {
            *covered = curve.is_hidden(k);
        }
        for crossing in seen.crossings() {
            let [over, under] = [
                (crossing.over, crossing.over_rho),
                (crossing.under, crossing.under_rho),
            ];
            let is_sure = crossing.confidence >= SURE;
            if under.0 as usize == i {
                cover(seen, crossing, [over, under], covered);
            }
            if over.0 as usize == i && !is_sure {
                cover(seen, crossing, [under, over], covered);
            }
        }
        covered
    }
}

/// Covers the points of the second strand within the width of the first. Each strand is given by
/// the index of its curve and the ρ of the crossing.
fn cover(
    seen: &Centerlines,
    crossing: &Crossing,
    [above, below]: [(u32, f32); 2],
    covered: &mut [bool],
) {
    let (Some(upper), Some(lower)) = (
        seen.curves().get(above.0 as usize),
        seen.curves().get(below.0 as usize),
    ) else {
        return;
    };
    let [top, at] = [place(upper, above.1), place(lower, below.1)];
    let (Some(top), Some(at)) = (top, at) else {
        return;
    };
    let Some(&width) = upper.widths_px().get(top) else {
        return;
    };
    let reach = 0.5 * width + MARGIN_PX;
    let far = ALONG * width.max(1.0);
    let is_near = |p: [f32; 2]| squared_distance(p, crossing.at) < far * far;
    let is_strand = |j: usize| above.0 != below.0 || j.abs_diff(top) < j.abs_diff(at);
    let strand = upper.points();
    let [mut first, mut last] = [strand.len(), 0];
    for (j, &point) in strand.iter().enumerate() {
        if is_near(point) && is_strand(j) {
            (first, last) = (first.min(j), j + 1);
        }
    }
    let last = last.min(strand.len().saturating_sub(1));
    for (k, (&point, covered)) in lower.points().iter().zip(covered).enumerate() {
        // If a rope crosses itself, a point belongs to the strand that is nearer along the rope.
        let is_own = above.0 != below.0 || k.abs_diff(at) < k.abs_diff(top);
        if !is_near(point) || !is_own {
            continue;
        }
        for j in first..last {
            let step = [strand[j], strand[j + 1]];
            *covered |= is_strand(j) && squared_from_step(point, step) < reach * reach;
        }
    }
}

/// Returns the index of the curve's point that is nearest to this ρ.
fn place(curve: &Curve, rho: f32) -> Option<usize> {
    let last = curve.points().len().checked_sub(1)?;
    Some(((rho.clamp(0.0, 1.0) * last as f32).round() as usize).min(last))
}

fn squared_distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    let [x, y] = [a[0] - b[0], a[1] - b[1]];
    x * x + y * y
}

/// Returns the squared distance of a point from the segment between two others.
fn squared_from_step(point: [f32; 2], [a, b]: [[f32; 2]; 2]) -> f32 {
    let way = [b[0] - a[0], b[1] - a[1]];
    let from = [point[0] - a[0], point[1] - a[1]];
    let size = way[0] * way[0] + way[1] * way[1];
    let share = match size > 0.0 {
        true => ((from[0] * way[0] + from[1] * way[1]) / size).clamp(0.0, 1.0),
        false => 0.0,
    };
    squared_distance(point, [a[0] + share * way[0], a[1] + share * way[1]])
}

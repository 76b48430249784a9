//! Ends of edges, measured as strands that come out of a crossing.

use super::Ground;
use crate::graph::arm::Arm;
use crate::graph::zones::{Zones, strand_color};
use crate::skeleton::NONE;
use crate::vec2::{self, Vec2};

/// An end of an edge, as a strand that comes out of a crossing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mouth {
    pub(super) arm: Arm,
    /// Curvature of the strand toward the crossing, in radians per pixel.
    pub(super) curvature: f32,
}

impl Mouth {
    pub(super) const NONE: Self = Self {
        arm: Arm {
            edge: NONE,
            end: 0,
            zone: 0,
            trim: 0,
            at: [0.0; 2],
            into: [0.0; 2],
            half_px: 0.0,
            color: [0.0; 3],
            past: crate::past::FormerPlaces::NONE,
        },
        curvature: 0.0,
    };
}

/// Length over which a strand's curvature is measured, and minimum length of a strand for this, in
/// half-widths.
pub(super) const CURVED: (f32, f32) = (9.0, 4.0);

/// Measures one end of an edge.
pub(super) fn mouth(e: usize, end: u8, of: Ground, zones: &Zones) -> Mouth {
    let mut arm = zones.arm(e, end, 0, of.graph, of.skeleton);
    let junction = of.graph.edges[e].nodes[usize::from(end)];
    if junction == NONE || of.graph.nodes[junction as usize].degree < 2 {
        return Mouth {
            arm,
            curvature: 0.0,
        };
    }
    arm.color = strand_color(of.image, of.graph, &arm, of.skeleton);
    arm.past = zones.past.recall(arm.at, arm.into);
    let pixels = of.graph.pixels(e);
    let at = |i: usize| {
        let i = if end == 0 { i } else { pixels.len() - 1 - i };
        of.skeleton.pixels[pixels[i] as usize].at()
    };
    let from = arm.trim as usize;
    let to = (from + (CURVED.0 * arm.half_px) as usize).min(pixels.len() - 1);
    if ((to - from) as f32) < CURVED.1 * arm.half_px {
        return Mouth {
            arm,
            curvature: 0.0,
        };
    }
    let middle = (from + to) / 2;
    let halves: [Vec2; 2] = [
        vec2::sub(at(middle), at(to)),
        vec2::sub(at(from), at(middle)),
    ];
    let px = 0.5 * (vec2::norm(halves[0]) + vec2::norm(halves[1]));
    let curvature = vec2::angle(halves[0], halves[1]) / px.max(1.0);
    // The fitted line has the arc's direction in the middle of the fit, so it is turned to the
    // direction at the arc's end.
    let reach_px = arm.reach_px().min(pixels.len() - from) as f32;
    let (sin, cos) = libm::sincosf(0.5 * curvature * reach_px);
    let [x, y] = arm.into;
    let into = [cos * x - sin * y, sin * x + cos * y];
    Mouth {
        arm: Arm { into, ..arm },
        curvature,
    }
}

//! Crossings of ropes that are followed: which points they cover, and how they move along.

use super::axis;
use crate::crossings::meet;
use crate::crossings::place::Place;
use crate::scene::{Crossing, Curve};
use crate::vec2::{self, Vec2};

/// Maximum movement of a crossing along its ropes from one frame to the next, in points.
const CROSSING: usize = 4;
/// Distance up to which a crossing strand blurs its surroundings: a factor of its width, plus
/// pixels.
const CLEAR: f32 = 1.1;
const CLEAR_PX: f32 = 2.0;

/// A rope that others may cross.
pub(super) trait Crossed {
    /// Clears the marks of all crossings.
    fn clear_crossings(&mut self);

    /// Marks the points covered by a strand that crosses at normalized arc length `rho`.
    fn cross(&mut self, rho: f32, over: &Over);

    /// Position and normal at normalized arc length `rho`.
    fn at(&self, rho: f32) -> (Vec2, Vec2);

    fn width_px(&self) -> f32;
}

/// A strand where it crosses another one.
pub(super) struct Over {
    at: Vec2,
    across: Vec2,
    clear_px: f32,
    /// Half the other strand's width.
    half_px: f32,
}

impl Over {
    /// Returns whether this strand reaches into the row or column that is read at a point of the
    /// other strand.
    pub(super) fn covers(&self, at: Vec2, normal: Vec2) -> bool {
        let axis = axis(normal);
        let reach_px = (self.half_px / normal[axis] * self.across[axis]).abs();
        vec2::dot(vec2::sub(at, self.at), self.across).abs() < self.clear_px + reach_px
    }
}

/// Marks on each rope where others cross it.
pub(super) fn note(ropes: &mut [impl Crossed], crossings: &[Crossing]) {
    ropes.iter_mut().for_each(Crossed::clear_crossings);
    for crossing in crossings {
        let over = (crossing.over, crossing.over_rho);
        let under = (crossing.under, crossing.under_rho);
        for ((rope, rho), (other, other_rho)) in [(over, under), (under, over)] {
            let (_, [x, y]) = ropes[other].at(other_rho);
            let over = Over {
                at: ropes[rope].at(rho).0,
                across: vec2::normal([y, -x]),
                clear_px: 0.5 * ropes[other].width_px() * CLEAR + CLEAR_PX,
                half_px: 0.5 * ropes[rope].width_px(),
            };
            ropes[rope].cross(rho, &over);
        }
    }
}

/// Moves a crossing to where the curves now meet near it. Returns false if they do not. No new
/// crossing can appear unnoticed. Strands that newly overlap cannot be distinguished, and lead to a
/// full extraction.
pub(super) fn carry(curves: &[Curve], crossing: &mut Crossing) -> bool {
    let pieces = |curve: usize| curves[curve].intervals() as f32;
    let place = |curve, rho: f32| Place {
        curve,
        at: rho * pieces(curve),
    };
    let over = place(crossing.over, crossing.over_rho);
    let under = place(crossing.under, crossing.under_rho);
    let Some(meeting) = meet::near(curves, over, under, CROSSING) else {
        return false;
    };
    crossing.at = meeting.at;
    crossing.over_rho = meeting.a.at / pieces(crossing.over);
    crossing.under_rho = meeting.b.at / pieces(crossing.under);
    true
}

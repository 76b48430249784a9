//! Whether a rope that crosses itself is knotted: its crossing sequence, and what is left when its ends are drawn apart.
//!
//! The picture of an open rope is a *knotoid* diagram (V. Turaev, "Knotoids", 2012): a line with two ends that may lie
//! anywhere, also within a loop. The model of pulling: each end is gripped where it is, lifted over everything else and
//! carried off; the rope never passes through itself, and no other rope holds it. In Turaev's words the ends are joined
//! by an arc over all the rest, and the question is whether the knot that this closes is trivial.
//!
//! *Pulls straight* is said when moves that a rope can make take every crossing away: Reidemeister's three moves, and
//! the slipping of an end out of a crossing that it lies over (`diagram`). *Knotted* is said when the Alexander
//! polynomial of the closed rope is not that of a straight one (`alexander`): its value at −1 is the knot's
//! determinant, 3 for an overhand knot, 5 for a figure-eight. Between the two nothing is said.

mod alexander;
mod diagram;

use crate::scene::{MOST_CROSSINGS, Scene, Status};
use crate::vec2::{self, Vec2};
use diagram::Diagram;
use std::fmt;

/// Below this confidence a crossing may be either way: what is said of the rope is then true of both.
const UNSURE: f32 = 0.1;
/// More unsure crossings than this (64 diagrams), and nothing is said.
const MOST_UNSURE: usize = 6;
/// The share of the rope to each side of a crossing over which its direction is taken.
const REACH: f32 = 0.01;

/// A place where the rope passes itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pass {
    /// Which crossing, numbered from 0 in the order in which the rope first comes by.
    pub crossing: usize,
    /// Whether this is the upper strand.
    pub over: bool,
}

/// A rope's passes over and under itself, from its first point to its last.
///
/// `Display` writes it with crossings numbered from 1: `O1 U2 O3 U1 O2 U3` is an overhand knot.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossingSequence {
    diagram: Diagram,
    /// Of each crossing.
    confidences: Vec<f32>,
    /// Whether all of the rope's crossings are known, and it has two ends to draw.
    whole: bool,
}

impl CrossingSequence {
    /// The sequence of `scene.curves[curve]`. Its crossings with other ropes are no part of it.
    ///
    /// # Panics
    /// When there is no such curve.
    pub fn of(scene: &Scene, curve: usize) -> Self {
        let rope = &scene.curves[curve];
        let mut passes = Vec::new();
        let mut signs = Vec::new();
        let mut confidences = Vec::new();
        for crossing in scene.crossings {
            if (crossing.over, crossing.under) != (curve, curve) {
                continue;
            }
            let direction = |rho: f32| {
                let ahead = along(&rope.points, rho + REACH);
                vec2::sub(ahead, along(&rope.points, rho - REACH))
            };
            let turn = vec2::cross(direction(crossing.over_rho), direction(crossing.under_rho));
            for (rho, over) in [(crossing.over_rho, true), (crossing.under_rho, false)] {
                let pass = Pass {
                    crossing: signs.len(),
                    over,
                };
                passes.push((rho, pass));
            }
            signs.push(turn > 0.0);
            confidences.push(crossing.confidence);
        }
        passes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let passes: Vec<Pass> = passes.into_iter().map(|(_, pass)| pass).collect();
        let order = in_order_of_appearance(&passes);
        Self {
            diagram: Diagram::new(&passes, &signs).renumbered(&order),
            confidences: order.iter().map(|&old| confidences[old]).collect(),
            whole: rope.status == Status::Ok
                && !rope.closed
                && scene.crossings.len() < MOST_CROSSINGS,
        }
    }

    /// The passes, from the rope's first point on: two for each crossing.
    pub fn passes(&self) -> &[Pass] {
        self.diagram.passes()
    }

    /// The least confidence among the crossings; 1 without one.
    pub fn confidence(&self) -> f32 {
        self.confidences.iter().copied().fold(1.0, f32::min)
    }

    /// Whether the rope comes out straight when its ends are drawn apart; `None` when that is not decided.
    ///
    /// `Some(false)`, knotted, is proven, and so is `Some(true)`, for the crossings as they were seen. A crossing of
    /// less confidence than 0.1 counts as not seen which way: an answer is then given if it is the same for both ways.
    /// None is given for a rope without ends, one that is lost or partly hidden, and crossings that do not fit into a
    /// plane, so that one of them must have been missed.
    pub fn pulls_straight(&self) -> Option<bool> {
        let is_unsure = |&crossing: &usize| self.confidences[crossing] < UNSURE;
        let unsure: Vec<usize> = (0..self.confidences.len()).filter(is_unsure).collect();
        if !self.whole || unsure.len() > MOST_UNSURE || !self.diagram.is_planar() {
            return None;
        }
        let mut answer = None;
        for choice in 0..1usize << unsure.len() {
            let mut diagram = self.diagram.clone();
            for (bit, &crossing) in unsure.iter().enumerate() {
                if choice >> bit & 1 == 1 {
                    diagram.turn_over(crossing);
                }
            }
            let this = pulls_straight(diagram)?;
            if *answer.get_or_insert(this) != this {
                return None;
            }
        }
        answer
    }
}

/// For a diagram whose crossings are all as they are drawn.
fn pulls_straight(diagram: Diagram) -> Option<bool> {
    if alexander::proves_a_knot(diagram.passes(), diagram.signs()) {
        return Some(false);
    }
    diagram.comes_apart().then_some(true)
}

/// The crossings as they are first met.
fn in_order_of_appearance(passes: &[Pass]) -> Vec<usize> {
    let mut order = Vec::new();
    for pass in passes {
        if !order.contains(&pass.crossing) {
            order.push(pass.crossing);
        }
    }
    order
}

/// The position at a normalized arc length; before the first point and after the last, those. The origin, where there
/// are no points.
fn along(points: &[Vec2], rho: f32) -> Vec2 {
    let Some(last) = points.len().checked_sub(1) else {
        return [0.0; 2];
    };
    let at = rho.clamp(0.0, 1.0) * last as f32;
    let i = (at as usize).min(last.saturating_sub(1));
    let next = (i + 1).min(last);
    vec2::along(points[i], vec2::sub(points[next], points[i]), at - i as f32)
}

impl fmt::Display for CrossingSequence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, pass) in self.passes().iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            let side = if pass.over { 'O' } else { 'U' };
            write!(f, "{gap}{side}{}", pass.crossing + 1)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;

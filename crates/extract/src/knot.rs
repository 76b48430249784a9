//! Decides from its crossing sequence whether a rope that crosses itself is knotted: whether a knot
//! remains when its ends are pulled apart.
//!
//! The picture of an open rope is a *knotoid* diagram (V. Turaev, "Knotoids", 2012): a line with
//! two ends that can be anywhere, also within a loop. In the model of pulling, each end is gripped
//! where it is, lifted over everything else and carried away. The rope never passes through itself,
//! and no other rope holds it. In Turaev's terms, an arc over everything else joins the ends, and
//! the question is whether the closed knot is trivial.
//!
//! The answer *pulls straight* means that moves that a rope can make remove every crossing. These
//! are Reidemeister's three moves, and an end that slips out of a crossing that it lies over
//! (`diagram`). The answer *knotted* means that the Alexander polynomial of the closed rope is not
//! that of a straight one (`alexander`). Its value at −1 is the knot's determinant, 3 for an
//! overhand knot and 5 for a figure-eight. All other cases are left undecided.
//!
//! Both are proofs about the diagram, and the picture may show another one. A crossing may be seen
//! the wrong way, or the curve may be wrong. An answer is therefore given only at a probability of
//! [`LEAST`] or more. The rope must be seen whole and nowhere be as wide as two strands: a tight
//! knot shows no crossings, but a bump.

mod alexander;
mod diagram;

use crate::scene::{Crossing, Curve, MOST_CROSSINGS, Scene, Status};
use crate::vec2::{self, Vec2};
use diagram::Diagram;
use std::fmt;

/// Minimum probability at which an answer is given: one in ten may be wrong.
const LEAST: f32 = 0.9;
/// Number of least confident crossings that are tried both ways (64 diagrams). All others are taken
/// as seen.
const MOST_UNSURE: usize = 6;
/// Width of a bump, in widths of the rope: halfway between one strand and two.
const BUMP: f32 = 1.5;
/// Arc length on each side of a crossing within which its other strand widens the rope, in widths.
/// A crossing at 30° is 1 / sin 30° long.
const CROSSED: f32 = 2.0;
/// Share of the rope's length, to each side of a crossing, over which its direction is taken.
const REACH: f32 = 0.01;

/// A place where the rope passes over or under itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pass {
    /// Number of the crossing, from 0, in the order in which the rope first reaches them.
    pub crossing: usize,
    /// True for the upper strand.
    pub over: bool,
}

/// A rope's passes over and under itself, from its first point to its last.
///
/// `Display` writes it with crossings numbered from 1: `O1 U2 O3 U1 O2 U3` is an overhand knot.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossingSequence {
    diagram: Diagram,
    /// Confidence of each crossing.
    confidences: Vec<f32>,
    /// Probability that the curve and the places of its crossings are right. It is 0 for a closed
    /// rope, one that is not seen whole, and one with a bump.
    certainty: f32,
}

impl CrossingSequence {
    /// The sequence of `scene.curves[curve]`, without its crossings with other ropes.
    ///
    /// # Panics
    /// If there is no such curve.
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
            certainty: if is_seen_whole(rope)
                && scene.crossings.len() < MOST_CROSSINGS
                && !has_bump(scene, curve)
            {
                rope.confidence
            } else {
                0.0
            },
        }
    }

    /// The passes from the rope's first point on, two for each crossing.
    pub fn passes(&self) -> &[Pass] {
        self.diagram.passes()
    }

    /// Minimum confidence of the crossings; 1 without any.
    pub fn confidence(&self) -> f32 {
        self.confidences.iter().copied().fold(1.0, f32::min)
    }

    /// Returns whether the rope comes out straight when its ends are pulled apart; `None` if this
    /// is undecided.
    ///
    /// An answer is given if its probability is 0.9 or more. This is the probability of the curve
    /// ([`Curve::confidence`]) times that of all arrangements of the crossings
    /// ([`Crossing::confidence`]) that have this answer.
    ///
    /// Four kinds of ropes are undecided:
    /// - A closed rope.
    /// - A rope that is lost or partly hidden.
    /// - A rope with a bump, which may be a tight knot.
    /// - A rope whose crossings do not fit into a plane, so that one of them must have been missed.
    pub fn pulls_straight(&self) -> Option<bool> {
        if self.certainty < LEAST || !self.diagram.is_planar() {
            return None;
        }
        let mut order: Vec<usize> = (0..self.confidences.len()).collect();
        order.sort_by(|&a, &b| self.confidences[a].total_cmp(&self.confidences[b]));
        let (unsure, others) = order.split_at(order.len().min(MOST_UNSURE));
        // A crossing's confidence is 2p − 1.
        let as_seen = |&crossing: &usize| 0.5 + 0.5 * self.confidences[crossing];
        let certainty = self.certainty * others.iter().map(as_seen).product::<f32>();
        let mut probabilities = [0.0; 2];
        for choice in 0..1usize << unsure.len() {
            let mut diagram = self.diagram.clone();
            let mut probability = certainty;
            for (bit, crossing) in unsure.iter().enumerate() {
                if choice >> bit & 1 == 1 {
                    diagram.turn_over(*crossing);
                    probability *= 1.0 - as_seen(crossing);
                } else {
                    probability *= as_seen(crossing);
                }
            }
            if probability > 0.0
                && let Some(answer) = pulls_straight(diagram)
            {
                probabilities[usize::from(answer)] += probability;
            }
        }
        let is_given = |answer: &bool| probabilities[usize::from(*answer)] >= LEAST;
        [false, true].into_iter().find(is_given)
    }
}

fn is_seen_whole(rope: &Curve) -> bool {
    rope.status == Status::Ok && !rope.closed && !rope.hidden.contains(&true)
}

/// Returns whether the rope is wider than one strand anywhere away from its crossings.
fn has_bump(scene: &Scene, curve: usize) -> bool {
    let rope = &scene.curves[curve];
    let is_along = |crossing: &&Crossing| [crossing.over, crossing.under].contains(&curve);
    let rhos = |crossing: &Crossing| {
        let passes = [
            (crossing.over, crossing.over_rho),
            (crossing.under, crossing.under_rho),
        ];
        passes
            .into_iter()
            .filter(|pass| pass.0 == curve)
            .map(|pass| pass.1)
    };
    let crossed: Vec<f32> = (scene.crossings.iter())
        .filter(is_along)
        .flat_map(rhos)
        .collect();
    let last = rope.widths_px.len().saturating_sub(1).max(1) as f32;
    let is_crossed = |i: usize| {
        let is_near =
            |rho: &f32| (rho - i as f32 / last).abs() * rope.length_px <= CROSSED * rope.width_px;
        crossed.iter().any(is_near)
    };
    let is_wide = |width_px: f32| width_px > BUMP * rope.width_px;
    (rope.widths_px.iter().enumerate()).any(|(i, &width_px)| is_wide(width_px) && !is_crossed(i))
}

/// The answer for a diagram whose crossings are all as they are drawn.
fn pulls_straight(diagram: Diagram) -> Option<bool> {
    if alexander::proves_a_knot(diagram.passes(), diagram.signs()) {
        return Some(false);
    }
    diagram.comes_apart().then_some(true)
}

/// The crossings in the order in which they are first met.
fn in_order_of_appearance(passes: &[Pass]) -> Vec<usize> {
    let mut order = Vec::new();
    for pass in passes {
        if !order.contains(&pass.crossing) {
            order.push(pass.crossing);
        }
    }
    order
}

/// Position at a normalized arc length. Before the first point and after the last, it is that
/// point. Without points, it is the origin.
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

//! A rope's picture as a diagram, and the moves that take crossings away from it.
//!
//! Kept as a signed Gauss code: the passes in their order and the sign of each crossing. Together they fix the diagram
//! on the sphere, its faces included (the cyclic order of the four directions at each crossing), so that a move is a
//! matter of passes that stand beside each other. A rope is in one piece, so a face that a move needs empty is empty.

use super::Pass;
use std::collections::HashSet;

/// Diagrams looked at on the way to a straight rope. Each is made by one third move, of which a tangle of the most
/// crossings reported has some tens: enough for several in a row, in milliseconds.
const MOST_DIAGRAMS: usize = 500;

/// A signed Gauss code.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Diagram {
    passes: Vec<Pass>,
    /// Of each crossing: whether the lower strand's direction lies counter-clockwise of the upper one's (with y up;
    /// with y down all signs are the others, which is the same diagram in a mirror, knotted as much).
    signs: Vec<bool>,
}

impl Diagram {
    /// Of passes of which each crossing of `signs` has two, one over and one under.
    pub(super) fn new(passes: &[Pass], signs: &[bool]) -> Self {
        Self {
            passes: passes.to_vec(),
            signs: signs.to_vec(),
        }
    }

    pub(super) fn passes(&self) -> &[Pass] {
        &self.passes
    }

    pub(super) fn signs(&self) -> &[bool] {
        &self.signs
    }

    /// The same with only the crossings of `order`, which are then numbered by it.
    pub(super) fn renumbered(&self, order: &[usize]) -> Self {
        let renamed = |pass: &Pass| {
            let crossing = order.iter().position(|&old| old == pass.crossing)?;
            Some(Pass { crossing, ..*pass })
        };
        Self {
            passes: self.passes.iter().filter_map(renamed).collect(),
            signs: order.iter().map(|&old| self.signs[old]).collect(),
        }
    }

    /// Exchanges upper and lower strand of a crossing.
    pub(super) fn turn_over(&mut self, crossing: usize) {
        self.signs[crossing] = !self.signs[crossing];
        for pass in &mut self.passes {
            pass.over ^= pass.crossing == crossing;
        }
    }

    /// Whether it can be drawn in the plane without further crossings, by Euler's formula.
    ///
    /// n crossings and two ends are n + 2 vertices, joined by 2n + 1 edges: n + 1 faces.
    pub(super) fn is_planar(&self) -> bool {
        self.faces().len() == self.signs.len() + 1
    }

    /// Whether the moves take every crossing away.
    pub(super) fn comes_apart(mut self) -> bool {
        self.simplify();
        let mut seen = HashSet::from([self.clone()]);
        let mut waiting = vec![self];
        while let Some(diagram) = waiting.pop() {
            if diagram.signs.is_empty() {
                return true;
            }
            for mut next in diagram.third_moves() {
                next.simplify();
                if seen.len() < MOST_DIAGRAMS && seen.insert(next.clone()) {
                    waiting.push(next);
                }
            }
            // The fewest crossings are looked at first: the last.
            waiting.sort_by_key(|diagram| std::cmp::Reverse(diagram.signs.len()));
        }
        false
    }

    /// Takes crossings away as long as an end slips out, or the first or the second move applies.
    fn simplify(&mut self) {
        while let Some(gone) = self.end_over().or(self.first_move()).or(self.second_move()) {
            let rest: Vec<usize> = (0..self.signs.len())
                .filter(|crossing| !gone.contains(crossing))
                .collect();
            *self = self.renumbered(&rest);
        }
    }

    /// An end that lies over its outermost crossing slips out of it.
    fn end_over(&self) -> Option<[usize; 2]> {
        let ends = [self.passes.first(), self.passes.last()];
        let end = ends.into_iter().flatten().find(|pass| pass.over)?;
        Some([end.crossing; 2])
    }

    /// A loop with nothing across it opens.
    fn first_move(&self) -> Option<[usize; 2]> {
        let mut pairs = self.passes.windows(2);
        let twist = pairs.find(|pair| pair[0].crossing == pair[1].crossing)?;
        Some([twist[0].crossing; 2])
    }

    /// A strand that lies across another twice in a row slips off it.
    fn second_move(&self) -> Option<[usize; 2]> {
        self.passes.windows(2).find_map(|pair| {
            let [a, b] = [pair[0].crossing, pair[1].crossing];
            let below = |crossing| {
                let of = |pass: &Pass| pass.crossing == crossing && !pass.over;
                self.passes.iter().position(of)
            };
            let beside = below(a)?.abs_diff(below(b)?) == 1;
            let slips = pair[0].over && pair[1].over && beside && self.signs[a] != self.signs[b];
            slips.then_some([a, b])
        })
    }

    /// The diagrams that the third move makes: a strand moves across a crossing that lies wholly above or below it.
    fn third_moves(&self) -> Vec<Self> {
        let last = 2 * self.signs.len();
        let mut moved = Vec::new();
        for face in self.faces() {
            let edges: Vec<usize> = face.iter().map(|dart| dart / 2).collect();
            if edges.len() != 3 || edges.contains(&0) || edges.contains(&last) {
                continue;
            }
            // How often each side of the triangle passes over: the top one twice, the middle one once, the bottom not.
            let mut overs = [0, 1, 2].map(|side| {
                let edge: usize = edges[side];
                usize::from(self.passes[edge - 1].over) + usize::from(self.passes[edge].over)
            });
            overs.sort_unstable();
            let mut crossings: Vec<usize> =
                edges.iter().map(|&e| self.passes[e].crossing).collect();
            crossings.extend(edges.iter().map(|&e| self.passes[e - 1].crossing));
            crossings.sort_unstable();
            crossings.dedup();
            if overs == [0, 1, 2] && crossings.len() == 3 {
                let mut next = self.clone();
                for &edge in &edges {
                    next.passes.swap(edge - 1, edge);
                }
                moved.push(next);
            }
        }
        moved
    }

    /// The faces, each as the darts along its border.
    ///
    /// Edge e runs from pass e − 1 to pass e; the first begins and the last ends at an end of the rope. Dart 2e is the
    /// edge as it runs, 2e + 1 the edge backwards. After a dart comes the next in turn around the vertex it runs to.
    fn faces(&self) -> Vec<Vec<usize>> {
        let darts = 2 * (2 * self.signs.len() + 1);
        // At an end of the rope the way leads back.
        let mut turn: Vec<usize> = (0..darts).collect();
        for (crossing, &sign) in self.signs.iter().enumerate() {
            let place = |over: bool| {
                let of = |pass: &Pass| pass.crossing == crossing && pass.over == over;
                self.passes.iter().position(of)
            };
            let (Some(over), Some(under)) = (place(true), place(false)) else {
                continue;
            };
            let out = |pass: usize| 2 * (pass + 1);
            let back = |pass: usize| 2 * pass + 1;
            let around = if sign {
                [out(over), out(under), back(over), back(under)]
            } else {
                [out(over), back(under), back(over), out(under)]
            };
            for i in 0..4 {
                turn[around[i]] = around[(i + 1) % 4];
            }
        }
        let mut faces = Vec::new();
        let mut is_known = vec![false; darts];
        for first in 0..darts {
            let mut face = Vec::new();
            let mut dart = first;
            while !std::mem::replace(&mut is_known[dart], true) {
                face.push(dart);
                dart = turn[dart ^ 1];
            }
            if !face.is_empty() {
                faces.push(face);
            }
        }
        faces
    }
}

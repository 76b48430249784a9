//! A rope's picture as a diagram, and the moves that remove crossings from it.
//!
//! The diagram is a signed Gauss code: the passes in order and the sign of each crossing. Together
//! they fix the diagram on the sphere, including its faces (the cyclic order of the four directions
//! at each crossing). A move therefore depends only on adjacent passes. A rope is in one piece, so
//! a face that has to be empty for a move is empty.

use super::Pass;
use std::collections::HashSet;

/// Maximum number of diagrams examined on the way to a straight rope. Each is made by one third
/// move. A tangle of the most crossings reported allows some tens of such moves. The limit is
/// enough for several in a row, and takes milliseconds.
const MOST_DIAGRAMS: usize = 500;

/// A signed Gauss code.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Diagram {
    passes: Vec<Pass>,
    /// For each crossing, true if the lower strand's direction is counterclockwise of the upper
    /// one's, with y up. With y down, all signs are opposite: the mirror image of the diagram,
    /// which is just as knotted.
    signs: Vec<bool>,
}

impl Diagram {
    /// Creates a diagram. Each crossing of `signs` has two of the passes, one over and one under.
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

    /// The same diagram with only the crossings of `order`, which gives their new numbers.
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

    /// Exchanges the upper and lower strand of a crossing.
    pub(super) fn turn_over(&mut self, crossing: usize) {
        self.signs[crossing] = !self.signs[crossing];
        for pass in &mut self.passes {
            pass.over ^= pass.crossing == crossing;
        }
    }

    /// Returns whether the diagram can be drawn in the plane without further crossings, by Euler's
    /// formula.
    ///
    /// n crossings and two ends are n + 2 vertices, joined by 2n + 1 edges: n + 1 faces.
    pub(super) fn is_planar(&self) -> bool {
        self.faces().len() == self.signs.len() + 1
    }

    /// Returns whether the moves remove every crossing.
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
            // The diagram with the fewest crossings is sorted last and examined first.
            waiting.sort_by_key(|diagram| std::cmp::Reverse(diagram.signs.len()));
        }
        false
    }

    /// Removes crossings as long as an end slips out, or the first or the second move applies.
    fn simplify(&mut self) {
        while let Some(gone) = self.end_over().or(self.first_move()).or(self.second_move()) {
            let rest: Vec<usize> = (0..self.signs.len())
                .filter(|crossing| !gone.contains(crossing))
                .collect();
            *self = self.renumbered(&rest);
        }
    }

    /// Finds an end that lies over its outermost crossing, so that it slips out.
    fn end_over(&self) -> Option<[usize; 2]> {
        let ends = [self.passes.first(), self.passes.last()];
        let end = ends.into_iter().flatten().find(|pass| pass.over)?;
        Some([end.crossing; 2])
    }

    /// Finds a loop with nothing across it, which opens.
    fn first_move(&self) -> Option<[usize; 2]> {
        let mut pairs = self.passes.windows(2);
        let twist = pairs.find(|pair| pair[0].crossing == pair[1].crossing)?;
        Some([twist[0].crossing; 2])
    }

    /// Finds a strand that lies across another twice in a row, so that it slips off.
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

    /// The diagrams that the third move makes: a strand moves across a crossing that is entirely
    /// above or below it.
    fn third_moves(&self) -> Vec<Self> {
        let last = 2 * self.signs.len();
        let mut moved = Vec::new();
        for face in self.faces() {
            let edges: Vec<usize> = face.iter().map(|dart| dart / 2).collect();
            if edges.len() != 3 || edges.contains(&0) || edges.contains(&last) {
                continue;
            }
            // Number of times that each side of the triangle passes over: the top one twice, the
            // middle one once, the bottom never.
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
    /// Edge e runs from pass e − 1 to pass e. The first edge begins at an end of the rope, and the
    /// last ends at one. Dart 2e is the edge in its direction, and 2e + 1 the edge backward. A dart
    /// is followed by the next one around the vertex that it runs to.
    fn faces(&self) -> Vec<Vec<usize>> {
        let darts = 2 * (2 * self.signs.len() + 1);
        // At an end of the rope, the path turns back.
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

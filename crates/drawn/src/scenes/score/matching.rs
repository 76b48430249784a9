//! Matches curves with ropes, and assigns each point of a curve its true position.

use super::super::Truth;
use super::super::line::{Vec2, minus, mix, norm};

/// Placement of a curve on its rope. Point i of n belongs at ρ = start + i/(n − 1), or
/// start + i/n on a closed rope. If the curve is reversed, ρ decreases instead: from 1 on an open
/// rope, from `start` on a closed one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    reversed: bool,
    /// Start of the curve; only for closed ropes.
    start: f64,
}

impl Placed {
    /// Distance of each point of a curve from the true point at the same ρ.
    pub(super) fn errors_px(self, truth: &[Vec2], closed: bool, curve: &[Vec2]) -> Vec<f64> {
        let intervals = if closed { curve.len() } else { curve.len() - 1 };
        let error = |(i, &point): (usize, &Vec2)| {
            let rho = i as f64 / intervals as f64;
            let rho = match (closed, self.reversed) {
                (true, false) => self.start + rho,
                (true, true) => self.start - rho,
                (false, false) => rho,
                (false, true) => 1.0 - rho,
            };
            norm(minus(point, at(truth, closed, rho)))
        };
        curve.iter().enumerate().map(error).collect()
    }

    fn cost_px(self, truth: &[Vec2], closed: bool, curve: &[Vec2]) -> f64 {
        let errors = self.errors_px(truth, closed, curve);
        errors.iter().sum::<f64>() / errors.len() as f64
    }

    /// Best placement of a curve on a rope, with its mean error.
    fn best(truth: &[Vec2], closed: bool, curve: &[Vec2]) -> (f64, Self) {
        let starts = if closed { 200 } else { 1 };
        let mut best = (
            f64::INFINITY,
            Self {
                reversed: false,
                start: 0.0,
            },
        );
        let mut consider = |placed: Self| {
            let cost_px = placed.cost_px(truth, closed, curve);
            if cost_px < best.0 {
                best = (cost_px, placed);
            }
            best
        };
        for reversed in [false, true] {
            for k in 0..starts {
                let start = f64::from(k) / f64::from(starts);
                consider(Self { reversed, start });
            }
        }
        if closed {
            let mut step = 0.5 / f64::from(starts);
            // Down to 1 / (200 · 2¹⁰) of the rope.
            for _ in 0..10 {
                let (_, now) = consider(Self {
                    reversed: false,
                    start: 0.0,
                });
                for side in [-step, step] {
                    let start = now.start + side;
                    consider(Self { start, ..now });
                }
                step *= 0.5;
            }
        }
        best
    }
}

/// True point at a normalized arc length.
fn at(truth: &[Vec2], closed: bool, rho: f64) -> Vec2 {
    let count = truth.len();
    if closed {
        let position = rho.rem_euclid(1.0) * count as f64;
        let i = (position as usize).min(count - 1);
        mix(truth[i], truth[(i + 1) % count], position - i as f64)
    } else {
        let position = rho.clamp(0.0, 1.0) * (count - 1) as f64;
        let i = (position as usize).min(count - 2);
        mix(truth[i], truth[i + 1], position - i as f64)
    }
}

/// Curves that the ropes were matched with.
#[derive(Debug, Default)]
pub(super) struct Pairing {
    pub(super) curve_of: Vec<Option<(usize, Placed)>>,
}

impl Pairing {
    pub(super) fn best(truth: &Truth, curves: &[Vec<Vec2>]) -> Self {
        /// Maximum number of curves that are considered. Further curves are noise and remain
        /// unmatched.
        const MOST: usize = 10;
        let costs: Vec<Vec<Option<(f64, Placed)>>> = truth
            .ropes
            .iter()
            .map(|rope| {
                let cost = |curve: &Vec<Vec2>| {
                    (curve.len() > 1).then(|| Placed::best(&rope.points, rope.closed, curve))
                };
                curves.iter().take(MOST).map(cost).collect()
            })
            .collect();
        let mut search = Search {
            costs: &costs,
            taken: vec![false; curves.len().min(MOST)],
            chosen: Vec::new(),
            best: (0, f64::INFINITY, Vec::new()),
        };
        search.descend(0, 0.0);
        let curve_of = (search.best.2.iter().zip(&costs))
            .map(|(&chosen, costs)| {
                let k = chosen?;
                costs[k].map(|(_, placed)| (k, placed))
            })
            .collect();
        Self { curve_of }
    }

    pub(super) fn is_used(&self, curve: usize) -> bool {
        self.curve_of.iter().flatten().any(|&(k, _)| k == curve)
    }
}

/// Search over all assignments, which is feasible because there are few ropes.
struct Search<'a> {
    costs: &'a [Vec<Option<(f64, Placed)>>],
    taken: Vec<bool>,
    chosen: Vec<Option<usize>>,
    /// Number of matched ropes, sum of costs, and curve of each rope.
    best: (usize, f64, Vec<Option<usize>>),
}

impl Search<'_> {
    fn descend(&mut self, rope: usize, cost_px: f64) {
        if rope == self.costs.len() {
            let matched = self.chosen.iter().flatten().count();
            let (most, least_px, chosen) = &mut self.best;
            if matched > *most || (matched == *most && cost_px < *least_px) {
                (*most, *least_px) = (matched, cost_px);
                chosen.clone_from(&self.chosen);
            }
            return;
        }
        for k in 0..self.taken.len() {
            if let Some((cost, _)) = self.costs[rope][k]
                && !self.taken[k]
            {
                self.taken[k] = true;
                self.chosen.push(Some(k));
                self.descend(rope + 1, cost_px + cost);
                self.chosen.pop();
                self.taken[k] = false;
            }
        }
        self.chosen.push(None);
        self.descend(rope + 1, cost_px);
        self.chosen.pop();
    }
}

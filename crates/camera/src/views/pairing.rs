//! Pairs the ropes of two views. The pair with the best chain comes first, and each rope is used
//! once.
//!
//! A chain has at most as many points as there are points with a place on the other curve. This
//! limit is quickly known for every pair. The pair with the highest limit is examined first. If its
//! chain is better than the limits of all others, no other pair has to be examined. If ropes cross
//! so often that this still takes more than a frame's time, the remaining ropes get no partner.
//! Otherwise they might get a wrong one.

use super::curve::Curve;
use super::matching::{Matching, ROWS};
use super::pair::ViewPair;
use super::ropes::NoSecondView;

/// Minimum share of a rope that must be on another for the two to be the same.
const LEAST_SCORE: f64 = 0.3;
/// Maximum number of steps of a frame's chains, each from one place to another. With 24 ropes in
/// each view and 30 places per pair, the search takes half a million.
const MOST_STEPS: usize = 2_000_000;

/// A rope's partner in the second view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partner {
    /// Number of the rope in the second view.
    pub rope: usize,
    /// True if its points are in the opposite order.
    pub is_backward: bool,
}

/// A pair of ropes that may be the same.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    first: usize,
    partner: Partner,
    /// Score of the pair's better chain. Until the pair is examined, the upper limit of that score.
    score: f64,
    is_looked_at: bool,
}

/// The partners, and working memory.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairing {
    candidates: Vec<Candidate>,
    partners: Vec<Result<Partner, NoSecondView>>,
    /// How well each rope matches its partner.
    scores: Vec<f64>,
}

impl Pairing {
    pub(super) fn clear(&mut self) {
        self.partners.clear();
    }

    /// Returns the result for each rope in the first view: its partner, or an error.
    pub(super) fn partners(&self) -> &[Result<Partner, NoSecondView>] {
        &self.partners
    }

    /// Returns the partners to be modified, and how well each rope matches its partner.
    pub(super) fn partners_mut(
        &mut self,
    ) -> impl Iterator<Item = (&mut Result<Partner, NoSecondView>, f64)> {
        self.partners.iter_mut().zip(self.scores.iter().copied())
    }

    /// Finds the partners.
    pub(super) fn pair(
        &mut self,
        cameras: &ViewPair,
        [firsts, seconds]: [&[Curve]; 2],
        matching: &mut Matching,
    ) {
        self.partners.clear();
        self.partners.resize(firsts.len(), Err(NoSecondView::Alone));
        self.scores.clear();
        self.scores.resize(firsts.len(), 0.0);
        self.candidates.clear();
        let look = |matching: &mut Matching, curves: [&Curve; 2]| {
            let every = curves[0].sights.len().div_ceil(ROWS).max(1);
            matching.look(cameras, curves, every);
        };
        for (first, one) in firsts.iter().enumerate() {
            for (rope, other) in seconds.iter().enumerate() {
                look(matching, [one, other]);
                let score = matching.most();
                if score >= LEAST_SCORE {
                    let partner = Partner {
                        rope,
                        is_backward: false,
                    };
                    self.candidates.push(Candidate {
                        first,
                        partner,
                        score,
                        is_looked_at: false,
                    });
                }
            }
        }
        let mut left = MOST_STEPS;
        while let Some(best) = self.best() {
            let Candidate {
                first,
                partner,
                score,
                ..
            } = *best;
            if best.is_looked_at {
                self.partners[first] = Ok(partner);
                self.scores[first] = score;
                let is_free =
                    |other: &Candidate| other.first != first && other.partner.rope != partner.rope;
                self.candidates.retain(is_free);
                continue;
            }
            let curves = [&firsts[first], &seconds[partner.rope]];
            look(matching, curves);
            let Some(rest) = left.checked_sub(2 * matching.steps()) else {
                break;
            };
            left = rest;
            let [forward, backward] = [false, true].map(|way| matching.chain(cameras, curves, way));
            best.partner.is_backward = backward > forward;
            (best.score, best.is_looked_at) = (forward.max(backward), true);
            self.candidates
                .retain(|candidate| candidate.score >= LEAST_SCORE);
        }
        for candidate in &self.candidates {
            self.partners[candidate.first] = Err(NoSecondView::Tangled);
        }
    }

    /// The pair with the highest score or limit.
    fn best(&mut self) -> Option<&mut Candidate> {
        let hope = |a: &Candidate| (a.score, !a.is_looked_at);
        self.candidates.iter_mut().max_by(|a, b| {
            let ((a, first), (b, second)) = (hope(a), hope(b));
            a.total_cmp(&b).then(first.cmp(&second))
        })
    }
}

//! Which rope of the second view each of the first is: the pair whose chain is the best first, and neither of the two again.
//!
//! No chain has more points than have a place on the other curve, which is soon known of every pair. So the pair of which most is hoped is
//! looked at first, and one whose chain is better than whatever else is hoped needs no other to be known. Where ropes cross so often that this is
//! still more work than a frame's time allows, those that are left have no partner, rather than perhaps a wrong one.

use super::curve::Curve;
use super::matching::{Matching, ROWS};
use super::pair::ViewPair;
use super::ropes::NoSecondView;

/// Ropes are the same if so much of one, as a share, is on the other.
const LEAST_SCORE: f64 = 0.3;
/// Steps of a frame's chains, each from one place to another: a rope of 30 places on each of 24 others asks for half a million in all.
const MOST_STEPS: usize = 2_000_000;

/// A rope's partner in the second view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partner {
    /// Which of its ropes.
    pub rope: usize,
    /// Whether its points come in the opposite order.
    pub is_backward: bool,
}

/// A rope of each view that may be the same.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    first: usize,
    partner: Partner,
    /// Of its better chain; what is hoped of that at most while it is not looked at.
    score: f64,
    is_looked_at: bool,
}

/// The partners, and room.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairing {
    candidates: Vec<Candidate>,
    partners: Vec<Result<Partner, NoSecondView>>,
    /// How well each rope goes with its partner.
    scores: Vec<f64>,
}

impl Pairing {
    pub(super) fn clear(&mut self) {
        self.partners.clear();
    }

    /// Of each rope of the first view its partner, or why it has none.
    pub(super) fn partners(&self) -> &[Result<Partner, NoSecondView>] {
        &self.partners
    }

    /// The same, to be turned, and how well each rope goes with its partner.
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

    /// The pair that is the best, or may be.
    fn best(&mut self) -> Option<&mut Candidate> {
        let hope = |a: &Candidate| (a.score, !a.is_looked_at);
        self.candidates.iter_mut().max_by(|a, b| {
            let ((a, first), (b, second)) = (hope(a), hope(b));
            a.total_cmp(&b).then(first.cmp(&second))
        })
    }
}

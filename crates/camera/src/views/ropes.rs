//! Ropes in two views: which is which, and where their points are.

use super::curve::Curve;
use super::matching::Matching;
use super::pair::ViewPair;
use super::refining::Refining;
use crate::space::{SeenRope, SpacePoint, cut_ends};
use thiserror::Error;

/// So many points of a rope are looked at to find its partner; and to find the places of its points, one of so many.
const ROWS: usize = 30;
const EVERY: usize = 3;
/// Ropes are the same if so much of one, as a share, is on the other, and if so much of it is not along the epipolar lines.
const LEAST_SCORE: f64 = 0.3;
const LEAST_MEASURED: f64 = 0.2;

/// A rope's partner in the second view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partner {
    /// Which of its ropes.
    pub rope: usize,
    /// Whether its points come in the opposite order.
    pub is_backward: bool,
}

/// Why a rope has no place in space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoSecondView {
    /// Points or widths are missing, or too few, or beyond the lens's model.
    #[error(
        "a rope in space needs 8 points or more, each with its width, whether it is hidden, and where the lens's model is one-to-one"
    )]
    Points,
    /// No rope of the second view is it.
    #[error(
        "no rope in the second view is where this one would be: look whether the second camera sees it, whether its range fits, \
         whether its pose beside the first is right, and that the rope does not run along the line from one camera to the other"
    )]
    Alone,
    /// It runs along the epipolar lines.
    #[error(
        "of the rope's {points} points {measured} have a depth, as it runs along the line from one camera to the other: turn the cameras, \
         so that it runs across"
    )]
    Along {
        /// How many were measured.
        measured: usize,
        /// Of how many.
        points: usize,
    },
}

/// Finds ropes in two views; keeps its room.
#[derive(Debug, Clone)]
pub struct RopeViews {
    cameras: ViewPair,
    views: [Vec<Curve>; 2],
    counts: [usize; 2],
    matching: Matching,
    /// Of each pair the best score, and whether that is backward.
    scores: Vec<(f64, bool)>,
    partners: Vec<Option<Partner>>,
    refining: Refining,
    places: Vec<SpacePoint>,
    before: Vec<SpacePoint>,
}

impl RopeViews {
    /// For two cameras.
    pub fn new(cameras: ViewPair) -> Self {
        Self {
            cameras,
            views: [Vec::new(), Vec::new()],
            counts: [0; 2],
            matching: Matching::default(),
            scores: Vec::new(),
            partners: Vec::new(),
            refining: Refining::default(),
            places: Vec::new(),
            before: Vec::new(),
        }
    }

    /// The views are others.
    pub fn clear(&mut self) {
        self.counts = [0; 2];
        self.partners.clear();
    }

    /// Takes in the next rope of the first view.
    pub fn add_first(&mut self, rope: &SeenRope) {
        self.add(0, rope);
    }

    /// Takes in the next rope of the second view.
    pub fn add_second(&mut self, rope: &SeenRope) {
        self.add(1, rope);
    }

    fn add(&mut self, view: usize, rope: &SeenRope) {
        let at = self.counts[view];
        let curves = &mut self.views[view];
        if at == curves.len() {
            curves.push(Curve::default());
        }
        let camera = [&self.cameras.first, &self.cameras.second][view];
        curves[at].take(camera, rope);
        self.counts[view] += 1;
    }

    /// Finds out which rope of the second view each of the first is, and returns it for each, in order.
    pub fn pair(&mut self) -> &[Option<Partner>] {
        let [firsts, seconds] = self.counts;
        self.scores.clear();
        for i in 0..firsts {
            for j in 0..seconds {
                let curves = [&self.views[0][i], &self.views[1][j]];
                let every = curves[0].sights.len().div_ceil(ROWS).max(1);
                self.matching.look(&self.cameras, curves, every);
                let [forward, backward] =
                    [false, true].map(|way| self.matching.chain(&self.cameras, curves, way));
                self.scores
                    .push((forward.max(backward), backward > forward));
            }
        }
        self.partners.clear();
        self.partners.resize(firsts, None);
        // The best pair first, and neither of the two again.
        for _ in 0..firsts.min(seconds) {
            let best =
                (self.scores.iter().enumerate()).max_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b));
            let Some((at, &(score, is_backward))) = best else {
                break;
            };
            if score < LEAST_SCORE {
                break;
            }
            let (i, rope) = (at / seconds, at % seconds);
            self.partners[i] = Some(Partner { rope, is_backward });
            for (k, score) in self.scores.iter_mut().enumerate() {
                if k / seconds == i || k % seconds == rope {
                    score.0 = f64::NEG_INFINITY;
                }
            }
        }
        &self.partners
    }

    /// Where the points of the first view's `i`-th rope are, in the first camera's frame.
    ///
    /// # Errors
    /// It has no partner, or too few of its points are known.
    pub fn locate(&mut self, i: usize) -> Result<&[SpacePoint], NoSecondView> {
        let Some(first) = self.views[0][..self.counts[0]].get(i) else {
            return Err(NoSecondView::Points);
        };
        if first.sights.is_empty() {
            return Err(NoSecondView::Points);
        }
        let partner = self.partners.get(i).copied().flatten();
        let Some(Partner { rope, is_backward }) = partner else {
            return Err(NoSecondView::Alone);
        };
        let curves = [first, &self.views[1][rope]];
        self.matching.look(&self.cameras, curves, EVERY);
        self.matching.chain(&self.cameras, curves, is_backward);
        let chain = &self.matching.best;
        if chain.len() < 2 {
            return Err(NoSecondView::Alone);
        }
        let refined = (self.refining).refine(&self.cameras, curves, chain, is_backward);
        let points = first.sights.len();
        let along = |measured| NoSecondView::Along { measured, points };
        refined.ok_or(along(0))?;
        (self.refining).write(&self.cameras, curves[0], &mut self.places);
        let measured = self.places.iter().filter(|place| place.is_measured).count();
        if (measured as f64) < LEAST_MEASURED * points as f64 {
            return Err(along(measured));
        }
        cut_ends(&mut self.places, first.ends, &mut self.before);
        Ok(&self.places)
    }
}

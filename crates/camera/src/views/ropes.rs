//! Pairs the ropes of two views, and locates their points.

use super::curve::Curve;
use super::exchanging::Exchanging;
use super::matching::Matching;
use super::pair::ViewPair;
use super::pairing::{Pairing, Partner};
use super::refining::Refining;
use crate::space::{SeenRope, SpacePoint, cut_ends};
use thiserror::Error;

/// Every n-th point of a rope is matched. Fewer points are matched if that would take more than
/// `MOST_STEPS` steps from one place to another.
const EVERY: usize = 3;
const MOST_STEPS: usize = 100_000;
/// Maximum number of steps per frame in the search for confused strands.
const MOST_TO_EXCHANGE: usize = 1_000_000;
/// Minimum share of a rope that must not run along the epipolar lines.
const LEAST_MEASURED: f64 = 0.2;

/// Why a rope could not be located in 3-D.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoSecondView {
    /// Points or widths are missing, too few, or beyond the lens model.
    #[error(
        "a rope in space needs 8 points or more, each with its width, whether it is hidden, and where the lens's model is one-to-one"
    )]
    Points,
    /// No rope of the second view matches.
    #[error(
        "no rope in the second view is where this one would be: look whether the second camera sees it, whether its range fits, \
         whether its pose beside the first is right, and that the rope does not run along the line from one camera to the other"
    )]
    Alone,
    /// Several ropes may match, and finding out which takes too long.
    #[error(
        "the ropes cross the lines on which this one is seen so often that it takes too long to find out which is it: leave out what is \
         no rope by the mask, or have fewer ropes in the pictures"
    )]
    Tangled,
    /// The rope runs along the epipolar lines.
    #[error(
        "of the rope's {points} points {measured} have a depth, as it runs along the line from one camera to the other: turn the cameras, \
         so that it runs across"
    )]
    Along {
        /// Number of measured points.
        measured: usize,
        /// Number of all points.
        points: usize,
    },
}

/// Locates ropes in two views, and reuses its buffers.
#[derive(Debug, Clone)]
pub struct RopeViews {
    cameras: ViewPair,
    views: [Vec<Curve>; 2],
    counts: [usize; 2],
    matching: Matching,
    pairing: Pairing,
    exchanging: Exchanging,
    refining: Refining,
    places: Vec<SpacePoint>,
    before: Vec<SpacePoint>,
}

impl RopeViews {
    /// Creates a finder for two cameras.
    pub fn new(cameras: ViewPair) -> Self {
        Self {
            cameras,
            views: [Vec::new(), Vec::new()],
            counts: [0; 2],
            matching: Matching::default(),
            pairing: Pairing::default(),
            exchanging: Exchanging::default(),
            refining: Refining::default(),
            places: Vec::new(),
            before: Vec::new(),
        }
    }

    /// Removes all ropes, in preparation for new views.
    pub fn clear(&mut self) {
        self.counts = [0; 2];
        self.pairing.clear();
    }

    /// Adds the next rope of the first view.
    pub fn add_first(&mut self, rope: &SeenRope) {
        self.add(0, rope);
    }

    /// Adds the next rope of the second view.
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

    /// Pairs the ropes. Returns the result for each rope in the first view, in order: its partner,
    /// or an error.
    pub fn pair(&mut self) -> &[Result<Partner, NoSecondView>] {
        let [firsts, seconds] = [0, 1].map(|view| &self.views[view][..self.counts[view]]);
        (self.pairing).pair(&self.cameras, [firsts, seconds], &mut self.matching);
        let mut left = MOST_TO_EXCHANGE;
        let [firsts, seconds] = &mut self.views;
        for ((partner, score), first) in self.pairing.partners_mut().zip(firsts) {
            if let Ok(partner) = partner {
                partner.is_backward = self.exchanging.exchange(
                    &self.cameras,
                    [first, &mut seconds[partner.rope]],
                    (partner.is_backward, score),
                    (&mut self.matching, &mut left),
                );
            }
        }
        self.pairing.partners()
    }

    /// Locates the points of the first view's `i`-th rope, in the first camera's frame.
    ///
    /// # Errors
    /// Its partner is missing or unknown, or too few of its points are measured.
    pub fn locate(&mut self, i: usize) -> Result<&[SpacePoint], NoSecondView> {
        let Some(first) = self.views[0][..self.counts[0]].get(i) else {
            return Err(NoSecondView::Points);
        };
        if first.sights.is_empty() {
            return Err(NoSecondView::Points);
        }
        let partner = self.pairing.partners().get(i).copied();
        let Partner { rope, is_backward } = partner.unwrap_or(Err(NoSecondView::Alone))?;
        let curves = [first, &self.views[1][rope]];
        let mut every = EVERY;
        self.matching.look(&self.cameras, curves, every);
        while self.matching.steps() > MOST_STEPS {
            every *= 2;
            self.matching.look(&self.cameras, curves, every);
        }
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

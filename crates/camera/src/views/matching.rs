//! Matches points of the first view's curve with places on the second's: finds the best chain
//! through all candidates.

use super::curve::Curve;
use super::pair::ViewPair;
use crate::space::length;

/// Number of points of a rope that are used to estimate how well it matches another rope.
pub(super) const ROWS: usize = 30;
/// Error of a place across the other curve, px. Along the epipolar line, the error is this divided
/// by the sine of the angle between the line and the curve. The sine is at least `FLATTEST`.
const OFF_PX: f64 = 1.5;
const FLATTEST: f64 = 0.05;
/// A chain does not end where the sine of that angle is less than this.
const FLAT: f64 = 0.2;
/// Maximum number of places for one point.
const MOST_PLACES: usize = 12;
/// Maximum slope of a rope, in mm ahead per mm to the side; and cost of a slope of 1, in points.
pub(super) const STEEPEST: f64 = 4.0;
const RUGGED: f64 = 0.05;
/// Maximum relative difference between the lengths of rope that the two views see, in addition to
/// the rope's rise. They differ because ropes are seen at an angle.
const UNLIKE: f64 = 0.3;
/// Maximum ratio of a rope's angular widths in the two views.
const WIDER: f64 = 2.0;

/// A point of the first view's curve, and a possible place on the second's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Match {
    /// Number of the point.
    pub point: usize,
    /// Position along the second curve, in points.
    pub u: f64,
    /// Distance ahead of the first camera, mm.
    pub depth: f64,
    /// Lateral tolerance there, mm.
    slack: f64,
    /// True if the epipolar line meets the curve at a small angle.
    is_flat: bool,
}

/// The best chain, and working memory.
#[derive(Debug, Clone, Default)]
pub(super) struct Matching {
    places: Vec<Match>,
    /// For each place, the score of the best chain that ends there, and the place before it.
    chains: Vec<(f64, Option<usize>)>,
    /// Distances of the second curve's points from an epipolar line.
    beside: Vec<f64>,
    /// The best chain.
    pub best: Vec<Match>,
    /// Number of points considered, and the number of them that have a place.
    rows: usize,
    met: usize,
}

impl Matching {
    /// Finds possible places on the second curve for every `every`-th point of the first.
    pub(super) fn look(&mut self, cameras: &ViewPair, [first, second]: [&Curve; 2], every: usize) {
        self.places.clear();
        (self.rows, self.met) = (0, 0);
        let [near, far] = cameras.range_mm;
        let off = OFF_PX / cameras.second_focal_px();
        for (point, sight) in first.sights.iter().enumerate().step_by(every) {
            self.rows += 1;
            let epipolar = cameras.epipolar(sight.ray);
            let Some([a, b, c]) = epipolar.line() else {
                continue;
            };
            self.beside.clear();
            let others = second.sights.iter();
            self.beside
                .extend(others.map(|other| a * other.ray[0] + b * other.ray[1] + c));
            let count = self.beside.len();
            let steps = if second.closed {
                count
            } else {
                count.saturating_sub(1)
            };
            let before = self.places.len();
            for j in 0..steps {
                let k = if j + 1 == count { 0 } else { j + 1 };
                let (from, to) = (self.beside[j], self.beside[k]);
                if (from > 0.0) == (to > 0.0) || self.places.len() == before + MOST_PLACES {
                    continue;
                }
                let share = from / (from - to);
                let [p, q] = [j, k].map(|i| second.sights[i].ray);
                let way = [q[0] - p[0], q[1] - p[1]];
                let depth = 1.0 / epipolar.inverse([p[0] + share * way[0], p[1] + share * way[1]]);
                let wider = sight.slim / second.sights[j].slim;
                if !(near..far).contains(&depth) || !(1.0 / WIDER..WIDER).contains(&wider) {
                    continue;
                }
                let sine = (to - from).abs() / length(way[0], way[1]);
                self.places.push(Match {
                    point,
                    u: j as f64 + share,
                    depth,
                    slack: depth * off / sine.max(FLATTEST),
                    is_flat: sine < FLAT,
                });
            }
            self.met += usize::from(self.places.len() > before);
        }
    }

    /// Upper limit of a chain's score.
    pub(super) fn most(&self) -> f64 {
        self.met as f64 / self.rows.max(1) as f64
    }

    /// Maximum number of steps, from one place to another, in the search for a chain.
    pub(super) fn steps(&self) -> usize {
        self.places.len() * self.places.len() / 2
    }

    /// Finds the best chain forward along the second curve, or backward. Its score is the share of
    /// points in it, minus penalties for ruggedness and for parts at the rope's ends that only one
    /// view sees.
    pub(super) fn chain(
        &mut self,
        cameras: &ViewPair,
        curves: [&Curve; 2],
        is_backward: bool,
    ) -> f64 {
        self.chains.clear();
        self.best.clear();
        let mut last: Option<(usize, f64)> = None;
        for (at, to) in self.places.iter().enumerate() {
            let mut best = (1.0 - self.missing(curves, is_backward, to, 0), None);
            for (before, from) in self.places[..at].iter().enumerate() {
                let score = self.chains[before].0 + 1.0;
                if from.point == to.point || score <= best.0 {
                    continue;
                }
                if let Some(rugged) = follows(cameras, curves, is_backward, [from, to])
                    && score - rugged > best.0
                {
                    best = (score - rugged, Some(before));
                }
            }
            self.chains.push(best);
            let whole = best.0 - self.missing(curves, is_backward, to, 1);
            if last.is_none_or(|(_, score)| whole > score) {
                last = Some((at, whole));
            }
        }
        let Some((end, score)) = last else {
            return 0.0;
        };
        let mut at = Some(end);
        while let Some(place) = at {
            self.best.push(self.places[place]);
            at = self.chains[place].1;
        }
        self.best.reverse();
        // If the other curve ends while running along the epipolar lines, points beyond its end
        // seem to be on it.
        let is_steep = |place: &Match| !place.is_flat;
        let last = self.best.iter().rposition(is_steep).map_or(0, |at| at + 1);
        let first = self.best.iter().position(is_steep).unwrap_or(0);
        if last >= first + 2 {
            self.best.truncate(last);
            self.best.drain(..first);
        }
        score / self.rows as f64
    }

    /// Difference between what the views see beyond a place, in points: before a chain's first
    /// place, or after its last. 0 if one of the views does not see the end.
    fn missing(
        &self,
        [first, second]: [&Curve; 2],
        is_backward: bool,
        place: &Match,
        end: usize,
    ) -> f64 {
        let other = if is_backward { 1 - end } else { end };
        if first.closed || second.closed || !first.ends[end] || !second.ends[other] {
            return 0.0;
        }
        let beyond = |curve: &Curve, u: f64, end: usize| {
            curve.step * if end == 0 { u } else { curve.last() - u }
        };
        let there = beyond(second, place.u, other);
        let here = beyond(first, place.point as f64, end);
        self.rows as f64 * (here - there).abs() / (first.step * first.last())
    }
}

/// Returns the cost of ruggedness between two places; `None` if the rope cannot continue from one
/// to the other.
fn follows(
    cameras: &ViewPair,
    [first, second]: [&Curve; 2],
    is_backward: bool,
    [from, to]: [&Match; 2],
) -> Option<f64> {
    let depth = 0.5 * (from.depth + to.depth);
    let slack = from.slack + to.slack;
    let way = if is_backward { -1.0 } else { 1.0 };
    let along = way * second.between(from.u, to.u);
    let here = depth * first.step * (to.point - from.point) as f64;
    let there = depth * second.step * along;
    let rise = (to.depth - from.depth).abs();
    let turned = cameras.baseline_mm / depth;
    if there < -slack || (there - here).abs() > slack + turned * rise + UNLIKE * here {
        return None;
    }
    let rugged = (rise - slack / turned).max(0.0) / here;
    (rugged <= STEEPEST).then_some(RUGGED * rugged * rugged)
}

//! Which place of the second view's curve belongs to a point of the first one's: the best chain through all that may.

use super::curve::Curve;
use super::pair::ViewPair;
use crate::space::length;

/// So many points of a rope are looked at to find out how well it goes with another.
pub(super) const ROWS: usize = 30;
/// A place on the other curve may be so many pixels off it, and so far along it where it meets the epipolar line flatly, of which no
/// less than this sine is reckoned with.
const OFF_PX: f64 = 1.5;
const FLATTEST: f64 = 0.05;
/// A chain does not end where that sine is less than this.
const FLAT: f64 = 0.2;
/// Places of one point, at most.
const MOST_PLACES: usize = 12;
/// A rope rises no more steeply than this, mm ahead for each aside; what a rise of 1 costs, in points.
pub(super) const STEEPEST: f64 = 4.0;
const RUGGED: f64 = 0.05;
/// What both views see of a rope's length may differ by this share more than by what it rises, as ropes are not seen squarely.
const UNLIKE: f64 = 0.3;
/// A rope is in one view no more than this times as wide, by its depth, as in the other.
const WIDER: f64 = 2.0;

/// A point of the first view's curve, and where it may be on the second's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Match {
    /// Which point.
    pub point: usize,
    /// How many points along the second curve.
    pub u: f64,
    /// How far ahead of the first camera, mm.
    pub depth: f64,
    /// How far aside of that it may be, mm.
    slack: f64,
    /// Whether the epipolar line meets the curve flatly there.
    is_flat: bool,
}

/// The chain that is best, and room.
#[derive(Debug, Clone, Default)]
pub(super) struct Matching {
    places: Vec<Match>,
    /// Of each place the score of the best chain that ends there, and the place before it.
    chains: Vec<(f64, Option<usize>)>,
    /// How far the second curve's points are from an epipolar line.
    beside: Vec<f64>,
    /// The best chain.
    pub best: Vec<Match>,
    /// How many points were looked at, and how many of them have a place.
    rows: usize,
    met: usize,
}

impl Matching {
    /// Finds where points of the first curve, one of `every`, may be on the second.
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

    /// What the score of a chain is at most.
    pub(super) fn most(&self) -> f64 {
        self.met as f64 / self.rows.max(1) as f64
    }

    /// How many steps from one place to another a chain takes to be found, at most.
    pub(super) fn steps(&self) -> usize {
        self.places.len() * self.places.len() / 2
    }

    /// The best chain forward along the second curve, or backward; its score is the share of the points that are in it, less what is
    /// rugged, and what one view sees of the rope's ends and the other does not.
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
        // Where the other curve ends on its way along the epipolar lines, points beyond that seem to be on it.
        let is_steep = |place: &Match| !place.is_flat;
        let last = self.best.iter().rposition(is_steep).map_or(0, |at| at + 1);
        let first = self.best.iter().position(is_steep).unwrap_or(0);
        if last >= first + 2 {
            self.best.truncate(last);
            self.best.drain(..first);
        }
        score / self.rows as f64
    }

    /// How many points the views differ by in what they see beyond a place: before a first one, or after a last. Of ropes whose end is
    /// not seen in both, none.
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

/// Whether the rope can go on from one place to another, and how rugged it is then.
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

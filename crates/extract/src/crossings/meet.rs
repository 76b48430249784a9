//! The places where the finished curves meet. Between their points the curves are straight, and two
//! strands cross exactly where these segments do.
//!
//! Segments are grouped into blocks with a bounding box each. Only blocks whose boxes overlap are
//! intersected segment by segment. If strands run along each other for a while, their centerlines
//! may meet several times within one overlap. An odd number of meetings is one crossing. An even
//! number is not a crossing, because the strands leave the overlap on the sides where they entered.

use super::place::Place;
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Segments in a block: few enough that a block's box is small compared with the image, and enough
/// that comparing boxes is little work.
const BLOCK: usize = 8;
/// Maximum number of meetings that are examined. At most 32 crossings are reported.
const MOST: usize = 256;

/// Two places at the same position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    pub(crate) at: Vec2,
    pub(crate) a: Place,
    pub(crate) b: Place,
}

/// Memory and result of the step.
#[derive(Debug)]
pub(crate) struct Meeter {
    blocks: Vec<Block>,
    all: Vec<Meeting>,
    /// For each of `all`, the first meeting of its overlap.
    first: Vec<usize>,
    /// One meeting for each crossing.
    pub(crate) crossings: Vec<Meeting>,
}

impl Default for Meeter {
    fn default() -> Self {
        // Room for the maximum, so that no later scene with more crossings allocates.
        Self {
            blocks: Vec::new(),
            all: Vec::with_capacity(MOST),
            first: Vec::with_capacity(MOST),
            crossings: Vec::with_capacity(MOST),
        }
    }
}

/// Segments `from..to` of a curve, and the box around them.
#[derive(Clone, Copy, Debug)]
struct Block {
    curve: usize,
    from: usize,
    to: usize,
    low: Vec2,
    high: Vec2,
}

impl Meeter {
    /// Fills `crossings`.
    pub(crate) fn find(&mut self, curves: &[Curve]) {
        self.blocks.clear();
        self.all.clear();
        for (c, curve) in curves.iter().enumerate() {
            self.add_blocks(c, curve);
        }
        for (k, p) in self.blocks.iter().enumerate() {
            for q in &self.blocks[k..] {
                if p.overlaps(q) {
                    intersect(curves, p, q, &mut self.all);
                }
            }
        }
        self.merge(curves);
    }

    fn add_blocks(&mut self, c: usize, curve: &Curve) {
        let pieces = curve.intervals();
        for from in (0..pieces).step_by(BLOCK) {
            let to = (from + BLOCK).min(pieces);
            let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
            for i in from..=to {
                let p = curve.points[i % curve.points.len()];
                (low, high) = (
                    [low[0].min(p[0]), low[1].min(p[1])],
                    [high[0].max(p[0]), high[1].max(p[1])],
                );
            }
            self.blocks.push(Block {
                curve: c,
                from,
                to,
                low,
                high,
            });
        }
    }

    /// Turns all meetings of an overlap into one crossing or none.
    fn merge(&mut self, curves: &[Curve]) {
        let key = |m: &Meeting| (m.a.curve, m.b.curve);
        self.all
            .sort_unstable_by(|m, n| key(m).cmp(&key(n)).then(m.a.at.total_cmp(&n.a.at)));
        self.first.clear();
        for (i, m) in self.all.iter().enumerate() {
            let same = |&j: &usize| {
                let n = &self.all[j];
                key(n) == key(m) && one_overlap(curves, n, m)
            };
            let before = (0..i).rev().find(same);
            self.first.push(before.map_or(i, |j| self.first[j]));
        }
        self.crossings.clear();
        for i in 0..self.all.len() {
            if self.first[i] != i {
                continue;
            }
            let members = || (i..self.all.len()).filter(|&j| self.first[j] == i);
            let count = members().count();
            if count % 2 == 1 {
                self.crossings
                    .extend(members().nth(count / 2).map(|j| self.all[j]));
            }
        }
    }
}

impl Block {
    fn overlaps(&self, other: &Block) -> bool {
        (0..2).all(|c| self.low[c] <= other.high[c] && other.low[c] <= self.high[c])
    }

    /// Returns whether the box around a segment overlaps the block's.
    fn is_near(&self, [from, to]: [Vec2; 2]) -> bool {
        let within =
            |c: usize| (from[c].min(to[c]) <= self.high[c]) & (self.low[c] <= from[c].max(to[c]));
        within(0) & within(1)
    }
}

/// Adds the meetings of the segments of `p` with those of `q`.
fn intersect(curves: &[Curve], p: &Block, q: &Block, all: &mut Vec<Meeting>) {
    let (a, b) = (&curves[p.curve], &curves[q.curve]);
    let same = p.curve == q.curve;
    // Segments nearer than this along the curve, the short way around, do not cross.
    let apart = a.nearest_crossing();
    for i in p.from..p.to {
        let first = if same { q.from.max(i + apart) } else { q.from };
        if first >= q.to || !q.is_near(a.piece(i)) {
            continue;
        }
        for j in first..q.to {
            if all.len() == MOST {
                return;
            }
            if same && a.neighbors(i, j) {
                continue;
            }
            let Some((t, u)) = meet(a.piece(i), b.piece(j)) else {
                continue;
            };
            let [from, to] = a.piece(i);
            let place = |curve, at| Place { curve, at };
            all.push(Meeting {
                at: vec2::along(from, vec2::sub(to, from), t),
                a: place(p.curve, i as f32 + t),
                b: place(q.curve, j as f32 + u),
            });
        }
    }
}

/// The first meeting of the curves within `reach` segments of two places.
pub(crate) fn near(curves: &[Curve], a: Place, b: Place, reach: usize) -> Option<Meeting> {
    let around = |place: Place| {
        let (middle, count) = (place.at.max(0.0) as usize, curves[place.curve].intervals());
        middle.saturating_sub(reach)..(middle + reach + 1).min(count)
    };
    for i in around(a) {
        let [from, to] = curves[a.curve].piece(i);
        for j in around(b) {
            if let Some((t, u)) = meet([from, to], curves[b.curve].piece(j)) {
                return Some(Meeting {
                    at: vec2::along(from, vec2::sub(to, from), t),
                    a: Place {
                        at: i as f32 + t,
                        ..a
                    },
                    b: Place {
                        at: j as f32 + u,
                        ..b
                    },
                });
            }
        }
    }
    None
}

/// The place on each of two segments where they meet, as a share of the segment's length.
fn meet([a, b]: [Vec2; 2], [c, d]: [Vec2; 2]) -> Option<(f32, f32)> {
    let side = |from: Vec2, to: Vec2, p: Vec2| vec2::cross(vec2::sub(to, from), vec2::sub(p, from));
    // Compares sides, so that a meeting in a point shared by two segments is counted once.
    let (ac, bc) = (side(c, d, a), side(c, d, b));
    let (ca, da) = (side(a, b, c), side(a, b, d));
    if (ac >= 0.0) == (bc >= 0.0) || (ca >= 0.0) == (da >= 0.0) {
        return None;
    }
    Some((ac / (ac - bc), ca / (ca - da)))
}

/// Returns whether the strands stay on top of each other between two of their meetings. Their
/// centerlines are then nowhere half a width apart.
fn one_overlap(curves: &[Curve], m: &Meeting, n: &Meeting) -> bool {
    let (a, b) = (&curves[m.a.curve], &curves[m.b.curve]);
    let half_px = 0.25 * (a.width_px + b.width_px);
    let ways = [a.way_px(m.a.at, n.a.at), b.way_px(m.b.at, n.b.at)];
    // Strands that close together have nearly the same length between the meetings.
    if (ways[0] - ways[1]).abs() > half_px {
        return false;
    }
    let steps = (ways[0] / half_px.max(1.0)).ceil().clamp(2.0, 64.0) as usize;
    (1..steps).all(|k| {
        let t = k as f32 / steps as f32;
        let on = |curve: &Curve, from: f32, to: f32| curve.at(from + t * curve.step(from, to));
        vec2::distance(on(a, m.a.at, n.a.at), on(b, m.b.at, n.b.at)) < half_px
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve along `at` for t from 0 to 1, 10 px wide.
    fn curve(points: usize, at: impl Fn(f32) -> Vec2) -> Curve {
        let mut curve = Curve::default();
        curve
            .points
            .extend((0..points).map(|i| at(i as f32 / (points - 1) as f32)));
        curve.width_px = 10.0;
        let pairs = curve.points.windows(2);
        curve.length_px = pairs.map(|p| vec2::distance(p[0], p[1])).sum();
        curve
    }

    fn crossings(curves: &[Curve]) -> Vec<Meeting> {
        let mut meeter = Meeter::default();
        meeter.find(curves);
        meeter.crossings
    }

    #[test]
    fn pieces_meet_where_they_cross() {
        let met = meet([[0.0, 0.0], [4.0, 4.0]], [[0.0, 2.0], [4.0, 2.0]]);
        assert_eq!(met, Some((0.5, 0.5)));
        let parallel = meet([[0.0, 0.0], [1.0, 0.0]], [[0.0, 1.0], [1.0, 1.0]]);
        assert_eq!(parallel, None);
    }

    #[test]
    fn a_crossing_through_points_of_both_curves_is_one() {
        let level = curve(21, |t| [200.0 * t, 100.0]);
        let steep = curve(21, |t| [100.0, 200.0 * t]);
        let found = crossings(&[level, steep]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].at, [100.0, 100.0]);
    }

    #[test]
    fn strands_that_run_along_each_other_and_part_on_the_other_side_cross_once() {
        let level = curve(101, |t| [400.0 * t, 100.0]);
        // For 120 px, the wavy curve is within a pixel of the other and meets it again and again.
        let wavy = curve(101, |t| {
            let x = 400.0 * t - 200.0;
            let aside = (x.abs() - 60.0).max(0.0) * x.signum() * 0.5;
            [200.0 + x, 100.0 + aside + 0.8 * (0.35 * x).sin()]
        });
        assert_eq!(crossings(&[level, wavy]).len(), 1);
    }

    #[test]
    fn strands_that_touch_and_part_on_the_same_side_do_not_cross() {
        let level = curve(101, |t| [400.0 * t, 100.0]);
        let bowed = curve(101, |t| {
            let x = 400.0 * t - 200.0;
            [200.0 + x, 99.5 + 0.0005 * x * x]
        });
        assert_eq!(crossings(&[level, bowed]).len(), 0);
    }

    #[test]
    fn strands_that_wind_around_each_other_cross_every_time() {
        let level = curve(101, |t| [400.0 * t, 100.0]);
        let wound = curve(101, |t| [400.0 * t, 100.0 + 9.0 * (20.0 * t + 0.5).sin()]);
        assert_eq!(crossings(&[level, wound]).len(), 6);
    }

    #[test]
    fn a_curve_crosses_itself_but_not_where_it_goes_on() {
        let loop_ = curve(120, |t| {
            let a = -4.4 + 8.8 * t;
            [150.0 + 16.0 * a - 60.0 * a.sin(), 110.0 + 60.0 * a.cos()]
        });
        let found = crossings(&[loop_]);
        assert_eq!(found.len(), 1);
        assert!((found[0].at[0] - 150.0).abs() < 1.0);
        assert!((found[0].a.at + found[0].b.at - 119.0).abs() < 0.1);
    }

    #[test]
    fn a_closed_curve_may_cross_where_its_points_begin() {
        let mut eight = curve(101, |t| {
            let a = std::f32::consts::TAU * t;
            [200.0 + 100.0 * a.sin(), 100.0 + 60.0 * (2.0 * a).sin()]
        });
        eight.points.pop();
        eight.closed = true;
        let found = crossings(&[eight]);
        assert_eq!(found.len(), 1);
        assert!(vec2::distance(found[0].at, [200.0, 100.0]) < 0.5);
    }
}

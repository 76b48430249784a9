//! Computes the depth of every point from a chain of matches, as a spline along the rope.

use super::curve::Curve;
use super::matching::{Match, STEEPEST};
use super::pair::{Epipolar, ViewPair};
use super::smooth::{Knot, Smooth};
use crate::space::{SpacePoint, length};

/// Number of points of a closed rope that are repeated before its first and after its last point.
const LAP: usize = 16;
/// Number of Gauss–Newton steps; the steps at which the bending is estimated; and the first step at
/// which outliers have less weight.
const STEPS: usize = 4;
const ASKED_AT: [usize; 2] = [1, 3];
const ROBUST_FROM: usize = 2;
/// Candidates for the bending: the difference between a point's depth and the mean depth of its two
/// neighbors, mm, for steps of `BENDS_AT_MM`. The difference grows with the step to the power of
/// 3/2.
const BENDS_MM: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0];
const BENDS_AT_MM: f64 = 5.0;
/// Minimum standard deviation of the curves' distances, px. Distances above `ROBUST` standard
/// deviations have less weight, and those above `FARTHEST_PX` are ignored.
const LEAST_SIGMA_PX: f64 = 0.05;
const ROBUST: f64 = 2.0;
const FARTHEST_PX: f64 = 6.0;
/// A point more than this many pixels beyond the other curve's end is not on it.
const BEYOND_PX: f64 = 1.5;
/// Test for points beyond the end of the chain of matches. They count as on the other curve if they
/// advance along it by at least this share of the expected distance, minus `LAG` points.
const GOES_ON: f64 = 0.4;
const LAG: f64 = 0.25;
/// Weight of hidden points; and standard deviation of an end's place along the epipolar line, px.
const HIDDEN: f64 = 0.1;
const END_PX: f64 = 1.5;
/// Error of a depth that was not measured, in mm per mm of distance from a measured point. Its
/// cause is that the bending of a rope varies. The error is four times as large if there is a
/// measured point on one side only.
const ASTRAY: f64 = 0.12;
/// Offset of a whole centerline from its rope's axis, as a share of the rope's width, due to light
/// from one side. For drawn ropes of 3 to 15 px, this offset is half of the error of their depths,
/// in pixels.
const BESIDE: f64 = 0.004;
/// Minimum sine of the angle between the epipolar line and the other curve at a measured point.
const FLATTEST: f64 = 0.2;

/// Data of a point on the rope.
#[derive(Debug, Clone, Copy)]
struct Axis {
    /// Number of the point on the first curve.
    point: usize,
    epipolar: Epipolar,
    /// Its inverse depth, and its position on the other curve.
    inverse: f64,
    u: f64,
    /// For a point beyond the chain of matches: where the chain ends on the other curve, and how
    /// much farther this point should be.
    beyond: Option<(f64, f64)>,
    /// Change of the point's distance from the other curve, px: `slope` per unit of inverse depth,
    /// and `by_pixel` per pixel of the first view.
    slope: f64,
    by_pixel: [f64; 2],
    /// Shift of the whole curves, px, that changes the point's inverse depth by one unit.
    shift_px: f64,
    is_measured: bool,
    is_steep: bool,
}

impl Axis {
    /// Returns true if the point has advanced less from the chain's end than expected.
    fn lags(&self, u: f64, second: &Curve) -> bool {
        self.beyond.is_some_and(|(end, more)| {
            let gone = second.between(end, u);
            gone * more.signum() < GOES_ON * more.abs() - LAG
        })
    }
}

/// Working memory for one rope.
#[derive(Debug, Clone, Default)]
pub(super) struct Refining {
    axes: Vec<Axis>,
    knots: Vec<Knot>,
    smooth: Smooth,
    /// Variance of the distances divided by that of the bends.
    stiffness: f64,
    /// Variance of the distances, px².
    variance: f64,
}

impl Refining {
    /// Computes the depths; `None` if the data do not suffice.
    pub(super) fn refine(
        &mut self,
        cameras: &ViewPair,
        curves: [&Curve; 2],
        chain: &[Match],
        is_backward: bool,
    ) -> Option<()> {
        self.begin(cameras, curves, chain, is_backward);
        self.variance = 4.0 * LEAST_SIGMA_PX * LEAST_SIGMA_PX;
        self.stiffness = self.stiffnesses(curves[0]).nth(3)?;
        for step in 0..STEPS {
            self.measure(cameras, curves, step >= ROBUST_FROM);
            self.hold_ends(cameras, curves, is_backward);
            if ASKED_AT.contains(&step) {
                self.ask(curves[0])?;
            }
            self.smooth.solve(&self.knots, self.stiffness)?;
            for (axis, (inverse, _)) in self.axes.iter_mut().zip(self.smooth.values()) {
                axis.inverse = inverse;
                axis.is_steep = false;
            }
            self.find_steep(curves[0].step);
        }
        Some(())
    }

    /// Marks where the rope would rise too steeply, because it was matched with something else
    /// there.
    fn find_steep(&mut self, step: f64) {
        for i in 1..self.axes.len() {
            let [a, b] = [i - 1, i].map(|k| 1.0 / self.axes[k].inverse);
            if (b - a).abs() > STEEPEST * step * a.min(b) {
                self.axes[i - 1].is_steep = true;
                self.axes[i].is_steep = true;
            }
        }
    }

    /// Interpolates depths and positions between those of the chain.
    fn begin(
        &mut self,
        cameras: &ViewPair,
        [first, second]: [&Curve; 2],
        chain: &[Match],
        is_backward: bool,
    ) {
        let count = first.sights.len();
        let lap = if first.closed { LAP.min(count) } else { 0 };
        let way = if is_backward { -1.0 } else { 1.0 };
        let ratio = way * first.step / second.step;
        self.axes.clear();
        let mut k = 0;
        for i in 0..count + 2 * lap {
            // On a closed rope, the point before the first is near the last.
            let point = (i + count - lap) % count;
            let at = point as f64;
            if i == lap {
                k = 0;
            }
            while k + 2 < chain.len() && chain[k + 1].point < point {
                k += 1;
            }
            let [a, b] = [&chain[k], &chain[k + 1]];
            let along = second.between(a.u, b.u);
            let share = (at - a.point as f64) / (b.point - a.point) as f64;
            let [p, q] = [1.0 / a.depth, 1.0 / b.depth];
            let beyond = match share {
                ..0.0 => Some((a.u, ratio * (at - a.point as f64))),
                0.0..=1.0 => None,
                _ => Some((b.u, ratio * (at - b.point as f64))),
            };
            let u = beyond.map_or(a.u + share * along, |(end, more)| end + more);
            self.axes.push(Axis {
                point,
                epipolar: cameras.epipolar(first.sights[point].ray),
                inverse: p + share.clamp(0.0, 1.0) * (q - p),
                u: second.within(u),
                beyond,
                slope: 0.0,
                by_pixel: [0.0; 2],
                shift_px: f64::INFINITY,
                is_measured: false,
                is_steep: false,
            });
        }
    }

    /// Measures the distances of the points from the other curve, across it, and how these
    /// distances change with depth.
    fn measure(&mut self, cameras: &ViewPair, [first, second]: [&Curve; 2], is_robust: bool) {
        let focal = cameras.second_focal_px();
        let robust = ROBUST * self.variance.sqrt();
        self.knots.clear();
        for axis in &mut self.axes {
            axis.is_measured = false;
            self.knots.push(Knot::default());
            let Some(seen) = axis.epipolar.at(axis.inverse) else {
                continue;
            };
            axis.u = second.nearest(seen.at, axis.u);
            let spot = second.spot(axis.u);
            let size = length(spot.way[0], spot.way[1]);
            let across = [-spot.way[1] / size, spot.way[0] / size];
            let beside = [0, 1].map(|k| focal * (seen.at[k] - spot.at[k]));
            let off = beside[0] * across[0] + beside[1] * across[1];
            let along = beside[0] * across[1] - beside[1] * across[0];
            // Nothing is measured beyond the end of the other curve, or on the way there.
            let is_there = off.abs() < FARTHEST_PX && along.abs() < BEYOND_PX;
            if !is_there || axis.is_steep || axis.lags(axis.u, second) {
                continue;
            }
            let slope = focal * (seen.by_inverse[0] * across[0] + seen.by_inverse[1] * across[1]);
            let most = focal * length(seen.by_inverse[0], seen.by_inverse[1]);
            let sine = slope.abs() / most;
            let sight = &first.sights[axis.point];
            axis.slope = slope;
            axis.shift_px = slope.abs().max(FLATTEST * most);
            axis.by_pixel = [0, 1].map(|k| {
                let way = cameras.turned([sight.by_pixel[0][k], sight.by_pixel[1][k], 0.0]);
                let moved = [0, 1].map(|axis| (way[axis] - seen.at[axis] * way[2]) / seen.ahead);
                focal * (moved[0] * across[0] + moved[1] * across[1])
            });
            let is_hidden = first.hidden[axis.point] || spot.is_hidden;
            axis.is_measured = !is_hidden && sine >= FLATTEST;
            let mut weight = if is_hidden { HIDDEN } else { 1.0 };
            if is_robust {
                weight *= (robust / off.abs()).min(1.0);
            }
            let info = weight * slope * slope;
            if let Some(knot) = self.knots.last_mut() {
                *knot = Knot {
                    info,
                    weighted: info * axis.inverse - weight * slope * off,
                };
            }
        }
    }

    /// Ties the ends together: both views see an end at the same place on the rope.
    fn hold_ends(&mut self, cameras: &ViewPair, [first, second]: [&Curve; 2], is_backward: bool) {
        let focal = cameras.second_focal_px();
        let info = self.variance / (END_PX * END_PX);
        for end in [0, 1] {
            let other = if is_backward { 1 - end } else { end };
            let at = [0, self.axes.len() - 1][end];
            let axis = &self.axes[at];
            let seen = axis.epipolar.at(axis.inverse);
            if let (true, true, Some(seen)) = (first.ends[end], second.ends[other], seen) {
                let there = second.spot([0.0, second.last()][other]).at;
                let by = seen.by_inverse.map(|d| focal * d);
                let off = [0, 1].map(|k| focal * (there[k] - seen.at[k]));
                let square = by[0] * by[0] + by[1] * by[1];
                let more = (by[0] * off[0] + by[1] * off[1]) / square;
                let knot = &mut self.knots[at];
                knot.info += info * square;
                knot.weighted += info * square * (axis.inverse + more);
            }
        }
    }

    /// Estimates the bending of the rope and the errors of the measured points by maximum
    /// likelihood.
    fn ask(&mut self, first: &Curve) -> Option<()> {
        let measured = self.knots.iter().filter(|knot| knot.info > 0.0).count();
        if measured < 3 {
            return None;
        }
        let (known, free) = ((measured - 2) as f64, (self.knots.len() - 2) as f64);
        let mut best: Option<(f64, f64, f64)> = None;
        for stiffness in self.stiffnesses(first) {
            let fit = self.smooth.solve(&self.knots, stiffness)?;
            let variance = (fit.sum / known).max(LEAST_SIGMA_PX * LEAST_SIGMA_PX);
            let unlikely = fit.sum / variance + known * libm::log(variance) + fit.log_determinant
                - free * libm::log(stiffness);
            if best.is_none_or(|(least, ..)| unlikely < least) {
                best = Some((unlikely, stiffness, variance));
            }
        }
        (_, self.stiffness, self.variance) = best?;
        Some(())
    }

    /// Candidates for the stiffness, from the most bending to the least.
    fn stiffnesses(&self, first: &Curve) -> impl Iterator<Item = f64> + use<> {
        let sum: f64 = self.axes.iter().map(|axis| axis.inverse).sum();
        let inverse = sum / self.axes.len() as f64;
        let step = first.step / inverse / BENDS_AT_MM;
        let variance = self.variance;
        BENDS_MM.into_iter().rev().map(move |bend| {
            let bend = bend * inverse * inverse * step * step.sqrt();
            variance / (bend * bend)
        })
    }

    /// Writes the points in 3-D.
    pub(super) fn write(&self, cameras: &ViewPair, first: &Curve, places: &mut Vec<SpacePoint>) {
        let focal = cameras.focal_px();
        let count = first.sights.len();
        let lap = (self.axes.len() - count) / 2;
        places.clear();
        let knots = self.knots.iter().zip(self.smooth.values());
        for (axis, (knot, (inverse, inverse_information))) in
            self.axes.iter().zip(knots).skip(lap).take(count)
        {
            let sight = &first.sights[axis.point];
            let depth = 1.0 / inverse;
            let square = depth * depth;
            // Share of the point's depth that comes from the distance measured at this point. The
            // first view's pixel accounts for half of this share.
            let own = (knot.info * inverse_information).min(1.0);
            let rest = 1.0 - 0.5 * own;
            let by_pixel = axis.by_pixel.map(|by| match axis.slope == 0.0 {
                true => 0.0,
                false => square * own * by / axis.slope,
            });
            let doubt_px = BESIDE * 2.0 * sight.slim * focal;
            let [x, y] = sight.by_pixel;
            let moved =
                |aside: [f64; 2], ray: f64| [0, 1].map(|k| depth * aside[k] + ray * by_pixel[k]);
            places.push(SpacePoint {
                point: sight.ray.map(|c| depth * c),
                by_pixel: [
                    moved(x, sight.ray[0]),
                    moved(y, sight.ray[1]),
                    moved([0.0; 2], sight.ray[2]),
                ],
                ray: sight.ray,
                variance: rest * self.variance * inverse_information * square * square,
                in_common: (1.0 - own) / rest,
                is_measured: axis.is_measured,
                doubt_px,
                // Both curves may be off.
                doubt_mm: std::f64::consts::SQRT_2 * doubt_px * square / axis.shift_px,
                width_mm: 2.0 * sight.slim * depth,
            });
        }
        doubt_bridges(first, places);
    }
}

/// Raises the variances of points that were not measured, depending on their distance from measured
/// points. On a closed rope, there are measured points on both sides.
fn doubt_bridges(first: &Curve, places: &mut [SpacePoint]) {
    let count = places.len();
    let measured = |i: &usize| places[*i].is_measured;
    let (Some(begin), Some(end)) = ((0..count).find(measured), (0..count).rev().find(measured))
    else {
        return;
    };
    let mut before = begin;
    for i in 0..count {
        if places[i].is_measured {
            before = i;
            continue;
        }
        let after = (i..count).find(|&k| places[k].is_measured);
        let steps = match after {
            Some(after) if i > begin => (i - before).min(after - i),
            _ if first.closed => ((i + count - end) % count).min((begin + count - i) % count),
            _ => 4 * i.abs_diff(if i < begin { begin } else { end }),
        };
        let place = &mut places[i];
        let way = ASTRAY * first.step * place.point[2] * steps as f64;
        let own = (1.0 - place.in_common) * place.variance;
        place.variance += way * way;
        place.in_common = 1.0 - own / place.variance;
    }
}

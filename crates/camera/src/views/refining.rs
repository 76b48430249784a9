//! From a chain of matches to the depth of every point, as a spline along the rope.

use super::curve::Curve;
use super::matching::{Match, STEEPEST};
use super::pair::{Epipolar, ViewPair};
use super::smooth::{Knot, Smooth};
use crate::space::{SpacePoint, length};

/// Points of a closed rope that are looked at twice, before its first and after its last.
const LAP: usize = 16;
/// Steps of Gauss and Newton; at which of them it is asked how much the rope bends, and from which on what is far off counts less.
const STEPS: usize = 4;
const ASKED_AT: [usize; 2] = [1, 3];
const ROBUST_FROM: usize = 2;
/// How far a point's depth is from between its neighbors', mm, is one of these, at steps of 5 mm. It goes with the power of 3/2 of the step.
const BENDS_MM: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0];
const BENDS_AT_MM: f64 = 5.0;
/// Distances of the curves are no surer than this, px; what is farther than so many times that counts less, and what is farther than so
/// many pixels not at all.
const LEAST_SIGMA_PX: f64 = 0.05;
const ROBUST: f64 = 2.0;
const FARTHEST_PX: f64 = 6.0;
/// What is farther than so many pixels beyond the other curve's end is not on it.
const BEYOND_PX: f64 = 1.5;
/// Where the chain of matches has ended, a point is on the other curve if that goes on by at least this share of what it should, but for
/// so many points.
const GOES_ON: f64 = 0.4;
const LAG: f64 = 0.25;
/// What is hidden counts so much, as a share; and an end's place along the epipolar line is as sure as this, px.
const HIDDEN: f64 = 0.1;
const END_PX: f64 = 1.5;
/// Where it was not measured, depth may be so far off, mm for each mm from where it was, as a rope bends more here than there; four
/// times that where it goes on from one side only.
const ASTRAY: f64 = 0.12;
/// A centerline is as a whole beside its rope's axis, as light falls on one side of it, by about this share of its width: by half of what drawn
/// ropes of 3 to 15 px have their depths off, in pixels.
const BESIDE: f64 = 0.004;
/// A point is measured if its epipolar line meets the other curve at no less than this sine.
const FLATTEST: f64 = 0.2;

/// What is known of a point.
#[derive(Debug, Clone, Copy)]
struct Axis {
    /// Which of the first curve's points.
    point: usize,
    epipolar: Epipolar,
    /// Its inverse depth, and where it is on the other curve.
    inverse: f64,
    u: f64,
    /// Beyond the chain of matches: where that ends on the other curve, and how much farther this should be.
    beyond: Option<(f64, f64)>,
    /// What a unit of inverse depth adds to its distance from that, px, and a pixel of the first view.
    slope: f64,
    by_pixel: [f64; 2],
    /// How many pixels' shift of the curves as a whole move its inverse depth by a unit.
    shift_px: f64,
    is_measured: bool,
    is_steep: bool,
}

impl Axis {
    /// Whether it has not gone on from the chain's end as it should have.
    fn lags(&self, u: f64, second: &Curve) -> bool {
        self.beyond.is_some_and(|(end, more)| {
            let gone = second.between(end, u);
            gone * more.signum() < GOES_ON * more.abs() - LAG
        })
    }
}

/// Room for one rope.
#[derive(Debug, Clone, Default)]
pub(super) struct Refining {
    axes: Vec<Axis>,
    knots: Vec<Knot>,
    smooth: Smooth,
    /// Of the point's place between its neighbors, by the distances' variance.
    stiffness: f64,
    /// The variance of the distances, px².
    variance: f64,
}

impl Refining {
    /// Finds the depths; `None` if too little says something of them.
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

    /// Finds where the rope would rise more steeply than one does: there it was matched with what it is not.
    fn find_steep(&mut self, step: f64) {
        for i in 1..self.axes.len() {
            let [a, b] = [i - 1, i].map(|k| 1.0 / self.axes[k].inverse);
            if (b - a).abs() > STEEPEST * step * a.min(b) {
                self.axes[i - 1].is_steep = true;
                self.axes[i].is_steep = true;
            }
        }
    }

    /// Depths and places between the chain's.
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
            // Of a closed rope what is before its first point is near its last.
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

    /// How far the points are from the other curve, across it, and what their depths have to do with that.
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
            // Beyond the end of the other curve, or on the way there, nothing is measured.
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

    /// Both views see a rope's end at the same place of it.
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

    /// Asks the measured points how much the rope bends, and how far they err: both are as is likeliest.
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

    /// What may be asked, from the most that a rope bends to the least.
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

    /// Writes the points in space.
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
            // How much its own distance has to do with its depth; half of that is the first view's, by the pixel.
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
                // Both curves may be.
                doubt_mm: std::f64::consts::SQRT_2 * doubt_px * square / axis.shift_px,
                width_mm: 2.0 * sight.slim * depth,
            });
        }
        doubt_bridges(first, places);
    }
}

/// Raises the variances of what was not measured, by how far away that was. Of a closed rope it was on both sides.
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

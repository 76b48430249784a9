//! Covariances of control points if each point has an error ellipsoid of its own, as in 3-D, where
//! distances are less certain than directions.
//!
//! [`Fitter::propagate`] tracks each pixel through the resampling exactly, in time proportional to
//! N m times the number of a point's neighbors. This module takes the points at equal steps as they
//! are. An error along the curve only makes a point slide on the curve, so it is left out for each
//! point. It matters only at the ends, between which everything is stretched, and for the length
//! between them. If the direction turns by `Δtₖ`, an error lengthens the curve by `Δtₖ` times the
//! error, and all later points slide.
//!
//! Let `tₖ` be the direction at point `k`, and `Nₖ = I − tₖtₖᵀ`. `Sₖ` is the ellipsoid of
//! independent errors there, and `Dₖ` that of errors shared by all points that a control point
//! reaches. `σ₀` and `σ₁` are the standard deviations of the ends along the curve. With `s = P c`,
//!
//! ```text
//! Cov(sⱼ) = ν Σₖ Pⱼₖ² Nₖ Sₖ Nₖ + Σₖ Pⱼₖ² Nₖ Dₖ Nₖ / Σₖ Pⱼₖ² + σ₀² aⱼ aⱼᵀ + σ₁² bⱼ bⱼᵀ + cⱼ cⱼᵀ,
//! aⱼ = Σₖ Pⱼₖ (1 − ρₖ) tₖ,    bⱼ = Σₖ Pⱼₖ ρₖ tₖ,    cⱼ = Σₖ Pⱼₖ τₖ tₖ,
//! τₖ² = (1 − ρₖ)² Lₖ + ρₖ² (Lₙ − Lₖ),    Lₖ = Σᵢ₍ᵢ≤ₖ₎ Δtᵢᵀ (ν Sᵢ + r Dᵢ) Δtᵢ
//! ```
//!
//! where `ν` is the number of neighbors with equal errors, and `r = N / m` the number of points
//! that a control point reaches. Shared errors move a control point as far as the points, because a
//! row of `P` sums to 1. Independent errors are amplified (for a cubic B-spline, by a factor of
//! about five in variance).

use crate::basis::MAX_CONTROL_POINTS;
use crate::fitter::Fitter;
use crate::noise::Square;
use crate::options::MAX_POINTS;
use crate::point::Point;
use lariat_portable::{Simd, WithSimd};

/// Number of points on each side from which a direction is computed.
const ASIDE: usize = 3;
/// Numbers in a vector.
const LANES: usize = 8;

/// Errors of a line's points.
#[derive(Debug, Clone, Copy)]
pub struct Spread<'a, const D: usize> {
    /// Covariance of each point's errors that are independent or shared with few neighbors.
    pub squares: &'a [Square<D>],
    /// Covariance of each point's errors that are shared with all points that a control point
    /// reaches.
    pub in_common: &'a [Square<D>],
    /// Standard deviation of each end along the line; for a closed line, of its start.
    pub ends: [f64; 2],
    /// Number of neighbors with equal errors, 1 or more.
    pub alike: f64,
}

/// Contributions of each point. Each component is a list, padded with zeros to whole vectors.
#[derive(Debug, Clone)]
pub(crate) struct Points<const D: usize> {
    /// Ellipsoid of independent errors across the line.
    across: [[Vec<f64>; D]; D],
    /// Ellipsoid of shared errors across the line.
    in_common: [[Vec<f64>; D]; D],
    /// The line's direction times the distance to the last point; in `second`, times the distance
    /// to the first.
    first: [Vec<f64>; D],
    second: [Vec<f64>; D],
    /// The line's direction times the distance by which the point may slide.
    slide: [Vec<f64>; D],
    /// A row of `P`.
    row: Vec<f64>,
}

/// Sums over all points for a control point's covariance.
struct Sums<'a, const D: usize> {
    points: &'a Points<D>,
    vectors: usize,
}

impl<const D: usize> Points<D> {
    pub(crate) fn new() -> Self {
        let room = || std::array::from_fn(|_| vec![0.0; MAX_POINTS]);
        Self {
            across: std::array::from_fn(|_| room()),
            in_common: std::array::from_fn(|_| room()),
            first: room(),
            second: room(),
            slide: room(),
            row: vec![0.0; MAX_POINTS],
        }
    }
}

impl<const D: usize> WithSimd for Sums<'_, D> {
    /// Sums of both kinds of error, along the line, and of `Pⱼₖ²`.
    type Output = ([Square<D>; 2], [[f64; D]; 3], f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let zero = simd.splat_f64s(0.0);
        let Points {
            across,
            in_common,
            first,
            second,
            slide,
            row,
        } = self.points;
        let row = &S::as_simd_f64s(row).0[..self.vectors];
        let (mut sums, mut gain) = ([[[zero; D]; D]; 2], zero);
        for (k, &p) in row.iter().enumerate() {
            let square = simd.mul_f64s(p, p);
            gain = simd.mul_add_f64s(p, p, gain);
            for (sums, of) in sums.iter_mut().zip([across, in_common]) {
                for a in 0..D {
                    for b in a..D {
                        let number = S::as_simd_f64s(&of[a][b]).0[k];
                        sums[a][b] = simd.mul_add_f64s(square, number, sums[a][b]);
                    }
                }
            }
        }
        let mut along = [[zero; D]; 3];
        for (k, &p) in row.iter().enumerate() {
            for (sums, of) in along.iter_mut().zip([first, second, slide]) {
                for a in 0..D {
                    let number = S::as_simd_f64s(&of[a]).0[k];
                    sums[a] = simd.mul_add_f64s(p, number, sums[a]);
                }
            }
        }
        let (mut squares, mut ways) = ([[[0.0; D]; D]; 2], [[0.0; D]; 3]);
        for a in 0..D {
            for b in a..D {
                for (square, sums) in squares.iter_mut().zip(&sums) {
                    square[a][b] = simd.reduce_sum_f64s(sums[a][b]);
                }
            }
            for (way, along) in ways.iter_mut().zip(&along) {
                way[a] = simd.reduce_sum_f64s(along[a]);
            }
        }
        (squares, ways, simd.reduce_sum_f64s(gain))
    }
}

impl<const D: usize> Fitter<D>
where
    [f64; D]: Point<D>,
{
    /// Computes the covariances of the last fit's control points if its `points`, at equal steps,
    /// have these errors. If residuals are larger than the points' own ellipsoids, the ellipsoids
    /// are enlarged. Shared errors do not appear in residuals. Does not allocate.
    ///
    /// Writes nothing if the numbers of points differ from the fitter's.
    pub fn spread(
        &mut self,
        points: &[[f64; D]],
        spread: &Spread<D>,
        covariances: &mut [Square<D>; MAX_CONTROL_POINTS],
    ) {
        <[f64; D]>::spread(self, points, spread, covariances);
    }
}

impl<const D: usize> Fitter<D> {
    /// Implements [`Fitter::spread`].
    pub(crate) fn spread_points(
        &mut self,
        points: &[[f64; D]],
        spread: &Spread<D>,
        covariances: &mut [Square<D>; MAX_CONTROL_POINTS],
    ) {
        let count = self.options.points;
        let squares = [spread.squares, spread.in_common];
        if points.len() != count || squares.iter().any(|of| of.len() != count) || count < 2 {
            return;
        }
        let closed = self.options.basis.is_closed();
        let of_points = &mut self.of_points;
        let (mut expected, last) = (0.0, (count - 1) as f64);
        let controls = self.fit.control_points.len();
        let reach = count as f64 / controls as f64;
        let (mut longer, mut before) = (0.0, None);
        for k in 0..count {
            let [from, to] = match closed {
                true => [(k + count - ASIDE.min(count)) % count, (k + ASIDE) % count],
                false => [k.saturating_sub(ASIDE), (k + ASIDE).min(count - 1)],
            };
            let controls = &self.fit.control_points;
            let way = match controls.as_slice() {
                // At its ends, the line has the direction of the curve.
                [end, next, ..] if !closed && k == 0 => [end, next],
                [.., next, end] if !closed && k == count - 1 => [next, end],
                _ => [&points[from], &points[to]],
            };
            let mut tangent = [0.0; D];
            let mut size = 0.0;
            for axis in 0..D {
                tangent[axis] = way[1][axis] - way[0][axis];
                size += tangent[axis] * tangent[axis];
            }
            let per_size = if size > 0.0 { 1.0 / size.sqrt() } else { 0.0 };
            for c in &mut tangent {
                *c *= per_size;
            }
            let [across, in_common] = squares.map(|of| without(&of[k], tangent));
            let rho = k as f64 / last;
            for a in 0..D {
                expected += across[a][a];
                for b in 0..D {
                    of_points.across[a][b][k] = across[a][b];
                    of_points.in_common[a][b][k] = in_common[a][b];
                }
                of_points.first[a][k] = (1.0 - rho) * tangent[a];
                of_points.second[a][k] = rho * tangent[a];
            }
            let turn: [f64; D] = match before.replace(tangent) {
                Some(before) => std::array::from_fn(|a| tangent[a] - before[a]),
                None => [0.0; D],
            };
            let [own, in_common] = squares.map(|of| within(&of[k], turn));
            longer += spread.alike * own + reach * in_common;
            of_points.row[k] = longer;
        }
        let linear = &self.sizes[self.shown].linear;
        let residuals = self.fit.residual_variance * (D * count) as f64 / expected;
        let alike = spread.alike * residuals.max(1.0);
        for k in 0..count {
            let (rho, before) = (k as f64 / last, of_points.row[k]);
            let [to_last, to_first] = [(1.0 - rho) * (1.0 - rho), rho * rho];
            let slides = (to_last * before + to_first * (longer - before)).sqrt();
            for a in 0..D {
                let tangent = of_points.first[a][k] + of_points.second[a][k];
                of_points.slide[a][k] = slides * tangent;
            }
        }
        let [one, other] = spread.ends.map(|sigma| sigma * sigma);
        let vectors = count.div_ceil(LANES);
        of_points.row[..vectors * LANES].fill(0.0);
        for (j, covariance) in covariances.iter_mut().enumerate().take(controls) {
            of_points.row[..count].copy_from_slice(linear.matrix.col_as_slice(j));
            let points = &*of_points;
            let ([own, in_common], [first, second, slide], gain) =
                self.arch.dispatch(Sums { points, vectors });
            let per_gain = if gain > 0.0 { 1.0 / gain } else { 0.0 };
            for a in 0..D {
                for b in a..D {
                    let ends = one * first[a] * first[b] + other * second[a] * second[b];
                    let across = alike * own[a][b] + per_gain * in_common[a][b];
                    covariance[a][b] = across + ends + slide[a] * slide[b];
                    covariance[b][a] = covariance[a][b];
                }
            }
        }
    }
}

/// `wᵀ S w`.
#[inline(always)]
fn within<const D: usize>(square: &Square<D>, way: [f64; D]) -> f64 {
    let mut sum = 0.0;
    for a in 0..D {
        for b in 0..D {
            sum += way[a] * square[a][b] * way[b];
        }
    }
    sum
}

/// The part of a covariance that is across a direction.
#[inline(always)]
fn without<const D: usize>(square: &Square<D>, along: [f64; D]) -> Square<D> {
    let mut times = [0.0; D];
    let mut twice = 0.0;
    for a in 0..D {
        for b in 0..D {
            times[a] += square[a][b] * along[b];
        }
        twice += along[a] * times[a];
    }
    let mut across = *square;
    for a in 0..D {
        for b in 0..D {
            across[a][b] += twice * along[a] * along[b] - along[a] * times[b] - times[a] * along[b];
        }
    }
    across
}

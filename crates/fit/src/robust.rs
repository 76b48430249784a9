//! The Huber option: points far from the curve have less weight, by iteratively reweighted least
//! squares (P. J. Huber, *Robust Statistics*, 1981; P. W. Holland and R. E. Welsch, *Robust
//! regression using iteratively reweighted least-squares*, 1977).
//!
//! ```text
//! σ = median rᵢ / median of χ_D · √(n / (n − m))      rᵢ = |cᵢ − f(ρᵢ)|, of the n points that are seen
//! wᵢ = wᵢ⁰ · min(1, kσ / rᵢ) · min(1, (gσ / rᵢ)²)
//! ```
//!
//! The first factor is Huber's: a point pulls at most as hard as one at `kσ`. For gross outliers
//! this is still too much. A few of them near an end, where the curve is flexible, move it by
//! several `σ`. The second factor makes their pull fade (as in F. R. Hampel's three-part
//! estimators). Fading may discard the wrong points, so the start is decisive. It is least squares,
//! or least squares through the running medians of the points (`medians`) if that halves the median
//! distance. A few outliers do not move the medians.

mod medians;

use crate::weighted::{Problem, Weighted, WeightedError, WeightedFit};
use medians::Medians;

/// Maximum number of reweightings after the first fit.
pub(crate) const MAX_ROUNDS: usize = 5;

/// The weights have converged if none changes by more than this share of the given one. The curve
/// then moves by far less than its noise.
const SETTLED: f64 = 0.01;

/// The `g` beyond which a pull fades. With Gaussian noise in three dimensions, one point in 10⁷ is
/// beyond this distance.
const GROSS: f64 = 6.0;

/// If no point is farther than this many `σ` from the curve of least squares, that curve is the
/// start. With 120 points of Gaussian noise in two dimensions, one rope in 25 has a point beyond
/// this distance.
const SUSPECT: f64 = 4.0;

/// The start from medians is used if its median distance is below this share of that of least
/// squares. If the curve is merely too stiff for its points, the medians do not give such a start,
/// and least squares is better.
const BETTER: f64 = 0.5;

/// Constants of Gaussian noise in `D` dimensions, whose length in units of its standard deviation
/// is `χ_D`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gaussian {
    /// Median of `χ_D`.
    pub(crate) median: f64,
    /// The `k` of 95 % efficiency: with `ψ(r) = min(r, k)`,
    /// `((D−1) E[ψ/r] + P(r < k))² / (D E[ψ²]) = 0.95`. This is the variance of the mean divided by
    /// the asymptotic variance of an M-estimator of location whose `ψ` acts along the radius.
    pub(crate) tuning: f64,
}

/// Constants for `D` = 1, 2, 3. In two dimensions the median is √(2 ln 2).
pub(crate) const GAUSSIAN: [Gaussian; 3] = [
    Gaussian {
        median: 0.674_489_750_196,
        tuning: 1.344_997_508_512,
    },
    Gaussian {
        median: 1.177_410_022_515,
        tuning: 1.501_141_083_526,
    },
    Gaussian {
        median: 1.538_172_254_455,
        tuning: 1.627_987_920_277,
    },
];

/// A robust fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HuberFit {
    /// The fit with the last weights. Its sums use those weights.
    pub(crate) fit: WeightedFit,
    /// Standard deviation of one coordinate of a point, px, from the median distance. Outliers do
    /// not affect it, and its square is used as the residual variance.
    pub(crate) sigma_px: f64,
    /// Number of reweightings, at most [`MAX_ROUNDS`].
    pub(crate) rounds: usize,
}

/// Scratch memory for the reweighting, reused from fit to fit.
pub(crate) struct Room {
    /// The given weights.
    given: Vec<f64>,
    /// Weights of the next round.
    next: Vec<f64>,
    /// Squared distances as bits, which sort like the numbers because none is negative.
    bits: Vec<u64>,
    /// Squared distances from the curve of least squares.
    least: Vec<f64>,
    medians: Medians,
}

impl Room {
    pub(crate) fn new(points: usize) -> Self {
        Self {
            given: vec![0.0; points],
            next: vec![0.0; points],
            bits: Vec::with_capacity(points),
            least: vec![0.0; points],
            medians: Medians::new(points),
        }
    }

    /// The median of the roots of `squared` over points of nonzero weight. For an even number of
    /// points, this is the upper of the two middle values.
    fn median_distance(&mut self, squared: &[f64]) -> f64 {
        self.bits.clear();
        for (squared, &weight) in squared.iter().zip(&self.given) {
            if weight > 0.0 {
                self.bits.push(squared.to_bits());
            }
        }
        if self.bits.is_empty() {
            return 0.0;
        }
        let middle = self.bits.len() / 2;
        f64::from_bits(*self.bits.select_nth_unstable(middle).1).sqrt()
    }

    /// Writes the weights of the next round. Weights are inversely proportional to distances beyond
    /// `bound_px`, and fall even faster beyond `gross` times that. Returns whether they equal the
    /// previous ones, `weights`, within [`SETTLED`].
    #[inline(always)]
    fn reweigh(&mut self, squared: &[f64], weights: &[f64], bound_px: f64, gross: f64) -> bool {
        let mut moved = 0u64;
        let given = self.given.iter().zip(weights);
        for ((next, (given, weight)), &squared) in self.next.iter_mut().zip(given).zip(squared) {
            let share = bound_px / squared.sqrt();
            let fade = gross * share;
            // Not `min`: at distance 0 the share is infinite, or NaN if the bound is 0 as well.
            let fade = if fade < 1.0 { fade * fade } else { 1.0 };
            let share = if share < 1.0 { share } else { 1.0 };
            *next = given * share * fade;
            moved |= u64::from((*next - weight).abs() > SETTLED * given);
        }
        moved == 0
    }
}

impl<const D: usize> Weighted<D> {
    /// Like [`Weighted::solve`], but points far from the curve get less weight than `weights`, so
    /// that a few outliers hardly move it. The points must be in order along the curve.
    /// [`Weighted::weights`] are the final weights. Does not allocate.
    ///
    /// # Errors
    /// Fails like `solve`, and if the points that agree do not determine the curve.
    ///
    /// # Panics
    /// If a slice does not have the size that the fitter was made for.
    pub(crate) fn huber(
        &mut self,
        problem: &Problem<'_, D>,
        control_points: &mut [[f64; D]],
    ) -> Result<HuberFit, WeightedError> {
        const { assert!(0 < D && D <= GAUSSIAN.len()) };
        let seen = self.load(problem)?;
        self.factor(problem)?;
        let [largest, _] = self.residuals();
        self.robust
            .given
            .copy_from_slice(&self.weights.all()[..self.points]);
        let gaussian = GAUSSIAN[D - 1];
        let mut median = self.start(problem, largest.sqrt() * gaussian.median / SUSPECT);
        let spare = (seen - self.count).max(1) as f64;
        let correction = (seen as f64 / spare).sqrt() / gaussian.median;
        let gross = GROSS / gaussian.tuning;
        let floor = self.rounding_px();
        let mut rounds = 0;
        loop {
            let (room, squared) = (&mut self.robust, &self.squared.all()[..self.points]);
            let weights = &mut self.weights.all_mut()[..self.points];
            let sigma_px = floor.max(correction * median);
            let settled = self.arch.dispatch(
                #[inline(always)]
                || room.reweigh(squared, weights, gaussian.tuning * sigma_px, gross),
            );
            if settled || rounds == MAX_ROUNDS {
                let fit = self.finish(problem, seen, control_points)?;
                return Ok(HuberFit {
                    fit,
                    sigma_px,
                    rounds,
                });
            }
            weights.copy_from_slice(&room.next);
            rounds += 1;
            self.factor(problem)?;
            self.residuals();
            let squared = &self.squared.all()[..self.points];
            median = self.robust.median_distance(squared);
        }
    }

    /// Chooses the start. The curve through the running medians replaces the current curve of least
    /// squares if it is better. It is not tried if the median distance is at least `enough_px`.
    /// Returns the median distance from the start.
    fn start(&mut self, problem: &Problem<'_, D>, enough_px: f64) -> f64 {
        let (points, stride) = (self.points, self.a.stride());
        let room = &mut self.robust;
        let least = room.median_distance(&self.squared.all()[..points]);
        if least >= enough_px || !room.medians.choose(&room.given) {
            return least;
        }
        room.least.copy_from_slice(&self.squared.all()[..points]);
        let columns = self.a.all()[self.count * stride..].chunks_exact(stride);
        let left = self.left.all_mut().chunks_exact_mut(stride);
        for (column, left) in columns.zip(left) {
            room.medians.run(self.arch, column, left);
        }
        self.y_least.copy_from_slice(&self.y);
        self.solve_left();
        self.normal.solve_lower(&mut self.y);
        self.complete(problem.pinned());
        self.residuals();
        let squared = &mut self.squared.all_mut()[..points];
        let other = self.robust.median_distance(squared);
        if other < BETTER * least {
            return other;
        }
        squared.copy_from_slice(&self.robust.least);
        self.y.copy_from_slice(&self.y_least);
        self.complete(None);
        least
    }

    /// Distance of a point from an exact curve that rounding alone can cause.
    fn rounding_px(&self) -> f64 {
        let points = &self.a.all()[self.count * self.a.stride()..];
        let largest = points.iter().fold(0.0, |a, b| f64::max(a, b.abs()));
        self.points as f64 * f64::EPSILON * largest
    }
}

#[cfg(test)]
mod tests;

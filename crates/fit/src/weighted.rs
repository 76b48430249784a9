//! Least squares whose algebra changes from frame to frame: points with different weights (0 if
//! hidden), and rows of `B` at measured arc lengths.
//!
//! ```text
//! minimize Σ wᵢ |cᵢ − Bᵢs|² + sᵀKs,   K = λDᵀD
//! a = R s,   A = B R⁻¹,               M = AᵀWA + R⁻ᵀKR⁻¹ = LLᵀ
//! y = L⁻¹AᵀWc,   a = L⁻ᵀy,   s = R⁻¹a
//! ```
//!
//! The normal equations of `B` itself lose `ε cond(B)²`. `R` comes from the QR of a nominal `B`,
//! computed in advance. `A` is therefore nearly orthonormal, and `M` is as well conditioned as the
//! weights allow. Rounding of `A` would still cost `ε cond(B)²`. One correction with the residuals
//! of `B` itself, `s + R⁻¹M⁻¹AᵀW(c − Bs)`, removes that, so the error is as small as with QR (the
//! corrected seminormal equations: Å. Björck, *Stability analysis of the method of seminormal
//! equations for linear least squares problems*, 1987). `Z = A L⁻ᵀ` gives all uncertainties of the
//! fit: its rows give the curve `f(ρᵢ) = zᵢᵀy` and the noise gain `|zᵢ|` of each of its points.

mod columns;
mod ends;
mod normal;
mod trust;

use crate::robust::Room;
use columns::{Columns, Gram, Residuals, Transpose, Triangular};
use ends::Ends;
use normal::Normal;
use trust::congruent;

/// Maximum ratio of the standard deviation of a point of the curve to that of a single point's
/// noise.
///
/// A centerline is accurate to a few tenths of a pixel. At 30 times that, the curve's uncertainty
/// is the width of a rope, and its position there is a guess. The limit also bounds the condition
/// number of `M`. The squares of the gains sum to `tr(M⁻¹AᵀA)`, so below the limit `cond(M)` is at
/// most about 30²N = 2·10⁵, and Cholesky keeps ten digits.
pub const MAX_NOISE_GAIN: f64 = 30.0;

/// Quality and uncertainty of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WeightedFit {
    /// Weighted sum of squared distances between points and curve, px².
    pub(crate) sum_w_r2: f64,
    /// Largest distance between the curve and a point of nonzero weight, px.
    pub(crate) max_px: f64,
    /// Expectation of `sum_w_r2` for noise of variance 1 in one coordinate: `tr((I−H)ᵀW(I−H))`. It
    /// is exact for weights 0 and 1, and if the variance of point `i` is `1/wᵢ`. Pinned ends count
    /// as points of weight 1. Without ridge and pins, it is the number of points with nonzero
    /// weight minus the number of control points.
    pub(crate) degrees_of_freedom: f64,
    /// Estimate of the 2-norm condition number of `BᵀWB + K`, with weight 1 at pinned ends. Mostly
    /// accurate to a factor of 2. Its root is comparable to the condition number of `B`.
    pub(crate) condition: f64,
    /// Largest standard deviation of a point of the curve, seen or hidden, for noise of standard
    /// deviation 1 in the points of the largest weight. With a ridge, it includes what the ridge
    /// leaves undetermined.
    pub(crate) noise_gain: f64,
}

/// Why weighted points have no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WeightedError {
    /// A weight is negative, infinite or NaN.
    #[error("the weight of point {index} is {weight}: give finite weights that are not negative")]
    NotAWeight {
        /// Index of the point, counted from 0.
        index: usize,
        /// Its weight.
        weight: f64,
    },
    /// Fewer points have a nonzero weight than there are control points.
    #[error(
        "only {seen} points are seen, and they cannot fix {control_points} control points: wait until more of \
         the curve is seen, or choose fewer control points"
    )]
    TooFewSeen {
        /// Number of points with a weight above 0, or pinned.
        seen: usize,
        /// Number of control points.
        control_points: usize,
    },
    /// The curve is undetermined where it is not seen: noise would dominate it.
    #[error(
        "the points that are seen do not determine the curve: somewhere its standard deviation would be {gain:.1e} \
         times theirs, and beyond {limit} nothing says where it runs; wait until more of it is seen, choose \
         fewer control points, or add a ridge"
    )]
    Undetermined {
        /// Ratio of the standard deviation there to that of a point; infinite if nothing determines
        /// the curve.
        gain: f64,
        /// The limit, [`MAX_NOISE_GAIN`].
        limit: f64,
    },
}

/// The problem to minimize, `Σ wᵢ |cᵢ − Bᵢs|² + sᵀKs`, with `N` points and `m` control points.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a, const D: usize> {
    /// `B`, N × m, row by row.
    pub(crate) b: &'a [f64],
    /// `R⁻¹` of the QR of a nominal `B` (with ridge: of `B` above `√λD`), m × m, row by row, zero
    /// below the diagonal. With another matrix, the accuracy is limited by `cond(B)²`.
    pub(crate) r_inverse: &'a [f64],
    pub(crate) points: &'a [[f64; D]],
    /// Weight of each point. A point of weight 0 is ignored, even if it is NaN.
    pub(crate) weights: &'a [f64],
    /// True if the curve's ends are the first and the last point exactly, whatever their weights.
    /// The first and last rows of `b` must be 1, 0, …, 0 and 0, …, 0, 1, and `m` at least 2.
    pub(crate) pins: bool,
    /// `K = λDᵀD`, m × m, symmetric.
    pub(crate) ridge: Option<&'a [f64]>,
}

impl<const D: usize> Problem<'_, D> {
    /// Both ends if they are pinned.
    pub(crate) fn pinned(&self) -> Option<[[f64; D]; 2]> {
        self.pins
            .then(|| [self.points[0], self.points[self.points.len() - 1]])
    }
}

/// Fits curves of `count` control points to `points` weighted points. It owns all of its memory.
pub(crate) struct Weighted<const D: usize> {
    pub(crate) points: usize,
    pub(crate) count: usize,
    pub(crate) arch: lariat_portable::Arch,
    /// Columns of `B`.
    b: Columns,
    /// A column of zeros.
    zeros: Columns,
    /// Columns of `A`, then those of the points.
    pub(crate) a: Columns,
    /// Columns of `WA`, then of `Z`.
    z: Columns,
    /// Weights in use: the given ones, or Huber's; 1 for pinned ends.
    pub(crate) weights: Columns,
    /// Residuals of the points, and their squared lengths.
    pub(crate) left: Columns,
    pub(crate) squared: Columns,
    /// `R⁻ᵀ`, row by row.
    lower: Vec<f64>,
    /// `R⁻ᵀKR⁻¹`, then `L⁻¹R⁻ᵀKR⁻¹L⁻ᵀ`.
    ridge: Vec<f64>,
    room: Vec<f64>,
    /// `L⁻¹R⁻ᵀ`, row by row.
    x: Vec<f64>,
    /// `XᵀV` of pinned ends.
    along: Vec<[f64; 2]>,
    pub(crate) normal: Normal<D>,
    coefficients: Vec<[f64; D]>,
    control_points: Vec<[f64; D]>,
    pub(crate) y: Vec<[f64; D]>,
    /// `y` of least squares, kept while another start is tried.
    pub(crate) y_least: Vec<[f64; D]>,
    ends: Ends,
    covariance: Vec<f64>,
    pub(crate) robust: Room,
}

impl<const D: usize> Weighted<D> {
    /// Allocates for curves of `count` control points through `points` points.
    ///
    /// # Panics
    /// If there are no control points, or fewer points than control points.
    pub(crate) fn new(points: usize, count: usize) -> Self {
        assert!(
            0 < count && count <= points,
            "no fewer points than control points"
        );
        Self {
            points,
            count,
            arch: lariat_portable::Arch::new(),
            b: Columns::new(count, points),
            zeros: Columns::new(1, points),
            a: Columns::new(count + D, points),
            z: Columns::new(count, points),
            weights: Columns::new(1, points),
            left: Columns::new(D, points),
            squared: Columns::new(1, points),
            lower: vec![0.0; count * count],
            ridge: vec![0.0; count * count],
            room: vec![0.0; count * count],
            x: vec![0.0; count * count],
            along: vec![[0.0; 2]; count],
            normal: Normal::new(count),
            coefficients: vec![[0.0; D]; count],
            control_points: vec![[0.0; D]; count],
            y: vec![[0.0; D]; count],
            y_least: vec![[0.0; D]; count],
            ends: Ends::new(count),
            covariance: vec![0.0; count * count],
            robust: Room::new(points),
        }
    }

    /// Fits the curve of least weighted squares. Does not allocate.
    ///
    /// # Errors
    /// Fails if a weight is invalid, if fewer points than control points have a weight, or if the
    /// points do not determine the curve. `control_points` are then unchanged.
    ///
    /// # Panics
    /// If a slice does not have the size that the fitter was made for.
    pub(crate) fn solve(
        &mut self,
        problem: &Problem<'_, D>,
        control_points: &mut [[f64; D]],
    ) -> Result<WeightedFit, WeightedError> {
        let seen = self.load(problem)?;
        self.factor(problem)?;
        self.finish(problem, seen, control_points)
    }

    /// `C`, m × m, row by row, of the last fit that succeeded. The control points' covariance is
    /// `σ²C` for each coordinate if the noise of point `i` has variance `σ²/wᵢ` in each (for
    /// weights 0 and 1: `σ²` of all visible points).
    ///
    /// After [`Weighted::huber`] it is approximate, because the weights are treated as constants.
    /// For many points with Gaussian noise, the true covariance is 1.01, 0.98 and 0.94 times `σ²C`
    /// in 1, 2 and 3 dimensions.
    pub(crate) fn covariance(&self) -> &[f64] {
        &self.covariance
    }

    /// Weights of the last fit; after [`Weighted::huber`] the reweighted ones; 1 at pinned ends.
    pub(crate) fn weights(&self) -> &[f64] {
        &self.weights.all()[..self.points]
    }

    /// Copies the problem into columns. Returns the number of visible points.
    pub(crate) fn load(&mut self, problem: &Problem<'_, D>) -> Result<usize, WeightedError> {
        let (points, count) = (self.points, self.count);
        assert_eq!(problem.b.len(), points * count, "B is N × m");
        assert_eq!(problem.points.len(), points, "N points");
        let seen = self.load_weights(problem)?;
        if seen < count {
            return Err(WeightedError::TooFewSeen {
                seen,
                control_points: count,
            });
        }
        let stride = self.b.stride();
        self.arch.dispatch(Transpose {
            rows: problem.b,
            width: count,
            columns: self.b.all_mut(),
            stride,
        });
        let (a, c) = self.a.all_mut().split_at_mut(count * stride);
        assert_eq!(problem.r_inverse.len(), count * count, "R⁻¹ is m × m");
        for (j, row) in self.lower.chunks_exact_mut(count).enumerate() {
            for (k, number) in row[..=j].iter_mut().enumerate() {
                *number = problem.r_inverse[k * count + j];
            }
        }
        self.arch.dispatch(Triangular {
            from: self.b.all(),
            lower: &self.lower,
            lower_stride: count,
            count,
            stride,
            to: a,
        });
        self.arch.dispatch(Transpose {
            rows: problem.points.as_flattened(),
            width: D,
            columns: c,
            stride,
        });
        let weights = self.weights.all();
        self.arch.dispatch(
            #[inline(always)]
            || columns::hide(c, weights),
        );
        if let Some(ridge) = problem.ridge {
            assert_eq!(ridge.len(), count * count, "the ridge is m × m");
            congruent(&self.lower, ridge, &mut self.room, &mut self.ridge);
        }
        Ok(seen)
    }

    /// Copies the weights. Returns the number of visible points.
    fn load_weights(&mut self, problem: &Problem<'_, D>) -> Result<usize, WeightedError> {
        assert_eq!(problem.weights.len(), self.points, "N weights");
        let weights = &mut self.weights.all_mut()[..self.points];
        weights.copy_from_slice(problem.weights);
        if problem.pins {
            assert!(self.count >= 2, "two ends are two control points");
        }
        let counted = self.arch.dispatch(
            #[inline(always)]
            || columns::count_seen(weights),
        );
        let Some(mut seen) = counted else {
            let is_weight = |weight: &f64| (0.0..f64::INFINITY).contains(weight);
            let index = weights.iter().position(|weight| !is_weight(weight));
            let index = index.unwrap_or(0);
            let weight = weights[index];
            return Err(WeightedError::NotAWeight { index, weight });
        };
        if problem.pins {
            for end in [0, self.points - 1] {
                seen += usize::from(weights[end] == 0.0);
                weights[end] = 1.0;
            }
        }
        Ok(seen)
    }

    /// Computes `L⁻¹`, `y` and `a` with the current weights.
    pub(crate) fn factor(&mut self, problem: &Problem<'_, D>) -> Result<(), WeightedError> {
        let (count, stride) = (self.count, self.a.stride());
        let (a, weights) = (self.a.all(), self.weights.all());
        let weighted = self.z.all_mut();
        self.arch.dispatch(
            #[inline(always)]
            || columns::weigh(&a[..count * stride], weights, weighted),
        );
        let sums_stride = self.normal.stride();
        self.arch.dispatch(Gram {
            left: self.z.all(),
            right: self.a.all(),
            stride,
            symmetric: true,
            sums: self.normal.start(),
            sums_stride,
        });
        if problem.ridge.is_some() {
            self.normal.add(&self.ridge);
        }
        if !self.normal.factor(self.arch) {
            return Err(WeightedError::Undetermined {
                gain: f64::INFINITY,
                limit: MAX_NOISE_GAIN,
            });
        }
        if problem.pins {
            self.hold_ends();
        }
        self.normal.copy_y(&mut self.y);
        self.complete(problem.pinned());
        Ok(())
    }

    /// Computes `V`: the rows of `Z` at both ends.
    fn hold_ends(&mut self) {
        let (a, stride, last) = (self.a.all(), self.a.stride(), self.points - 1);
        self.ends.set(|j| {
            let mut z = [0.0; 2];
            for (k, &inverse) in self.normal.inverse_row(j)[..=j].iter().enumerate() {
                z[0] += inverse * a[k * stride];
                z[1] += inverse * a[k * stride + last];
            }
            z
        });
    }

    /// Computes `a` from `y`, through the ends if they are pinned.
    pub(crate) fn complete(&mut self, pinned: Option<[[f64; D]; 2]>) {
        if let Some(pinned) = pinned {
            self.ends.pin(pinned, &mut self.y);
        }
        self.normal.coefficients(&self.y, &mut self.coefficients);
    }

    /// Computes the right-hand side for other points, the columns in `left`, with the current
    /// weights.
    pub(crate) fn solve_left(&mut self) {
        let right = self.y.as_flattened_mut();
        self.arch.dispatch(Gram {
            left: self.z.all(),
            right: self.left.all(),
            stride: self.z.stride(),
            symmetric: false,
            sums: right,
            sums_stride: D,
        });
    }

    /// Computes the squared distances of all points from the curve, from `A` and `a`. Returns the
    /// largest of those with a weight, and the weighted sum.
    pub(crate) fn residuals(&mut self) -> [f64; 2] {
        let (basis, points) = self.a.all().split_at(self.count * self.a.stride());
        self.arch.dispatch(Residuals {
            basis,
            points,
            left: self.left.all_mut(),
            coefficients: &self.coefficients,
            weights: self.weights.all(),
            squared: self.squared.all_mut(),
        })
    }
}

#[cfg(test)]
pub(crate) mod oracle;
#[cfg(test)]
mod tests;

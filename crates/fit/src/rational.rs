//! Rational Bezier curves `f(ρ) = Σ wⱼ pⱼ Bⱼ(ρ) / Σ wⱼ Bⱼ(ρ)`, whose weights are estimated together
//! with their control points. They represent some curves exactly that a polynomial only
//! approximates, such as an arc of a circle.
//!
//! The control points are projected out (`projection`). A descent finds the most probable
//! log-weights (`belief`, `descent`), from the weights of the previous frame or from a linearized
//! start. If it does not converge, the result is the polynomial, marked as not converged.

mod belief;
mod covariance;
mod descent;
mod design;
mod joint;
mod kernels;
mod linearization;
mod projection;
mod triangular;
mod trust_region;

use crate::point::Point;
use belief::Belief;
use descent::Descent;
use design::Design;
use faer::MatRef;
use linearization::Model;

/// Maximum ratio of a weight to the geometric mean of all weights, or vice versa. It is nine
/// standard deviations of the prior, and a control point with a hundredth of the weight moves with
/// a hundred times the noise.
pub const MAX_WEIGHT: f64 = 100.0;

/// Maximum number of steps from the weights of the previous frame. Two or three are enough if only
/// the noise has changed. If five are not enough, those weights do not help.
const WARM_STEPS: usize = 5;

/// Maximum number of steps from the linearized start. That start may be far off if the noise is
/// large, or if no rational curve fits the points. A rope's curve of order 4 then takes four or
/// five steps, and rarely more than twenty.
const COLD_STEPS: usize = 25;

/// A rational Bezier curve fitted to a centerline.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct RationalFit<'a, const D: usize> {
    /// The `n + 1` control points, in the points' unit (px).
    pub control_points: &'a [[f64; D]],
    /// The `n + 1` weights, all positive; their geometric mean is 1.
    pub weights: &'a [f64],
    /// Sum of the squared distances between the points and the curve at each point's `ρ`, px².
    pub squared_residuals: f64,
    /// Largest of these distances, px.
    pub max_px: f64,
    /// Number of given minus fitted numbers: `D (N − free control points)`, minus `n` weights if
    /// `converged`. The squared residuals divided by this number are the variance of one
    /// coordinate's residual.
    pub degrees_of_freedom: usize,
    /// True if the weights were determined from the points. If false, all weights are 1 and the
    /// curve is the best polynomial: there were too few points, or no weights between
    /// 1/[`MAX_WEIGHT`] and [`MAX_WEIGHT`] were found within the allowed steps. If the polynomial
    /// itself passes through the points up to rounding (a straight line, a point), the weights are
    /// 1, and `converged` is true after 0 steps.
    pub converged: bool,
    /// Number of descent steps, including those of a failed warm start, but not the up to 8 rounds
    /// of the linearized start.
    pub steps: usize,
}

/// Fits rational Bezier curves to centerlines with a fixed number of points, evenly spaced by arc
/// length.
pub struct RationalFitter<const D: usize> {
    design: Design,
    descent: Descent,
    control_points: Vec<[f64; D]>,
    covariance: covariance::Covariance,
    joint: joint::Joint,
    /// True if the next search starts from the last weights.
    warm: bool,
    /// Variance of a coordinate of the last fit if its weights were determined, px².
    variance: Option<f64>,
}

impl<const D: usize> RationalFitter<D>
where
    [f64; D]: Point<D>,
{
    /// Allocates and does the algebra that does not depend on the points, on the uniform grid
    /// `ρᵢ = i/(N − 1)`. With `pin_ends` the first and the last control point are the first and the
    /// last point.
    ///
    /// # Panics
    /// If the order is not in 1 ..= [`MAX_ORDER`](crate::MAX_ORDER), or `points` not in `order + 1`
    /// ..= [`MAX_POINTS`](crate::MAX_POINTS), or `D` is 0.
    pub fn new(order: usize, points: usize, pin_ends: bool) -> Self {
        <[f64; D]>::make_rational(order, points, pin_ends)
    }

    /// Fits the rational curve with the highest posterior probability given `points` (ordered along
    /// the curve, evenly spaced by arc length). Its squared residuals are never larger than the
    /// polynomial's. Does not allocate. Takes at most 30 steps in addition to the linearized start.
    /// It starts from the last fit's weights if that fit converged.
    ///
    /// If points are not finite, the control points are not finite either, and `converged` is
    /// false.
    ///
    /// # Panics
    /// If the number of points is not the one that the fitter was made for.
    pub fn fit(&mut self, points: &[[f64; D]]) -> RationalFit<'_, D> {
        <[f64; D]>::fit_rational(self, points)
    }

    /// Joint covariance of the control points and the log-weights, divided by `σ²`. The matrix is
    /// square with `(n+1) (D+1)` rows: the coordinates of the first control point, of the second
    /// and so on, then the log-weights. It is a first-order approximation and includes the prior of
    /// the weights. If the noise is so large that the curve is far from linear in the weights, it
    /// is only an indication. After a fit that did not converge, the weights are 1 and treated as
    /// known. Computed on request. Does not allocate.
    pub fn joint_covariance_factor(&mut self) -> MatRef<'_, f64> {
        <[f64; D]>::joint_factor(self)
    }
}

impl<const D: usize> RationalFitter<D> {
    /// Implements [`RationalFitter::new`].
    pub(crate) fn make(order: usize, points: usize, pin_ends: bool) -> Self {
        assert!(
            (1..=crate::MAX_ORDER).contains(&order),
            "a curve has an order from 1 to {}",
            crate::MAX_ORDER
        );
        assert!(
            (order + 1..=crate::MAX_POINTS).contains(&points) && D > 0,
            "a curve needs as many points as control points, and at most {}",
            crate::MAX_POINTS
        );
        let design = Design::new(order, points, pin_ends);
        Self {
            descent: Descent::new(&design, D),
            control_points: vec![[0.0; D]; design.count],
            covariance: covariance::Covariance::new(&design),
            joint: joint::Joint::new(&design, D),
            warm: false,
            variance: None,
            design,
        }
    }

    /// Implements [`RationalFitter::fit`].
    pub(crate) fn fit_points(&mut self, points: &[[f64; D]]) -> RationalFit<'_, D> {
        assert_eq!(
            points.len(),
            self.design.points,
            "a fitter takes the number of points that it was made for"
        );
        self.descent.set_points(&self.design, points);
        let belief = Belief::new(&self.design, points);
        let (converged, steps) = match &belief {
            Some(belief) => self.search(belief),
            None => (false, 0),
        };
        self.warm = converged;
        self.variance = belief
            .filter(|_| converged)
            .map(|belief| belief.variance(self.descent.projection.squared));
        if !converged {
            self.descent.start_at_polynomial(&self.design);
        }
        self.answer(converged, steps)
    }

    /// Forgets the last fit's weights. The next fit is like the first.
    pub fn forget(&mut self) {
        self.warm = false;
    }

    /// The `(n+1) × (n+1)` covariance factor `C`. If the last fit's weights are treated as known,
    /// the covariance of the control points is `σ² C ⊗ I`, for independent noise of variance `σ²`
    /// in every coordinate. The uncertainty of the weights is not included. Computed on request.
    /// Does not allocate.
    pub fn covariance_factor(&mut self) -> MatRef<'_, f64> {
        let count = self.design.count;
        let factor = self.covariance.at(&self.design, &self.descent.projection);
        MatRef::from_row_major_slice(factor, count, count)
    }

    /// Implements [`RationalFitter::joint_covariance_factor`].
    pub(crate) fn joint_factor(&mut self) -> MatRef<'_, f64> {
        let size = self.design.count * (D + 1);
        MatRef::from_row_major_slice(self.joint_covariance(), size, size)
    }

    fn joint_covariance(&mut self) -> &[f64] {
        let Self {
            design,
            descent,
            joint,
            covariance,
            ..
        } = self;
        let fixed = covariance.at(design, &descent.projection);
        let Some(variance) = self.variance else {
            return joint.at_known_weights(design.count, D, fixed);
        };
        descent.linearize(design, Model::GaussNewton);
        joint.set_spread(descent, variance);
        joint.set_sensitivity(design, descent, &self.control_points);
        joint.assemble(design.count, D, fixed);
        joint.with_ends(design, descent, covariance, D)
    }

    /// Leaves the descent at the best weights. Returns whether they are usable, and the number of
    /// steps.
    fn search(&mut self, belief: &Belief) -> (bool, usize) {
        let Self {
            descent, design, ..
        } = self;
        let known = std::mem::take(&mut self.warm);
        if known {
            descent.keep_weights();
        }
        descent.start_at_polynomial(design);
        let polynomial = descent.projection.squared;
        // A polynomial passes through the points, so weights cannot improve it.
        if belief.is_rounding(polynomial) {
            return (true, 0);
        }
        let mut steps = 0;
        for warm in [true, false] {
            let (limit, model) = if !warm {
                descent.start_linearized(design, belief);
                (COLD_STEPS, Model::GaussNewton)
            } else if known {
                descent.restore_weights(design);
                (WARM_STEPS, Model::Newton)
            } else {
                continue;
            };
            let (converged, taken) = descent.descend(design, belief, limit, model);
            steps += taken;
            if converged
                && descent.projection.squared <= polynomial
                && descent.largest_log_weight() <= libm::log(MAX_WEIGHT)
            {
                return (true, steps);
            }
        }
        (false, steps)
    }

    /// Returns the curve of the descent's projection.
    fn answer(&mut self, converged: bool, steps: usize) -> RationalFit<'_, D> {
        let projection = &mut self.descent.projection;
        let design = &self.design;
        let first = design.first_free();
        design.to_bernstein(&mut projection.coefficients, D);
        for (k, numerator) in projection.coefficients.chunks_exact(D).enumerate() {
            let weight = projection.weights[first + k];
            self.control_points[first + k] = std::array::from_fn(|axis| numerator[axis] / weight);
        }
        if design.pinned {
            let last = design.count - 1;
            self.control_points[0] = self.descent.point(design, 0);
            self.control_points[last] = self.descent.point(design, design.points - 1);
        }
        let fitted_weights = if converged { design.count - 1 } else { 0 };
        RationalFit {
            control_points: &self.control_points,
            weights: &self.descent.projection.weights,
            squared_residuals: self.descent.projection.squared,
            max_px: self.descent.projection.largest_squared(design).sqrt(),
            degrees_of_freedom: D * (design.points - design.free()) - fitted_weights,
            converged,
            steps,
        }
    }
}

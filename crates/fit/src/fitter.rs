//! A fitter: everything that does not depend on the points, computed once, and the fit of one
//! centerline.

use crate::adaptive::Adaptive;
use crate::basis::{Basis, MAX_CONTROL_POINTS};
use crate::checked;
use crate::choice::Line;
use crate::condition;
use crate::coordinate::Coordinate;
use crate::error::{FitError, FitterError};
use crate::filter::{CurveSpace, CurveSpaceError};
use crate::folded::Points;
use crate::linear::Linear;
use crate::noise::{EvenFit, Propagation, Square};
use crate::options::{Options, Rho, Weights};
use crate::point::Point;
use crate::rational::RationalFitter;
use crate::resample::Resampler;
use crate::spread;
use crate::tolerance::Tolerance;
use faer::{Mat, MatRef};

/// Coordinates of this size or larger are refused. No sensor has nearly as many pixels, and below
/// this size the squares of residuals are still accurate enough.
pub const MAX_COORDINATE_PX: f64 = 1e9;

/// A curve fitted to a centerline, and its quality.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fit<const D: usize = 2> {
    /// Family of curves, with the chosen size if there was a choice.
    pub basis: Basis,
    /// The descriptor `s`, in the points' unit. Names and docs say px, but any unit works.
    pub control_points: Vec<[f64; D]>,
    /// Weights of the control points of a rational curve; otherwise empty.
    pub weights: Vec<f64>,
    /// Clamped knots of a B-spline; otherwise empty.
    pub knots: Vec<f64>,
    /// Root mean squared distance between a point and the curve at that point's `ρ`, px.
    pub rms_px: f64,
    /// Largest of these distances, px.
    pub max_px: f64,
    /// σ², the variance of one coordinate's residual, px²: the sum of squares divided by its
    /// degrees of freedom, `D (N − (n+1))` without ridge or pins. It is 0 without degrees of
    /// freedom (`N = n + 1`).
    pub residual_variance: f64,
    /// 2-norm condition number of the solved problem: the maximum amplification of a relative error
    /// of the points in the control points.
    pub condition: f64,
    /// The m × m factor `C` of the control points' covariance `σ² C ⊗ I`. Without ridge, pins or
    /// weights, it is `(BᵀB)⁻¹`.
    pub covariance_factor: Mat<f64>,
}

impl<const D: usize> Fit<D> {
    /// The noise gain: the standard deviation of the least certain control point's coordinate, for
    /// noise of standard deviation 1 in the points' coordinates.
    pub fn noise_gain(&self) -> f64 {
        let variances = (0..self.control_points.len()).map(|j| self.covariance_factor[(j, j)]);
        variances.fold(0.0, f64::max).sqrt()
    }
}

/// Fits curves of one family to centerlines with a fixed number of points in `D` dimensions.
pub struct Fitter<const D: usize = 2> {
    pub(crate) options: Options,
    pub(crate) arch: lariat_portable::Arch,
    /// One size, or all sizes to choose from, the smallest first. Sizes with knots of individual
    /// ropes follow.
    pub(crate) sizes: Vec<Size<D>>,
    /// Number of sizes to choose from.
    pub(crate) choosable: usize,
    /// Index of the size whose knots, condition and covariance are in `fit`.
    pub(crate) shown: usize,
    /// Scratch memory for points: one for mirror-symmetric bases, one for others.
    points: [Points<D>; 2],
    /// Scratch memory for points in `f64` if they are given in `f32`.
    room: Vec<[f64; D]>,
    pub(crate) fit: Fit<D>,
    /// Scratch memory for the squared distance of each point from a curve.
    pub(crate) squared: Vec<f64>,
    propagation: Propagation<D>,
    pub(crate) of_points: spread::Points<D>,
}

/// A basis of one size, and its method of fitting.
pub(crate) struct Size<const D: usize> {
    pub(crate) linear: Linear<D>,
    way: Way<D>,
    /// Created on the first request.
    space: Option<CurveSpace>,
}

enum Way<const D: usize> {
    /// Fits by a matrix computed in advance.
    Linear,
    /// Fits by algebra that depends on the points.
    Adaptive(Box<Adaptive<D>>),
    /// Also fits weights of the control points.
    Rational(Box<RationalFitter<D>>),
}

impl<const D: usize> Size<D> {
    pub(crate) fn new(basis: Basis, options: &Options) -> Result<Self, FitterError> {
        let linear = Linear::new(basis, options)?;
        Ok(Self::by(linear, options))
    }

    /// Creates a cubic B-spline with these clamped knots.
    pub(crate) fn on_knots(
        basis: Basis,
        knots: Vec<f64>,
        options: &Options,
    ) -> Result<Self, FitterError> {
        let linear = Linear::on_knots(basis, knots, options)?;
        Ok(Self::by(linear, options))
    }

    fn by(linear: Linear<D>, options: &Options) -> Self {
        let way = match linear.basis {
            Basis::RationalBezier { order } => {
                let fitter = RationalFitter::make(order, options.points, options.pin_ends);
                Way::Rational(Box::new(fitter))
            }
            _ if options.weights != Weights::Even || options.rho == Rho::Measured => {
                Way::Adaptive(Box::new(Adaptive::new(&linear, options)))
            }
            _ => Way::Linear,
        };
        Self {
            linear,
            way,
            space: None,
        }
    }

    fn space(&self) -> Result<CurveSpace, CurveSpaceError> {
        let linear = &self.linear;
        let count = linear.basis.control_points();
        match linear.basis {
            // A polyline has corners at its points, and a mean is one point: these points
            // themselves move.
            Basis::FeaturePoints { .. } | Basis::CenterOfMass => CurveSpace::of_points(count),
            _ => CurveSpace::new(linear.b.as_ref()),
        }
    }

    /// Point of the curve at the `i`-th point's ρ, given control points and the `weights` of a
    /// rational curve.
    pub(crate) fn point(&self, i: usize, control_points: &[[f64; D]], weights: &[f64]) -> [f64; D] {
        let (mut sum, mut whole) = ([0.0; D], 0.0);
        for (j, control_point) in control_points.iter().enumerate() {
            let mut share = match &self.way {
                Way::Adaptive(adaptive) => adaptive.row(i)[j],
                Way::Linear | Way::Rational(_) => self.linear.b[(i, j)],
            };
            if let (Way::Rational(_), Some(weight)) = (&self.way, weights.get(j)) {
                share *= weight;
                whole += share;
            }
            for axis in 0..D {
                sum[axis] += share * control_point[axis];
            }
        }
        match whole {
            0.0 => sum,
            _ => sum.map(|c| c / whole),
        }
    }
}

/// Distances of points from a curve.
pub(crate) struct Residuals {
    /// Sum of the squares, each times its point's weight, px².
    pub(crate) weighted_sum: f64,
    /// Sum of the weights.
    pub(crate) weights: f64,
    pub(crate) max_px: f64,
    /// Variance of one coordinate, px²; 0 without degrees of freedom.
    pub(crate) variance: f64,
}

impl Residuals {
    /// Residuals of points that all count the same. `freedom` is the degrees of freedom of all
    /// coordinates.
    fn even(sum: f64, max_px: f64, points: usize, freedom: f64) -> Self {
        Self {
            weighted_sum: sum,
            weights: points as f64,
            max_px,
            variance: if freedom > 0.0 { sum / freedom } else { 0.0 },
        }
    }
}

impl Fitter<2> {
    /// Computes everything that a fit needs except the points.
    ///
    /// # Errors
    /// Fails if a size or the number of points is out of range, if there are fewer points than
    /// control points, if an option does not apply to the basis, or if the condition number is so
    /// high that rounding errors would dominate the control points. The error names the nearest
    /// allowed request.
    pub fn new(options: Options) -> Result<Self, FitterError> {
        Self::in_dimensions(options)
    }
}

impl<const D: usize> Fitter<D>
where
    [f64; D]: Point<D>,
{
    /// Like [`Fitter::new`], for points in the plane or in 3-D.
    ///
    /// # Errors
    /// Fails as [`Fitter::new`] does.
    pub fn in_dimensions(options: Options) -> Result<Self, FitterError> {
        <[f64; D]>::make_fitter(options)
    }

    /// Fits the curve nearest to `points` by least squares. Does not allocate. The result is valid
    /// until the next fit.
    ///
    /// `points` are in pixels, and ordered along the curve. They are evenly spaced by arc length,
    /// unless the fitter measures arc length.
    ///
    /// # Errors
    /// Fails if the number of points is not the fitter's, or if one is not a position in a picture.
    /// With weights or measured arc lengths, also fails if the points do not determine the curve.
    pub fn fit<T: Coordinate>(&mut self, points: &[[T; D]]) -> Result<&Fit<D>, FitError> {
        self.fit_within(points, Tolerance::default())
    }

    /// Like [`Fitter::fit`]. If the fitter was made to [choose](Options::choose_size) the number of
    /// control points, uses the fewest that keep the curve within `tolerance` of the points.
    ///
    /// # Errors
    /// Fails as [`Fitter::fit`] does.
    pub fn fit_within<T: Coordinate>(
        &mut self,
        points: &[[T; D]],
        tolerance: Tolerance,
    ) -> Result<&Fit<D>, FitError> {
        self.in_f64(points, |fitter, points| {
            <[f64; D]>::fit(fitter, &Line::of(points), tolerance).map(|_| ())
        })?;
        Ok(&self.fit)
    }

    /// Computes only the control points, by equation 8 of the paper, in less than half the time of
    /// a complete fit. The residuals of the last fit ([`Fitter::last`]) are then NaN. If this
    /// shortcut is unavailable (another solver, weights, a size to be chosen, rational curves),
    /// this does a complete fit.
    ///
    /// # Errors
    /// Fails as [`Fitter::fit`] does.
    pub fn control_points<T: Coordinate>(
        &mut self,
        points: &[[T; D]],
    ) -> Result<&[[f64; D]], FitError> {
        self.in_f64(points, |fitter, points| {
            <[f64; D]>::describe(fitter, points).map(|_| ())
        })?;
        Ok(&self.fit.control_points)
    }

    /// Like [`Fitter::fit`], with a weight of 0 or more for each point: 0 for a hidden point.
    ///
    /// # Errors
    /// Fails as [`Fitter::fit`] does, if the fitter was made without weights, or if weights are
    /// invalid.
    pub fn fit_weighted<T: Coordinate>(
        &mut self,
        points: &[[T; D]],
        weights: &[f64],
    ) -> Result<&Fit<D>, FitError> {
        self.in_f64(points, |fitter, points| {
            let line = Line {
                weights: Some(weights),
                ..Line::of(points)
            };
            <[f64; D]>::fit(fitter, &line, Tolerance::default()).map(|_| ())
        })?;
        Ok(&self.fit)
    }

    /// Runs a fit on `points` in `f64`.
    fn in_f64<T: Coordinate>(
        &mut self,
        points: &[[T; D]],
        fit: impl FnOnce(&mut Self, &[[f64; D]]) -> Result<(), FitError>,
    ) -> Result<(), FitError> {
        let mut room = std::mem::take(&mut self.room);
        let result = fit(self, T::widen(points, &mut room));
        self.room = room;
        result
    }

    /// Computes the covariances of the last fit's control points from pixel noise. The fit's points
    /// came from `line`, whose input was pixels that a map transformed. The pixels have independent
    /// noise of variance σ² in each coordinate. `squares` are `JJᵀ` of the map's derivatives there,
    /// in the order of those points. Returns σ², px², estimated from the residuals.
    /// `crates/fit/src/noise.rs` contains the derivation. Does not allocate.
    ///
    /// Writes nothing and returns 0 if `line` or `squares` do not have the fitter's number of
    /// points.
    pub fn propagate(
        &mut self,
        line: &Resampler<D>,
        squares: &[Square<D>],
        covariances: &mut [Square<D>; MAX_CONTROL_POINTS],
    ) -> f64 {
        <[f64; D]>::carry_noise(self, line, squares, covariances)
    }
}

impl<const D: usize> Fitter<D> {
    /// Implements [`Fitter::in_dimensions`].
    pub(crate) fn make(options: Options) -> Result<Self, FitterError> {
        checked::check(&options)?;
        let mut sizes = vec![Size::new(options.basis, &options)?];
        if options.choose_size {
            let smaller = std::iter::successors(options.basis.smaller(), |basis| basis.smaller());
            for basis in smaller {
                sizes.push(Size::new(basis.named(), &options)?);
            }
            sizes.reverse();
        }
        let largest = sizes.len() - 1;
        let linear = &sizes[largest].linear;
        let count = linear.basis.control_points();
        let fit = Fit {
            basis: options.basis,
            control_points: vec![[0.0; D]; count],
            weights: Vec::with_capacity(count),
            knots: linear.knots.clone(),
            rms_px: 0.0,
            max_px: 0.0,
            residual_variance: 0.0,
            condition: linear.condition,
            covariance_factor: linear.covariance.clone(),
        };
        Ok(Self {
            options,
            arch: lariat_portable::Arch::new(),
            shown: largest,
            points: [true, false].map(|folded| Points::new(options.points, folded)),
            room: Vec::with_capacity(options.points),
            choosable: sizes.len(),
            sizes,
            fit,
            squared: vec![0.0; options.points],
            propagation: Propagation::new(),
            of_points: spread::Points::new(),
        })
    }

    /// Implements [`Fitter::control_points`].
    pub(crate) fn describe(&mut self, points: &[[f64; D]]) -> Result<&[[f64; D]], FitError> {
        if let [size] = &mut self.sizes[..]
            && matches!(size.way, Way::Linear)
            && points.len() == self.options.points
        {
            let lanes = &mut self.points[usize::from(!condition::is_mirrored(size.linear.basis))];
            let fit = &mut self.fit;
            let described =
                (size.linear).describe(self.arch, points, lanes, &mut fit.control_points);
            if described.is_some() {
                (fit.rms_px, fit.max_px, fit.residual_variance) = (f64::NAN, f64::NAN, f64::NAN);
                return Ok(&self.fit.control_points);
            }
        }
        self.fit_line(&Line::of(points), Tolerance::default())
            .map(|fit| &fit.control_points[..])
    }

    /// Implements [`Fitter::fit_within`] and [`Fitter::fit_weighted`].
    pub(crate) fn fit_line(
        &mut self,
        line: &Line<D>,
        tolerance: Tolerance,
    ) -> Result<&Fit<D>, FitError> {
        let size = match self.choosable {
            1 => 0,
            _ => self.size_for(line, tolerance)?.0,
        };
        self.fit_of_size(size, line)
    }

    /// Checks the number of points, and of weights.
    pub(crate) fn check(&self, line: &Line<D>) -> Result<(), FitError> {
        let expected = self.options.points;
        let given = line.points.len();
        if given != expected {
            return Err(FitError::Count { given, expected });
        }
        match line.weights {
            Some(_) if self.options.weights == Weights::Even => Err(FitError::NoWeights),
            Some(weights) if weights.len() != expected => Err(FitError::WeightCount {
                given: weights.len(),
                expected,
            }),
            _ => Ok(()),
        }
    }

    /// Fits a curve of this size into `fit.control_points`.
    pub(crate) fn fit_size(
        &mut self,
        size: usize,
        points: &[[f64; D]],
        weights: Option<&[f64]>,
    ) -> Result<Residuals, FitError> {
        let Size { linear, way, .. } = &mut self.sizes[size];
        let control_points = &mut self.fit.control_points;
        control_points.resize(linear.basis.control_points(), [0.0; D]);
        Ok(match way {
            Way::Linear => {
                let lanes = &mut self.points[usize::from(!condition::is_mirrored(linear.basis))];
                let Some(squared) = linear.fit(self.arch, points, lanes, control_points) else {
                    return Err(misplaced(points));
                };
                let freedom = D as f64 * linear.freedom;
                Residuals::even(squared.sum, squared.max.sqrt(), points.len(), freedom)
            }
            Way::Adaptive(_) | Way::Rational(_) if !are_places(points) => {
                return Err(misplaced(points));
            }
            Way::Adaptive(adaptive) => {
                adaptive.fit(points, weights, &self.options, control_points)?
            }
            Way::Rational(rational) => {
                let fit = rational.fit_points(points);
                control_points.copy_from_slice(fit.control_points);
                self.fit.weights.clear();
                if fit.converged {
                    self.fit.weights.extend_from_slice(fit.weights);
                }
                let freedom = fit.degrees_of_freedom as f64;
                Residuals::even(fit.squared_residuals, fit.max_px, points.len(), freedom)
            }
        })
    }

    /// Sets everything in `fit` except the curve and its residuals to the values of this size.
    pub(crate) fn show(&mut self, size: usize) {
        let Size { linear, way, .. } = &mut self.sizes[size];
        let fit = &mut self.fit;
        // Sizes of individual ropes may have changed.
        let known = self.shown == size && size < self.choosable;
        self.shown = size;
        match way {
            Way::Linear if known => {}
            Way::Linear => {
                fit.basis = linear.basis;
                fit.condition = linear.condition;
                fit.knots.clone_from(&linear.knots);
                copy(linear.covariance.as_ref(), &mut fit.covariance_factor);
            }
            Way::Adaptive(adaptive) => {
                fit.basis = linear.basis;
                fit.condition = adaptive.condition();
                fit.knots.clear();
                fit.knots.extend_from_slice(adaptive.knots());
                copy(adaptive.covariance(), &mut fit.covariance_factor);
            }
            Way::Rational(rational) => {
                let order = linear.basis.order();
                fit.basis = if fit.weights.is_empty() {
                    Basis::Bezier { order }
                } else {
                    Basis::RationalBezier { order }
                };
                copy(rational.covariance_factor(), &mut fit.covariance_factor);
            }
        }
    }

    /// Forgets the initial values for the next fit (the weights of a rational curve), because the
    /// next centerline belongs to another rope.
    pub fn forget(&mut self) {
        for size in &mut self.sizes {
            if let Way::Rational(rational) = &mut size.way {
                rational.forget();
            }
        }
    }

    /// The options of the fitter.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The last fit. Before the first fit it contains zeros, except for the condition number and
    /// the covariance, which do not depend on points.
    pub fn last(&self) -> &Fit<D> {
        &self.fit
    }

    /// The space of this fitter's largest curves, for a [`Filter`](crate::Filter) of their control
    /// points.
    ///
    /// # Errors
    /// Does not fail within the fitter's own limits; the error type lists what else could be wrong.
    pub fn curve_space(&self) -> Result<CurveSpace, CurveSpaceError> {
        self.sizes[self.choosable - 1].space()
    }

    /// The space of the last fit's curve. It is the same object, or a clone of it, as long as the
    /// curves are the same. Created on the first request.
    ///
    /// # Errors
    /// Fails as [`Fitter::curve_space`] does.
    pub fn last_space(&mut self) -> Result<CurveSpace, CurveSpaceError> {
        let size = &mut self.sizes[self.shown];
        if let Some(space) = &size.space {
            return Ok(space.clone());
        }
        let space = size.space()?;
        size.space = Some(space.clone());
        Ok(space)
    }

    /// Implements [`Fitter::propagate`].
    pub(crate) fn carry_noise(
        &mut self,
        line: &Resampler<D>,
        squares: &[Square<D>],
        covariances: &mut [Square<D>; MAX_CONTROL_POINTS],
    ) -> f64 {
        let points = self.options.points;
        if line.shape().0 != points || squares.len() != points {
            return 0.0;
        }
        let linear = &self.sizes[self.shown].linear;
        let even = EvenFit {
            p: &linear.matrix,
            b: &linear.b,
        };
        let growth = self.propagation.run(&even, line, squares, covariances);
        let fit = &self.fit;
        let squared = fit.residual_variance * D as f64 * linear.freedom;
        let variance = if growth > 0.0 { squared / growth } else { 0.0 };
        let count = fit.control_points.len();
        for (j, covariance) in covariances.iter_mut().enumerate().take(count) {
            let share = fit.covariance_factor[(j, j)] / linear.covariance[(j, j)];
            // Both are 0 for a pinned end that depends on several points.
            let share = if share.is_finite() { share } else { 1.0 };
            *covariance = covariance.map(|row| row.map(|c| variance * share * c));
        }
        variance
    }

    /// `P`, m × N, such that `P` times the points are the control points, the same for every axis.
    /// It is the constant Jacobian `∂s/∂c̄` of the descriptor with respect to the points. If there
    /// is a choice of sizes, it is that of the last chosen size.
    pub fn matrix(&self) -> MatRef<'_, f64> {
        self.sizes[self.shown].linear.matrix.transpose()
    }
}

/// Copies a matrix into reused memory. Allocates only to grow.
fn copy(from: MatRef<'_, f64>, to: &mut Mat<f64>) {
    let (rows, columns) = from.shape();
    to.truncate(rows.min(to.nrows()), columns.min(to.ncols()));
    to.resize_with(rows, columns, |_, _| 0.0);
    to.copy_from(from);
}

/// Returns whether every coordinate is a valid position.
fn are_places<const D: usize>(points: &[[f64; D]]) -> bool {
    points.as_flattened().iter().all(is_coordinate)
}

/// Also rejects NaN.
fn is_coordinate(c: &f64) -> bool {
    c.abs() < MAX_COORDINATE_PX
}

/// Creates the error that names the first invalid coordinate.
fn misplaced<const D: usize>(points: &[[f64; D]]) -> FitError {
    let mut coordinates = points.as_flattened().iter();
    let place = coordinates.position(|c| !is_coordinate(c)).unwrap_or(0);
    FitError::NotAPoint {
        index: place / D.max(1),
        value: points
            .as_flattened()
            .get(place)
            .copied()
            .unwrap_or(f64::NAN),
    }
}

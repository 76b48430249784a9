//! A fitter: everything that does not depend on the points, computed once; and the fit of one centerline.

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

/// Coordinates of this size or more are refused: no sensor is near it, and the squares of residuals stay
/// exact enough to mean something below it.
pub const MAX_COORDINATE_PX: f64 = 1e9;

/// A curve fitted to a centerline, and how well it fits.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fit<const D: usize = 2> {
    /// The family of curves, and the size where it was chosen.
    pub basis: Basis,
    /// The descriptor `s`, in the points' unit: px, and wherever px is said here, what the points come in.
    pub control_points: Vec<[f64; D]>,
    /// Weights of the control points: of rational curves only, else empty.
    pub weights: Vec<f64>,
    /// The clamped knots of a B-spline, else empty.
    pub knots: Vec<f64>,
    /// Root of the mean squared distance between a point and the curve at that point's `ρ`, px.
    pub rms_px: f64,
    /// The largest of these distances, px.
    pub max_px: f64,
    /// σ², the variance of one coordinate's residual, px²: the sum of squares by its degrees of freedom,
    /// `D (N − (n+1))` without ridge or pins. 0 where nothing is left to tell it by (`N = n + 1`).
    pub residual_variance: f64,
    /// The condition number in the 2-norm of what was solved: how much a relative error of the points can grow
    /// in the control points.
    pub condition: f64,
    /// `C`, m × m, of the control points' covariance `σ² C ⊗ I`; without ridge, pins or weights it is `(BᵀB)⁻¹`.
    pub covariance_factor: Mat<f64>,
}

impl<const D: usize> Fit<D> {
    /// The noise gain: the standard deviation of the least certain control point's coordinate, for noise of
    /// standard deviation 1 in the points' coordinates.
    pub fn noise_gain(&self) -> f64 {
        let variances = (0..self.control_points.len()).map(|j| self.covariance_factor[(j, j)]);
        variances.fold(0.0, f64::max).sqrt()
    }
}

/// Fits curves of one family to centerlines of one number of points in `D` dimensions.
pub struct Fitter<const D: usize = 2> {
    pub(crate) options: Options,
    pub(crate) arch: lariat_portable::Arch,
    /// One, or one of each size to choose from, the smallest first; behind these, those that ropes have for themselves.
    pub(crate) sizes: Vec<Size<D>>,
    /// How many there are to choose from.
    pub(crate) choosable: usize,
    /// Whose knots, condition and covariance `fit` holds.
    pub(crate) shown: usize,
    /// Room for points, for bases that read the same backwards and for others.
    points: [Points<D>; 2],
    /// Room for the points in `f64`, where they come in `f32`.
    room: Vec<[f64; D]>,
    pub(crate) fit: Fit<D>,
    /// Room for the squared distance of each point from a curve.
    pub(crate) squared: Vec<f64>,
    propagation: Propagation<D>,
    pub(crate) of_points: spread::Points<D>,
}

/// A basis of one size and how it is fitted.
pub(crate) struct Size<const D: usize> {
    pub(crate) linear: Linear<D>,
    way: Way<D>,
    /// Once it has been asked for.
    space: Option<CurveSpace>,
}

enum Way<const D: usize> {
    /// By the matrix that is known beforehand.
    Linear,
    /// By an algebra that depends on the points.
    Adaptive(Box<Adaptive<D>>),
    /// With weights of the control points.
    Rational(Box<RationalFitter<D>>),
}

impl<const D: usize> Size<D> {
    pub(crate) fn new(basis: Basis, options: &Options) -> Result<Self, FitterError> {
        let linear = Linear::new(basis, options)?;
        Ok(Self::by(linear, options))
    }

    /// A cubic B-spline with these clamped knots.
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
            // Lines between points bend at them: the points themselves are what moves.
            Basis::FeaturePoints { .. } | Basis::CenterOfMass => CurveSpace::of_points(count),
            _ => CurveSpace::new(linear.b.as_ref()),
        }
    }

    /// The point on the curve of these control points where the `i`-th point's ρ is; `weights` are of rational curves that
    /// have some.
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

/// How far points are from a curve.
pub(crate) struct Residuals {
    /// The sum of the squares, each times its point's weight, px².
    pub(crate) weighted_sum: f64,
    /// The sum of the weights.
    pub(crate) weights: f64,
    pub(crate) max_px: f64,
    /// That of one coordinate, px²; 0 where nothing is left to tell it by.
    pub(crate) variance: f64,
}

impl Residuals {
    /// Those of points that all count the same; `freedom` counts the coordinates that were not used up.
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
    /// Computes all that a fit needs beside the points.
    ///
    /// # Errors
    /// A size or number of points out of range, fewer points than control points, an option that the basis has no use
    /// for, or a condition number that would drown the control points in rounding errors; with the nearest that is
    /// allowed.
    pub fn new(options: Options) -> Result<Self, FitterError> {
        Self::in_dimensions(options)
    }
}

impl<const D: usize> Fitter<D>
where
    [f64; D]: Point<D>,
{
    /// As [`Fitter::new`], for points of the plane or of space.
    ///
    /// # Errors
    /// As [`Fitter::new`].
    pub fn in_dimensions(options: Options) -> Result<Self, FitterError> {
        <[f64; D]>::make_fitter(options)
    }

    /// The curve nearest to `points` in the least-squares sense. Allocates nothing; the result stands until
    /// the next fit.
    ///
    /// `points` are pixels, ordered along the curve, evenly spaced by arc length unless it is measured.
    ///
    /// # Errors
    /// Another number of points than the fitter was made for, or one that is no place in a picture; with weights or
    /// measured arc lengths also points that do not determine the curve.
    pub fn fit<T: Coordinate>(&mut self, points: &[[T; D]]) -> Result<&Fit<D>, FitError> {
        self.fit_within(points, Tolerance::default())
    }

    /// As [`Fitter::fit`], of the fewest control points that keep the curve within `tolerance` of the points, if the
    /// fitter was made to [choose](Options::choose_size) their number.
    ///
    /// # Errors
    /// As [`Fitter::fit`].
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

    /// The control points alone, equation 8 of the paper and nothing else, in less than half of the time. Of the last fit
    /// ([`Fitter::last`]) the residuals are NaN then. Where there is no such short way (another solver, weights, a size to
    /// be chosen, rational curves) it is a fit.
    ///
    /// # Errors
    /// As [`Fitter::fit`].
    pub fn control_points<T: Coordinate>(
        &mut self,
        points: &[[T; D]],
    ) -> Result<&[[f64; D]], FitError> {
        self.in_f64(points, |fitter, points| {
            <[f64; D]>::describe(fitter, points).map(|_| ())
        })?;
        Ok(&self.fit.control_points)
    }

    /// As [`Fitter::fit`], with each point counting as much as its weight says, 0 or more: 0 for a point that is not
    /// seen.
    ///
    /// # Errors
    /// As [`Fitter::fit`]; a fitter made without weights; invalid weights.
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

    /// The covariances of the last fit's control points, where its points came from `line`, and what `line`
    /// was given were pixels with independent noise of variance σ² in each coordinate that a map took elsewhere:
    /// `squares` are `JJᵀ` of its derivatives there, in the order of those points. Returns σ², px², as
    /// the residuals tell it. The derivation stands at the head of `crates/fit/src/noise.rs`. Allocates nothing.
    ///
    /// None of it is written, and 0 returned, if `line` or `squares` have another number of points than the fitter.
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
    /// [`Fitter::in_dimensions`].
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

    /// [`Fitter::control_points`].
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

    /// [`Fitter::fit_within`] and [`Fitter::fit_weighted`].
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

    /// Whether there are as many points, and weights, as the fitter was made for.
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

    /// Makes what `fit` says beside the curve and its residuals that of this size.
    pub(crate) fn show(&mut self, size: usize) {
        let Size { linear, way, .. } = &mut self.sizes[size];
        let fit = &mut self.fit;
        // What ropes have for themselves may be another than it was.
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

    /// Forgets what the next fit would begin with (the weights of a rational curve): the next centerline is another
    /// rope's.
    pub fn forget(&mut self) {
        for size in &mut self.sizes {
            if let Way::Rational(rational) = &mut size.way {
                rational.forget();
            }
        }
    }

    /// What the fitter was made with.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The last fit; before the first, zeros with the condition number and the covariance that hold anyway.
    pub fn last(&self) -> &Fit<D> {
        &self.fit
    }

    /// The space of this fitter's largest curves, for a [`Filter`](crate::Filter) of their control points.
    ///
    /// # Errors
    /// None where the fitter's own limits were kept; the type says what else could be wrong.
    pub fn curve_space(&self) -> Result<CurveSpace, CurveSpaceError> {
        self.sizes[self.choosable - 1].space()
    }

    /// That of the last fit's curve: the same object, or a clone of it, for as long as the curves are the same. Made when
    /// it is first asked for.
    ///
    /// # Errors
    /// As [`Fitter::curve_space`].
    pub fn last_space(&mut self) -> Result<CurveSpace, CurveSpaceError> {
        let size = &mut self.sizes[self.shown];
        if let Some(space) = &size.space {
            return Ok(space.clone());
        }
        let space = size.space()?;
        size.space = Some(space.clone());
        Ok(space)
    }

    /// [`Fitter::propagate`].
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
            // A pinned end of many points has neither.
            let share = if share.is_finite() { share } else { 1.0 };
            *covariance = covariance.map(|row| row.map(|c| variance * share * c));
        }
        variance
    }

    /// `P`, m × N, such that `P` times the points are the control points, the same for every axis. It is the Jacobian
    /// `∂s/∂c̄` of the descriptor with respect to the points, and constant; of the size last chosen where there is a
    /// choice.
    pub fn matrix(&self) -> MatRef<'_, f64> {
        self.sizes[self.shown].linear.matrix.transpose()
    }
}

/// Copies a matrix, into memory that is kept. Allocates only to grow.
fn copy(from: MatRef<'_, f64>, to: &mut Mat<f64>) {
    let (rows, columns) = from.shape();
    to.truncate(rows.min(to.nrows()), columns.min(to.ncols()));
    to.resize_with(rows, columns, |_, _| 0.0);
    to.copy_from(from);
}

/// Whether every coordinate is one of a place in a picture.
fn are_places<const D: usize>(points: &[[f64; D]]) -> bool {
    points.as_flattened().iter().all(is_coordinate)
}

/// NaN is not.
fn is_coordinate(c: &f64) -> bool {
    c.abs() < MAX_COORDINATE_PX
}

/// The error that names the first coordinate that is not finite.
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

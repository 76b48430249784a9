//! Dimensions of curves. [`Point`] has no generic method, so this crate compiles fitters, kernels
//! and filters once for each dimension. Otherwise every program that fits would compile them again,
//! for all vector sets.

use faer::MatRef;

use crate::MAX_CONTROL_POINTS;
use crate::choice::{Judged, Line, SteadySize};
use crate::error::{FitError, FitterError};
use crate::filter::{
    CurveSpace, Filter, FilterError, FilterOptions, FilterStep, Noise, PredictError, Prediction,
    UpdateError,
};
use crate::fitter::{Fit, Fitter};
use crate::noise::Square;
use crate::options::Options;
use crate::rational::{RationalFit, RationalFitter};
use crate::resample::{ResampleError, Resampler};
use crate::spread::Spread;
use crate::tolerance::Tolerance;

/// A point in the plane, `[f64; 2]`, or in 3-D, `[f64; 3]`. Its functions are the methods of
/// [`Fitter`], [`SteadySize`], [`Resampler`], [`RationalFitter`] and [`Filter`].
pub trait Point<const D: usize>: Sealed {
    #[doc(hidden)]
    fn make_fitter(options: Options) -> Result<Fitter<D>, FitterError>;
    #[doc(hidden)]
    fn fit<'a>(
        fitter: &'a mut Fitter<D>,
        line: &Line<D>,
        tolerance: Tolerance,
    ) -> Result<&'a Fit<D>, FitError>;
    #[doc(hidden)]
    fn least_size(
        fitter: &mut Fitter<D>,
        line: &Line<D>,
        tolerance: Tolerance,
    ) -> Result<(usize, bool), FitError>;
    #[doc(hidden)]
    fn fit_at<'a>(
        fitter: &'a mut Fitter<D>,
        size: usize,
        line: &Line<D>,
    ) -> Result<&'a Fit<D>, FitError>;
    #[doc(hidden)]
    fn lies_on(fitter: &mut Fitter<D>, line: &Line<D>, tolerance: Tolerance) -> bool;
    #[doc(hidden)]
    fn describe<'a>(
        fitter: &'a mut Fitter<D>,
        points: &[[f64; D]],
    ) -> Result<&'a [[f64; D]], FitError>;
    #[doc(hidden)]
    fn carry_noise(
        fitter: &mut Fitter<D>,
        line: &Resampler<D>,
        squares: &[Square<D>],
        covariances: &mut [Square<D>; MAX_CONTROL_POINTS],
    ) -> f64;
    #[doc(hidden)]
    fn spread(
        fitter: &mut Fitter<D>,
        points: &[[f64; D]],
        spread: &Spread<D>,
        covariances: &mut [Square<D>; MAX_CONTROL_POINTS],
    );
    #[doc(hidden)]
    fn fit_steadily(
        size: &mut SteadySize,
        fitter: &mut Fitter<D>,
        line: &Line<D>,
        tolerance: Tolerance,
        exposed_ns: u64,
    ) -> Result<Judged, FitError>;
    #[doc(hidden)]
    fn resample<'a>(
        resampler: &'a mut Resampler<D>,
        points: &[[f64; D]],
        closed: bool,
    ) -> Result<&'a [[f64; D]], ResampleError>;
    #[doc(hidden)]
    fn make_rational(order: usize, points: usize, pin_ends: bool) -> RationalFitter<D>;
    #[doc(hidden)]
    fn fit_rational<'a>(
        fitter: &'a mut RationalFitter<D>,
        points: &[[f64; D]],
    ) -> RationalFit<'a, D>;
    #[doc(hidden)]
    fn joint_factor(fitter: &mut RationalFitter<D>) -> MatRef<'_, f64>;
    #[doc(hidden)]
    fn make_filter(
        max_control_points: usize,
        options: FilterOptions,
    ) -> Result<Filter<D>, FilterError>;
    #[doc(hidden)]
    fn take_in(
        filter: &mut Filter<D>,
        t_ns: u64,
        space: &CurveSpace,
        control_points: &[[f64; D]],
        noise: Noise<'_>,
    ) -> Result<FilterStep, UpdateError>;
    #[doc(hidden)]
    fn foretell(filter: &mut Filter<D>, t_ns: u64) -> Result<&Prediction<D>, PredictError>;
}

/// Prevents implementations outside of this crate.
pub trait Sealed {}

macro_rules! points {
    ($($D:literal)*) => {$(
        impl Sealed for [f64; $D] {}

        impl Point<$D> for [f64; $D] {
            fn make_fitter(options: Options) -> Result<Fitter<$D>, FitterError> {
                Fitter::make(options)
            }

            fn fit<'a>(
                fitter: &'a mut Fitter<$D>,
                line: &Line<$D>,
                tolerance: Tolerance,
            ) -> Result<&'a Fit<$D>, FitError> {
                fitter.fit_line(line, tolerance)
            }

            fn least_size(
                fitter: &mut Fitter<$D>,
                line: &Line<$D>,
                tolerance: Tolerance,
            ) -> Result<(usize, bool), FitError> {
                fitter.size_for(line, tolerance)
            }

            fn fit_at<'a>(
                fitter: &'a mut Fitter<$D>,
                size: usize,
                line: &Line<$D>,
            ) -> Result<&'a Fit<$D>, FitError> {
                fitter.fit_of_size(size, line)
            }

            fn lies_on(fitter: &mut Fitter<$D>, line: &Line<$D>, tolerance: Tolerance) -> bool {
                fitter.is_within(line, tolerance)
            }

            fn describe<'a>(
                fitter: &'a mut Fitter<$D>,
                points: &[[f64; $D]],
            ) -> Result<&'a [[f64; $D]], FitError> {
                fitter.describe(points)
            }

            fn carry_noise(
                fitter: &mut Fitter<$D>,
                line: &Resampler<$D>,
                squares: &[Square<$D>],
                covariances: &mut [Square<$D>; MAX_CONTROL_POINTS],
            ) -> f64 {
                fitter.carry_noise(line, squares, covariances)
            }

            fn spread(
                fitter: &mut Fitter<$D>,
                points: &[[f64; $D]],
                spread: &Spread<$D>,
                covariances: &mut [Square<$D>; MAX_CONTROL_POINTS],
            ) {
                fitter.spread_points(points, spread, covariances);
            }

            fn fit_steadily(
                size: &mut SteadySize,
                fitter: &mut Fitter<$D>,
                line: &Line<$D>,
                tolerance: Tolerance,
                exposed_ns: u64,
            ) -> Result<Judged, FitError> {
                size.fit_steadily(fitter, line, tolerance, exposed_ns)
            }

            fn resample<'a>(
                resampler: &'a mut Resampler<$D>,
                points: &[[f64; $D]],
                closed: bool,
            ) -> Result<&'a [[f64; $D]], ResampleError> {
                resampler.even_out(points, closed)
            }

            fn make_rational(order: usize, points: usize, pin_ends: bool) -> RationalFitter<$D> {
                RationalFitter::make(order, points, pin_ends)
            }

            fn fit_rational<'a>(
                fitter: &'a mut RationalFitter<$D>,
                points: &[[f64; $D]],
            ) -> RationalFit<'a, $D> {
                fitter.fit_points(points)
            }

            fn joint_factor(fitter: &mut RationalFitter<$D>) -> MatRef<'_, f64> {
                fitter.joint_factor()
            }

            fn make_filter(
                max_control_points: usize,
                options: FilterOptions,
            ) -> Result<Filter<$D>, FilterError> {
                Filter::make(max_control_points, options)
            }

            fn take_in(
                filter: &mut Filter<$D>,
                t_ns: u64,
                space: &CurveSpace,
                control_points: &[[f64; $D]],
                noise: Noise<'_>,
            ) -> Result<FilterStep, UpdateError> {
                filter.take_in(t_ns, space, control_points, noise)
            }

            fn foretell(
                filter: &mut Filter<$D>,
                t_ns: u64,
            ) -> Result<&Prediction<$D>, PredictError> {
                filter.foretell(t_ns)
            }
        }
    )*};
}
points!(2 3);

//! Fitters: the choice of a curve, with the names of the settings, and the fit of points in arrays.

use crate::errors::value_error;
use crate::fit::Fit;
use lariat_fit::{
    Basis, Knots, Line, MAX_CONTROL_POINTS, Options, Rho, Solver, Tolerance, Weights,
};
use numpy::{AllowTypeChange, PyArray2, PyArrayLike1, PyArrayLike2};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, TryLockError};
use thiserror::Error;

/// Number of control points if only the basis is given, as in the settings.
const DEFAULT_CONTROL_POINTS: usize = 9;

/// Name of the basis for which curve and control points are chosen automatically.
const AUTO: &str = "auto";

/// Number of control points: fixed, or chosen for each curve.
#[derive(Clone, Copy)]
enum ControlPoints {
    Named(usize),
    Auto,
}

impl<'a, 'py> FromPyObject<'a, 'py> for ControlPoints {
    type Error = PyErr;

    fn extract(count: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match count.extract() {
            Ok(count) if (2..=MAX_CONTROL_POINTS).contains(&count) => Ok(Self::Named(count)),
            Err(_) if count.extract::<String>().is_ok_and(|name| name == AUTO) => Ok(Self::Auto),
            _ => Err(value_error(format!(
                "control_points is a whole number, 2 to {MAX_CONTROL_POINTS}, or \"auto\""
            ))),
        }
    }
}

/// Fits curves of one family to centerlines with a fixed number of points. Everything that does not
/// depend on the points is computed once.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Fitter {
    fitter: Mutex<lariat_fit::Fitter>,
    options: Options,
}

#[pymethods]
impl Fitter {
    #[new]
    #[pyo3(
        signature = (
            points=120, control_points=None, basis=AUTO, *, closed=false, max_control_points=17, degree=3, knots="uniform",
            solver="pinv", ridge=0.0, pin_ends=false, rho="even", weighted=false, robust=false
        ),
        // Shows the default of `basis` by its value instead of its name in Rust.
        text_signature = "(points=120, control_points=None, basis='auto', *, closed=False, max_control_points=17, degree=3, \
            knots='uniform', solver='pinv', ridge=0.0, pin_ends=False, rho='even', weighted=False, robust=False)"
    )]
    #[expect(
        clippy::too_many_arguments,
        reason = "as many as the settings have keys, all by name"
    )]
    fn new(
        py: Python<'_>,
        points: usize,
        control_points: Option<ControlPoints>,
        basis: &str,
        closed: bool,
        max_control_points: usize,
        degree: usize,
        knots: &str,
        solver: &str,
        ridge: f64,
        pin_ends: bool,
        rho: &str,
        weighted: bool,
        robust: bool,
    ) -> PyResult<Self> {
        let knots = named("knots", knots, Knots::NAMED)?;
        let (basis, choose_size) = match control_points {
            None if basis == AUTO => {
                let auto = Options::auto(points, closed);
                (auto.basis, auto.choose_size)
            }
            _ => {
                let most = match control_points {
                    None => DEFAULT_CONTROL_POINTS,
                    Some(ControlPoints::Named(count)) => count,
                    Some(ControlPoints::Auto) => max_control_points,
                };
                let basis = basis_of(basis, closed, most, degree, knots)?;
                (basis, matches!(control_points, Some(ControlPoints::Auto)))
            }
        };
        let options = Options::default()
            .basis(basis)
            .choose_size(choose_size)
            .points(points)
            .solver(named("solver", solver, Solver::ALL)?)
            .ridge(ridge)
            // Only an open curve has ends.
            .pin_ends(pin_ends && !closed)
            .rho(named("rho", rho, Rho::ALL)?)
            .weights(match (robust, weighted) {
                (true, _) => Weights::Robust,
                (false, true) => Weights::Given,
                (false, false) => Weights::Even,
            });
        let fitter = py
            .detach(|| lariat_fit::Fitter::new(options))
            .map_err(value_error)?;
        Ok(Self {
            fitter: Mutex::new(fitter),
            options,
        })
    }

    /// Fits a curve to `points` by least squares. `width` is the rope's width, and `hidden` is True
    /// for each unobserved point. Both matter if the number of control points is chosen
    /// automatically. The curve is then within an eighth of the width, at most 2 px, of 95 % of the
    /// observed points. It is within half a width of all of them.
    #[pyo3(signature = (points, weights=None, *, width=None, hidden=None))]
    fn fit<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        weights: Option<PyArrayLike1<'py, f64, AllowTypeChange>>,
        width: Option<f64>,
        hidden: Option<PyArrayLike1<'py, bool>>,
    ) -> PyResult<Fit> {
        let points = points_of(points)?;
        let weights = weights.map(|weights| weights.as_array().to_vec());
        let hidden = hidden.map_or(Vec::new(), |hidden| hidden.as_array().to_vec());
        // Without a width, only the limit in pixels applies.
        let width = width.unwrap_or(f64::NAN);
        let tolerance = Tolerance::of_width(width, Tolerance::WIDTHS, Tolerance::LIMIT_PX);
        let fit = py.detach(|| -> Result<_, Problem> {
            let mut fitter = self.fitter()?;
            let line = Line {
                points: &points,
                weights: weights.as_deref(),
                hidden: &hidden,
            };
            let (size, _) = fitter.least_size(&line, tolerance)?;
            Ok(fitter.fit_at(size, &line)?.clone())
        });
        Ok(Fit::new(fit?, points.len()))
    }

    /// The constant matrix P with s = P c: the Jacobian of the control points with respect to the
    /// points, of shape (control points, points). It is the same for x and y.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let fitter = self.fitter()?;
        let rows = fitter.matrix().row_iter();
        let rows: Vec<Vec<f64>> = rows.map(|row| row.iter().copied().collect()).collect();
        Ok(PyArray2::from_vec2(py, &rows)?)
    }

    /// Number of points of a centerline.
    #[getter]
    fn points(&self) -> usize {
        self.options.points
    }

    /// The family of curves, such as `"bezier"`.
    #[getter]
    fn basis(&self) -> &'static str {
        self.options.basis.name()
    }

    /// Forgets the state for the next fit (the weights of a rational curve). Call it before the
    /// centerline of another rope.
    fn forget(&self) -> PyResult<()> {
        self.fitter()?.forget();
        Ok(())
    }

    fn __repr__(&self) -> String {
        format!(
            "<lariat.Fitter of {} to {} points>",
            self.options.basis, self.options.points
        )
    }
}

/// Reason why a fit failed.
#[derive(Debug, Error)]
enum Problem {
    #[error("another thread fits with this fitter: give each thread a fitter of its own")]
    Busy,
    #[error(transparent)]
    Fit(#[from] lariat_fit::FitError),
}

impl From<Problem> for PyErr {
    fn from(problem: Problem) -> Self {
        match problem {
            Problem::Busy => PyRuntimeError::new_err(problem.to_string()),
            Problem::Fit(_) => value_error(problem),
        }
    }
}

impl Fitter {
    fn fitter(&self) -> Result<MutexGuard<'_, lariat_fit::Fitter>, Problem> {
        match self.fitter.try_lock() {
            Ok(fitter) => Ok(fitter),
            // Every fit starts from scratch, so a poisoned fitter is still usable.
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Problem::Busy),
        }
    }
}

/// The family with this name, as in the settings, and this number of control points. "auto" means
/// the paper's family, because the number is given.
fn basis_of(
    name: &str,
    closed: bool,
    control_points: usize,
    degree: usize,
    knots: Knots,
) -> PyResult<Basis> {
    // Degree of the Bezier curve.
    let order = control_points.saturating_sub(1);
    // As many coefficients as an open curve has control points, or one fewer.
    let fourier = Basis::Fourier {
        harmonics: (order / 2).max(1),
    };
    let spline = Basis::BSpline {
        degree: degree.min(order),
        control_points,
        knots,
    };
    let families = [
        (AUTO, Basis::Bezier { order }),
        named_by_itself(Basis::Bezier { order }),
        named_by_itself(spline),
        named_by_itself(Basis::RationalBezier { order }),
        named_by_itself(fourier),
        named_by_itself(Basis::FeaturePoints {
            count: control_points,
        }),
        named_by_itself(Basis::CenterOfMass),
    ];
    let family = named("basis", name, families)?;
    Ok(if closed { fourier } else { family })
}

fn named_by_itself(family: Basis) -> (&'static str, Basis) {
    (family.name(), family)
}

/// Finds the value with this name.
fn named<T: Copy, const N: usize>(what: &str, name: &str, known: [(&str, T); N]) -> PyResult<T> {
    let found = known.iter().find(|(known, _)| *known == name);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names = known.map(|(name, _)| name).join(", ");
        value_error(format!(
            "there is no {what} '{name}': choose one of {names}"
        ))
    })
}

/// Parses rows of x and y.
fn points_of(points: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    let wanted = || {
        value_error(
            "points are rows of x and y: an array of shape (n, 2), or a list of pairs of numbers",
        )
    };
    let points: PyArrayLike2<'_, f64, AllowTypeChange> = points.extract().map_err(|_| wanted())?;
    let rows = points.as_array();
    if rows.ncols() != 2 {
        return Err(wanted());
    }
    Ok(rows
        .rows()
        .into_iter()
        .map(|row| [row[0], row[1]])
        .collect())
}

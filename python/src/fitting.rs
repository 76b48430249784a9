//! Fitters: which curve is asked for, in the words of the settings, and the fit of points in arrays.

use crate::errors::value_error;
use crate::fit::Fit;
use lariat_fit::{Basis, Knots, Options, Rho, Solver, Weights};
use numpy::{AllowTypeChange, PyArray2, PyArrayLike1, PyArrayLike2};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, TryLockError};
use thiserror::Error;

/// The order: a number, or chosen anew for each curve.
enum Order {
    Named(usize),
    Auto,
}

impl<'a, 'py> FromPyObject<'a, 'py> for Order {
    type Error = PyErr;

    fn extract(order: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match order.extract() {
            Ok(order) => Ok(Self::Named(order)),
            Err(_) if order.extract::<String>().is_ok_and(|name| name == "auto") => Ok(Self::Auto),
            Err(_) => Err(value_error("order is a whole number, 1 to 31, or \"auto\"")),
        }
    }
}

/// Fits curves of one family to centerlines of one number of points: all that does not depend on the points is computed
/// once.
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
            points=120, order=Order::Named(8), basis="bezier", *, closed=false, max_order=16, degree=3, knots="uniform",
            solver="pinv", ridge=0.0, pin_ends=false, rho="even", weighted=false, robust=false
        ),
        // What Rust cannot say of the order.
        text_signature = "(points=120, order=8, basis='bezier', *, closed=False, max_order=16, degree=3, \
            knots='uniform', solver='pinv', ridge=0.0, pin_ends=False, rho='even', weighted=False, robust=False)"
    )]
    #[expect(
        clippy::too_many_arguments,
        reason = "as many as the settings have keys, all by name"
    )]
    fn new(
        py: Python<'_>,
        points: usize,
        order: Order,
        basis: &str,
        closed: bool,
        max_order: usize,
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
        let largest = match order {
            Order::Named(order) => order,
            Order::Auto => max_order,
        };
        let options = Options {
            basis: basis_of(basis, closed, largest, degree, knots)?,
            choose_size: matches!(order, Order::Auto),
            points,
            solver: named("solver", solver, Solver::ALL)?,
            ridge,
            // A closed curve has no ends.
            pin_ends: pin_ends && !closed,
            rho: named("rho", rho, Rho::ALL)?,
            weights: match (robust, weighted) {
                (true, _) => Weights::Robust,
                (false, true) => Weights::Given,
                (false, false) => Weights::Even,
            },
        };
        let fitter = py
            .detach(|| lariat_fit::Fitter::new(options))
            .map_err(value_error)?;
        Ok(Self {
            fitter: Mutex::new(fitter),
            options,
        })
    }

    /// The curve nearest to `points` in the least-squares sense.
    #[pyo3(signature = (points, weights=None))]
    fn fit<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        weights: Option<PyArrayLike1<'py, f64, AllowTypeChange>>,
    ) -> PyResult<Fit> {
        let points = points_of(points)?;
        let weights = weights.map(|weights| weights.as_array().to_vec());
        let fit = py.detach(|| -> Result<_, Problem> {
            let mut fitter = self.fitter()?;
            let fit = match &weights {
                None => fitter.fit(&points)?,
                Some(weights) => fitter.fit_weighted(&points, weights)?,
            };
            Ok(fit.clone())
        });
        Ok(Fit::new(fit?, points.len()))
    }

    /// The constant matrix P with s = P c: the Jacobian of the control points by the points, of shape
    /// (control points, points). It is the same for x and y.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let fitter = self.fitter()?;
        let rows = fitter.matrix().row_iter();
        let rows: Vec<Vec<f64>> = rows.map(|row| row.iter().copied().collect()).collect();
        Ok(PyArray2::from_vec2(py, &rows)?)
    }

    /// How many points a centerline has.
    #[getter]
    fn points(&self) -> usize {
        self.options.points
    }

    /// The family of curves, such as `"bezier"`.
    #[getter]
    fn basis(&self) -> &'static str {
        self.options.basis.name()
    }

    /// Forgets what the next fit would begin with (the weights of a rational curve): the next centerline is another rope's.
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

/// Why there is no fit.
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
            // Every fit begins anew.
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Problem::Busy),
        }
    }
}

/// The family in the words of the settings: as many control points as its order says, and one.
fn basis_of(
    name: &str,
    closed: bool,
    order: usize,
    degree: usize,
    knots: Knots,
) -> PyResult<Basis> {
    // As many coefficients as an open curve of this order has control points, or one fewer.
    let fourier = Basis::Fourier {
        harmonics: (order / 2).max(1),
    };
    let spline = Basis::BSpline {
        degree: degree.min(order),
        control_points: order + 1,
        knots,
    };
    let families = [
        Basis::Bezier { order },
        spline,
        Basis::RationalBezier { order },
        fourier,
        Basis::FeaturePoints { count: order + 1 },
        Basis::CenterOfMass,
    ]
    .map(|family| (family.name(), family));
    let family = named("basis", name, families)?;
    Ok(if closed { fourier } else { family })
}

/// The value of this name.
fn named<T: Copy, const N: usize>(what: &str, name: &str, known: [(&str, T); N]) -> PyResult<T> {
    let found = known.iter().find(|(known, _)| *known == name);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names = known.map(|(name, _)| name).join(", ");
        value_error(format!(
            "there is no {what} '{name}': choose one of {names}"
        ))
    })
}

/// Rows of x and y.
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

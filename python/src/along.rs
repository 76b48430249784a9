//! Evaluation of a curve at one ρ, or at each ρ of an array.

use crate::errors::value_error;
use numpy::ndarray::Array2;
use numpy::{
    AllowTypeChange, PyArray1, PyArrayDyn, PyArrayLike1, PyArrayMethods, PyUntypedArray,
    PyUntypedArrayMethods, ToPyArray,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// Largest rounding error of a rho that is a sum of steps. A million steps, each off by an ulp,
/// stay far below it.
const ROUNDING: f64 = 1e-9;

/// Normalized arc lengths from 0 to 1: a number, or an array of numbers.
pub(crate) enum Rho<'py> {
    /// A number.
    One(f64),
    /// A one-dimensional array.
    Many(PyArrayLike1<'py, f64, AllowTypeChange>),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Rho<'py> {
    type Error = PyErr;

    fn extract(rho: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        // An array with a single number also converts to a float, but the result must be an array.
        let is_row = rho
            .cast::<PyUntypedArray>()
            .is_ok_and(|array| array.ndim() > 0);
        if !is_row && let Ok(rho) = rho.extract() {
            return on_curve(rho).map(|_| Self::One(rho));
        }
        let rhos: PyArrayLike1<'py, f64, AllowTypeChange> = rho.extract().map_err(|_| {
            PyTypeError::new_err(
                "rho is a number from 0 to 1, or a row of them: an array of shape (n,)",
            )
        })?;
        rhos.as_array().iter().try_for_each(|&rho| on_curve(rho))?;
        Ok(Self::Many(rhos))
    }
}

/// # Errors
/// A `ValueError` if rho is outside 0 to 1.
fn on_curve(rho: f64) -> PyResult<()> {
    match (-ROUNDING..=1.0 + ROUNDING).contains(&rho) {
        true => Ok(()),
        false => Err(value_error(format!(
            "rho is {rho}, and a rope is where rho is from 0, its first end, to 1, its last"
        ))),
    }
}

impl<'py> Rho<'py> {
    /// The length of the array; `None` for a number.
    pub(crate) fn count(&self) -> Option<usize> {
        match self {
            Self::One(_) => None,
            Self::Many(rhos) => Some(rhos.len()),
        }
    }

    /// A vector at each rho: of shape (D,), or (n, D) for n values.
    pub(crate) fn vectors<const D: usize>(
        &self,
        py: Python<'py>,
        at: impl Fn(f64) -> [f64; D],
    ) -> Bound<'py, PyArrayDyn<f64>> {
        self.rows(py, D, |rho, row| row.copy_from_slice(&at(rho)))
    }

    /// `width` numbers at each rho.
    pub(crate) fn rows(
        &self,
        py: Python<'py>,
        width: usize,
        write: impl Fn(f64, &mut [f64]),
    ) -> Bound<'py, PyArrayDyn<f64>> {
        match self {
            Self::One(rho) => {
                let mut row = vec![0.0; width];
                write(rho.clamp(0.0, 1.0), &mut row);
                PyArray1::from_vec(py, row).to_dyn().clone()
            }
            Self::Many(rhos) => {
                let rhos = rhos.as_array();
                let mut numbers = Array2::zeros((rhos.len(), width));
                for (mut row, &rho) in numbers.rows_mut().into_iter().zip(rhos) {
                    if let Some(row) = row.as_slice_mut() {
                        write(rho.clamp(0.0, 1.0), row);
                    }
                }
                numbers.to_pyarray(py).to_dyn().clone()
            }
        }
    }

    /// A number at each rho: a float, or an array of n floats.
    pub(crate) fn numbers(
        &self,
        py: Python<'py>,
        at: impl Fn(f64) -> f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self {
            Self::One(rho) => at(rho.clamp(0.0, 1.0)).into_pyobject(py)?.into_any(),
            Self::Many(rhos) => {
                let rhos = rhos.as_array();
                let numbers: Vec<f64> = rhos.iter().map(|rho| at(rho.clamp(0.0, 1.0))).collect();
                PyArray1::from_vec(py, numbers).into_any()
            }
        })
    }
}

/// Value of an undefined direction: NaN, which propagates into every result.
pub(crate) const fn nowhere<const D: usize>() -> [f64; D] {
    [f64::NAN; D]
}

//! What Rust says is wrong, as Python's exceptions: the sentence stays.

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;
use std::fmt::Display;

/// What is wrong with a value.
pub(crate) fn value_error(cause: impl Display) -> PyErr {
    PyValueError::new_err(cause.to_string())
}

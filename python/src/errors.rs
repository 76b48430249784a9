//! Converts Rust errors to Python exceptions with the same message.

use lariat_wire::WireError;
use pyo3::PyErr;
use pyo3::exceptions::{PyOSError, PyPermissionError, PyValueError};
use std::fmt::Display;

/// The exception for an invalid value.
pub(crate) fn value_error(cause: impl Display) -> PyErr {
    PyValueError::new_err(cause.to_string())
}

/// The exception for a problem with a rig: `ValueError` for an invalid name, `PermissionError`, or
/// `OSError`.
pub(crate) fn wire_error(cause: WireError) -> PyErr {
    let sentence = cause.to_string();
    match cause {
        WireError::RigName(_) | WireError::DomainName(_) => PyValueError::new_err(sentence),
        WireError::Permission { .. }
        | WireError::Owner { .. }
        | WireError::Folder { .. }
        | WireError::DomainOfUser { .. } => PyPermissionError::new_err(sentence),
        _ => PyOSError::new_err(sentence),
    }
}

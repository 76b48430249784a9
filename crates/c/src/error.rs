#![allow(unsafe_code)] // Functions that C calls by name.
//! Errors for C: a number and a message.

use std::cell::RefCell;
use std::ffi::{CString, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

use lariat_wire::{NoPrediction, NoShape, NoSpace, WireError, WriteError};

/// Version of this interface. It is part of the shared library's name, so a program never runs with
/// another version.
pub const LARIAT_ABI: u32 = 1;

/// The name of a rig or a domain contains characters that are not allowed, or has the wrong length.
pub const LARIAT_ERROR_NAME: c_int = -1;
/// Shared memory is missing or too small.
pub const LARIAT_ERROR_MEMORY: c_int = -2;
/// The chain is of another release.
pub const LARIAT_ERROR_VERSION: c_int = -3;
/// The rig already has its maximum number of readers.
pub const LARIAT_ERROR_TOO_MANY: c_int = -4;
/// The chain belongs to another user.
pub const LARIAT_ERROR_PERMISSION: c_int = -5;
/// The transport failed.
pub const LARIAT_ERROR_TRANSPORT: c_int = -6;
/// A required pointer is NULL: a reader, space for an answer, or the descriptor of a rope in
/// another state.
pub const LARIAT_ERROR_NULL: c_int = -7;
/// The chain describes ropes by points or by their center instead of a curve.
pub const LARIAT_ERROR_NO_CURVE: c_int = -8;
/// The descriptor's numbers do not describe a curve.
pub const LARIAT_ERROR_UNREADABLE: c_int = -9;
/// The direction of the curve is undefined there, because its derivative vanishes.
pub const LARIAT_ERROR_NO_DIRECTION: c_int = -10;
/// The frame does not contain this rope.
pub const LARIAT_ERROR_NO_ROPE: c_int = -11;
/// The rope cannot be predicted; lariat_error says why.
pub const LARIAT_ERROR_NO_PREDICTION: c_int = -12;
/// A bug in lariat. Please report the text of lariat_error.
pub const LARIAT_ERROR_FAULT: c_int = -13;
/// The rig's frames already have a writer.
pub const LARIAT_ERROR_TAKEN: c_int = -14;
/// Invalid image: its size, pixel format, time or number is wrong, or no slot is on loan.
pub const LARIAT_ERROR_IMAGE: c_int = -15;

/// The rope's position in space is unknown; lariat_error says why.
pub const LARIAT_ERROR_NO_SPACE: c_int = -16;

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Returns the last error in this thread as a sentence that says what to do; empty before the first
/// error. The text is valid until the next error in this thread.
#[unsafe(no_mangle)]
pub extern "C" fn lariat_error() -> *const c_char {
    LAST.with_borrow(|text| text.as_ptr())
}

/// Returns the interface version of the library: LARIAT_ABI of its own header.
#[unsafe(no_mangle)]
pub extern "C" fn lariat_abi() -> u32 {
    LARIAT_ABI
}

/// Returns the release of lariat that the library belongs to, such as "0.1.0". All processes of a
/// rig must be of the same release.
#[unsafe(no_mangle)]
pub extern "C" fn lariat_version() -> *const c_char {
    const VERSION: &std::ffi::CStr = match std::ffi::CStr::from_bytes_with_nul(
        concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes(),
    ) {
        Ok(version) => version,
        Err(_) => c"",
    };
    VERSION.as_ptr()
}

/// Reason why a call failed.
#[derive(Debug)]
pub(crate) struct Failure {
    code: c_int,
    text: String,
}

impl Failure {
    pub(crate) fn new(code: c_int, text: impl Into<String>) -> Self {
        Self {
            code,
            text: text.into(),
        }
    }

    pub(crate) fn null(what: &str) -> Self {
        Self::new(LARIAT_ERROR_NULL, format!("{what} is NULL"))
    }
}

impl From<WireError> for Failure {
    fn from(cause: WireError) -> Self {
        let code = match cause {
            WireError::RigName(_) | WireError::DomainName(_) => LARIAT_ERROR_NAME,
            WireError::NoSharedMemory(_) | WireError::TooLittleSpace { .. } => LARIAT_ERROR_MEMORY,
            WireError::Version { .. } => LARIAT_ERROR_VERSION,
            WireError::TooManyReaders { .. } => LARIAT_ERROR_TOO_MANY,
            WireError::Permission { .. }
            | WireError::Owner { .. }
            | WireError::Folder { .. }
            | WireError::DomainOfUser { .. } => LARIAT_ERROR_PERMISSION,
            WireError::SecondWriter { .. } => LARIAT_ERROR_TAKEN,
            _ => LARIAT_ERROR_TRANSPORT,
        };
        Self::new(code, cause.to_string())
    }
}

impl From<WriteError> for Failure {
    fn from(cause: WriteError) -> Self {
        match cause {
            WriteError::Wire(cause) => cause.into(),
            WriteError::FramesTaken { .. } => Self::new(LARIAT_ERROR_TAKEN, cause.to_string()),
            cause => Self::new(LARIAT_ERROR_IMAGE, cause.to_string()),
        }
    }
}

impl From<NoShape> for Failure {
    fn from(cause: NoShape) -> Self {
        let code = match cause {
            NoShape::FeaturePoints | NoShape::CenterOfMass | NoShape::Nowhere(_) => {
                LARIAT_ERROR_NO_CURVE
            }
            NoShape::Unreadable => LARIAT_ERROR_UNREADABLE,
        };
        Self::new(code, cause.to_string())
    }
}

impl From<NoSpace> for Failure {
    fn from(cause: NoSpace) -> Self {
        match cause {
            NoSpace::NoShape(cause @ NoShape::Unreadable) => cause.into(),
            NoSpace::NotFollowed => Self::new(
                LARIAT_ERROR_NO_SPACE,
                "this reader reads ropes in the image only: call lariat_follow_in_space after lariat_open",
            ),
            cause => Self::new(LARIAT_ERROR_NO_SPACE, cause.to_string()),
        }
    }
}

impl From<NoPrediction> for Failure {
    fn from(cause: NoPrediction) -> Self {
        match cause {
            NoPrediction::NoShape(cause) => cause.into(),
            cause => Self::new(LARIAT_ERROR_NO_PREDICTION, cause.to_string()),
        }
    }
}

/// Runs a call from C and returns its result. On failure, returns the error's number and stores its
/// message for `lariat_error`. Panics do not unwind into C.
pub(crate) fn answer(work: impl FnOnce() -> Result<c_int, Failure>) -> c_int {
    let done = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|cause| {
        let text = cause.downcast_ref::<&str>().copied().map(String::from);
        let text = text.or_else(|| cause.downcast_ref::<String>().cloned());
        Err(Failure::new(
            LARIAT_ERROR_FAULT,
            format!("lariat has a fault: {}", text.unwrap_or_default()),
        ))
    });
    done.unwrap_or_else(|failure| {
        // A message never contains a NUL. If it did, it would be replaced by an empty message.
        LAST.set(CString::new(failure.text).unwrap_or_default());
        failure.code
    })
}

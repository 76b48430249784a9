//! Errors of a camera, each as a sentence with what to do about it.

use std::io;
use std::path::PathBuf;

use super::controls::ControlError;
use super::negotiate::NoCommonFormat;

/// Why a camera cannot be opened, set up or read.
#[derive(Debug, thiserror::Error)]
pub enum CameraError {
    /// The path does not exist.
    #[error("there is no {}: {cameras}", path.display())]
    Absent {
        /// The path as given.
        path: PathBuf,
        /// The cameras that exist.
        cameras: String,
    },
    /// The user lacks permission to open it.
    #[error("this user may not open {}: {remedy}", path.display())]
    NoPermission {
        /// The path as given.
        path: PathBuf,
        /// The users with permission, and the command that gives it.
        remedy: String,
    },
    /// Another program uses it.
    #[error("{} is in use by {holder}: end that first, a camera shows its pictures to one program at a time", path.display())]
    Busy {
        /// The path as given.
        path: PathBuf,
        /// The program, as far as it is known.
        holder: String,
    },
    /// It was unplugged, or its driver has failed.
    #[error("{} does not answer any more ({error}): it was unplugged, or its driver has given up; plug it in again", path.display())]
    Gone {
        /// The path as given.
        path: PathBuf,
        /// The kernel's error.
        error: io::Error,
    },
    /// The path is not a device that delivers pictures.
    #[error("{} is no camera: {what}", path.display())]
    NotACamera {
        /// The path as given.
        path: PathBuf,
        /// Its kind, and what to name instead.
        what: String,
    },
    /// The camera lacks the requested format, or any format that lariat reads.
    #[error("{}: {why}", path.display())]
    NoCommonFormat {
        /// The path as given.
        path: PathBuf,
        /// The request, and what is available.
        why: NoCommonFormat,
    },
    /// The driver set a different format from the requested one, which it had listed.
    #[error("{} was asked for {asked} and set {got}: {remedy}", path.display())]
    OtherFormat {
        /// The path as given.
        path: PathBuf,
        /// The requested format and size.
        asked: String,
        /// The format and size that it set.
        got: String,
        /// The remedy.
        remedy: String,
    },
    /// A control that does not exist, or a value that it does not accept.
    #[error("{}: {why}", path.display())]
    Control {
        /// The path as given.
        path: PathBuf,
        /// The control, and what is available.
        why: ControlError,
    },
    /// The kernel refused a call that a camera should support.
    #[error("{} cannot {doing}: {error}", path.display())]
    Refused {
        /// The path as given.
        path: PathBuf,
        /// The attempted action, with the name of the call.
        doing: &'static str,
        /// The kernel's error.
        error: io::Error,
    },
}

//! What can be wrong with a camera, each as a sentence with what to do about it.

use std::io;
use std::path::PathBuf;

use super::controls::ControlError;
use super::negotiate::NoCommonFormat;

/// Why a camera cannot be opened, set up or read.
#[derive(Debug, thiserror::Error)]
pub enum CameraError {
    /// The path leads nowhere.
    #[error("there is no {}: {cameras}", path.display())]
    Absent {
        /// As it was named.
        path: PathBuf,
        /// Which cameras there are.
        cameras: String,
    },
    /// The user may not open it.
    #[error("this user may not open {}: {remedy}", path.display())]
    NoPermission {
        /// As it was named.
        path: PathBuf,
        /// Who may, and what to type.
        remedy: String,
    },
    /// Another program has it.
    #[error("{} is in use by {holder}: end that first, a camera shows its pictures to one program at a time", path.display())]
    Busy {
        /// As it was named.
        path: PathBuf,
        /// The program, as far as it can be told.
        holder: String,
    },
    /// It was unplugged, or its driver has given it up.
    #[error("{} does not answer any more ({error}): it was unplugged, or its driver has given up; plug it in again", path.display())]
    Gone {
        /// As it was named.
        path: PathBuf,
        /// What the kernel said.
        error: io::Error,
    },
    /// It is no device that gives pictures.
    #[error("{} is no camera: {what}", path.display())]
    NotACamera {
        /// As it was named.
        path: PathBuf,
        /// What it is, and what to name instead.
        what: String,
    },
    /// The camera has nothing that lariat reads, or not what was asked for.
    #[error("{}: {why}", path.display())]
    NoCommonFormat {
        /// As it was named.
        path: PathBuf,
        /// What was asked for and what there is.
        why: NoCommonFormat,
    },
    /// The driver took another format than the one it was asked for, and had listed.
    #[error("{} was asked for {asked} and set {got}: {remedy}", path.display())]
    OtherFormat {
        /// As it was named.
        path: PathBuf,
        /// The format and size that it was asked for.
        asked: String,
        /// What it set.
        got: String,
        /// What to ask for instead.
        remedy: String,
    },
    /// A control that does not exist, or a value that it does not have.
    #[error("{}: {why}", path.display())]
    Control {
        /// As it was named.
        path: PathBuf,
        /// Which, and what there is.
        why: ControlError,
    },
    /// The kernel refused something that a camera should be able to do.
    #[error("{} cannot {doing}: {error}", path.display())]
    Refused {
        /// As it was named.
        path: PathBuf,
        /// What was tried, and the call's name.
        doing: &'static str,
        /// What the kernel said.
        error: io::Error,
    },
}

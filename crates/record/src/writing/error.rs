//! Errors of writing a recording, with messages that say what to do.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::space::NoRoom;

/// Why a recording could not be started, or ended early.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// A recording of this name exists.
    #[error("there is a recording {} already: name another file, or replace it with --force", .0.display())]
    Exists(PathBuf),
    /// A file of this name exists and is not a recording.
    #[error("{} is not a recording, and is not overwritten: name another file", .0.display())]
    NoRecording(PathBuf),
    /// Another program is writing to the file.
    #[error("{} is being written by another program: name another file", .0.display())]
    InUse(PathBuf),
    /// The file could not be created.
    #[error("the recording {} could not be begun ({cause}): is its folder there, and may it be written to?", path.display())]
    Begin {
        /// The file.
        path: PathBuf,
        /// The system's error.
        cause: io::Error,
    },
    /// There is no more room. The file is closed properly.
    #[error("the recording {} ends here, and all before it is in it: {why}", path.display())]
    Full {
        /// The file.
        path: PathBuf,
        /// What is full.
        why: NoRoom,
    },
    /// A write failed. The file can be read up to the last chunk before it.
    #[error(
        "writing to the recording {} failed ({cause}): it can be read up to what was written before, about the last second \
         is lost. Look after the disk",
        path.display()
    )]
    Broken {
        /// The file.
        path: PathBuf,
        /// The system's error.
        cause: io::Error,
    },
    /// The writing thread has panicked and reported the reason.
    #[error(
        "the recording's own thread fell, for the reason it gave above: the file can be read up to its last whole chunk"
    )]
    Fallen,
}

impl WriteError {
    /// Converts an error of the MCAP writer. The MCAP writer writes to memory, so only a commit can
    /// fail.
    pub(super) fn broken(path: &Path, fault: mcap::McapError) -> Self {
        Self::Broken {
            path: path.to_owned(),
            cause: match fault {
                mcap::McapError::Io(cause) => cause,
                other => io::Error::other(other),
            },
        }
    }
}

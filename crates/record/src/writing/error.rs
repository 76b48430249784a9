//! Why a recording cannot be written, each as a sentence that says what to do.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::space::NoRoom;

/// Why a recording could not be begun, or ends before its time.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// There is a recording of that name.
    #[error("there is a recording {} already: name another file, or replace it with --force", .0.display())]
    Exists(PathBuf),
    /// There is something else of that name.
    #[error("{} is not a recording, and is not overwritten: name another file", .0.display())]
    NoRecording(PathBuf),
    /// Another program is writing to it.
    #[error("{} is being written by another program: name another file", .0.display())]
    InUse(PathBuf),
    /// The file could not be made.
    #[error("the recording {} could not be begun ({cause}): is its folder there, and may it be written to?", path.display())]
    Begin {
        /// The file.
        path: PathBuf,
        /// The system's own word.
        cause: io::Error,
    },
    /// There is no room for more. The file is closed well.
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
        /// The system's own word.
        cause: io::Error,
    },
    /// The thread that writes has panicked, and has said why.
    #[error(
        "the recording's own thread fell, for the reason it gave above: the file can be read up to its last whole chunk"
    )]
    Fallen,
}

impl WriteError {
    /// What a fault of the format's writer means: it writes to memory, so the commit is all that can fail.
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

//! Opens the destination of a recording: a new file, a file that replaces an old recording once it
//! has contents, a pipe or a device.

use std::fs::{self, File};
use std::io::{self, Read};
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};

use super::error::WriteError;

/// Policy for an existing recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Replace it once the new one has contents. A file that is not a recording is kept anyway.
    Replace,
    /// Keep it.
    Keep,
}

/// A file opened for a recording.
#[derive(Debug)]
pub(super) struct Opened {
    pub(super) file: File,
    /// True for a pipe or a device, which cannot be written at a position.
    pub(super) is_stream: bool,
    pub(super) old: Option<Old>,
}

/// An old recording, with the new one next to it.
#[derive(Debug)]
pub(super) struct Old {
    path: PathBuf,
    beside: PathBuf,
    /// Prevents other programs from writing to the old one.
    _lock: File,
}

impl Old {
    /// Replaces the old recording by the new one.
    pub(super) fn make_room(&self) -> io::Result<()> {
        fs::rename(&self.beside, &self.path)
    }
}

impl Drop for Old {
    fn drop(&mut self) {
        // Fails harmlessly if the new recording has already been renamed.
        let _ = fs::remove_file(&self.beside);
    }
}

/// Opens the file of a new recording; `-` is standard output.
pub(super) fn open(path: &Path, existing: Existing) -> Result<Opened, WriteError> {
    let begin = |cause| WriteError::Begin {
        path: path.to_owned(),
        cause,
    };
    let stream = |file: io::Result<File>| {
        Ok(Opened {
            file: file.map_err(begin)?,
            is_stream: true,
            old: None,
        })
    };
    if path == Path::new("-") {
        let stdout = io::stdout();
        return stream(stdout.as_fd().try_clone_to_owned().map(File::from));
    }
    let mut options = File::options();
    let options = options.read(true).write(true);
    match options.create_new(true).open(path) {
        Ok(file) => {
            lock(&file, path)?;
            return Ok(Opened {
                file,
                is_stream: false,
                old: None,
            });
        }
        Err(cause) if cause.kind() == io::ErrorKind::AlreadyExists => {}
        Err(cause) => return Err(begin(cause)),
    }
    let found = fs::metadata(path).map_err(begin)?;
    if found.is_dir() {
        return Err(WriteError::NoRecording(path.to_owned()));
    }
    if !found.is_file() {
        return stream(File::options().append(true).open(path));
    }
    let mut old = options.create_new(false).open(path).map_err(begin)?;
    lock(&old, path)?;
    let mut magic = [0; 8];
    let is_recording = old.read_exact(&mut magic).is_ok() && magic == *mcap::MAGIC;
    match existing {
        _ if !is_recording && found.len() > 0 => Err(WriteError::NoRecording(path.to_owned())),
        Existing::Keep => Err(WriteError::Exists(path.to_owned())),
        Existing::Replace => beside(path, old).map_err(begin),
    }
}

/// Creates a file next to the old one.
fn beside(path: &Path, old: File) -> io::Result<Opened> {
    // Resolves links.
    let path = path.canonicalize()?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    // The process id makes the name unique.
    let beside = path.with_file_name(format!(".{name}.{}", std::process::id()));
    let file = File::options()
        .read(true)
        .write(true)
        .create(true)
        .truncate(true)
        .open(&beside)?;
    flock(&file, FlockOperation::NonBlockingLockExclusive)?;
    Ok(Opened {
        file,
        is_stream: false,
        old: Some(Old {
            path,
            beside,
            _lock: old,
        }),
    })
}

fn lock(file: &File, path: &Path) -> Result<(), WriteError> {
    match flock(file, FlockOperation::NonBlockingLockExclusive) {
        Err(rustix::io::Errno::WOULDBLOCK) => Err(WriteError::InUse(path.to_owned())),
        // Some file systems do not support locks.
        _ => Ok(()),
    }
}

//! Decides where a command writes: one rule for every file that any command makes, and for standard
//! output.
//!
//! * `-` is standard output. Links are followed. A device or a pipe is opened and written into.
//! * An existing regular file is refused, or replaced with `--force`; its permissions are kept. A
//!   file that the same command reads (same device and inode) is always refused.
//! * A file is written completely or not at all: it grows under another name in the same folder and
//!   is then renamed.
//! * All this, and whether the folder is writable, is checked before the work begins. For `run`,
//!   the chain's own process checks it before it starts any other.
//! * Messages printed along with a file go to standard error if the file goes to standard output.
//!
//! A **closed pipe** (`| head`) ends the command in order, with exit code 1 because something was
//! not printed. Only a chain reports it. Rust ignores SIGPIPE, so the write fails and nothing is
//! interrupted: cameras get their controls back, and shared memory is cleaned up. Any other failure
//! to write standard output is reported, and the exit code is 1. A full disk that swallows the live
//! line does not stop a chain, because a robot depends on the chain. The chain reports the failure
//! at its end. If nobody reads standard error, messages are discarded (the macros in `lib.rs`).

mod folder;
mod stdout;

pub use folder::OutputFolder;
pub use stdout::{Unread, print};

use crate::exit::wrong_use;
use anyhow::{Context, Result, bail};
use rustix::fs::{Access, access};
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Policy for a file that already exists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Replace it.
    Replace,
    /// Keep it, and refuse to write.
    Keep,
}

impl Existing {
    /// Returns the policy that `--force` selects.
    pub fn forced(force: bool) -> Self {
        if force { Self::Replace } else { Self::Keep }
    }
}

/// The destination of a file.
#[derive(Debug, Clone)]
pub struct Output {
    /// The path as the user wrote it.
    path: PathBuf,
    place: Place,
    existing: Existing,
}

#[derive(Debug, Clone)]
enum Place {
    Stdout,
    /// A device or a pipe.
    Into,
    /// A regular file. Links have been followed.
    File(PathBuf),
}

impl Output {
    /// Checks everything that can be checked before anything is written. `inputs` are the files
    /// that the command reads.
    ///
    /// # Errors
    /// Returns an error if the destination cannot be written or is one of the inputs, or if an
    /// existing file is to be kept.
    pub fn new<'a>(
        path: &Path,
        existing: Existing,
        inputs: impl IntoIterator<Item = &'a Path>,
    ) -> Result<Self> {
        let place = place(path).with_context(|| Self::failure(path))?;
        if let Place::File(file) = &place {
            let own = identity(file);
            if own.is_some() && inputs.into_iter().any(|input| identity(input) == own) {
                bail!(
                    "{} is what is read here, and is not overwritten: name another file",
                    path.display()
                );
            }
            if own.is_some() && existing == Existing::Keep {
                return Err(is_there(path));
            }
            begin_beside(file).with_context(|| Self::failure(path))?;
        }
        Ok(Self {
            path: path.to_owned(),
            place,
            existing,
        })
    }

    /// Requires the ending that matches the content of the file. Anything but a regular file may
    /// have any name.
    ///
    /// # Errors
    /// Returns an error if the name has another ending.
    pub fn require_ending(&self, ending: &str) -> Result<()> {
        let has_it =
            (self.path.extension()).is_some_and(|found| found.eq_ignore_ascii_case(ending));
        if matches!(self.place, Place::File(_)) && !has_it {
            wrong_use!(
                "the file is a {}: give it a name that ends in .{ending}, not {self}",
                ending.to_uppercase()
            );
        }
        Ok(())
    }

    /// Writes the whole file.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written, or if it was created meanwhile.
    pub fn write(&self, bytes: &[u8]) -> Result<()> {
        let mut file = self.begin()?;
        file.write_all(bytes)
            .with_context(|| Self::failure(&self.path))?;
        file.place()
    }

    /// Begins to write.
    ///
    /// # Errors
    /// Returns an error if the destination cannot be written.
    pub fn begin(&self) -> Result<Growing> {
        let begin = || match &self.place {
            Place::Stdout => Ok(Body::Stdout(io::stdout())),
            // An open file behind a descriptor is extended, not truncated.
            Place::Into => File::options()
                .append(true)
                .open(&self.path)
                .map(Body::Into),
            Place::File(file) => begin_beside(file).map(Body::Beside),
        };
        Ok(Growing {
            body: begin().with_context(|| Self::failure(&self.path))?,
            output: self.clone(),
        })
    }

    /// Prints text on standard output, or on standard error if the file itself goes to standard
    /// output.
    ///
    /// # Errors
    /// Returns an error if the text cannot be written.
    pub fn print(&self, text: &str) -> Result<()> {
        if self.is_stdout() {
            eprint!("{text}");
            return Ok(());
        }
        print(text)
    }

    /// Allows replacing the file from now on, because it is this command's own.
    pub fn replace_from_now_on(&mut self) {
        self.existing = Existing::Replace;
    }

    /// Returns true for a regular file, which can be rewritten as a whole.
    pub fn is_file(&self) -> bool {
        matches!(self.place, Place::File(_))
    }

    /// Returns true if the file goes to standard output.
    pub fn is_stdout(&self) -> bool {
        matches!(self.place, Place::Stdout)
    }

    fn failure(path: &Path) -> String {
        format!("cannot write {}", path.display())
    }
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_stdout() {
            return f.write_str("standard output");
        }
        self.path.display().fmt(f)
    }
}

/// Returns the error for an existing file that is kept.
fn is_there(path: &Path) -> anyhow::Error {
    anyhow::anyhow!(
        "there is a file {} already: name another one, or overwrite it with --force",
        path.display()
    )
}

/// Determines what a path refers to.
fn place(path: &Path) -> Result<Place> {
    const STDOUT: [&str; 4] = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];
    if STDOUT.iter().any(|name| path == Path::new(name)) {
        return Ok(Place::Stdout);
    }
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => bail!("it is a folder: name a file"),
        Ok(found) if !found.is_file() || is_descriptor(path) => {
            access(path, Access::WRITE_OK)?;
            Ok(Place::Into)
        }
        _ => Ok(Place::File(followed(path)?)),
    }
}

/// Returns true if the path names a descriptor that is already open.
fn is_descriptor(path: &Path) -> bool {
    ["/dev/fd", "/proc/self/fd", "/dev/stderr", "/dev/stdin"]
        .iter()
        .any(|name| path.starts_with(name))
}

/// Follows links, even to a file that does not exist yet.
fn followed(path: &Path) -> io::Result<PathBuf> {
    // The kernel's own limit.
    const MOST_LINKS: usize = 40;
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(target) = fs::read_link(&path) else {
            return Ok(path);
        };
        path = path.parent().unwrap_or(Path::new("")).join(target);
    }
    Err(rustix::io::Errno::LOOP.into())
}

/// Identifies a file independently of its name.
fn identity(path: &Path) -> Option<(u64, u64)> {
    let found = fs::metadata(path).ok()?;
    Some((found.dev(), found.ino()))
}

/// Creates a temporary file in the folder of the given file. It is deleted when dropped.
fn begin_beside(file: &Path) -> io::Result<NamedTempFile> {
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.exists() {
        let why = format!("there is no folder {}", folder.display());
        return Err(io::Error::new(io::ErrorKind::NotFound, why));
    }
    // Give it the permissions of any new file, because a temporary file is readable only by its
    // owner.
    tempfile::Builder::new()
        .permissions(fs::Permissions::from_mode(0o666))
        .tempfile_in(folder)
        .map_err(|cause| of_the_system(&cause))
}

/// Returns the system's own error, without the temporary name of the file.
pub fn of_the_system(cause: &io::Error) -> io::Error {
    let inner =
        std::error::Error::source(cause).and_then(|inner| inner.downcast_ref::<io::Error>());
    let code = inner.unwrap_or(cause).raw_os_error();
    code.map_or_else(|| cause.kind().into(), io::Error::from_raw_os_error)
}

/// A file that is renamed to its destination when it is complete. If it is dropped earlier, nothing
/// is left behind, except data already written into a device or a pipe.
pub struct Growing {
    body: Body,
    output: Output,
}

enum Body {
    Stdout(io::Stdout),
    Into(File),
    Beside(NamedTempFile),
}

impl Growing {
    /// Puts the file in its place.
    ///
    /// # Errors
    /// Returns an error if the file cannot be synced, or if a file that is to be kept was created
    /// there meanwhile.
    pub fn place(mut self) -> Result<()> {
        let path = &self.output.path;
        let about = || Output::failure(path);
        let file = match self.body {
            Body::Stdout(ref mut stdout) => {
                return stdout::kept(stdout.flush()).with_context(about);
            }
            Body::Into(_) => return Ok(()),
            Body::Beside(file) => file,
        };
        let Place::File(target) = &self.output.place else {
            return Ok(());
        };
        file.as_file().sync_all().with_context(about)?;
        let placed = match self.output.existing {
            Existing::Replace => {
                // Keep the permissions of the old file if possible.
                if let Ok(old) = fs::metadata(target) {
                    let _ = file.as_file().set_permissions(old.permissions());
                }
                file.persist(target)
            }
            Existing::Keep => file.persist_noclobber(target),
        };
        match placed {
            Ok(_) => Ok(()),
            Err(fault) if fault.error.kind() == io::ErrorKind::AlreadyExists => Err(is_there(path)),
            Err(fault) => Err(of_the_system(&fault.error)).with_context(about),
        }
    }
}

impl Write for Growing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.body {
            Body::Stdout(stdout) => stdout::kept(stdout.write(bytes)),
            Body::Into(file) => file.write(bytes),
            // Bypass the temporary file's own `write`, because its errors contain the temporary
            // name.
            Body::Beside(file) => file.as_file_mut().write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.body {
            Body::Stdout(stdout) => stdout::kept(stdout.flush()),
            Body::Into(file) => file.flush(),
            Body::Beside(file) => file.as_file_mut().flush(),
        }
    }
}

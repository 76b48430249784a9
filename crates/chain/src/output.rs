//! Where a command writes: one rule for every file that any command makes, and for standard output.
//!
//! `-` is standard output. A device or a pipe is written into. A link is followed. A file that is there is kept, unless `--force`
//! says otherwise, and one that the same command reads is kept in any case. A file is there whole or not at all: it grows under another
//! name beside its place. What stands against it is said before the work begins.
//!
//! # How it works
//!
//! `src/output.rs` decides for every file of every command. `-` is standard output; what is no regular file is opened and written
//! into; links are followed. A regular file that is there is refused, or replaced with `--force`, its permissions kept; one that the same command reads
//! (by device and inode) is refused always. A file grows beside its place under another name and is put there whole. All this,
//! and whether the folder can be written to, is asked before the work begins: of `run` by the chain's own process, before it starts any other. What is
//! printed beside a file that goes to standard output goes to standard error.
//!
//! A **closed pipe** (`| head`) ends the command in order, with exit code 1, as something was not printed: a chain says so, any other ends without a word. Rust has SIGPIPE ignored,
//! so the write fails, and nothing is cut off in the middle: cameras get their controls back, shared memory is swept. Any other failure to
//! write standard output is said, and the exit code is 1. A chain goes on while a full disk swallows its live line, as it has a
//! robot to serve, and says it at its end. Standard error that nobody reads is nothing (the macros in `main.rs`).

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

/// What to do where there is a file already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// The new one takes its place.
    Replace,
    /// It stays, and the command refuses.
    Keep,
}

impl Existing {
    /// As `--force` says.
    pub fn forced(force: bool) -> Self {
        if force { Self::Replace } else { Self::Keep }
    }
}

/// Where a file goes.
#[derive(Debug, Clone)]
pub struct Output {
    /// As the user named it.
    path: PathBuf,
    place: Place,
    existing: Existing,
}

#[derive(Debug, Clone)]
enum Place {
    Stdout,
    /// A device or a pipe.
    Into,
    /// A regular file, where links lead.
    File(PathBuf),
}

impl Output {
    /// Asks all that can be asked before anything is written. `inputs`: the files that the command reads.
    ///
    /// # Errors
    /// It cannot be written to, there is a file that is to be kept, or it is one of the inputs.
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

    /// A file's name says what is in it; what is no file may have any.
    ///
    /// # Errors
    /// It does not end so.
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

    /// Writes all of it.
    ///
    /// # Errors
    /// It cannot be written, or there is a file by now.
    pub fn write(&self, bytes: &[u8]) -> Result<()> {
        let mut file = self.begin()?;
        file.write_all(bytes)
            .with_context(|| Self::failure(&self.path))?;
        file.place()
    }

    /// Begins to write.
    ///
    /// # Errors
    /// It cannot be written to.
    pub fn begin(&self) -> Result<Growing> {
        let begin = || match &self.place {
            Place::Stdout => Ok(Body::Stdout(io::stdout())),
            // What a descriptor leads to is written on where it stands.
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

    /// Says something beside the file: on standard output, unless the file itself goes there.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn print(&self, text: &str) -> Result<()> {
        if self.is_stdout() {
            eprint!("{text}");
            return Ok(());
        }
        print(text)
    }

    /// What is there from now on is this command's own, and a newer one takes its place.
    pub fn replace_from_now_on(&mut self) {
        self.existing = Existing::Replace;
    }

    /// Whether it is a regular file, which can be written whole again and again.
    pub fn is_file(&self) -> bool {
        matches!(self.place, Place::File(_))
    }

    /// Whether it goes to standard output.
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

/// The sentence about a file that is kept.
fn is_there(path: &Path) -> anyhow::Error {
    anyhow::anyhow!(
        "there is a file {} already: name another one, or overwrite it with --force",
        path.display()
    )
}

/// What a name means.
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

/// Whether it is a name of something that is open already.
fn is_descriptor(path: &Path) -> bool {
    ["/dev/fd", "/proc/self/fd", "/dev/stderr", "/dev/stdin"]
        .iter()
        .any(|name| path.starts_with(name))
}

/// Where links lead, also to what is not there yet.
fn followed(path: &Path) -> io::Result<PathBuf> {
    // As many as the kernel follows.
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

/// What tells a file from all others, whatever its name.
fn identity(path: &Path) -> Option<(u64, u64)> {
    let found = fs::metadata(path).ok()?;
    Some((found.dev(), found.ino()))
}

/// A file beside the one that is meant, which is gone if it is dropped.
fn begin_beside(file: &Path) -> io::Result<NamedTempFile> {
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.exists() {
        let why = format!("there is no folder {}", folder.display());
        return Err(io::Error::new(io::ErrorKind::NotFound, why));
    }
    // As readable as any file the user makes, where a temporary file is the user's alone.
    tempfile::Builder::new()
        .permissions(fs::Permissions::from_mode(0o666))
        .tempfile_in(folder)
        .map_err(|cause| of_the_system(&cause))
}

/// The system's own word, without the name that the file has meanwhile.
pub fn of_the_system(cause: &io::Error) -> io::Error {
    let inner =
        std::error::Error::source(cause).and_then(|inner| inner.downcast_ref::<io::Error>());
    let code = inner.unwrap_or(cause).raw_os_error();
    code.map_or_else(|| cause.kind().into(), io::Error::from_raw_os_error)
}

/// A file that grows, and is put in its place when it is whole. Dropped before, there is nothing of it, but for what has gone into
/// a device or a pipe.
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
    /// It is not on the disk, or there is a file by now, and it is to be kept.
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
                // As the old one was; where that may not be, as any new one.
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
            // Not through the temporary file, whose errors have its name.
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

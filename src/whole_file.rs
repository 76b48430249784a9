//! Files that are written whole or not at all: under another name first, then put in place.

use anyhow::{Context, Result};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// What to do where there is a file already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Existing {
    Replace,
    Keep,
}

/// Writes `bytes` to `path`. Whoever reads it sees the old file or the whole new one.
///
/// # Errors
/// The folder cannot be written to, or there is a file already and it is to be kept.
pub(crate) fn write(path: &Path, bytes: &[u8], existing: Existing) -> Result<()> {
    let mut file = Growing::new(path)?;
    file.write_all(bytes)
        .with_context(|| format!("cannot write {}", path.display()))?;
    file.place(existing)
}

/// A file that grows under another name, and is put in place when it is whole. Dropped before, it is gone.
pub(crate) struct Growing {
    file: NamedTempFile,
    path: PathBuf,
}

impl Growing {
    /// # Errors
    /// The folder cannot be written to.
    pub(crate) fn new(path: &Path) -> Result<Self> {
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        // As readable as any file the user makes, where a temporary file is the user's alone.
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder
            .tempfile_in(folder)
            .with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self {
            file,
            path: path.to_owned(),
        })
    }

    /// Puts the file in place.
    ///
    /// # Errors
    /// It is not on the disk, or there is a file already and it is to be kept.
    pub(crate) fn place(self, existing: Existing) -> Result<()> {
        let Self { file, path } = self;
        let about = || format!("cannot write {}", path.display());
        file.as_file().sync_all().with_context(about)?;
        let placed = match existing {
            Existing::Replace => file.persist(&path),
            Existing::Keep => file.persist_noclobber(&path),
        };
        placed.map_err(|e| e.error).with_context(about)?;
        Ok(())
    }
}

impl Write for Growing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

//! Files that are written whole or not at all: under another name first, then put in place.

use anyhow::{Context, Result};
use std::io::Write;
use std::path::Path;

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
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let about = || format!("cannot write {}", path.display());
    // As readable as any file the user makes, where a temporary file is the user's alone.
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder).with_context(about)?;
    file.write_all(bytes).with_context(about)?;
    file.as_file().sync_all().with_context(about)?;
    let placed = match existing {
        Existing::Replace => file.persist(path),
        Existing::Keep => file.persist_noclobber(path),
    };
    placed.map_err(|e| e.error).with_context(about)?;
    Ok(())
}

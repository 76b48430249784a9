//! Files that are written whole or not at all: under another name first, then put in place.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};

/// Writes `bytes` to `path`, whose folder is made if there is none.
///
/// # Errors
/// The folder cannot be made or written to.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let about = || format!("cannot write {}", path.display());
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).with_context(about)?;
    // As readable as any file the user makes, where a temporary file is the user's alone.
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder).with_context(about)?;
    file.write_all(bytes).with_context(about)?;
    file.persist(path)
        .map_err(|e| e.error)
        .with_context(about)?;
    Ok(())
}

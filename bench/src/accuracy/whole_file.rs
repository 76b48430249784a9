//! Atomic file writes: to a temporary name first, then renamed.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};

/// Writes `bytes` to `path`. Creates its folder if necessary.
///
/// # Errors
/// The folder cannot be created or written to.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let about = || format!("cannot write {}", path.display());
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).with_context(about)?;
    // The same permissions as any file of the user. A temporary file is private by default.
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

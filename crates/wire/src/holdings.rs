//! The files and folders of this process's domain. Their owners decide who can take part.

use std::fs;
use std::path::{Path, PathBuf};

use crate::WireError;
use crate::domain::{config_here, root_of};
use crate::memory::SHM;

/// The folders and files of the domain that `LARIAT_DOMAIN` names, or of the user's own domain: its
/// folder with all contents, and its shared memory. This call does not join the domain.
///
/// # Errors
/// `LARIAT_DOMAIN` is not a valid name.
pub fn holdings() -> Result<Vec<PathBuf>, WireError> {
    let config = config_here()?;
    let root = root_of(&config);
    let mut found = Vec::new();
    if root.exists() {
        found.push(root.clone());
        below(&root, &mut found);
    }
    let prefix = config.global.prefix.to_string();
    let shared = fs::read_dir(SHM).into_iter().flatten().flatten();
    let of_domain = shared.filter(|file| file.file_name().to_string_lossy().starts_with(&prefix));
    found.extend(of_domain.map(|file| file.path()));
    Ok(found)
}

fn below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        found.push(entry.path());
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            below(&entry.path(), found);
        }
    }
}

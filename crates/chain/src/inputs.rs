//! Expands the paths that the user named to pictures.

use anyhow::{Context, Result, bail};
use lariat_capture::{
    PICTURES, foreign_example, names_a_picture, names_a_recording, natural_order,
};
use std::cmp::Ordering;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

/// Returns the pictures in the user's order, and an error for each path that is not usable. The
/// pictures of a folder are in natural order.
pub fn pictures(paths: &[PathBuf]) -> (Vec<PathBuf>, Vec<anyhow::Error>) {
    let (mut found, mut wrong) = (Vec::new(), Vec::new());
    for path in paths {
        if !path.is_dir() || names_a_recording(path) {
            // Opening the file will show whether it exists and is a picture.
            found.push(path.clone());
            continue;
        }
        match in_folder(path) {
            Ok(pictures) => found.extend(pictures),
            Err(error) => wrong.push(error),
        }
    }
    (found, wrong)
}

fn in_folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let about = || format!("cannot list the folder {}", folder.display());
    let (mut pictures, mut folders, mut others) = (Vec::new(), Vec::new(), Vec::new());
    for entry in std::fs::read_dir(folder).with_context(about)? {
        let path = entry.with_context(about)?.path();
        if path.is_dir() {
            folders.push(path);
        } else if names_a_picture(&path) && path.is_file() {
            pictures.push(path);
        } else {
            others.push(path);
        }
    }
    let foreign = foreign_example(&others);
    if let (true, Some(foreign)) = (pictures.is_empty(), &foreign) {
        bail!(
            "there is no picture ({PICTURES}) in the folder {}: {foreign}",
            folder.display()
        );
    }
    if pictures.is_empty() && folders.is_empty() {
        bail!(
            "there is no picture ({PICTURES}) in the folder {}: name the pictures, or another folder",
            folder.display()
        );
    }
    if pictures.is_empty() {
        folders.sort_by(|a, b| by_name(a, b));
        bail!(
            "there is no picture ({PICTURES}) in the folder {} itself: name one of its folders, such as {}",
            folder.display(),
            folders[0].display()
        );
    }
    if let Some(foreign) = foreign {
        tracing::warn!(
            "left out files of {} that are not {PICTURES} by their names: {foreign}",
            folder.display()
        );
    }
    pictures.sort_by(|a, b| by_name(a, b));
    Ok(pictures)
}

fn by_name(a: &Path, b: &Path) -> Ordering {
    natural_order(a.as_os_str().as_bytes(), b.as_os_str().as_bytes())
}

//! Masks from elsewhere, as pictures in a folder: each of the name of the picture it belongs to.

use anyhow::{Result, bail};
use lariat_chain::picture::Picture;
use std::path::{Path, PathBuf};

/// A folder of masks.
pub(super) struct Masks(PathBuf);

impl Masks {
    /// # Errors
    /// There is no such folder.
    pub(super) fn new(folder: &Path) -> Result<Self> {
        if !folder.is_dir() {
            bail!(
                "there is no folder {}: --masks takes a folder of PNG pictures, white for rope",
                folder.display()
            );
        }
        Ok(Self(folder.to_owned()))
    }

    /// Where the mask of the picture at `path` would be.
    pub(super) fn name(&self, path: &Path) -> PathBuf {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        self.0.join(format!("{stem}.png"))
    }

    /// The mask of the picture at `path`, and where it is.
    ///
    /// # Errors
    /// It is not there, or is no picture.
    pub(super) fn of(&self, path: &Path) -> Result<(PathBuf, Picture)> {
        let name = self.name(path);
        if !name.exists() {
            bail!(
                "there is no mask of {}: it would be {}",
                path.display(),
                name.display()
            );
        }
        let mask = Picture::load(&name)?.into_gray();
        Ok((name, mask))
    }
}

//! A folder for several output files: a report, or overlays.

use super::{Existing, Output, begin_beside};
use anyhow::{Context, Result, bail};
use std::fs;
use std::path::{Path, PathBuf};

/// An output folder. A folder that was created and stays empty is removed again.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    existing: Existing,
    is_new: bool,
}

impl OutputFolder {
    /// Creates the folder, and checks everything that can be checked before anything is written.
    /// `names` are some of the files that will be written.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be created or written to. Also fails if it contains
    /// one of the files and files are to be kept.
    pub fn new<'a>(
        path: &Path,
        existing: Existing,
        names: impl IntoIterator<Item = &'a str>,
    ) -> Result<Self> {
        let shown = path.display();
        let about = || format!("cannot write to the folder {shown}");
        if path.exists() && !path.is_dir() {
            bail!("cannot write to the folder {shown}: it is a file");
        }
        let old = names.into_iter().find(|name| path.join(name).exists());
        if let Some(name) = old.filter(|_| existing == Existing::Keep) {
            bail!(
                "there is a {name} in the folder {shown} already: name another folder, or overwrite what is there with --force"
            );
        }
        let is_new = !path.exists();
        fs::create_dir_all(path).with_context(about)?;
        let folder = Self {
            path: path.to_owned(),
            existing,
            is_new,
        };
        begin_beside(&path.join("-")).with_context(about)?;
        Ok(folder)
    }

    /// Writes one of the files.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written, or if it already exists.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        Output::new(&self.path.join(name), self.existing, [])?.write(bytes)
    }

    /// Allows replacing files from now on, because they are this command's own.
    pub fn replace_from_now_on(&mut self) {
        self.existing = Existing::Replace;
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if self.is_new {
            // This fails unless the folder is empty.
            let _ = fs::remove_dir(&self.path);
        }
    }
}

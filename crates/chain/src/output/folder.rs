//! A folder that several files go to: a report, or overlays.

use super::{Existing, Output, begin_beside};
use anyhow::{Context, Result, bail};
use std::fs;
use std::path::{Path, PathBuf};

/// The folder. One that was made in vain is taken away again.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    existing: Existing,
    is_new: bool,
}

impl OutputFolder {
    /// Makes the folder, and asks all that can be asked before anything is written. `names`: some of the files that are to be
    /// written.
    ///
    /// # Errors
    /// It cannot be made or written to, or there is one of the files already, and it is to be kept.
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
    /// It cannot be written, or there is one already.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        Output::new(&self.path.join(name), self.existing, [])?.write(bytes)
    }

    /// What is there from now on is this command's own, and newer ones take its place.
    pub fn replace_from_now_on(&mut self) {
        self.existing = Existing::Replace;
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if self.is_new {
            // Only an empty one can be taken away.
            let _ = fs::remove_dir(&self.path);
        }
    }
}

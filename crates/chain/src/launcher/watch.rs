//! Watches a settings file: the kernel reports that it was written or replaced.

use std::ffi::OsString;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;

use anyhow::{Context, Result};
use rustix::fs::inotify::{self, CreateFlags, Reader, WatchFlags};

/// A watch on the file's folder, because editors replace the file.
pub(super) struct Watch {
    inotify: OwnedFd,
    name: OsString,
}

impl Watch {
    /// Starts to watch a settings file.
    ///
    /// # Errors
    /// Returns an error if there is no file, or if the kernel cannot watch it.
    pub(super) fn of(file: Option<&Path>) -> Result<Self> {
        let file = file.context("there is none (lariat.toml here, or --config FILE)")?;
        let name = file.file_name().context("it has no name")?;
        let folder = match file.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let inotify = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC)?;
        inotify::add_watch(
            &inotify,
            folder,
            WatchFlags::CLOSE_WRITE | WatchFlags::MOVED_TO,
        )?;
        Ok(Self {
            inotify,
            name: name.to_owned(),
        })
    }

    /// Returns true if the file has changed since the last call.
    pub(super) fn has_changed(&mut self) -> bool {
        let mut buffer = [MaybeUninit::uninit(); 4096];
        let mut events = Reader::new(&self.inotify, &mut buffer);
        let mut changed = false;
        while let Ok(event) = events.next() {
            let name = event.file_name().map(|name| name.to_bytes());
            changed |= name == Some(self.name.as_encoded_bytes());
        }
        changed
    }
}

impl AsFd for Watch {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.inotify.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_file_that_is_written_or_replaced_has_changed_and_another_beside_it_has_not() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("lariat.toml");
        fs::write(&file, "").unwrap();
        let mut watch = Watch::of(Some(&file)).unwrap();
        assert!(!watch.has_changed());
        fs::write(folder.path().join("notes"), "").unwrap();
        assert!(!watch.has_changed());
        fs::write(&file, "[fit]").unwrap();
        assert!(watch.has_changed());
        assert!(!watch.has_changed());
        let other = folder.path().join("lariat.toml~");
        fs::write(&other, "").unwrap();
        fs::rename(&other, &file).unwrap();
        assert!(watch.has_changed());
        assert!(Watch::of(None).is_err());
    }
}

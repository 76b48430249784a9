//! Watches a folder through inotify. The kernel reports each event, so that an idle folder takes no
//! CPU time.

use std::ffi::{OsStr, OsString};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use rustix::fs::inotify::{self, CreateFlags, ReadFlags, Reader, WatchFlags};
use rustix::io::Result;

/// An event in the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Event {
    /// A file with this name is complete: its writer has closed it, or it was moved here.
    Came(OsString),
    /// The file was moved away, and may return under another name.
    Left(OsString),
    /// The folder itself was removed or moved away.
    Gone,
    /// A folder with its name exists again.
    Back,
    /// More events occurred than the kernel keeps.
    Missed,
}

const IN_FOLDER: WatchFlags = WatchFlags::CLOSE_WRITE
    .union(WatchFlags::MOVED_TO)
    .union(WatchFlags::MOVED_FROM)
    .union(WatchFlags::DELETE_SELF)
    .union(WatchFlags::MOVE_SELF)
    .union(WatchFlags::ONLYDIR);
/// Flags for the parent folder, where the folder may come back.
const AROUND: WatchFlags = WatchFlags::CREATE
    .union(WatchFlags::MOVED_TO)
    .union(WatchFlags::ONLYDIR);

/// A folder that is watched.
#[derive(Debug)]
pub(super) struct Folder {
    inotify: OwnedFd,
    path: PathBuf,
    /// The kernel's number for the folder; `None` while it is gone.
    watch: Option<i32>,
    around: Option<i32>,
}

impl Folder {
    /// Starts watching. `path` is absolute.
    pub(super) fn watch(path: &Path) -> Result<Self> {
        let inotify = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC)?;
        // Without a watch on the parent, a folder that was removed stays gone.
        let around = path
            .parent()
            .and_then(|parent| inotify::add_watch(&inotify, parent, AROUND).ok());
        let watch = Some(inotify::add_watch(&inotify, path, IN_FOLDER)?);
        Ok(Self {
            inotify,
            path: path.to_owned(),
            watch,
            around,
        })
    }

    /// Reports the events since the last call, in order.
    pub(super) fn drain(&mut self, mut happened: impl FnMut(Event)) {
        let mut buffer = [MaybeUninit::uninit(); 4096];
        let inotify = &self.inotify;
        let mut events = Reader::new(inotify, &mut buffer);
        while let Ok(event) = events.next() {
            let (what, of) = (event.events(), Some(event.wd()));
            let name = event.file_name();
            let name = name.map(|name| OsStr::from_bytes(name.to_bytes()).to_owned());
            if what.contains(ReadFlags::QUEUE_OVERFLOW) {
                happened(Event::Missed);
            } else if of == self.watch {
                if what.intersects(ReadFlags::DELETE_SELF | ReadFlags::MOVE_SELF) {
                    // A folder that was moved is still watched at its new place.
                    if let Some(watch) = self.watch.take() {
                        let _ = inotify::remove_watch(inotify, watch);
                    }
                    happened(Event::Gone);
                } else if what.contains(ReadFlags::MOVED_FROM) {
                    name.map(Event::Left).into_iter().for_each(&mut happened);
                } else if what.intersects(ReadFlags::CLOSE_WRITE | ReadFlags::MOVED_TO) {
                    name.map(Event::Came).into_iter().for_each(&mut happened);
                }
            } else if of == self.around && self.watch.is_none() {
                let is_it = name.as_deref() == self.path.file_name();
                let watch = || inotify::add_watch(inotify, &self.path, IN_FOLDER).ok();
                self.watch = is_it.then(watch).flatten();
                if self.watch.is_some() {
                    happened(Event::Back);
                }
            }
        }
    }
}

impl AsFd for Folder {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.inotify.as_fd()
    }
}

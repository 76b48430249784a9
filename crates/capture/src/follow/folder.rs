//! What happens in a folder, told by the kernel (inotify): nothing is looked for, and nothing costs anything while nothing
//! happens.

use std::ffi::{OsStr, OsString};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

use rustix::fs::inotify::{self, CreateFlags, ReadFlags, Reader, WatchFlags};
use rustix::io::Result;

/// Something happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Event {
    /// A file of this name is whole: whoever wrote it has closed it, or it was moved here.
    Came(OsString),
    /// The file was moved away, and may come under another name.
    Left(OsString),
    /// The folder itself was removed or moved away.
    Gone,
    /// There is a folder of its name again.
    Back,
    /// More happened than the kernel keeps.
    Missed,
}

const IN_FOLDER: WatchFlags = WatchFlags::CLOSE_WRITE
    .union(WatchFlags::MOVED_TO)
    .union(WatchFlags::MOVED_FROM)
    .union(WatchFlags::DELETE_SELF)
    .union(WatchFlags::MOVE_SELF)
    .union(WatchFlags::ONLYDIR);
/// In the folder that holds it, where it may come back.
const AROUND: WatchFlags = WatchFlags::CREATE
    .union(WatchFlags::MOVED_TO)
    .union(WatchFlags::ONLYDIR);

/// A folder that is watched.
#[derive(Debug)]
pub(super) struct Folder {
    inotify: OwnedFd,
    path: PathBuf,
    /// The kernel's number for the folder; none while it is gone.
    watch: Option<i32>,
    around: Option<i32>,
}

impl Folder {
    /// Watches from now on. `path`: an absolute one.
    pub(super) fn watch(path: &Path) -> Result<Self> {
        let inotify = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC)?;
        // Without it a folder that is gone is gone for good.
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

    /// What has happened since it was asked last, in order.
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
                    // One that was moved is still watched, wherever it is.
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

//! Waits for a device to come back under its name, by inotify on the folders of its path.

use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};

use rustix::fs::inotify::{self, CreateFlags, Reader, WatchFlags};
use rustix::io::Result;

/// Wakes when something happens in a folder on the path of a device.
#[derive(Debug)]
pub(super) struct Hotplug {
    inotify: OwnedFd,
    /// The folders of the path, the nearest first. Those of `/dev/v4l/by-id` appear with the first
    /// camera and disappear with the last.
    folders: Vec<PathBuf>,
}

/// Events that announce a device: its node is created or moved in, and then made accessible to
/// users other than root (`ATTRIB`).
const EVENTS: WatchFlags = WatchFlags::CREATE
    .union(WatchFlags::MOVED_TO)
    .union(WatchFlags::ATTRIB);

impl Hotplug {
    /// Starts watching. `device` is an absolute path.
    pub(super) fn watch(device: &Path) -> Result<Self> {
        let inotify = inotify::init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC)?;
        // `/dev/v4l/by-id` and its parents.
        let folders = device.ancestors().skip(1).take(3);
        let hotplug = Self {
            inotify,
            folders: folders.map(Path::to_owned).collect(),
        };
        hotplug.watch_folders();
        Ok(hotplug)
    }

    /// Discards past events, so that only new ones wake the caller.
    pub(super) fn drain(&self) {
        let mut buffer = [MaybeUninit::uninit(); 1024];
        let mut events = Reader::new(&self.inotify, &mut buffer);
        while events.next().is_ok() {}
        // Also watches a folder that has just been created.
        self.watch_folders();
    }

    fn watch_folders(&self) {
        for folder in &self.folders {
            // Only existing folders are watched. Watching one twice is harmless.
            let _ = inotify::add_watch(&self.inotify, folder, EVENTS);
        }
    }
}

impl AsFd for Hotplug {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.inotify.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use lariat_message::now_ns;
    use rustix::event::PollFlags;

    use super::*;
    use crate::until::{Until, Woken};

    fn wait(hotplug: &Hotplug, ms: u64) -> Woken {
        let event = Some((hotplug.as_fd(), PollFlags::IN));
        Until::forever().wait(event, Some(now_ns() + ms * 1_000_000))
    }

    #[test]
    fn a_name_that_comes_back_with_all_its_folders_wakes() {
        let root = tempfile::tempdir().expect("the system has a folder for temporary files");
        let folder = root.path().join("v4l/by-id");
        let device = folder.join("usb-camera");
        let hotplug = Hotplug::watch(&device).expect("inotify");
        assert_eq!(wait(&hotplug, 1), Woken::Moment, "nothing has happened");
        for made in [root.path().join("v4l"), folder] {
            fs::create_dir(&made).expect("made");
            assert_eq!(wait(&hotplug, 60_000), Woken::Ready(PollFlags::IN));
            hotplug.drain();
        }
        assert_eq!(wait(&hotplug, 1), Woken::Moment, "it was drained");
        std::os::unix::fs::symlink("../../video0", &device).expect("made");
        assert_eq!(wait(&hotplug, 60_000), Woken::Ready(PollFlags::IN));
    }

    #[test]
    fn a_device_that_is_opened_to_others_wakes() {
        let root = tempfile::tempdir().expect("the system has a folder for temporary files");
        let folder = root.path().join("dev/v4l");
        fs::create_dir_all(&folder).expect("made");
        let device = folder.join("video0");
        fs::write(&device, "").expect("made");
        let hotplug = Hotplug::watch(&device).expect("inotify");
        let mut permissions = fs::metadata(&device).expect("there").permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&device, permissions).expect("set");
        assert_eq!(wait(&hotplug, 60_000), Woken::Ready(PollFlags::IN));
    }
}

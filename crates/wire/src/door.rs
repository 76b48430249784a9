#![allow(unsafe_code)] // Objects removed under the lock are dropped by hand.
//! Locks for joining and leaving a domain. There are two, and the kernel releases both however a
//! process ends.
//!
//! Every process of a domain shares the lock on its folder `living`. A process that obtains this
//! lock exclusively knows that all other processes of the domain have ended. It then removes
//! everything in the domain, whatever its state. The lock on the domain's own folder is held by the
//! one process that creates or removes anything: node, services, ports. If this process finds
//! anything half created or half removed, a dead process left it, and this process finishes the
//! work (`tidy`). Sending and receiving need no lock: a port is entered in its service's list only
//! once everything that it needs exists.
//!
//! A process that is stopped while it holds the lock makes the others wait for [`PATIENCE`]. They
//! then report which process it is.

use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io;
use std::mem::ManuallyDrop;
use std::ops::Deref;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use iceoryx2::prelude::*;
use rustix::fs::OFlags;

use crate::WireError;
use crate::domain::root_of;
use crate::tidy;

/// Maximum wait for a process that joins or leaves, which takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(2);
pub(crate) const LIVING: &str = "living";

/// A process's membership in a domain. The last one to leave removes everything that is left.
#[derive(Debug)]
pub(crate) struct Door {
    config: Config,
    /// All processes of the domain share its lock.
    living: File,
    /// True if the lock could not be obtained for a removal.
    given_up: AtomicBool,
}

impl Door {
    /// Enters a domain, creates its folder if needed, and cleans up.
    pub(crate) fn enter(config: &Config) -> Result<(Arc<Self>, Passing), WireError> {
        let root = root_of(config);
        let passing = Passing::into(&root)?;
        let living = living(&root).map_err(|cause| unusable(&root, &cause))?;
        if living.try_lock().is_ok() && !tidy::has_living_nodes(config) {
            tidy::remove_all(config, &passing);
        } else {
            tidy::finish(config, &passing);
        }
        living
            .lock_shared()
            .map_err(|cause| unusable(&root, &cause))?;
        let door = Self {
            config: config.clone(),
            living,
            given_up: AtomicBool::new(false),
        };
        Ok((Arc::new(door), passing))
    }

    /// Waits until no other process joins or leaves, and keeps others from doing so.
    pub(crate) fn pass(&self) -> Result<Passing, WireError> {
        Passing::into(&root_of(&self.config))
    }

    /// Creates an object under the lock that must also be removed under the lock.
    pub(crate) fn hold<T, E>(
        self: &Arc<Self>,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Result<Held<T>, E>, WireError> {
        let _passing = self.pass()?;
        Ok(make().map(|made| self.keep(made)))
    }

    /// Wraps an object that was created under the lock.
    pub(crate) fn keep<T>(self: &Arc<Self>, made: T) -> Held<T> {
        Held {
            made: ManuallyDrop::new(made),
            door: self.clone(),
        }
    }

    /// Obtains the lock for removals. `None` means that nothing can be removed. Other processes
    /// then clean up, as if this one had been killed.
    pub(crate) fn leave(&self) -> Option<Passing> {
        if self.given_up.load(Ordering::Relaxed) {
            return None;
        }
        let passing = self.pass();
        self.given_up.store(passing.is_err(), Ordering::Relaxed);
        passing.ok()
    }
}

impl Drop for Door {
    fn drop(&mut self) {
        let Some(passing) = self.leave() else {
            return;
        };
        if self.living.try_lock().is_ok() && !tidy::has_living_nodes(&self.config) {
            tidy::remove_all(&self.config, &passing);
        }
    }
}

/// An object of the transport that is removed under the lock.
pub(crate) struct Held<T> {
    made: ManuallyDrop<T>,
    door: Arc<Door>,
}

impl<T> Deref for Held<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.made
    }
}

impl<T: fmt::Debug> fmt::Debug for Held<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.made.fmt(f)
    }
}

impl<T> Drop for Held<T> {
    fn drop(&mut self) {
        if let Some(_passing) = self.door.leave() {
            // SAFETY: `made` is dropped only here, and not used again.
            unsafe { ManuallyDrop::drop(&mut self.made) };
        }
    }
}

/// The right to create and remove, held by one process at a time. A thread that holds the right
/// must not request it again.
#[derive(Debug)]
pub(crate) struct Passing {
    _lock: File,
}

impl Passing {
    /// Waits for the right in the domain with this folder, which is created if needed.
    pub(crate) fn into(root: &Path) -> Result<Self, WireError> {
        let until = Instant::now() + PATIENCE;
        loop {
            let folder = open_folder(root).map_err(|cause| unusable(root, &cause))?;
            let inode = folder.metadata().map(|data| data.ino()).ok();
            let locked = lock(folder, until).map_err(|cause| unusable(root, &cause))?;
            let Some(folder) = locked else {
                return Err(WireError::Held {
                    folder: root.display().to_string(),
                    holder: holder(inode.unwrap_or(0)),
                });
            };
            // During the wait, another process may have removed the folder and created it again.
            if fs::symlink_metadata(root).map(|data| data.ino()).ok() == inode {
                return Ok(Self { _lock: folder });
            }
        }
    }

    /// Obtains the right only if it is free now.
    pub(crate) fn at_once(root: &Path) -> Option<Self> {
        let folder = File::open(root).ok()?;
        folder.try_lock().ok()?;
        Some(Self { _lock: folder })
    }

    /// Returns whether no process that uses lariat's locks is in the domain.
    pub(crate) fn is_alone(&self, root: &Path) -> bool {
        match File::open(root.join(LIVING)) {
            Ok(living) => living.try_lock().is_ok(),
            Err(cause) => cause.kind() == io::ErrorKind::NotFound,
        }
    }
}

fn open_folder(path: &Path) -> io::Result<File> {
    let made = fs::DirBuilder::new().mode(0o700).create(path);
    match made {
        Err(cause) if cause.kind() != io::ErrorKind::AlreadyExists => Err(cause),
        // Do not follow a link that was put there in the meantime.
        _ => fs::OpenOptions::new()
            .read(true)
            .custom_flags((OFlags::NOFOLLOW | OFlags::DIRECTORY).bits() as i32)
            .open(path),
    }
}

fn living(root: &Path) -> io::Result<File> {
    open_folder(&root.join(LIVING))
}

/// Obtains a lock; `None` if it is not free by `until`. A separate thread waits for it, because the
/// kernel offers no timeout.
fn lock(file: File, until: Instant) -> io::Result<Option<File>> {
    match file.try_lock() {
        Ok(()) => return Ok(Some(file)),
        Err(TryLockError::WouldBlock) => {}
        Err(TryLockError::Error(cause)) => return Err(cause),
    }
    let (send, receive) = mpsc::channel();
    thread::Builder::new().spawn(move || {
        let locked = file.lock().map(|()| file);
        // After the timeout nobody receives this, and the lock is released with the file.
        let _ = send.send(locked);
    })?;
    match receive.recv_timeout(until.saturating_duration_since(Instant::now())) {
        Ok(locked) => locked.map(Some),
        Err(_) => Ok(None),
    }
}

/// Number of attempts to read the kernel's list. It is read in pieces, and a change in between may
/// hide a line.
const LOOKS: usize = 3;

/// The process that holds the lock on a file, from the kernel's list.
fn holder(inode: u64) -> String {
    let read = || fs::read_to_string("/proc/locks").unwrap_or_default();
    let Some(pid) = (0..LOOKS).find_map(|_| holder_in(&read(), inode)) else {
        return "a process that cannot be seen from here".into();
    };
    let name = fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
    format!("process {pid} ({})", name.trim())
}

/// Parses lines such as `1: FLOCK ADVISORY WRITE 4711 08:02:131077 0 EOF`. A waiting process has an
/// arrow after the number.
fn holder_in(locks: &str, inode: u64) -> Option<u32> {
    let mut lines = locks
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>());
    let line = lines.find(|words| {
        let of_file = words.get(5).and_then(|file| file.rsplit(':').next());
        words.get(1) == Some(&"FLOCK") && of_file.and_then(|text| text.parse().ok()) == Some(inode)
    })?;
    line[4].parse().ok()
}

fn unusable(root: &Path, cause: &io::Error) -> WireError {
    WireError::Folder {
        folder: root.display().to_string(),
        cause: cause.to_string(),
    }
}

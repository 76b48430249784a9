#![allow(unsafe_code)] // What leaves under the lock is dropped by hand.
//! Who is in a domain, and who joins or leaves it just now: two locks, which the kernel takes back however a process ends.
//!
//! Every process of a domain shares the lock on its folder `living`. Who can have that lock alone knows that nobody lives
//! there, and removes everything of the domain, whatever state it was left in. The lock on the domain's own folder is held by the
//! one process that makes or removes anything: node, services, ports. What it finds half made or half removed was
//! therefore left by a dead one, and is finished by it (`tidy`). Sending and receiving take no lock: a port is entered in its
//! service's list when all that it needs has been made.
//!
//! A process that is stopped while it holds the lock keeps the others waiting: for [`PATIENCE`], then they say who it is.

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

/// How long a process that joins or leaves is waited for. It takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(2);
pub(crate) const LIVING: &str = "living";

/// A process's place in a domain; with the last one to leave goes all that is left.
#[derive(Debug)]
pub(crate) struct Door {
    config: Config,
    /// Its lock is shared by all that live here.
    living: File,
    /// The lock could not be had when something was to be removed.
    given_up: AtomicBool,
}

impl Door {
    /// Enters a domain, whose folder is made if there is none, and brings it into order.
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

    /// Waits until no other process joins or leaves, and keeps them from it.
    pub(crate) fn pass(&self) -> Result<Passing, WireError> {
        Passing::into(&root_of(&self.config))
    }

    /// Makes what is to be removed under the lock, too.
    pub(crate) fn hold<T, E>(
        self: &Arc<Self>,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Result<Held<T>, E>, WireError> {
        let _passing = self.pass()?;
        Ok(make().map(|made| self.keep(made)))
    }

    /// Keeps what was made while passing.
    pub(crate) fn keep<T>(self: &Arc<Self>, made: T) -> Held<T> {
        Held {
            made: ManuallyDrop::new(made),
            door: self.clone(),
        }
    }

    /// To leave; `None`: nothing can be removed, which is left to others, as if this process had been killed.
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

/// Something of the transport's that is removed under the lock.
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
            // SAFETY: it is dropped here alone, and not used again.
            unsafe { ManuallyDrop::drop(&mut self.made) };
        }
    }
}

/// The right to make and to remove, which one process at a time has. A thread that has it must not ask for it again.
#[derive(Debug)]
pub(crate) struct Passing {
    _lock: File,
}

impl Passing {
    /// Of the domain with this folder, which is made if there is none.
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
            // It may have been removed, and made again by another, while it was waited for.
            if fs::symlink_metadata(root).map(|data| data.ino()).ok() == inode {
                return Ok(Self { _lock: folder });
            }
        }
    }

    /// If it can be had at once.
    pub(crate) fn at_once(root: &Path) -> Option<Self> {
        let folder = File::open(root).ok()?;
        folder.try_lock().ok()?;
        Some(Self { _lock: folder })
    }

    /// Whether nobody is in the domain, of all that know its locks.
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
        // Not through a link that was put there since it was looked at.
        _ => fs::OpenOptions::new()
            .read(true)
            .custom_flags((OFlags::NOFOLLOW | OFlags::DIRECTORY).bits() as i32)
            .open(path),
    }
}

fn living(root: &Path) -> io::Result<File> {
    open_folder(&root.join(LIVING))
}

/// Takes a lock; `None`: not until then. A thread waits for it, since the kernel knows no end of such a wait.
fn lock(file: File, until: Instant) -> io::Result<Option<File>> {
    match file.try_lock() {
        Ok(()) => return Ok(Some(file)),
        Err(TryLockError::WouldBlock) => {}
        Err(TryLockError::Error(cause)) => return Err(cause),
    }
    let (send, receive) = mpsc::channel();
    thread::Builder::new().spawn(move || {
        let locked = file.lock().map(|()| file);
        // Nobody waits any more: the lock goes back with the file.
        let _ = send.send(locked);
    })?;
    match receive.recv_timeout(until.saturating_duration_since(Instant::now())) {
        Ok(locked) => locked.map(Some),
        Err(_) => Ok(None),
    }
}

/// How often the kernel's list is read: it comes in pieces, and what changes between two of them may hide a line.
const LOOKS: usize = 3;

/// The process that holds the lock on a file, as the kernel lists it.
fn holder(inode: u64) -> String {
    let read = || fs::read_to_string("/proc/locks").unwrap_or_default();
    let Some(pid) = (0..LOOKS).find_map(|_| holder_in(&read(), inode)) else {
        return "a process that cannot be seen from here".into();
    };
    let name = fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
    format!("process {pid} ({})", name.trim())
}

/// Lines are `1: FLOCK  ADVISORY  WRITE 4711 08:02:131077 0 EOF`; who waits has an arrow after the number.
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

//! Reserves disk space in advance, so that a full disk is noticed while a file can still be closed
//! properly.
//!
//! Blocks are reserved after the file's end (`fallocate`, which keeps the file's length), so that
//! writing to them cannot fail for lack of space. The rest is freed when the file is closed. The
//! limit on a file's size is checked as well, since the kernel enforces it only when bytes are
//! written. If a file system cannot reserve space, a full disk is noticed only when a write fails.

use std::fmt;
use std::fs::File;
use std::io;

use rustix::fs::{FallocateFlags, fallocate};
use rustix::io::Errno;
use rustix::process::{Resource, getrlimit};

/// Space reserved beyond the current need, so that requests are made at most a few times per
/// second.
const AHEAD_BYTES: u64 = 32 << 20;

/// Why a file cannot grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoRoom {
    /// The disk is full.
    Disk,
    /// The user's quota is exhausted.
    Quota,
    /// The maximum file size is reached. Contains the limit in bytes, if it is a limit of this
    /// process.
    FileSize(Option<u64>),
}

impl fmt::Display for NoRoom {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Disk => write!(f, "the disk is full: free some of it, or record elsewhere"),
            Self::Quota => write!(
                f,
                "this user's quota on the disk is used up: free some of it, or record elsewhere"
            ),
            Self::FileSize(Some(bytes)) => write!(
                f,
                "files of this process may have no more than {bytes} bytes: raise the limit (ulimit -f)"
            ),
            Self::FileSize(None) => write!(
                f,
                "this file system has no longer files: record to another one"
            ),
        }
    }
}

/// Reserved space of a growing file.
#[derive(Debug)]
pub(crate) struct Space {
    file: File,
    /// End of the reserved blocks.
    reserved_to: u64,
    /// True if the file system can reserve space.
    can_reserve: bool,
}

impl Space {
    /// Tracks a file. `file` is another handle of the file being written.
    pub(crate) fn of(file: File) -> Self {
        Self {
            file,
            reserved_to: 0,
            can_reserve: true,
        }
    }

    /// Reserves space for a file of this length.
    pub(crate) fn reserve(&mut self, length: u64) -> Result<(), NoRoom> {
        let most = getrlimit(Resource::Fsize).current;
        if let Some(most) = most.filter(|&most| length > most) {
            return Err(NoRoom::FileSize(Some(most)));
        }
        if length <= self.reserved_to || !self.can_reserve {
            return Ok(());
        }
        let ahead = (length + AHEAD_BYTES).min(most.unwrap_or(u64::MAX));
        match self.reserve_to(ahead) {
            // On an almost full disk, only the necessary space is requested.
            Err(Errno::NOSPC | Errno::DQUOT | Errno::FBIG) => match self.reserve_to(length) {
                Err(Errno::NOSPC) => Err(NoRoom::Disk),
                Err(Errno::DQUOT) => Err(NoRoom::Quota),
                Err(Errno::FBIG) => Err(NoRoom::FileSize(None)),
                _ => Ok(()),
            },
            // Either the file system does not support reservation, or the next write will fail as
            // well.
            Err(_) => {
                self.can_reserve = false;
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    fn reserve_to(&mut self, length: u64) -> Result<(), Errno> {
        let from = self.reserved_to;
        loop {
            match fallocate(&self.file, FallocateFlags::KEEP_SIZE, from, length - from) {
                Err(Errno::INTR) => {}
                outcome => {
                    outcome?;
                    self.reserved_to = length;
                    return Ok(());
                }
            }
        }
    }

    /// Frees the space reserved after the file's end.
    pub(crate) fn give_back(&mut self) -> io::Result<()> {
        let length = self.file.metadata()?.len();
        // Setting the current length frees the blocks after it.
        self.file.set_len(length)?;
        self.reserved_to = length;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::os::unix::fs::MetadataExt;

    #[test]
    fn what_is_reserved_is_there_but_not_in_the_files_length_and_is_given_back() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(b"begun").unwrap();
        let mut space = Space::of(file.try_clone().unwrap());
        assert_eq!(space.reserve(1 << 20), Ok(()));
        assert_eq!(file.metadata().unwrap().len(), 5);
        if space.can_reserve {
            assert!(file.metadata().unwrap().blocks() * 512 >= 1 << 20);
        }
        space.give_back().unwrap();
        assert_eq!(file.metadata().unwrap().len(), 5);
        assert!(file.metadata().unwrap().blocks() * 512 < 1 << 20);
    }

    #[test]
    fn a_file_that_no_disk_can_hold_is_refused() {
        let mut space = Space::of(tempfile::tempfile().unwrap());
        if space.reserve(1).is_ok() && space.can_reserve {
            // Half of the maximum file offset.
            assert!(space.reserve(1 << 62).is_err());
            // A smaller reservation is still possible.
            assert_eq!(space.reserve(1 << 10), Ok(()));
        }
    }
}

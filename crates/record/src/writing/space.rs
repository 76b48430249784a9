//! Room on the disk, taken before it is needed: a full disk is learnt of while there is still room to close a file well.
//!
//! Blocks are reserved ahead of the file's end (`fallocate`, which leaves its length as it is), so that whatever is written
//! into them cannot fail for want of space; what is left over is given back when the file is closed. The limit on a file's
//! size is looked at as well, since the kernel asks for it only when bytes are written. A file system that cannot reserve
//! says so once, and then only a failing write can tell.

use std::fmt;
use std::fs::File;
use std::io;

use rustix::fs::{FallocateFlags, fallocate};
use rustix::io::Errno;
use rustix::process::{Resource, getrlimit};

/// So much is reserved beyond what is needed now, so that it is asked for a few times a second at most.
const AHEAD_BYTES: u64 = 32 << 20;

/// Why a file can grow no further.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoRoom {
    /// The disk is full.
    Disk,
    /// The user may have no more of it.
    Quota,
    /// No file may be longer: the limit in bytes, if it is this process's own.
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

/// The room that a growing file has.
#[derive(Debug)]
pub(crate) struct Space {
    file: File,
    /// Blocks are there up to this byte.
    reserved_to: u64,
    /// Whether the file system can reserve.
    can_reserve: bool,
}

impl Space {
    /// `file`: another handle of the file that is written to.
    pub(crate) fn of(file: File) -> Self {
        Self {
            file,
            reserved_to: 0,
            can_reserve: true,
        }
    }

    /// Makes sure that the file can grow to this length.
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
            // Near the end of the disk only what is needed is asked for.
            Err(Errno::NOSPC | Errno::DQUOT | Errno::FBIG) => match self.reserve_to(length) {
                Err(Errno::NOSPC) => Err(NoRoom::Disk),
                Err(Errno::DQUOT) => Err(NoRoom::Quota),
                Err(Errno::FBIG) => Err(NoRoom::FileSize(None)),
                _ => Ok(()),
            },
            // Not supported, or a fault that the next write will meet as well.
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

    /// Gives back what is reserved behind the file's end.
    pub(crate) fn give_back(&mut self) -> io::Result<()> {
        let length = self.file.metadata()?.len();
        // To the length it has: this frees the blocks behind it.
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
            // Half of what a file offset can say.
            assert!(space.reserve(1 << 62).is_err());
            // A smaller one is still possible.
            assert_eq!(space.reserve(1 << 10), Ok(()));
        }
    }
}

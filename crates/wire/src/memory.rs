//! Reserves shared memory before use. Otherwise a full `/dev/shm` causes SIGBUS at the first access
//! to a page, in the middle of a frame.

use std::fs::{self, DirEntry};
use std::io;

use rustix::fs::{FallocateFlags, fallocate, statvfs};

use crate::WireError;

pub(crate) const SHM: &str = "/dev/shm";
/// Memory of the transport itself in addition to a channel's slots: connection tables of a few
/// hundred kB.
const BESIDE_SLOTS: u64 = 1 << 20;

/// Checks that shared memory exists and has space for the transport's own tables.
pub(crate) fn require_shared_memory() -> Result<(), WireError> {
    require_space("lariat", 0)
}

/// Checks that another `bytes` bytes fit.
pub(crate) fn require_space(channel: &str, bytes: u64) -> Result<(), WireError> {
    let shm = statvfs(SHM).map_err(|cause| WireError::NoSharedMemory(cause.to_string()))?;
    let available = shm.f_bavail * shm.f_frsize;
    let needed = bytes + BESIDE_SLOTS;
    // A file system without blocks (`f_blocks` is 0) is a tmpfs without a limit.
    if shm.f_blocks > 0 && available < needed {
        return Err(too_little(channel, needed, available));
    }
    Ok(())
}

/// Allocates the pages of a segment now. Other processes may take the space that `require_space`
/// found, so only this is reliable.
pub(crate) fn reserve_segment(channel: &str, id: &str) -> Result<(), WireError> {
    let Some(segment) = segment_of(id) else {
        return Ok(());
    };
    let reserve = || -> io::Result<u64> {
        let file = fs::OpenOptions::new()
            .read(true)
            .write(true)
            .open(segment.path())?;
        let bytes = file.metadata()?.len();
        fallocate(&file, FallocateFlags::KEEP_SIZE, 0, bytes)?;
        Ok(bytes)
    };
    match reserve() {
        Err(cause) if cause.kind() == io::ErrorKind::StorageFull => {
            let needed = segment.metadata().map_or(0, |data| data.len());
            let available = statvfs(SHM).map_or(0, |shm| shm.f_bavail * shm.f_frsize);
            Err(too_little(channel, needed, available))
        }
        // Without fallocate (on an old kernel), pages are allocated at first access as usual.
        _ => Ok(()),
    }
}

/// The shared memory with a writer's slots, found by the transport's ID of the writer.
fn segment_of(id: &str) -> Option<DirEntry> {
    let entries = fs::read_dir(SHM).ok()?;
    entries.flatten().find(|entry| {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        name.contains(id) && name.ends_with(".data")
    })
}

/// Size of that shared memory in bytes; 0 if it is gone.
pub(crate) fn segment_bytes(id: &str) -> u64 {
    let data = segment_of(id).and_then(|segment| segment.metadata().ok());
    data.map_or(0, |data| data.len())
}

fn too_little(channel: &str, needed: u64, available: u64) -> WireError {
    WireError::TooLittleSpace {
        channel: channel.into(),
        needed_mb: needed.div_ceil(1_000_000),
        available_mb: available / 1_000_000,
    }
}

#![allow(unsafe_code)] // Memory is mapped from a driver, and lent to it.
//! What streaming asks of a camera's driver: the few calls behind [`Stream`](super::stream::Stream).

use std::os::fd::{AsFd, BorrowedFd};
use std::ptr::NonNull;

use rustix::io::{Errno, Result};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};

use super::device::Device;
use super::stamp::DriverTime;
use super::sys;

/// Where a frame's memory comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Memory {
    /// The driver's own, mapped: a frame is copied from there.
    Mapped,
    /// Ours: the driver writes into it.
    Lent,
}

impl Memory {
    fn code(self) -> u32 {
        match self {
            Self::Mapped => sys::MEMORY_MMAP,
            Self::Lent => sys::MEMORY_USERPTR,
        }
    }
}

/// A buffer that the driver has filled, or failed to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Filled {
    pub(super) index: usize,
    /// Where in the buffer the frame begins, and how many bytes it has.
    pub(super) offset: usize,
    pub(super) bytes: usize,
    pub(super) sequence: u32,
    pub(super) time: DriverTime,
    /// Whether the driver says that the frame is damaged.
    pub(super) is_damaged: bool,
}

/// A camera's driver, opened and set up.
pub(super) trait Driver: Send {
    /// Ready to be read from when a frame is.
    fn fd(&self) -> BorrowedFd<'_>;

    /// Asks for so many buffers, 0 to give them up; says how many there are.
    fn request(&self, memory: Memory, count: usize) -> Result<usize>;

    /// Maps a buffer of the driver's own.
    fn map(&self, index: usize) -> Result<Mapping>;

    /// Has a buffer filled: the driver's own, or `lent` memory.
    ///
    /// # Safety
    /// Lent memory stays valid, and nobody touches it, until the buffer is dequeued, streaming has been stopped with
    /// success, or the driver is dropped.
    unsafe fn queue(&self, index: usize, lent: Option<NonNull<[u8]>>) -> Result<()>;

    /// Takes the buffer that was filled first; `AGAIN` if none is.
    fn dequeue(&self, memory: Memory) -> Result<Filled>;

    /// Starts or stops.
    fn stream(&self, on: bool) -> Result<()>;

    /// For how long frames are exposed, where the camera says it.
    fn exposure_ns(&self) -> Option<u64>;
}

/// A driver's buffer in this process's memory, to be read while the driver does not fill it.
#[derive(Debug)]
pub(super) struct Mapping(NonNull<[u8]>);

// SAFETY: memory without a tie to a thread.
unsafe impl Send for Mapping {}

impl Mapping {
    fn new(fd: BorrowedFd, offset: u64, bytes: usize) -> Result<Self> {
        let protection = ProtFlags::READ;
        // SAFETY: a new mapping, where the kernel likes it; nothing else is there.
        let start = unsafe {
            mmap(
                std::ptr::null_mut(),
                bytes,
                protection,
                MapFlags::SHARED,
                fd,
                offset,
            )?
        };
        let start = NonNull::new(start.cast::<u8>()).ok_or(Errno::NOMEM)?;
        Ok(Self(NonNull::slice_from_raw_parts(start, bytes)))
    }

    /// The bytes. Only between a buffer's dequeuing and its next queuing: the driver writes there else.
    pub(super) fn bytes(&self) -> &[u8] {
        // SAFETY: mapped for reading until it is dropped, in this length; any byte is a byte.
        unsafe { self.0.as_ref() }
    }
}

#[cfg(test)]
impl Mapping {
    /// A fake driver's memory: a file's.
    pub(super) fn of_file(file: &std::fs::File, bytes: usize) -> Result<Self> {
        Self::new(file.as_fd(), 0, bytes)
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: it was mapped by `new` in this length, and nobody borrows from it any more.
        let _ = unsafe { munmap(self.0.as_ptr().cast(), self.0.len()) };
    }
}

impl Device {
    /// An empty buffer, with its plane if the device has planes: lariat takes no format of several memory planes.
    fn buffer(&self, memory: Memory, index: usize) -> (sys::Buffer, [sys::Plane; 1]) {
        let buffer = sys::Buffer {
            index: index as u32,
            kind: self.buffer_type(),
            memory: memory.code(),
            ..Default::default()
        };
        (buffer, [sys::Plane::default()])
    }
}

impl Driver for Device {
    fn fd(&self) -> BorrowedFd<'_> {
        self.as_fd()
    }

    fn request(&self, memory: Memory, count: usize) -> Result<usize> {
        let mut request = sys::RequestBuffers {
            count: count as u32,
            kind: self.buffer_type(),
            memory: memory.code(),
            ..Default::default()
        };
        sys::request_buffers(self, &mut request)?;
        Ok(request.count as usize)
    }

    fn map(&self, index: usize) -> Result<Mapping> {
        let (mut buffer, mut planes) = self.buffer(Memory::Mapped, index);
        sys::query_buffer(self, &mut buffer, &mut planes)?;
        let (offset, bytes) = match self.has_planes() {
            true => (planes[0].offset(), planes[0].length),
            false => (buffer.offset(), buffer.length),
        };
        Mapping::new(self.as_fd(), offset.into(), bytes as usize)
    }

    unsafe fn queue(&self, index: usize, lent: Option<NonNull<[u8]>>) -> Result<()> {
        let memory = match lent {
            Some(_) => Memory::Lent,
            None => Memory::Mapped,
        };
        let (mut buffer, mut planes) = self.buffer(memory, index);
        if let Some(lent) = lent {
            let address = lent.as_ptr().cast::<u8>().expose_provenance() as u64;
            let bytes = lent.len().min(u32::MAX as usize) as u32;
            if self.has_planes() {
                (planes[0].m, planes[0].length) = (address, bytes);
            } else {
                (buffer.m, buffer.length) = (address, bytes);
            }
        }
        // SAFETY: the caller's promise, with streaming stopped by VIDIOC_STREAMOFF, or the only descriptor closed.
        unsafe { sys::queue_buffer(self, &mut buffer, &mut planes) }
    }

    fn dequeue(&self, memory: Memory) -> Result<Filled> {
        let (mut buffer, mut planes) = self.buffer(memory, 0);
        sys::dequeue_buffer(self, &mut buffer, &mut planes)?;
        let (offset, end) = match self.has_planes() {
            // Of a plane the used bytes count what stands before the frame.
            true => (planes[0].data_offset, planes[0].bytesused),
            false => (0, buffer.bytesused),
        };
        Ok(Filled {
            index: buffer.index as usize,
            offset: offset as usize,
            bytes: end.saturating_sub(offset) as usize,
            sequence: buffer.sequence,
            time: DriverTime {
                flags: buffer.flags,
                s: buffer.timestamp_s,
                us: buffer.timestamp_us,
            },
            is_damaged: buffer.flags & sys::BUF_FLAG_ERROR != 0,
        })
    }

    fn stream(&self, on: bool) -> Result<()> {
        match on {
            true => sys::stream_on(self, self.buffer_type()),
            false => sys::stream_off(self, self.buffer_type()),
        }
    }

    fn exposure_ns(&self) -> Option<u64> {
        Device::exposure_ns(self)
    }
}

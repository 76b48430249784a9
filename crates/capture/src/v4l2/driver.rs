#![allow(unsafe_code)] // Maps memory from a driver and lends memory to it.
//! The calls of a camera's driver that streaming needs, behind [`Stream`](super::stream::Stream).

use std::os::fd::{AsFd, BorrowedFd};
use std::ptr::NonNull;

use rustix::io::{Errno, Result};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};

use super::device::Device;
use super::stamp::DriverTime;
use super::sys;

/// Owner of a frame's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Memory {
    /// The driver's own memory, mapped. Frames are copied from it.
    Mapped,
    /// Our memory, which the driver writes into.
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

/// A buffer that the driver has filled, or failed to fill.
#[derive(Debug, Clone, Copy)]
pub(super) struct Filled {
    pub(super) index: usize,
    /// Offset of the frame in the buffer, and its length in bytes.
    pub(super) offset: usize,
    pub(super) bytes: usize,
    pub(super) sequence: u32,
    pub(super) time: DriverTime,
    /// True if the driver reports that the frame is damaged.
    pub(super) is_damaged: bool,
}

/// The driver of a camera that is open and set up.
pub(super) trait Driver: Send {
    /// Descriptor that becomes readable when a frame is ready.
    fn fd(&self) -> BorrowedFd<'_>;

    /// Requests this many buffers, 0 to free them. Returns how many there are.
    fn request(&self, memory: Memory, count: usize) -> Result<usize>;

    /// Maps one of the driver's own buffers.
    fn map(&self, index: usize) -> Result<Mapping>;

    /// Queues a buffer to be filled: the driver's own, or `lent` memory.
    ///
    /// # Safety
    /// Lent memory must stay valid and untouched until the buffer is dequeued, streaming has been
    /// stopped successfully, or the driver is dropped.
    unsafe fn queue(&self, index: usize, lent: Option<NonNull<[u8]>>) -> Result<()>;

    /// Dequeues the buffer that was filled first; `AGAIN` if none is filled.
    fn dequeue(&self, memory: Memory) -> Result<Filled>;

    /// Starts or stops streaming.
    fn stream(&self, on: bool) -> Result<()>;

    /// Exposure time of frames, if the camera reports it.
    fn exposure_ns(&self) -> Option<u64>;
}

/// A driver's buffer mapped into this process, to be read while the driver does not fill it.
#[derive(Debug)]
pub(super) struct Mapping(NonNull<[u8]>);

// SAFETY: the memory is not tied to a thread.
unsafe impl Send for Mapping {}

impl Mapping {
    fn new(fd: BorrowedFd, offset: u64, bytes: usize) -> Result<Self> {
        let protection = ProtFlags::READ;
        // SAFETY: a new mapping at an address that the kernel chooses, so nothing else is there.
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

    /// The bytes. Valid only between a buffer's dequeuing and its next queuing, because the driver
    /// writes there at other times.
    pub(super) fn bytes(&self) -> &[u8] {
        // SAFETY: mapped for reading, in this length, until it is dropped; any byte is valid.
        unsafe { self.0.as_ref() }
    }
}

#[cfg(test)]
impl Mapping {
    /// Maps a file as a fake driver's memory.
    pub(super) fn of_file(file: &std::fs::File, bytes: usize) -> Result<Self> {
        Self::new(file.as_fd(), 0, bytes)
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: `new` mapped it in this length, and nobody borrows from it any more.
        let _ = unsafe { munmap(self.0.as_ptr().cast(), self.0.len()) };
    }
}

impl Device {
    /// Creates an empty buffer, with one plane in case the device has planes. Lariat accepts no
    /// format with several memory planes.
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
        // SAFETY: by the caller's contract. Streaming is stopped by VIDIOC_STREAMOFF or by closing
        // the only descriptor.
        unsafe { sys::queue_buffer(self, &mut buffer, &mut planes) }
    }

    fn dequeue(&self, memory: Memory) -> Result<Filled> {
        let (mut buffer, mut planes) = self.buffer(memory, 0);
        sys::dequeue_buffer(self, &mut buffer, &mut planes)?;
        let (offset, end) = match self.has_planes() {
            // The used bytes of a plane include those before the frame.
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

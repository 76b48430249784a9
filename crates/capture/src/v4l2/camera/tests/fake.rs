#![allow(unsafe_code)] // The fake driver writes into lent memory, as a real one would.
//! A camera on a test bench: a driver that fails on demand, and the memory lent to it.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::ptr::NonNull;
use std::sync::{Arc, Mutex, MutexGuard};

use rustix::io::Result as Kernel;

use crate::v4l2::camera::*;
use crate::v4l2::driver::{Filled, Mapping};
use crate::v4l2::stamp::DriverTime;
use crate::v4l2::sys;

const SIDE: u32 = 8;
const BYTES: usize = 64;
const PERIOD_NS: u64 = 2_000_000;

/// The camera's hardware, as the kernel sees it.
#[derive(Debug, Default)]
pub(super) struct Hardware {
    /// Calls that fail, in order. Each entry fails the next call with its name.
    pub(super) failing: VecDeque<(&'static str, Errno)>,
    /// Error of every call until the device is closed. `is_absent`: the device cannot be opened.
    pub(super) broken: Option<Errno>,
    pub(super) is_absent: bool,
    pub(super) takes_lent: bool,
    pub(super) buffers: usize,
    /// Numbers and addresses of the buffers to be filled.
    pub(super) queued: VecDeque<(usize, usize)>,
    /// Number and address of every buffer that was ever queued.
    pub(super) addresses: Vec<(usize, usize)>,
    pub(super) streaming: bool,
    pub(super) sequence: u32,
    pub(super) opened: u32,
    pub(super) left: u32,
}

/// Handle with which a test controls the hardware.
pub(super) struct Hand {
    hardware: Arc<Mutex<Hardware>>,
    bell: UnixStream,
    memory: Arc<File>,
}

/// An open device.
pub(super) struct Fake {
    hardware: Arc<Mutex<Hardware>>,
    bell: UnixStream,
    memory: Arc<File>,
}

pub(super) fn lock(hardware: &Mutex<Hardware>) -> MutexGuard<'_, Hardware> {
    hardware.lock().expect("no test panics while it holds it")
}

impl Fake {
    fn call(&self, name: &'static str) -> Kernel<MutexGuard<'_, Hardware>> {
        let mut hardware = lock(&self.hardware);
        if let Some(errno) = hardware.broken {
            // As after a fatal error, streaming can still be stopped. On a missing device every
            // call fails.
            if errno == Errno::NODEV || matches!(name, "DQBUF" | "QBUF") {
                return Err(errno);
            }
        }
        if hardware
            .failing
            .front()
            .is_some_and(|(next, _)| *next == name)
            && let Some((_, errno)) = hardware.failing.pop_front()
        {
            return Err(errno);
        }
        Ok(hardware)
    }
}

impl Driver for Fake {
    fn fd(&self) -> BorrowedFd<'_> {
        self.bell.as_fd()
    }

    fn request(&self, memory: Memory, count: usize) -> Kernel<usize> {
        let mut hardware = self.call("REQBUFS")?;
        if memory == Memory::Lent && !hardware.takes_lent {
            return Err(Errno::INVAL);
        }
        hardware.buffers = count.min(hardware.buffers.max(3));
        Ok(hardware.buffers)
    }

    fn map(&self, _index: usize) -> Kernel<Mapping> {
        drop(self.call("QUERYBUF")?);
        Mapping::of_file(&self.memory, BYTES)
    }

    unsafe fn queue(&self, index: usize, lent: Option<NonNull<[u8]>>) -> Kernel<()> {
        let mut hardware = self.call("QBUF")?;
        let address = lent.map_or(0, |lent| lent.as_ptr().cast::<u8>().expose_provenance());
        hardware.queued.push_back((index, address));
        hardware.addresses.push((index, address));
        Ok(())
    }

    fn dequeue(&self, memory: Memory) -> Kernel<Filled> {
        let mut hardware = self.call("DQBUF")?;
        let mut word = [0; 2];
        match (&self.bell).read(&mut word) {
            Ok(2) => {}
            _ => return Err(Errno::AGAIN),
        }
        let [value, flags] = word;
        hardware.sequence += 1;
        let (index, address) = hardware.queued.pop_front().ok_or(Errno::AGAIN)?;
        if memory == Memory::Lent {
            // SAFETY: the memory is lent. It is therefore valid and untouched by others until the
            // buffer is dequeued, which happens now.
            unsafe {
                std::ptr::with_exposed_provenance_mut::<u8>(address).write_bytes(value, BYTES)
            };
        }
        let now_us = (now_ns() / 1000) as i64;
        Ok(Filled {
            index,
            offset: 0,
            bytes: if flags == SHORT { BYTES - 1 } else { BYTES },
            sequence: hardware.sequence - 1,
            time: DriverTime {
                flags: sys::BUF_FLAG_TIMESTAMP_MONOTONIC | sys::BUF_FLAG_TSTAMP_SRC_SOE,
                s: now_us / 1_000_000,
                us: now_us % 1_000_000 - 1,
            },
            is_damaged: flags == DAMAGED,
        })
    }

    fn stream(&self, on: bool) -> Kernel<()> {
        let mut hardware = self.call(if on { "STREAMON" } else { "STREAMOFF" })?;
        hardware.streaming = on;
        hardware.sequence = 0;
        if !on {
            hardware.queued.clear();
            if hardware.broken == Some(Errno::IO) {
                hardware.broken = None;
            }
        }
        Ok(())
    }

    fn exposure_ns(&self) -> Option<u64> {
        None
    }
}

impl Drop for Fake {
    fn drop(&mut self) {
        let mut hardware = lock(&self.hardware);
        hardware.queued.clear();
        hardware.broken = None;
    }
}

pub(super) const GOOD: u8 = 0;
pub(super) const DAMAGED: u8 = 1;
pub(super) const SHORT: u8 = 2;

pub(super) struct FakePort(Hand);

impl Hand {
    fn open(&self) -> Fake {
        lock(&self.hardware).opened += 1;
        Fake {
            hardware: self.hardware.clone(),
            bell: self.bell.try_clone().expect("a descriptor"),
            memory: self.memory.clone(),
        }
    }
}

impl Port for FakePort {
    type Driver = Fake;

    fn reopen(&mut self) -> Result<(Fake, Option<String>), CameraError> {
        if lock(&self.0.hardware).is_absent {
            return Err(CameraError::Absent {
                path: "fake".into(),
                cameras: String::new(),
            });
        }
        Ok((self.0.open(), None))
    }

    fn refusal(&self, doing: &'static str, errno: Errno) -> CameraError {
        CameraError::Refused {
            path: "fake".into(),
            doing,
            error: errno.into(),
        }
    }

    fn settled(&mut self, _driver: &Fake) -> Option<String> {
        None
    }

    fn leave(&mut self, _driver: &Fake) {
        lock(&self.0.hardware).left += 1;
    }
}

/// A camera, its hardware, and slots to lend to it.
pub(super) struct Bench {
    // Dropped before the memory lent to it.
    pub(super) camera: Camera<FakePort>,
    pub(super) hardware: Arc<Mutex<Hardware>>,
    frames: UnixStream,
    slots: [Box<[u8; BYTES]>; SLOTS],
}

impl Bench {
    pub(super) fn new(io: Io, takes_lent: bool) -> Self {
        let hardware = Arc::new(Mutex::new(Hardware {
            takes_lent,
            ..Hardware::default()
        }));
        let (frames, bell) = UnixStream::pair().expect("a pair");
        bell.set_nonblocking(true).expect("set");
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(&[77; BYTES]).expect("written");
        let hand = Hand {
            hardware: hardware.clone(),
            bell,
            memory: Arc::new(file),
        };
        let shape = Shape {
            width: SIDE,
            height: SIDE,
            stride: SIDE,
            encoding: Encoding::Plain(PixelFormat::Gray8),
            range: ColorRange::Full,
            buffer_bytes: BYTES,
            interval_ns: Some(PERIOD_NS),
        };
        let camera = Camera::new(
            "fake".to_owned(),
            hand.open(),
            FakePort(hand),
            shape,
            io,
            None,
        );
        let mut bench = Self {
            camera,
            hardware,
            frames,
            slots: std::array::from_fn(|_| Box::new([0; BYTES])),
        };
        for index in 0..bench.camera.slots_wanted() {
            bench.lend(index);
        }
        bench
    }

    fn lend(&mut self, index: usize) {
        let memory = NonNull::from(&mut self.slots[index][..]);
        // SAFETY: the memory is boxed, outlives the camera, and is not read before it is given
        // back.
        self.camera.lend(unsafe { LentSlot::new(index, memory) });
    }

    pub(super) fn hardware(&self) -> MutexGuard<'_, Hardware> {
        lock(&self.hardware)
    }

    /// Fills the driver's next frame with this value.
    pub(super) fn expose(&mut self, value: u8, flags: u8) {
        self.frames.write_all(&[value, flags]).expect("room");
    }

    pub(super) fn next(&mut self) -> Frame {
        self.camera.next().expect("no fault").expect("no end")
    }

    /// Returns the next frame that is not blank, and lends its slot again.
    pub(super) fn next_image(&mut self) -> Frame {
        loop {
            let frame = self.next();
            if let Some(key) = frame.slot {
                self.lend(key.index());
            }
            if frame.width > 0 {
                return frame;
            }
        }
    }

    /// Returns number and value of the next frame that is not blank, and lends its slot again.
    pub(super) fn shown(&mut self) -> (u64, u8) {
        loop {
            let frame = self.next();
            if frame.width == 0 {
                continue;
            }
            let value = match frame.slot {
                Some(key) => self.slots[key.index()][BYTES - 1],
                None => {
                    let mut pixels = [0; BYTES];
                    self.camera.write(&mut pixels);
                    pixels[BYTES - 1]
                }
            };
            assert!(
                frame
                    .exposed_ns
                    .is_some_and(|exposed_ns| exposed_ns <= now_ns())
            );
            if let Some(key) = frame.slot {
                self.lend(key.index());
            }
            return (frame.sequence, value);
        }
    }

    pub(super) fn said(&mut self) -> String {
        let warnings = std::iter::from_fn(|| self.camera.take_warning());
        warnings.collect::<Vec<_>>().join("\n")
    }

    pub(super) fn news(&mut self) -> String {
        let news = std::iter::from_fn(|| self.camera.take_news());
        news.collect::<Vec<_>>().join("\n")
    }
}

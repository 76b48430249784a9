#![allow(unsafe_code)] // The fake driver writes where a real one would, into memory that it is lent.
//! A camera through what happens to it, by a driver that fails when it is told to.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::ptr::NonNull;
use std::sync::{Arc, Mutex, MutexGuard};

use rustix::io::Result as Kernel;

use super::*;
use crate::v4l2::driver::{Filled, Mapping};
use crate::v4l2::stamp::DriverTime;
use crate::v4l2::sys;

const SIDE: u32 = 8;
const BYTES: usize = 64;
const PERIOD_NS: u64 = 2_000_000;

/// The camera's hardware, as the kernel sees it.
#[derive(Debug, Default)]
struct Hardware {
    /// Calls that fail: each the next one of its name.
    failing: VecDeque<(&'static str, Errno)>,
    /// What every call fails with, until the device is closed; and whether the device can be opened.
    broken: Option<Errno>,
    is_absent: bool,
    takes_lent: bool,
    buffers: usize,
    /// Numbers and addresses of what waits to be filled.
    queued: VecDeque<(usize, usize)>,
    /// Every address that was ever queued, by number.
    addresses: Vec<(usize, usize)>,
    streaming: bool,
    sequence: u32,
    opened: u32,
    left: u32,
}

/// The test's hand on it.
struct Hand {
    hardware: Arc<Mutex<Hardware>>,
    bell: UnixStream,
    memory: Arc<File>,
}

/// An open device.
struct Fake {
    hardware: Arc<Mutex<Hardware>>,
    bell: UnixStream,
    memory: Arc<File>,
}

fn lock(hardware: &Mutex<Hardware>) -> MutexGuard<'_, Hardware> {
    hardware.lock().expect("no test panics while it holds it")
}

impl Fake {
    fn call(&self, name: &'static str) -> Kernel<MutexGuard<'_, Hardware>> {
        let mut hardware = lock(&self.hardware);
        if let Some(errno) = hardware.broken {
            // As after a fatal error, streaming can be stopped; of a device that is gone, nothing can be done.
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
            // SAFETY: lent, and so valid and untouched by others, until it is dequeued: here, now.
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

const GOOD: u8 = 0;
const DAMAGED: u8 = 1;
const SHORT: u8 = 2;

struct FakePort(Hand);

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

    fn reopen(&mut self) -> Result<Fake, CameraError> {
        if lock(&self.0.hardware).is_absent {
            return Err(CameraError::Absent {
                path: "fake".into(),
                cameras: String::new(),
            });
        }
        Ok(self.0.open())
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

/// A camera, the hardware behind it, and slots that it can be lent.
struct Bench {
    // Dropped before the memory that it is lent.
    camera: Camera<FakePort>,
    hardware: Arc<Mutex<Hardware>>,
    frames: UnixStream,
    slots: [Box<[u8; BYTES]>; SLOTS],
}

impl Bench {
    fn new(io: Io, takes_lent: bool) -> Self {
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
        // SAFETY: the memory is boxed, lives longer than the camera, and is not looked at before it was given back.
        self.camera.lend(unsafe { LentSlot::new(index, memory) });
    }

    fn hardware(&self) -> MutexGuard<'_, Hardware> {
        lock(&self.hardware)
    }

    /// The driver has a frame of this value.
    fn expose(&mut self, value: u8, flags: u8) {
        self.frames.write_all(&[value, flags]).expect("room");
    }

    fn next(&mut self) -> Frame {
        self.camera.next().expect("no fault").expect("no end")
    }

    /// The next frame's number and value; blank ones are passed over. Its slot is lent anew.
    fn shown(&mut self) -> (u64, u8) {
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

    fn said(&mut self) -> String {
        let warnings = std::iter::from_fn(|| self.camera.take_warning());
        warnings.collect::<Vec<_>>().join("\n")
    }

    fn news(&mut self) -> String {
        let news = std::iter::from_fn(|| self.camera.take_news());
        news.collect::<Vec<_>>().join("\n")
    }
}

#[test]
fn frames_are_written_where_the_slots_are_and_each_slot_keeps_its_number() {
    let mut bench = Bench::new(Io::Auto, true);
    bench.hardware().buffers = 32;
    for number in 1..=50 {
        bench.expose(number as u8, GOOD);
        assert_eq!(bench.shown(), (number, number as u8));
    }
    assert!(bench.news().contains("USERPTR, 4 slots"));
    let mut numbers: Vec<_> = bench.hardware().addresses.clone();
    numbers.sort_unstable();
    numbers.dedup();
    assert_eq!(numbers.len(), 4, "{numbers:?}");
}

#[test]
fn a_driver_with_fewer_buffers_than_slots_has_what_it_can_take() {
    let mut bench = Bench::new(Io::Auto, true);
    for number in 1..=20 {
        bench.expose(number as u8, GOOD);
        assert_eq!(bench.shown(), (number, number as u8));
    }
}

#[test]
fn what_does_not_take_memory_is_copied_from() {
    let mut bench = Bench::new(Io::Auto, false);
    bench.expose(1, GOOD);
    assert_eq!(bench.shown(), (1, 77));
    assert!(bench.news().contains("MMAP"));
    let mut bench = Bench::new(Io::UserPointer, false);
    let refused = bench.camera.next().expect_err("it may not be copied from");
    assert!(refused.to_string().contains("REQBUFS"), "{refused}");
}

#[test]
fn without_slots_a_frame_is_kept_until_it_is_asked_for() {
    let mut bench = Bench::new(Io::Mapped, true);
    bench.camera.slots.clear();
    for number in 1..=9 {
        bench.expose(0, GOOD);
        assert_eq!(bench.shown(), (number, 77));
    }
}

#[test]
fn damaged_and_short_frames_are_gaps_and_said() {
    let mut bench = Bench::new(Io::Auto, true);
    for (value, flags) in [(1, GOOD), (2, DAMAGED), (3, SHORT), (4, GOOD)] {
        bench.expose(value, flags);
    }
    assert_eq!([bench.shown(), bench.shown()], [(1, 1), (4, 4)]);
    let said = bench.said();
    assert!(said.contains("a frame was lost at the source"), "{said}");
}

#[test]
fn calls_that_fail_once_are_tried_again_and_said() {
    for call in ["REQBUFS", "QBUF", "STREAMON"] {
        for io in [Io::Auto, Io::Mapped] {
            let mut bench = Bench::new(io, true);
            bench.hardware().failing.push_back((call, Errno::INVAL));
            bench.expose(5, GOOD);
            assert_eq!(bench.shown().0, 1);
            let said = bench.said();
            assert!(
                said.contains(call) && said.contains("tried twice: 1"),
                "{said}"
            );
        }
    }
}

#[test]
fn a_broken_stream_is_started_anew_and_numbers_go_on() {
    let mut bench = Bench::new(Io::Auto, true);
    bench.expose(1, GOOD);
    assert_eq!(bench.shown(), (1, 1));
    bench.hardware().broken = Some(Errno::IO);
    bench.expose(2, GOOD);
    let (number, value) = bench.shown();
    assert!(number > 1);
    assert_eq!(value, 2);
    assert_eq!(bench.hardware().opened, 1);
    let said = bench.said();
    assert!(said.contains("is started anew"), "{said}");
    assert!(bench.news().contains("frames come again"));
}

#[test]
fn an_unplugged_camera_is_told_of_at_once_by_blank_frames_and_comes_back() {
    let mut bench = Bench::new(Io::Auto, true);
    bench.expose(1, GOOD);
    assert_eq!(bench.shown(), (1, 1));
    {
        let mut hardware = bench.hardware();
        hardware.broken = Some(Errno::NODEV);
        hardware.is_absent = true;
    }
    bench.expose(2, GOOD);
    for number in 2..5 {
        let frame = bench.next();
        assert_eq!((frame.width, frame.sequence, frame.slot), (0, number, None));
        assert_eq!(frame.bytes(), 0);
    }
    assert!(bench.said().contains("waited for until it comes back"));
    bench.hardware().is_absent = false;
    let (number, value) = bench.shown();
    assert!(number >= 5);
    assert_eq!((value, bench.hardware().opened), (2, 2));
    let news = bench.news();
    assert!(
        news.contains("there again") && news.contains("frames come again"),
        "{news}"
    );
}

#[test]
fn a_stall_is_said_once_and_frames_after_it_go_on() {
    let mut bench = Bench::new(Io::Auto, true);
    for number in 1..=2 {
        bench.expose(1, GOOD);
        assert_eq!(bench.shown().0, number);
    }
    bench.said();
    let (first, second) = (bench.next(), bench.next());
    assert_eq!([first.width, second.width], [0, 0]);
    assert_eq!([first.sequence, second.sequence], [3, 4]);
    assert_eq!(bench.said().matches("no frame has come").count(), 1);
    bench.expose(9, GOOD);
    assert_eq!(bench.shown().1, 9);
    assert!(bench.news().contains("frames come again"));
}

#[test]
fn before_the_first_frame_nothing_is_told_and_the_wait_can_be_ended() {
    let bench = Bench::new(Io::Auto, true);
    let mut camera = bench.camera;
    let (mut stop_in, stop) = UnixStream::pair().expect("a pair");
    stop_in.write_all(&[1]).expect("room");
    let until = Until::new(None, stop.as_fd());
    assert_eq!(camera.advance(&until).expect("no fault"), Next::Nothing);
    drop(camera);
    let hardware = lock(&bench.hardware);
    assert!(!hardware.streaming);
    assert_eq!(hardware.left, 1);
}

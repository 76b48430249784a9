use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Sender};
use std::time::{Duration, Instant};

use lariat_capture::{LentSlot, SourceError, Woken};
use lariat_test_support::allocations;
use lariat_wire::{DEPTH, Message, PixelFormat, SourceKind};
use rustix::event::PollFlags;

use super::*;
use crate::stages::capture::tests::{domain, station};
use crate::stop::Stop;

const MS: u64 = 1_000_000;
const SIZE: [u32; 2] = [8, 4];
/// Rows are padded.
const STRIDE: u32 = 20;
const BYTES: usize = 80;

/// An action of the depth camera.
enum Deed {
    /// Delivers an image of this value, exposed at this time.
    Image(u16, u64),
    /// Loses an image.
    Lost,
    /// Delivers a blank frame.
    Silence,
    Fault,
}

/// A scripted depth camera that fills the slots that it is lent.
struct Scripted {
    deeds: mpsc::Receiver<Deed>,
    bell: UnixStream,
    slots: Vec<LentSlot>,
    sequence: u64,
    /// Number of actions that have taken effect.
    settled: Arc<AtomicU64>,
    /// Number of allocations of its thread, at each request for an image.
    allocated: Arc<Mutex<Vec<u64>>>,
}

impl FrameSource for Scripted {
    fn kind(&self) -> SourceKind {
        SourceKind::Camera
    }

    fn largest_frame_bytes(&self) -> usize {
        BYTES + 16
    }

    fn slots_wanted(&self) -> usize {
        3
    }

    fn lend(&mut self, slot: LentSlot) {
        self.slots.push(slot);
    }

    fn advance(&mut self, until: &Until) -> Result<Next, SourceError> {
        self.allocated.lock().unwrap().push(allocations());
        self.settled.store(self.sequence, Ordering::SeqCst);
        match until.wait(Some((self.bell.as_fd(), PollFlags::IN)), None) {
            Woken::Ready(_) => {}
            _ => return Ok(Next::Nothing),
        }
        // The test has ended.
        if self.bell.read(&mut [0]).unwrap() == 0 {
            return Ok(Next::Nothing);
        }
        self.sequence += 1;
        let (value, exposed_ns) = match self.deeds.recv().unwrap() {
            Deed::Image(value, exposed_ns) => (value, exposed_ns),
            Deed::Silence => return Ok(Next::Frame(Frame::blank(self.sequence, now_ns()))),
            Deed::Fault => return Err(SourceError::Unnamed),
            Deed::Lost => return Ok(Next::Nothing),
        };
        let mut slot = self.slots.pop().expect("one is lent");
        for pixel in slot.chunks_exact_mut(2) {
            pixel.copy_from_slice(&value.to_le_bytes());
        }
        Ok(Next::Frame(Frame {
            sequence: self.sequence,
            width: SIZE[0],
            height: SIZE[1],
            stride: STRIDE,
            format: PixelFormat::Gray16,
            exposed_ns: Some(exposed_ns),
            slot: Some(slot.give_back()),
        }))
    }

    fn write(&mut self, _pixels: &mut [u8]) {
        panic!("its images are in their slots");
    }
}

/// A depth camera, the sender of its frames, and a reader of the images.
struct Bench {
    camera: Option<DepthCamera>,
    reader: lariat_wire::Receiver<[u8]>,
    deeds: Sender<Deed>,
    bell: UnixStream,
    deeds_done: u64,
    settled: Arc<AtomicU64>,
    allocated: Arc<Mutex<Vec<u64>>>,
    captured: u64,
    _station: Station,
}

impl Bench {
    fn new(rig: &str, patience_ns: u64) -> Self {
        let (stop, _stopper) = Stop::by_another().expect("a stop");
        let station = station(rig, stop);
        let (deeds, done) = mpsc::channel();
        let (bell, heard) = UnixStream::pair().expect("a pair");
        let settled = Arc::new(AtomicU64::new(0));
        let allocated = Arc::new(Mutex::new(Vec::with_capacity(10_000)));
        let source = Scripted {
            deeds: done,
            bell: heard,
            slots: Vec::with_capacity(8),
            sequence: 0,
            settled: settled.clone(),
            allocated: allocated.clone(),
        };
        let bounds = Bounds {
            within_ns: Some(20 * MS),
            patience_ns,
        };
        let camera = DepthCamera::start(Box::new(source), bounds, domain, &station);
        let camera = camera.expect("it starts");
        let reader = lariat_wire::Receiver::create(&station.domain, &station.rig, &DEPTH, None);
        Self {
            camera: Some(camera),
            reader: reader.expect("a reader"),
            deeds,
            bell,
            deeds_done: 0,
            settled,
            allocated,
            captured: 0,
            _station: station,
        }
    }

    /// Performs an action and returns when it has taken effect. The effect of a fault is not
    /// visible here.
    fn does(&mut self, deed: Deed) {
        let is_fault = matches!(deed, Deed::Fault);
        self.deeds.send(deed).expect("its thread lives");
        self.bell.write_all(&[1]).expect("room");
        self.deeds_done += 1;
        let deadline = Instant::now() + Duration::from_secs(20);
        while !is_fault && self.settled.load(Ordering::SeqCst) < self.deeds_done {
            assert!(Instant::now() < deadline, "its thread stands still");
            std::thread::yield_now();
        }
    }

    /// Notes that capture has sent a frame exposed at this time.
    fn frame(&mut self, exposed_ns: u64) -> anyhow::Result<()> {
        self.captured += 1;
        let header = FrameHeader {
            trace: Trace {
                sequence: self.captured + 7,
                captured: self.captured,
                exposed_ns,
                captured_ns: now_ns(),
                ..Trace::EMPTY
            },
            width: 640,
            height: 480,
            stride: 640,
            ..FrameHeader::default()
        };
        self.camera.as_mut().expect("not ended").frame(&header)
    }

    /// Reads the next depth image. Returns the number of its frame and its value, or `None` for an
    /// empty one.
    fn read(&mut self) -> (u64, Option<u16>) {
        let deadline = Instant::now() + Duration::from_secs(20);
        let message = loop {
            if let Some(message) = self.reader.next().expect("readable") {
                break message;
            }
            assert!(Instant::now() < deadline, "none came");
            self.reader.sleep(Some(deadline), None).expect("asleep");
        };
        (message.header().trace.captured, value(&message))
    }

    fn end(&mut self) -> DepthCounts {
        self.camera
            .take()
            .expect("not ended")
            .end()
            .expect("no fault")
    }
}

fn value(message: &Message<[u8]>) -> Option<u16> {
    let header = message.header();
    assert_eq!(header.trace.sequence, header.trace.captured + 7);
    assert_eq!(header.format(), Some(PixelFormat::Gray16));
    if header.width == 0 {
        assert!(message.is_empty());
        return None;
    }
    assert_eq!([header.width, header.height], SIZE);
    assert_eq!(header.stride, STRIDE);
    assert!(message.len() >= BYTES);
    let value = u16::from_le_bytes([message[0], message[1]]);
    assert!(
        message
            .chunks_exact(2)
            .all(|pixel| pixel == value.to_le_bytes())
    );
    Some(value)
}

/// Longer than a test takes, but finite in case a test fails.
const NEVER: u64 = 30_000 * MS;

#[test]
fn each_frame_has_the_image_nearest_in_time_with_its_own_trace() {
    let mut bench = Bench::new("nearest", NEVER);
    bench.does(Deed::Image(1, 1_000 * MS));
    bench.frame(1_000 * MS).unwrap();
    assert_eq!(bench.read(), (1, Some(1)));
    bench.frame(1_033 * MS).unwrap();
    bench.does(Deed::Image(2, 1_031 * MS));
    bench.does(Deed::Image(3, 1_040 * MS));
    assert_eq!(bench.read(), (2, Some(2)));
    // Both neighbors are too far away.
    bench.frame(1_066 * MS).unwrap();
    bench.does(Deed::Image(4, 1_090 * MS));
    assert_eq!(bench.read(), (3, None));
    bench.does(Deed::Lost);
    bench.does(Deed::Image(5, 1_200 * MS));
    bench.frame(1_201 * MS).unwrap();
    bench.does(Deed::Image(6, 1_250 * MS));
    assert_eq!(bench.read(), (4, Some(5)));
    let counts = DepthCounts {
        images: 6,
        lost: 1,
        unpaired: 3,
    };
    assert_eq!(bench.end(), counts);
}

#[test]
fn an_image_is_that_of_as_many_frames_as_it_is_nearest_to() {
    let mut bench = Bench::new("twice", NEVER);
    for k in 0..30 {
        let begin_ns = (1_000 + 32 * k) * MS;
        bench.does(Deed::Image(k as u16, begin_ns + 20 * MS));
        for at_ms in [8, 24] {
            bench.frame(begin_ns + at_ms * MS).unwrap();
        }
        let first = 2 * k + 1;
        // The image of the second frame is known when the next image arrives.
        if k > 0 {
            assert_eq!(bench.read(), (first - 1, Some(k as u16 - 1)));
        }
        assert_eq!(bench.read(), (first, Some(k as u16)));
    }
    bench.does(Deed::Image(30, 5_000 * MS));
    assert_eq!(bench.read(), (60, Some(29)));
    assert_eq!(bench.end().unpaired, 1);
}

#[test]
fn no_frame_waits_for_long_and_none_at_all_for_a_silent_camera() {
    let mut bench = Bench::new("silent-depth", NEVER);
    bench.frame(1_000 * MS).unwrap();
    assert_eq!(bench.read(), (1, None), "it has not begun");
    bench.does(Deed::Image(1, 1_001 * MS));
    bench.frame(1_000 * MS + 1).unwrap();
    assert_eq!(bench.read(), (2, Some(1)));
    bench.frame(1_033 * MS).unwrap();
    bench.does(Deed::Silence);
    assert_eq!(bench.read(), (3, None));
    assert_eq!(bench.end().lost, 0);

    let mut bench = Bench::new("late-depth", MS);
    bench.does(Deed::Image(1, 1_000 * MS));
    bench.frame(1_000 * MS).unwrap();
    assert_eq!(bench.read(), (1, Some(1)));
    bench.frame(1_010 * MS).unwrap();
    assert_eq!(
        bench.read(),
        (2, Some(1)),
        "within the bound, and no nearer one has come"
    );
    bench.frame(1_040 * MS).unwrap();
    assert_eq!(bench.read(), (3, None));
}

#[test]
fn frames_that_wait_at_the_end_are_answered_and_a_fault_is_told_with_the_next_frame() {
    let mut bench = Bench::new("end-depth", 50 * MS);
    bench.does(Deed::Image(1, 1_000 * MS));
    bench.frame(1_000 * MS).unwrap();
    assert_eq!(bench.read(), (1, Some(1)));
    bench.frame(1_005 * MS).unwrap();
    bench.end();
    assert_eq!(bench.read(), (2, Some(1)));

    let mut bench = Bench::new("fault-depth", NEVER);
    bench.does(Deed::Fault);
    let deadline = Instant::now() + Duration::from_secs(20);
    let fault = loop {
        match bench.frame(1_000 * MS) {
            Err(fault) => break fault,
            Ok(()) => assert!(Instant::now() < deadline, "its thread goes on"),
        }
        std::thread::yield_now();
    };
    assert!(
        format!("{fault:#}").contains("the depth camera ended with a fault"),
        "{fault:#}"
    );
}

#[test]
fn an_image_allocates_nothing_but_the_transport_s_box_for_its_slot() {
    let mut bench = Bench::new("boxes", NEVER);
    for k in 0..300 {
        bench.does(Deed::Image(k as u16, (1_000 + 33 * k) * MS));
        bench.frame((1_001 + 33 * k) * MS).unwrap();
        if k > 0 {
            // The next image shows that no other is nearer.
            assert_eq!(bench.read(), (k, Some(k as u16 - 1)));
        }
    }
    let allocated = bench.allocated.lock().unwrap();
    let [begin, end] = [allocated.len() / 3, allocated.len() * 2 / 3];
    let count = allocated[end] - allocated[begin];
    // The camera is asked twice per image: when the image has arrived, and when the frame has
    // arrived.
    let images = (end - begin) as u64 / 2;
    assert!(
        count > 0 && count <= images + 1,
        "{count} for {images} images"
    );
    drop(allocated);
    // This image releases the last frame.
    bench.does(Deed::Image(0, 20_000 * MS));
    assert_eq!(bench.end().images, 301);
}

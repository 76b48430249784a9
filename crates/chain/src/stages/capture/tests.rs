use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::Duration;

use lariat_capture::{LentSlot, SourceError};
use lariat_wire::{Delivery, Domain, FRAMES, PixelFormat, Receiver, WireError};

use super::*;
use crate::settings::{Arrangement, Capture};
use crate::stages::handover::Handover;
use crate::stages::orders::Orders;
use crate::stages::status::Status;
use crate::stop::{Stop, Stopper};

const SIDE: u32 = 16;
const BYTES: usize = (SIDE * SIDE) as usize;

/// A uniformly gray frame that shows its number.
fn grey(sequence: u64) -> Frame {
    Frame {
        sequence,
        width: SIDE,
        height: SIDE,
        stride: SIDE,
        format: PixelFormat::Gray8,
        exposed_ns: None,
        slot: None,
    }
}

/// A source whose thread fills the slots that it is lent, `wanted` at a time.
struct Filled {
    wanted: usize,
    empty: Option<mpsc::Sender<LentSlot>>,
    full: mpsc::Receiver<LentSlot>,
    thread: Option<JoinHandle<()>>,
    sequence: u64,
}

impl Filled {
    fn new(wanted: usize) -> Self {
        let (empty, to_fill) = mpsc::channel::<LentSlot>();
        let (filled, full) = mpsc::channel();
        let thread = std::thread::spawn(move || {
            for (sequence, mut slot) in (1..).zip(to_fill) {
                slot.fill(sequence);
                if filled.send(slot).is_err() {
                    break;
                }
            }
        });
        Self {
            wanted,
            empty: Some(empty),
            full,
            thread: Some(thread),
            sequence: 0,
        }
    }
}

impl Drop for Filled {
    fn drop(&mut self) {
        drop(self.empty.take());
        let thread = self.thread.take().expect("joined once");
        thread.join().expect("the thread ends by itself");
    }
}

impl FrameSource for Filled {
    fn kind(&self) -> SourceKind {
        SourceKind::Rendered
    }

    fn largest_frame_bytes(&self) -> usize {
        // Longer than a frame, as a driver's buffers may be.
        BYTES + 100
    }

    fn slots_wanted(&self) -> usize {
        self.wanted
    }

    fn lend(&mut self, slot: LentSlot) {
        assert_eq!(slot.len(), self.largest_frame_bytes());
        let empty = self.empty.as_ref().expect("not dropped");
        empty.send(slot).expect("the thread listens");
    }

    fn advance(&mut self, _until: &Until) -> Result<Next, SourceError> {
        self.sequence += 1;
        let slot = self.full.recv().expect("the thread goes on");
        Ok(Next::Frame(Frame {
            slot: Some(slot.give_back()),
            ..grey(self.sequence)
        }))
    }

    fn write(&mut self, _pixels: &mut [u8]) {
        panic!("its pixels are in their slots");
    }
}

/// A source of frames with the given exposure times. Afterwards it is silent but does not end.
struct Live {
    exposed_ns: Vec<u64>,
    shown: u64,
}

impl FrameSource for Live {
    fn kind(&self) -> SourceKind {
        SourceKind::Camera
    }

    fn largest_frame_bytes(&self) -> usize {
        BYTES
    }

    fn advance(&mut self, until: &Until) -> Result<Next, SourceError> {
        let Some(&exposed_ns) = self.exposed_ns.get(self.shown as usize) else {
            until.wait(None, None);
            return Ok(Next::Nothing);
        };
        self.shown += 1;
        Ok(Next::Frame(Frame {
            exposed_ns: Some(exposed_ns),
            ..grey(self.shown)
        }))
    }

    fn write(&mut self, pixels: &mut [u8]) {
        pixels.fill(self.shown as u8);
    }
}

/// The test's part of a chain: a sender of a source's frames, and the reader of their channel.
struct Bench<'w> {
    sender: Sender<'w>,
    station: Station,
    changes: Changes<()>,
    stopper: Stopper,
    reader: Receiver<[u8]>,
}

impl Bench<'_> {
    fn send_all(&mut self, most: u64) {
        let sent = (self.sender).send_all(&mut self.station, &self.changes, most);
        sent.expect("sent");
    }
}

pub(super) fn domain() -> Result<Domain, WireError> {
    Domain::named(&format!("f{}", std::process::id()))
}

pub(super) fn station(rig: &str, stop: Stop) -> Station {
    Station {
        domain: domain().expect("a domain"),
        rig: rig.parse().expect("a plain name"),
        delivery: Delivery::NewestWins,
        stop,
        status: Status::of_the_chain().expect("none"),
        handover: Handover::default(),
        version: 0,
        orders: Orders::default(),
        arrangement: Arrangement::default(),
        stage: None,
        name: "capture",
        settings: String::new(),
        reads: Default::default(),
        undelivered: Default::default(),
        announcement: None,
    }
}

fn with_sender(
    rig: &str,
    source: Box<dyn FrameSource>,
    lasts_ns: Option<u64>,
    test: impl FnOnce(Bench),
) {
    let (stop, stopper) = Stop::by_another().expect("a stop");
    let station = station(rig, stop);
    let domain = || domain().expect("a domain");
    let frames = slot_lender::writer(&station, source.as_ref()).expect("a writer");
    let reader = Receiver::create(&domain(), &station.rig, &FRAMES, None).expect("a reader");
    let changes = Orders::default().listen(&Settings::default(), |_, _| Ok(None));
    let sender = Sender {
        depths: None,
        lender: SlotLender::new(source, &frames).expect("slots"),
        truth: None,
        truth3: None,
        // One frame in a hundred days, so a frame that is paced would never come.
        schedule: schedule(Fps::PerSecond(1e-7), false),
        sent: Sent::default(),
        ahead: 0,
        restarts: 0,
        lasts_ns,
        end_ns: None,
        punctuality: None,
    };
    test(Bench {
        sender,
        station,
        changes: changes.expect("no thread is needed"),
        stopper,
        reader,
    });
}

fn schedule(fps: Fps, lossless: bool) -> Schedule {
    let settings = Capture {
        fps,
        ..Capture::default()
    };
    Schedule::new(&settings, lossless).expect("a pace")
}

#[test]
fn slots_that_a_thread_fills_are_sent_as_they_are_and_lent_again() {
    for wanted in [1, 3] {
        let rig = format!("filled{wanted}");
        with_sender(&rig, Box::new(Filled::new(wanted)), None, |mut bench| {
            bench.sender.schedule = schedule(Fps::Max, false);
            // More frames than the channel has slots in shared memory.
            for sequence in 1..=60 {
                bench.send_all(sequence);
                let frame = bench.reader.next().expect("readable").expect("a frame");
                let header = frame.header();
                assert_eq!(header.trace.sequence, sequence);
                assert_eq!(header.trace.captured, sequence);
                assert_eq!((header.width, header.stride), (SIDE, SIDE));
                assert_eq!(frame.len(), BYTES + 100);
                assert!(frame.iter().all(|&byte| u64::from(byte) == sequence));
            }
        });
    }
}

#[test]
fn a_live_frame_is_sent_when_it_comes_and_keeps_its_own_time() {
    let exposed_ns = vec![now_ns() - 7_000, now_ns() - 5_000, now_ns() - 3_000];
    let source = Live {
        exposed_ns: exposed_ns.clone(),
        shown: 0,
    };
    with_sender("live", Box::new(source), None, |mut bench| {
        bench.send_all(3);
        for exposed_ns in exposed_ns {
            let trace = bench
                .reader
                .next()
                .unwrap()
                .expect("a frame")
                .header()
                .trace;
            assert_eq!(trace.exposed_ns, exposed_ns);
            assert!(trace.captured_ns >= exposed_ns);
        }
    });
}

#[test]
fn a_source_without_frames_is_waited_for_until_the_stage_is_stopped() {
    let source = Live {
        exposed_ns: Vec::new(),
        shown: 0,
    };
    with_sender("silent", Box::new(source), None, |mut bench| {
        let Bench {
            sender,
            station,
            changes,
            stopper,
            ..
        } = &mut bench;
        std::thread::scope(|scope| {
            scope.spawn(|| stopper.stop());
            sender.send_all(station, changes, 1).expect("it ends");
        });
        assert_eq!(sender.sent, Sent::default());
    });
}

#[test]
fn a_source_without_frames_is_not_waited_for_longer_than_the_chain_lasts() {
    let source = Live {
        exposed_ns: vec![now_ns()],
        shown: 0,
    };
    with_sender("short", Box::new(source), Some(5_000_000), |mut bench| {
        bench.send_all(9);
        assert_eq!(bench.sender.sent.count, 1);
    });
}

/// A source whose second frame takes a fifth of a second.
struct Slow(u64);

impl FrameSource for Slow {
    fn kind(&self) -> SourceKind {
        SourceKind::Files
    }

    fn largest_frame_bytes(&self) -> usize {
        BYTES
    }

    fn advance(&mut self, _until: &Until) -> Result<Next, SourceError> {
        self.0 += 1;
        if self.0 == 2 {
            // The test needs a late frame, so this sleep is not a wait for anything.
            std::thread::sleep(Duration::from_millis(200));
        }
        Ok(Next::Frame(grey(self.0)))
    }

    fn write(&mut self, _pixels: &mut [u8]) {}
}

#[test]
fn moments_that_a_slow_source_lets_pass_are_frames_lost_at_the_source() {
    for lossless in [false, true] {
        let rig = format!("slow{}", u8::from(lossless));
        with_sender(&rig, Box::new(Slow(0)), None, |mut bench| {
            bench.sender.schedule = schedule(Fps::PerSecond(1000.0), lossless);
            let mut sequences = [0; 2];
            for (sent, sequence) in (1..).zip(&mut sequences) {
                bench.send_all(sent);
                let frame = bench.reader.next().expect("readable").expect("a frame");
                *sequence = frame.header().trace.sequence;
            }
            assert_eq!(sequences[0], 1);
            if lossless {
                assert_eq!(sequences[1], 2);
            } else {
                assert!(sequences[1] >= 200, "{}", sequences[1]);
            }
            assert_eq!(bench.sender.sent.last_sequence, sequences[1]);
        });
    }
}

#![allow(unsafe_code)] // Setting the domain in the environment is unsafe.
//! Test that none of the four stages allocates per frame once warm. The real stages run as threads
//! of the test.
//!
//! The transport does allocate: iceoryx2 0.10 keeps each slot that it lends in a small box, created
//! with the loan and freed on sending. There is one box per message. The test recognizes these
//! boxes by their size and counts them separately.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use lariat_wire::{DESCRIPTORS, Delivery, Descriptors, Domain, Receiver, Rig, Writer};
use rustix::process::{Signal, getpid, kill_process};

use super::handover::Handover;
use super::{Supervision, capture, extract, fit, sink};
use crate::settings::{Fps, Settings};

type Stage = fn(&Settings, Supervision) -> anyhow::Result<()>;

const STAGES: [(&str, Stage); 4] = [
    ("sink", sink::run),
    ("fit", fit::run),
    ("extract", extract::run),
    ("capture", capture::run),
];

/// Messages that a stage sends per frame. The second message of capture is the truth.
const MESSAGES: [u64; STAGES.len()] = [0, 1, 1, 2];

/// True while allocations are counted.
static WARM: AtomicBool = AtomicBool::new(false);
/// Measured size of the box that the transport allocates for a slot, in bytes.
static LENT: AtomicUsize = AtomicUsize::new(0);
static ALLOCATIONS: [AtomicU64; STAGES.len()] = [const { AtomicU64::new(0) }; STAGES.len()];
static LOANS: [AtomicU64; STAGES.len()] = [const { AtomicU64::new(0) }; STAGES.len()];

thread_local! {
    /// Stage that runs on this thread.
    static STAGE: Cell<Option<usize>> = const { Cell::new(None) };
    /// True while this thread measures the allocation of a slot.
    static MEASURES: Cell<bool> = const { Cell::new(false) };
}

fn count(bytes: usize) {
    if MEASURES.get() {
        LENT.store(bytes, Ordering::Relaxed);
    }
    if let (true, Some(stage)) = (WARM.load(Ordering::Relaxed), STAGE.get()) {
        let is_loan = bytes == LENT.load(Ordering::Relaxed);
        let counter = if is_loan { &LOANS } else { &ALLOCATIONS };
        counter[stage].fetch_add(1, Ordering::Relaxed);
    }
}

/// Lends a slot to measure what the transport allocates for it.
fn measure_a_loan() {
    let domain = Domain::open().expect("a domain");
    let rig = "measured".parse().expect("a plain name");
    let writer = Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins);
    let writer = writer.expect("a writer");
    drop(writer.slot().expect("a slot"));
    MEASURES.set(true);
    let slot = writer.slot();
    MEASURES.set(false);
    drop(slot.expect("a slot"));
}

#[test]
fn no_stage_allocates_per_frame_once_warm() {
    let domain = format!("a{}", std::process::id());
    // SAFETY: Only the standard library accesses the environment of this process, and does so under
    // a lock.
    unsafe { std::env::set_var("LARIAT_DOMAIN", &domain) };
    lariat_test_support::watch(count);
    measure_a_loan();
    let mut settings = Settings::default();
    settings.sink.live = false;
    settings.capture.fps = Fps::PerSecond(100.0);
    // The sink also keeps a report up to date from a separate thread, and each stage writes its
    // handover state.
    let report = tempfile::tempdir().expect("a folder");
    settings.run.out = Some(report.path().join("report"));
    let mut frames = 0;
    std::thread::scope(|scope| {
        for (index, (_, run)) in STAGES.iter().enumerate() {
            let settings = &settings;
            scope.spawn(move || {
                STAGE.set(Some(index));
                let supervision = Supervision {
                    handover: Handover::make("stage").expect("memory"),
                    ..Supervision::of_this_process().expect("a supervision")
                };
                run(settings, supervision).expect("the stage runs");
            });
        }
        let domain = Domain::open().expect("a domain");
        let reader = Receiver::descriptors(&domain, &Rig::default()).expect("a reader");
        // Waits for a frame, and returns how many frames capture had sent by then.
        let wait_for = |fitted: u64| loop {
            let message = reader.wait(Instant::now() + Duration::from_secs(60));
            let message = message.expect("readable").expect("a descriptor");
            if message.trace.fitted >= fitted {
                break message.trace.captured;
            }
        };
        // The rope crosses itself for the first time while allocations are counted, 5 s into its
        // motion.
        let begin = wait_for(200);
        WARM.store(true, Ordering::SeqCst);
        let end = wait_for(900);
        WARM.store(false, Ordering::SeqCst);
        frames = end - begin;
        kill_process(getpid(), Signal::TERM).expect("a signal to itself");
    });
    let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{domain}"));
    for (stage, (name, _)) in STAGES.iter().enumerate() {
        assert_eq!(
            ALLOCATIONS[stage].load(Ordering::SeqCst),
            0,
            "{name} allocated"
        );
        let loans = LOANS[stage].load(Ordering::SeqCst);
        // Capture is some frames ahead of this reader when counting starts and ends, and further
        // ahead on a loaded machine. A second box per message would still be noticed.
        let most = MESSAGES[stage] * frames * 3 / 2;
        assert!(loans <= most, "{name}: {loans} for {frames} frames");
    }
}

//! The other processes, which write and read.

use std::io::Read;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::RelaySender;
use crate::Samples;
use anyhow::Result;
use lariat_wire::{
    DESCRIPTORS, Delivery, Descriptor, Descriptors, Domain, Reader, Rig, Writer, now_ns,
};
use serde::{Deserialize, Serialize};

/// One process's part in the measurement.
#[derive(clap::Args)]
pub(crate) struct PartArgs {
    what: What,
    /// Messages per second
    #[arg(long, default_value_t = 100.0)]
    rate: f64,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum What {
    /// Write descriptors
    Write,
    /// Send 64 bytes through bare iceoryx2
    Relay,
    /// Wait for descriptors, and print what arrived
    Read,
}

/// Results of a reader.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Saw {
    /// Number of messages received.
    pub(super) frames: u64,
    /// Number of messages missed between the first and the last.
    pub(super) missed: u64,
    /// Median time from the fit stage's timestamp until the reader has the message.
    pub(super) p50_us: f64,
    pub(super) p99_us: f64,
}

/// Runs the part until standard input ends.
pub(crate) fn part(args: &PartArgs) -> Result<()> {
    let ended = Arc::new(AtomicBool::new(false));
    let input = ended.clone();
    std::thread::spawn(move || {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        input.store(true, Ordering::Relaxed);
    });
    match args.what {
        What::Write => write(args.rate, &ended),
        What::Relay => relay(args.rate, &ended),
        What::Read => read(&ended),
    }
}

/// Calls `work` at a fixed rate, with sleeps in between.
fn beat(rate: f64, ended: &AtomicBool, mut work: impl FnMut(u64) -> Result<()>) -> Result<()> {
    let period = Duration::from_secs_f64(1.0 / rate.max(0.1));
    let mut due = Instant::now();
    let mut number = 0;
    while !ended.load(Ordering::Relaxed) {
        // The sleep is the sender's schedule.
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        due += period;
        number += 1;
        work(number)?;
    }
    Ok(())
}

fn write(rate: f64, ended: &AtomicBool) -> Result<()> {
    let domain = Domain::open()?;
    let writer = Writer::<Descriptors>::create(
        &domain,
        &Rig::default(),
        &DESCRIPTORS,
        &Delivery::NewestWins,
    )?;
    let rope = rope();
    beat(rate, ended, |number| {
        let mut slot = writer.slot()?;
        slot.count = 1;
        slot.curves[0] = rope;
        (slot.trace.extracted, slot.trace.fitted) = (number, number);
        slot.trace.exposed_ns = now_ns();
        slot.trace.fitted_ns = now_ns();
        slot.send()?;
        Ok(())
    })
}

/// Returns a wavy rope of order 8.
fn rope() -> Descriptor {
    let mut rope = Descriptor::EMPTY;
    (rope.degree, rope.count, rope.samples) = (8, 9, 120);
    for (j, point) in rope.control_points[..9].iter_mut().enumerate() {
        let t = j as f64 / 8.0;
        *point = [100.0 + 400.0 * t, 240.0 + 100.0 * (7.0 * t).sin()];
    }
    rope
}

fn relay(rate: f64, ended: &AtomicBool) -> Result<()> {
    let domain = Domain::open()?;
    let sender = RelaySender::create(&domain, 0)?;
    beat(rate, ended, |number| {
        let mut message = [number; 8];
        message[0] = now_ns();
        sender.send(message)
    })
}

fn read(ended: &AtomicBool) -> Result<()> {
    let mut reader = Reader::open("default")?;
    let mut latency_us = Samples::default();
    let (mut first, mut last) = (None, 0);
    while !ended.load(Ordering::Relaxed) {
        let frame = reader.wait(Instant::now() + Duration::from_millis(100))?;
        let now_ns = now_ns();
        if let (Some(message), true) = (frame.message(), frame.is_new()) {
            latency_us.push((now_ns - message.trace.fitted_ns) as f64 / 1e3);
            last = message.trace.fitted;
            first.get_or_insert(last);
        }
    }
    let frames = latency_us.count() as u64;
    let saw = Saw {
        frames,
        missed: first.map_or(0, |first| last - first + 1 - frames),
        p50_us: latency_us.percentile(0.5),
        p99_us: latency_us.percentile(0.99),
    };
    println!("{}", serde_json::to_string(&saw)?)?;
    Ok(())
}

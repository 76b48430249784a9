//! Capture as a process: a source's frames, written into shared memory and sent when they are due.

use anyhow::Context;
use lariat_capture::{FrameSource, Pacer};
use lariat_wire::{Centerlines, FrameHeader, SourceKind, TRUTH, Trace, Writer, now_ns};

use super::Station;
use super::status::Sent;
use crate::settings::{Fps, Settings};

/// Sends frames until the source or its time ends, or a signal comes.
pub(crate) fn run(settings: &Settings) -> anyhow::Result<()> {
    let mut station = Station::open(settings, "capture")?;
    let mut source = lariat_capture::open(&settings.capture.source(settings.extract.points))?;
    let mut pacer = Pacer::new(settings.capture.pace())?;
    let Station {
        domain,
        rig,
        delivery,
        ..
    } = &station;
    let frames = Writer::frames(domain, rig, delivery, source.largest_frame_bytes())?;
    let truth = source
        .has_truth()
        .then(|| Writer::<Centerlines>::create(domain, rig, &TRUTH, delivery))
        .transpose()?;
    tell_of_another_pace(settings, source.as_ref());
    precise_timer();
    station.ready()?;
    let result = send_frames(
        settings,
        &station,
        source.as_mut(),
        &mut pacer,
        &frames,
        truth.as_ref(),
    );
    let (sent, outcome) = result;
    if outcome.is_ok() && !station.stop.asked() {
        station.status.done();
    }
    station.status.sent(sent);
    outcome
}

fn send_frames(
    settings: &Settings,
    station: &Station,
    source: &mut dyn FrameSource,
    pacer: &mut Pacer,
    frames: &Writer<[u8]>,
    truth: Option<&Writer<Centerlines>>,
) -> (Sent, anyhow::Result<()>) {
    let mut sent = Sent::default();
    let mut outcome = Ok(());
    let most = settings.run.frames.unwrap_or(u64::MAX);
    let mut end_ns = None;
    let mut rest = station.rest();
    while sent.count < most && !station.stop.asked() {
        rest.if_due(now_ns());
        let mut wait_for = |due_ns| {
            let duration_ns = settings.run.duration_ns();
            let is_over = duration_ns
                .is_some_and(|lasts_ns| due_ns >= *end_ns.get_or_insert(due_ns + lasts_ns));
            !is_over && rest.while_waiting(|| station.stop.sleep_until(due_ns))
        };
        match send_next(source, pacer, frames, truth, &mut sent, &mut wait_for) {
            Ok(true) => {}
            Ok(false) => break,
            Err(cause) => {
                outcome = Err(cause);
                break;
            }
        }
    }
    (sent, outcome)
}

/// Sends one frame; `false` when there is none, its time is over, or a signal came.
///
/// `wait_for`: sleeps until the frame is due; `false` if that is not to be waited for.
fn send_next(
    source: &mut dyn FrameSource,
    pacer: &mut Pacer,
    frames: &Writer<[u8]>,
    truth: Option<&Writer<Centerlines>>,
    sent: &mut Sent,
    wait_for: &mut impl FnMut(u64) -> bool,
) -> anyhow::Result<bool> {
    let next = source.next().context("the source ended with a fault")?;
    while let Some(warning) = source.take_warning() {
        tracing::warn!("{warning}");
    }
    let Some(frame) = next else { return Ok(false) };
    // Everything is in its place before the frame is due: then only the sending is left.
    let mut slot = frames.frame_slot(frame.bytes())?;
    source.write(&mut slot);
    let truth_slot = match truth {
        None => None,
        Some(writer) => {
            let mut slot = writer.slot()?;
            source.truth(&mut slot).then_some(slot)
        }
    };
    let due_ns = pacer.next_due_ns(now_ns());
    if !wait_for(due_ns) {
        return Ok(false);
    }
    sent.count += 1;
    sent.last_sequence = frame.sequence;
    let trace = Trace {
        sequence: frame.sequence,
        captured: sent.count,
        exposed_ns: due_ns,
        captured_ns: now_ns(),
        ..Trace::EMPTY
    };
    *slot.header_mut() = FrameHeader {
        trace,
        width: frame.width,
        height: frame.height,
        stride: frame.stride,
        pixel_format: frame.format as u32,
        source: source.kind() as u32,
        reserved: [0; 7],
    };
    slot.send()?;
    if let Some(mut slot) = truth_slot {
        slot.trace = trace;
        slot.send()?;
    }
    // The kernel takes the waking of a socket's reader as a sign that the waker is about to sleep, and puts the reader on
    // the waker's core; but capture goes on to make the next frame. So it lets the reader go first.
    std::thread::yield_now();
    Ok(true)
}

/// A video that was made for another rate is shown at the one that is set; the user may not have known.
fn tell_of_another_pace(settings: &Settings, source: &dyn FrameSource) {
    if let (Some(native), Fps::PerSecond(fps), SourceKind::Video) =
        (source.native_fps(), settings.capture.fps, source.kind())
        && (native - fps).abs() > 0.01 * fps
    {
        tracing::info!(
            "the video was made for {native:.2} frames/s and is sent at {fps}: --fps {native:.2} shows it as it was"
        );
    }
}

/// Lets a wait end when it is due: the kernel otherwise takes 50 µs of leeway. Not to be had is no fault.
fn precise_timer() {
    let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1));
}

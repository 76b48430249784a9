//! The capture process: writes a source's frames to shared memory and sends them when they are due.

mod depths;
mod punctual;

use std::os::fd::AsFd;

use anyhow::Context;
use lariat_capture::{Frame, FrameSource, Next, Source, SourceError, Until};
use lariat_wire::{
    Centerlines, Command, CommandReader, Delivery, Descriptors3, Domain, SourceKind, TRUTH, TRUTH3,
    Trace, Writer, now_ns,
};

use super::arrangement::precise_timer;
use super::orders::Changes;
use super::slot_lender::{self, SlotLender};
use super::status::{Sent, Word};
use super::{Station, Supervision};
use crate::pipeline::{Schedule, frame_header};
use crate::settings::{Fps, Settings, Stage};
use depths::{DepthSlot, Depths};
use punctual::Punctuality;

/// Interval at which capture shows that it is alive if nothing else does.
const BEAT_NS: u64 = 1_000_000_000;
/// Interval at which a restarted capture looks for a missing camera.
const LOOK_AGAIN_NS: u64 = 200_000_000;

/// Sends frames until the source ends, the running time is over, or a signal arrives.
pub fn run(settings: &Settings, supervision: Supervision) -> anyhow::Result<()> {
    let mut station = Station::open(settings, Stage::Capture, supervision)?;
    let before = station.handover.progress();
    let Some((mut source, depth_camera)) = open_again(settings, &mut station, before.restarts)?
    else {
        if !station.stop.asked() {
            station.status.say(Word::Done);
        }
        station.status.say(Word::Sent(before.sent));
        return Ok(());
    };
    let goes_on = before.restarts > 0 && source.pass_over(before.taken)?;
    // Offset from the source's own frame numbers to those sent.
    let ahead = match goes_on {
        true => before.sent.last_sequence - before.taken,
        false => before.sent.last_sequence,
    };
    let first = match source.largest_frame_bytes() {
        // The size of the frames is known when the first one arrives.
        0 => {
            station.ready()?;
            let Some(first) = wait_for_first(settings, source.as_mut(), &mut station)? else {
                if !station.stop.asked() {
                    station.status.say(Word::Done);
                }
                station.status.say(Word::Sent(Sent::default()));
                return Ok(());
            };
            Some(first)
        }
        _ => None,
    };
    let frames = slot_lender::writer(&station, source.as_ref())?;
    let Station {
        domain,
        rig,
        delivery,
        ..
    } = &station;
    let own_depth = source.depth_size();
    let truth = (source.has_truth())
        .then(|| Writer::<Centerlines>::create(domain, rig, &TRUTH, delivery))
        .transpose()?;
    let truth3 = (source.has_truth() && own_depth.is_some())
        .then(|| Writer::<Descriptors3>::create(domain, rig, &TRUTH3, delivery))
        .transpose()?;
    let depths = Depths::open(settings, &station, depth_camera, own_depth)?;
    tell_of_another_pace(settings, source.as_ref());
    precise_timer();
    let mut sender = Sender {
        lender: SlotLender::new(source, &frames)?,
        truth: truth.as_ref(),
        truth3: truth3.as_ref(),
        depths,
        schedule: Schedule::new(
            &settings.capture,
            matches!(station.delivery, Delivery::Lossless { .. }),
        )?,
        sent: before.sent,
        ahead,
        restarts: before.restarts,
        lasts_ns: settings.run.duration_ns(),
        end_ns: None,
        punctuality: (!settings.run.arrangement.realtime).then(Punctuality::default),
    };
    // A change of capture's settings restarts it. Other changes only update the version.
    let changes = station.listen(settings, |_, _| Ok(None::<()>))?;
    if let Some(first) = first {
        sender.send(&first, &mut station, &mut |_, _| true)?;
    } else {
        station.ready()?;
    }
    let most = settings.run.frames.unwrap_or(u64::MAX);
    let outcome = sender.send_all(&mut station, &changes, most);
    let sent = sender.sent;
    let depths = sender.depths.take();
    // Stop the camera and join the thread before the last status message.
    drop(sender);
    let ended = depths.map_or(Ok(None), Depths::end);
    let outcome = outcome.and_then(|()| {
        if let Some(counts) = ended? {
            station.status.say(Word::Depths(counts));
        }
        Ok(())
    });
    if outcome.is_ok() && !station.stop.asked() {
        station.status.say(Word::Done);
    }
    station.status.say(Word::Sent(sent));
    outcome.and_then(|()| station.assert_all_delivered())
}

/// A source, and its depth camera if there is one.
type Sources = (Box<dyn FrameSource>, Option<Box<dyn FrameSource>>);

/// Opens the source. If a predecessor used a camera, waits for it, for example after it was
/// unplugged. Returns `None` if a signal arrives or the running time ends first.
fn open_again(
    settings: &Settings,
    station: &mut Station,
    restarts: u64,
) -> anyhow::Result<Option<Sources>> {
    let lasts_ns = settings.run.duration_ns();
    let end_ns = lasts_ns.map_or(u64::MAX, |lasts_ns| now_ns().saturating_add(lasts_ns));
    let mut is_told = false;
    while !station.stop.asked() && now_ns() < end_ns {
        let cause = match open_both(settings, station) {
            Ok(sources) => return Ok(Some(sources)),
            Err(cause) => cause,
        };
        let error = cause.downcast_ref::<SourceError>();
        if restarts == 0 || !error.is_some_and(SourceError::is_of_an_absent_camera) {
            return Err(cause);
        }
        if !std::mem::replace(&mut is_told, true) {
            tracing::warn!("{cause}; it is waited for until it comes back");
        }
        station.handover.beat();
        station.stop.sleep_until(now_ns() + LOOK_AGAIN_NS);
    }
    Ok(None)
}

/// Opens the source, and a depth camera at the same frame rate.
fn open_both(settings: &Settings, station: &Station) -> anyhow::Result<Sources> {
    let source = open(settings, station)?;
    let options = depths::camera_options(settings, source.native_fps())?;
    let depth = options.map(|options| lariat_capture::open(&Source::Camera(options)));
    Ok((source, depth.transpose()?))
}

/// Opens the source. A simulated robot reads the commands of its rig.
fn open(settings: &Settings, station: &Station) -> anyhow::Result<Box<dyn FrameSource>> {
    let source = settings.source();
    let Source::Simulated(options) = &source else {
        return Ok(lariat_capture::open(&source)?);
    };
    let reader = CommandReader::open(Domain::open()?, &station.rig)?;
    let mut is_broken = false;
    let commands = move || -> Option<Command> {
        reader.next().unwrap_or_else(|cause| {
            if !std::mem::replace(&mut is_broken, true) {
                tracing::warn!("the robot stands still, as its commands cannot be read: {cause}");
            }
            None
        })
    };
    Ok(lariat_capture::open_simulated(options, Box::new(commands))?)
}

struct Sender<'w> {
    lender: SlotLender<'w>,
    truth: Option<&'w Writer<Centerlines>>,
    truth3: Option<&'w Writer<Descriptors3>>,
    depths: Option<Depths>,
    schedule: Schedule,
    sent: Sent,
    /// Offset from the source's frame numbers to those sent.
    ahead: u64,
    /// Number of restarts of capture.
    restarts: u64,
    /// Time for which frames are sent, counted from when the first one is due, or from the start if
    /// none arrives.
    lasts_ns: Option<u64>,
    /// End of that time.
    end_ns: Option<u64>,
    /// Counts late wake-ups of a source without realtime priority.
    punctuality: Option<Punctuality>,
}

impl Sender<'_> {
    /// Sends up to `most` frames.
    fn send_all(
        &mut self,
        station: &mut Station,
        changes: &Changes<()>,
        most: u64,
    ) -> anyhow::Result<()> {
        let began_ns = now_ns();
        let mut rest = station.rest();
        while self.sent.count < most && !station.stop.asked() {
            station.change(changes);
            rest.if_due(now_ns());
            let latest_ns = self.lasts_ns.map(|lasts_ns| began_ns + lasts_ns);
            let deadline_ns = self.end_ns.or(latest_ns);
            // Show the supervisor that capture is alive.
            let beat_ns = station.handover.is_held().then(|| now_ns() + BEAT_NS);
            let until_ns = deadline_ns.into_iter().chain(beat_ns).min();
            let until = Until::new(until_ns, station.stop.as_fd());
            let next = self.lender.source.advance(&until);
            rest.has_waited(until.waited_ns());
            tell(self.lender.source.as_mut());
            match next.context("the source ended with a fault")? {
                Next::Frame(frame) => {
                    let mut wait = |station: &mut Station, due_ns| {
                        rest.while_waiting(|| wait_until(station, due_ns))
                    };
                    if !self.send(&frame, station, &mut wait)? {
                        break;
                    }
                }
                Next::Nothing if deadline_ns.is_some_and(|end_ns| now_ns() >= end_ns) => break,
                Next::Nothing => station.handover.beat(),
                Next::End => break,
            }
        }
        Ok(())
    }

    /// Sends one frame. Returns `false` when the running time is over or a signal arrives.
    ///
    /// `wait` sleeps until the frame is due. It returns `false` if a signal arrives.
    fn send(
        &mut self,
        frame: &Frame,
        station: &mut Station,
        wait: &mut impl FnMut(&mut Station, u64) -> bool,
    ) -> anyhow::Result<bool> {
        // Prepare everything before the frame is due, so that only the sending is left.
        let mut slot = self.lender.slot_of(frame)?;
        let truth_slot = match self.truth {
            None => None,
            Some(writer) => {
                let mut slot = writer.slot()?;
                self.lender.source.truth(&mut slot).then_some(slot)
            }
        };
        let truth3_slot = match self.truth3 {
            None => None,
            Some(writer) => {
                let mut slot = writer.slot()?;
                (self.lender.source.truth_in_space(&mut slot)).then_some(slot)
            }
        };
        let depth_slot = match &mut self.depths {
            None => None,
            Some(depths) => depths.slot(frame.sequence, self.lender.source.as_mut())?,
        };
        // A frame with its own exposure time is sent immediately.
        let is_live = frame.exposed_ns.is_some();
        let after_ns = self.lender.source.due_after_ns();
        let ready_ns = now_ns();
        let due_ns = self.schedule.due_ns(ready_ns, frame.exposed_ns, after_ns);
        let end_ns = |lasts_ns| *self.end_ns.get_or_insert(due_ns.saturating_add(lasts_ns));
        let is_over = self
            .lasts_ns
            .map(end_ns)
            .is_some_and(|end_ns| due_ns >= end_ns);
        if is_over || !(is_live || wait(station, due_ns)) {
            return Ok(false);
        }
        if let (false, Some(punctuality)) = (is_live, &mut self.punctuality)
            && punctuality.is_starved(ready_ns, due_ns, now_ns())
        {
            tracing::warn!(
                "capture is woken more than a period late for over 1 % of the frames, as other programs use the cores: give the \
                 chain realtime priority (--realtime), or choose fewer frames/s"
            );
        }
        self.sent.count += 1;
        self.sent.last_sequence = self.ahead + self.schedule.sequence(frame);
        let mut trace = Trace {
            sequence: self.sent.last_sequence,
            captured: self.sent.count,
            exposed_ns: due_ns,
            captured_ns: now_ns(),
            settings: station.version,
            ..Trace::EMPTY
        };
        trace.set_restarts(0, self.restarts);
        station.handover.note(self.sent, frame.sequence);
        let header = frame_header(frame, self.lender.source.kind(), trace);
        *slot.header_mut() = header;
        // Send the depth image first, so that it is there when the frame arrives.
        if let Some(DepthSlot { size, mut slot }) = depth_slot {
            *slot.header_mut() = header.of_depth(size);
            station.note(slot.send()?);
        }
        station.note(slot.send()?);
        if let Some(depths) = &mut self.depths {
            depths.sent(&header)?;
        }
        if let Some(mut slot) = truth_slot {
            slot.trace = trace;
            station.note(slot.send()?);
        }
        if let Some(mut slot) = truth3_slot {
            slot.trace = trace;
            station.note(slot.send()?);
        }
        // The kernel assumes that a thread that wakes a socket's reader is about to sleep, and puts
        // the reader on its core. Capture continues with the next frame instead, so it yields to
        // the reader.
        std::thread::yield_now();
        self.lender.lend()?;
        Ok(true)
    }
}

/// Sleeps until a frame is due. Returns `false` if a signal arrives.
fn wait_until(station: &mut Station, due_ns: u64) -> bool {
    while station.handover.is_held() && due_ns > now_ns() + BEAT_NS {
        if !station.stop.sleep_until(now_ns() + BEAT_NS) {
            return false;
        }
        station.handover.beat();
    }
    station.stop.sleep_until(due_ns)
}

/// Waits for the first frame of a source. Returns `None` if the running time ends or the chain is
/// stopped before.
fn wait_for_first(
    settings: &Settings,
    source: &mut dyn FrameSource,
    station: &mut Station,
) -> anyhow::Result<Option<Frame>> {
    let lasts_ns = settings.run.duration_ns();
    let deadline_ns = lasts_ns.map(|lasts_ns| now_ns().saturating_add(lasts_ns));
    loop {
        let beat_ns = station.handover.is_held().then(|| now_ns() + BEAT_NS);
        let until_ns = deadline_ns.into_iter().chain(beat_ns).min();
        let next = source.advance(&Until::new(until_ns, station.stop.as_fd()));
        station.handover.beat();
        tell(source);
        match next.context("the source ended with a fault")? {
            Next::Frame(frame) => return Ok(Some(frame)),
            Next::Nothing => {
                let is_over = deadline_ns.is_some_and(|end_ns| now_ns() >= end_ns);
                if is_over || station.stop.asked() {
                    return Ok(None);
                }
            }
            Next::End => return Ok(None),
        }
    }
}

/// Logs the warnings and news of the source.
fn tell(source: &mut dyn FrameSource) {
    while let Some(warning) = source.take_warning() {
        tracing::warn!("{warning}");
    }
    while let Some(news) = source.take_news() {
        tracing::info!("{news}");
    }
}

/// Reports that a video was made for a different frame rate than the settings say, because the user
/// may not know.
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

#[cfg(test)]
mod tests;

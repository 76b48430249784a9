//! The recorder as a process: reads every channel of a rig and passes the messages to the writing
//! thread.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

use anyhow::{Context, Result};
use lariat_extract::Mask;
use lariat_record::{
    Clock, Ended, Existing, Flushed, Head, Losses, Options, Recorder, RingOptions, Writer,
};
use lariat_sink::{FinalCounts, Ledger};
use lariat_wire::{Descriptors, FRAMES, now_ns};
use signal_hook::consts::SIGUSR1;

use super::about::{self, Rig};
use super::channels::{Channels, Counters};
use super::{STAGE, report};
use lariat_chain::calibrated::Calibrated;
use lariat_chain::places::Places;
use lariat_chain::run_files::check_recording;
use lariat_chain::settings::{Camera, Settings};
use lariat_chain::stages::orders::Changes;
use lariat_chain::stages::status::{LastWord, Word};
use lariat_chain::stages::{Station, Supervision, arrangement};

/// Interval at which losses are recorded, if there are new ones.
const LOSSES_EVERY: Duration = Duration::from_secs(1);

/// Records until a signal arrives, the requested amount is recorded, or space runs out.
pub(super) fn run(settings: &Settings, file: &Path, supervision: Supervision) -> Result<ExitCode> {
    check_recording(settings, file)?;
    // Called before any thread starts, because threads inherit the placement of this one.
    arrangement::keep_apart(&settings.run.arrangement);
    let mut station = Station::beside(settings, STAGE, supervision)?;
    let supervised = station.status.is_supervised();
    // Other rigs may get their masks from elsewhere.
    let masks = !supervised || settings.extract.mask == Mask::External;
    // A restarted recorder has missed the beginning.
    let from_start =
        supervised && !settings.capture.is_external() && station.handover.progress().restarts == 0;
    let camera = &settings.camera;
    let space = !supervised || camera.depth.is_some() || camera.second.is_some();
    let is_brief = supervised && settings.capture.is_of_pictures();
    let channels = Channels::open(&station, masks, space, is_brief)?;
    let recorder = begin(settings, file)?;
    let mut stage = Stage {
        channels,
        recorder,
        ledger: Ledger::new(from_start),
        counters: Counters::default(),
        rig: rig(settings, supervised),
        camera: None,
        places: Places::default(),
        losses: Losses::default(),
        losses_due: Instant::now(),
        frames: 0,
        first: None,
        version: settings.version,
    };
    let changes = station.listen(settings, |_, now| Ok(Some(now.clone())))?;
    if supervised {
        if station.handover.progress().restarts == 0 {
            stage.recorder.begins_with_the_rig();
        }
        stage.attach(true)?;
    }
    let flush = flush_on_signal(settings)?;
    station.ready()?;
    station.say_who_is_missing(FRAMES.name());
    let outcome = stage.run_until_end(settings, &mut station, &changes, supervised, file, &flush);
    station.status.say(Word::Ending);
    if outcome.is_ok() {
        stage
            .ledger
            .finish(match supervised.then(LastWord::of_the_chain) {
                Some(LastWord::Counts(counts)) => counts,
                Some(LastWord::Never) | None => FinalCounts::default(),
            });
        // This fails only if the recording has ended, which is reported below.
        let _ = stage.write_losses(true);
    }
    stage.end(settings, file, outcome)
}

/// Source of the rig's settings.
fn rig(settings: &Settings, supervised: bool) -> Rig {
    if supervised {
        return Rig::Ours(Box::new(settings.clone()));
    }
    Rig::Theirs {
        name: settings.run.rig.clone(),
        said: None,
        fit: None,
    }
}

/// Begins the recording, in its file or in memory.
fn begin(settings: &Settings, file: &Path) -> Result<Recorder> {
    let clock = Clock::now();
    let record = &settings.record;
    let head = Head {
        rig: settings.run.rig.clone(),
        about: about::metadata(settings, clock),
    };
    let options = Options {
        images: record.images(),
        queue_bytes: record.queue_bytes,
        waits: settings.run.lossless,
        clock,
    };
    let about = "the thread that writes could not be started";
    let Some(time) = record.ring else {
        let existing = if record.replace {
            Existing::Replace
        } else {
            Existing::Keep
        };
        let writer = Writer::create(file, existing, &head, record.compression)?;
        return Recorder::to_file(writer, &head, options).context(about);
    };
    eprintln!("lariat: {}", report::ring(record, file));
    let ring = RingOptions {
        time,
        bytes: record.ring_bytes,
        compression: record.compression,
        report: Box::new(|flushed: Flushed| eprintln!("lariat: {}", report::flushed(&flushed))),
    };
    Recorder::to_ring(ring, &head, options).context(about)
}

/// Flag that is set by the signal for writing the ring. Without a ring, the signal does nothing.
fn flush_on_signal(settings: &Settings) -> Result<Option<Arc<AtomicBool>>> {
    let asked = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(SIGUSR1, asked.clone())
        .context("the signal SIGUSR1 could not be listened to")?;
    Ok(settings.record.ring.map(|_| asked))
}

struct Stage {
    channels: Channels,
    recorder: Recorder,
    ledger: Ledger,
    counters: Counters,
    rig: Rig,
    /// Lens and plane of the rig, with the version of the settings that name them. `places` has the
    /// mapping that was used last.
    camera: Option<(u32, Camera)>,
    places: Places<u32>,
    /// Losses that were recorded last.
    losses: Losses,
    losses_due: Instant,
    frames: u64,
    /// Arrival time of the first message.
    first: Option<Instant>,
    /// Newest version of the rig's settings so far.
    version: u32,
}

impl Stage {
    fn run_until_end(
        &mut self,
        settings: &Settings,
        station: &mut Station,
        changes: &Changes<Settings>,
        supervised: bool,
        file: &Path,
        flush: &Option<Arc<AtomicBool>>,
    ) -> Result<()> {
        // In a chain, capture decides when the run is over.
        let lasts = settings.run.duration.filter(|_| !supervised);
        let most = settings.run.frames.filter(|_| !supervised);
        let most = most.unwrap_or(u64::MAX);
        loop {
            let last_look = station.stop.asked();
            let Self {
                channels,
                recorder,
                ledger,
                counters,
                camera,
                places,
                ..
            } = self;
            let places = |shapes: &Descriptors| {
                let (version, camera) = camera.as_ref()?;
                let load = |_: &u32| Calibrated::load(camera);
                (*version == shapes.trace.settings).then(|| places.of(shapes, *version, load))?
            };
            let seen = channels.drain(recorder, ledger, counters, places)?;
            self.frames += seen.frames;
            if seen.messages > 0 {
                self.first.get_or_insert_with(Instant::now);
            }
            if seen.begun && !supervised {
                self.version = seen.settings.unwrap_or(0);
                self.attach(true)?;
            } else if !supervised && seen.settings > Some(self.version) {
                self.version = seen.settings.unwrap_or(0);
                self.attach(false)?;
            }
            if let Some(changed) = station.change(changes) {
                self.rig.change(changed);
                self.attach(false)?;
            }
            if let Some(flush) = flush
                && flush.swap(false, Ordering::Relaxed)
            {
                self.recorder.flush_to(dated(file))?;
            }
            let deadline = self.first.zip(lasts).map(|(first, lasts)| first + lasts);
            let is_over = deadline.is_some_and(|deadline| Instant::now() >= deadline);
            if last_look || is_over || self.frames >= most {
                return Ok(());
            }
            if Instant::now() >= self.losses_due {
                self.losses_due = Instant::now() + LOSSES_EVERY;
                self.write_losses(false)?;
            }
            self.channels.sleep(station, deadline)?;
        }
    }

    /// Attaches the rig's settings to the recording and uses them from now on.
    fn attach(&mut self, is_first: bool) -> Result<(), Ended> {
        self.rig.attach(&mut self.recorder, is_first)?;
        self.camera = self.rig.camera();
        Ok(())
    }

    /// Records the losses if there are new ones, or if this is the last time.
    fn write_losses(&mut self, last: bool) -> Result<(), Ended> {
        let lost = self.ledger.lost();
        let drops = self.recorder.drops();
        let losses = Losses {
            at_ns: 0,
            source: lost.source,
            capture: lost.capture + lost.mask,
            extract: lost.extract,
            bridge: lost.bridge,
            fit: lost.fit,
            dropped_frames: drops.frames,
            dropped_centerlines: drops.centerlines,
            dropped_descriptors: drops.descriptors,
            dropped_truth: drops.truth,
            dropped_masks: drops.masks,
            dropped_depths: drops.depths,
            dropped_descriptors3: drops.descriptors3,
        };
        if losses == self.losses && !last {
            return Ok(());
        }
        self.losses = losses;
        self.recorder.losses(&Losses {
            at_ns: now_ns(),
            ..losses
        })
    }

    /// Closes the recording and reports its contents in a sentence.
    fn end(self, settings: &Settings, file: &Path, outcome: Result<()>) -> Result<ExitCode> {
        let Self {
            channels, recorder, ..
        } = self;
        // No writer should wait for this reader while the file is closed.
        drop(channels);
        let drops = recorder.drops();
        let lasted = self.first.map_or(Duration::ZERO, |first| first.elapsed());
        let ending = recorder.finish();
        if settings.record.ring.is_none() && ending.fault.is_none() && ending.written.is_empty() {
            // An empty file would only get in the way of the next recording.
            if !ending.written.kept_old && file.is_file() {
                let _ = std::fs::remove_file(file);
            }
            eprintln!("lariat: {}", report::nothing(file, &ending.written));
            outcome?;
            return Ok(ExitCode::SUCCESS);
        }
        // If the disk failed, only the fault is known about the file.
        let is_known = ending.fault.is_none() || ending.written.bytes > 0;
        if settings.record.ring.is_none() && is_known {
            let said = report::recorded(file, &ending.written, lasted, drops, &self.losses);
            eprintln!("lariat: {said}");
        }
        if let Some(fault) = ending.fault {
            return Err(fault.into());
        }
        outcome?;
        Ok(ExitCode::SUCCESS)
    }
}

/// File for the current contents of the ring: `run.mcap` becomes `run-20261122T063000Z.mcap`.
fn dated(file: &Path) -> PathBuf {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    let stamp = report::utc(since.unwrap_or_default().as_secs());
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let ending = file
        .extension()
        .map_or("mcap".into(), |ending| ending.to_string_lossy());
    let named = |more: &str| file.with_file_name(format!("{stem}-{stamp}{more}.{ending}"));
    // The ring was requested twice within a second.
    let again = (2..).map(|count| named(&format!("-{count}")));
    std::iter::once(named(""))
        .chain(again)
        .find(|path| !path.exists())
        .unwrap_or_else(|| named(""))
}

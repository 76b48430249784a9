//! `lariat replay --compare`: shows how other settings change the results of a recording.
//!
//! All recorded frames go through extract and fit with the new settings, in order, as in a chain
//! without losses. The recorded settings process the same frames in alternation, so that the times
//! of both come from one machine and one run. Without other settings, the comparison shows what
//! this release computes differently.

mod figures;

use super::ReplayArgs;
use super::stages::{Stages, prepare};
use super::table;
use crate::versioned::Versioned;
use anyhow::{Context, Result, bail};
pub(super) use figures::Figures;
use figures::Times;
use lariat_chain::output::print;
use lariat_chain::recorded::RecordedSettings;
use lariat_chain::recorded::{Decoder, Gather, Gathered};
use lariat_chain::settings::Settings;
use lariat_record::{Recording, Span};
use lariat_wire::Trace;
use serde::Serialize;
use std::process::ExitCode;

/// Everything that is printed.
#[derive(Debug, Serialize)]
pub(super) struct Comparison {
    /// Reference for the errors: `truth`, or what was `recorded`.
    pub(super) against: &'static str,
    pub(super) frames: u64,
    /// Number of frames without an image or without a mask.
    pub(super) skipped: u64,
    pub(super) recorded: Figures,
    pub(super) now: Figures,
}

/// Runs the comparison.
pub(super) fn run(args: &ReplayArgs) -> Result<ExitCode> {
    let recording = args.recording.open()?;
    let file = crate::recording::shown(&args.recording.file);
    let impossible = || format!("{file} cannot be compared");
    if !recording.has_traces() {
        bail!(
            "{file} cannot be compared: lariat did not make it, and nothing was computed in it. `lariat run --source {file}` \
             shows its frames"
        );
    }
    let recorded = RecordedSettings::of(&recording)
        .with_context(impossible)?
        .with_context(|| {
            format!("{file} cannot be compared: the settings that it was made with are not in it")
        })?;
    let settings = recorded.changed(&args.flags)?;
    let mut race = Race::new(&recorded.settings, &settings, &recording)?;
    race.whole(&recording).with_context(impossible)?;
    let comparison = race.finish();
    if args.json {
        print(&format!(
            "{}\n",
            serde_json::to_string(&Versioned::first(&comparison))?
        ))?;
    } else {
        print(&table::text(&comparison))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn has_truth(recording: &Recording) -> Result<bool> {
    let topics = recording.topics()?;
    let is_truth = |name: &str| name.rsplit('/').next() == Some("truth");
    Ok(topics
        .iter()
        .any(|topic| topic.messages > 0 && is_truth(&topic.name)))
}

/// Runs both settings over the same frames.
pub(super) struct Race {
    then: Stages,
    now: Stages,
    decoders: [Decoder; 2],
    recorded: Figures,
    figures: Figures,
    /// Times with the recorded settings and with the new ones.
    times: [Times; 2],
    count: u64,
    skipped: u64,
    has_truth: bool,
}

impl Race {
    pub(super) fn new(then: &Settings, now: &Settings, recording: &Recording) -> Result<Self> {
        Ok(Self {
            then: Stages::new(then)?,
            now: Stages::new(now)?,
            decoders: Default::default(),
            recorded: Figures::new(),
            figures: Figures::new(),
            times: [Times::default(), Times::default()],
            count: 0,
            skipped: 0,
            has_truth: has_truth(recording)?,
        })
    }

    pub(super) fn whole(&mut self, recording: &Recording) -> Result<()> {
        let mut frames = Gather::new(recording, Span::default())?;
        while let Some(gathered) = frames.next()? {
            self.frame(gathered)?;
        }
        if self.count == 0 {
            bail!("there is no frame in it with its image");
        }
        Ok(())
    }

    fn frame(&mut self, gathered: &Gathered) -> Result<()> {
        let truth = match self.has_truth {
            true => gathered.truth(),
            false => gathered.centerlines(),
        };
        if let Some(truth) = truth {
            self.recorded.truth(truth);
            self.figures.truth(truth);
        }
        if let Some(centerlines) = gathered.centerlines() {
            self.recorded.centerlines(centerlines);
        }
        if let Some(descriptors) = gathered.descriptors() {
            self.recorded.descriptors(descriptors);
        }
        let Some(frame) = gathered.frame() else {
            return Ok(());
        };
        let header = frame.header;
        let Ok(prepared) = prepare(gathered, &mut self.decoders) else {
            self.skipped += 1;
            return Ok(());
        };
        if !prepared.is_blank() && !prepared.has_mask() && self.now.needs_masks() {
            self.skipped += 1;
            return Ok(());
        }
        self.count += 1;
        let trace = Trace {
            extracted: self.count,
            fitted: self.count,
            ..header.trace
        };
        // The run that comes second finds the frame in the cache, so the two take turns going
        // first.
        let mut runs = [(&mut self.then, 0), (&mut self.now, 1)];
        if self.count.is_multiple_of(2) {
            runs.reverse();
        }
        for (stages, which) in runs {
            stages.extract(&prepared, trace);
            stages.fit_seen(trace);
            if !prepared.is_blank() {
                self.times[which].add(stages.extract_time, stages.fit_time);
            }
        }
        self.figures.centerlines(&self.now.centerlines);
        self.figures.descriptors(&self.now.descriptors);
        Ok(())
    }

    pub(super) fn finish(self) -> Comparison {
        let [then, now] = self.times;
        let against = match self.has_truth {
            true => "truth",
            false => "recorded",
        };
        Comparison {
            against,
            frames: self.count,
            skipped: self.skipped,
            recorded: self.recorded.finish(then),
            now: self.figures.finish(now),
        }
    }
}

//! `lariat replay --check`: checks that recomputing gives the recorded results.
//!
//! Extract gets the frames that it processed in the recorded run, in the same order. Fit gets the
//! centerlines that it received then. The counters in the recorded traces identify both exactly.
//! Each result therefore has the same past as in the recorded run, whatever was lost on the way,
//! and any difference comes from the computation.

use super::ReplayArgs;
use super::difference::{Comparer, Difference, Rule};
use super::distance;
use super::stages::{Stages, prepare};
use crate::versioned::Versioned;
use anyhow::{Context, Result, bail};
use lariat_chain::exit::wrong_use;
use lariat_chain::layout::{self, hanging};
use lariat_chain::output::print;
use lariat_chain::recorded::RecordedSettings;
use lariat_chain::recorded::{Decoder, Gather, Gathered, Pixels};
use lariat_chain::settings::Settings;
use lariat_record::{About, Recording, Span};
use lariat_sink::Machine;
use lariat_wire::{Centerlines, Descriptors};
use serde::Serialize;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Tolerance for machines of different kinds, in pixels: far below what an image resolves, and far
/// above rounding errors.
const OTHER_MACHINE_PX: f64 = 1e-9;

/// Result of a check.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    /// Comparison rule: `bits`, or the tolerance in pixels.
    pub(super) rule: String,
    pub(super) frames: u64,
    pub(super) centerlines: u64,
    pub(super) descriptors: u64,
    /// Number of messages that could not be recomputed and were skipped; only with a tolerance.
    pub(super) skipped: u64,
    /// Largest distance between two positions, in pixels (of the descriptors' unit).
    pub(super) largest_px: f64,
    pub(super) frames_per_s: f64,
    pub(super) extract_us: f64,
    pub(super) fit_us: f64,
    pub(super) difference: Option<Shown>,
}

/// First difference.
#[derive(Debug, Serialize)]
pub(super) struct Shown {
    /// Frame number of the source.
    pub(super) sequence: u64,
    pub(super) what: &'static str,
    pub(super) field: String,
    pub(super) recorded: String,
    pub(super) now: String,
    pub(super) distance: f64,
}

/// Runs the check.
pub(super) fn run(args: &ReplayArgs) -> Result<ExitCode> {
    let recording = args.recording.open()?;
    let file = crate::recording::shown(&args.recording.file);
    let impossible = || format!("{file} cannot be checked");
    let settings = settings(&recording, args).with_context(impossible)?;
    let mut check = Check::new(&settings, &recording, args.within)?;
    let begin = Instant::now();
    check.whole(&recording).with_context(impossible)?;
    let outcome = check.outcome(begin.elapsed());
    if args.json {
        print(&format!(
            "{}\n",
            serde_json::to_string(&Versioned::first(&outcome))?
        ))?;
    } else {
        print(&text(&file, &outcome, recording.about(), args.within))?;
    }
    Ok(match outcome.difference {
        None => ExitCode::SUCCESS,
        Some(_) => ExitCode::FAILURE,
    })
}

fn settings(recording: &Recording, args: &ReplayArgs) -> Result<RecordedSettings> {
    if args.flags.is_given() {
        wrong_use!("a check uses the settings of the recording: with others, use --compare");
    }
    if !recording.has_traces() {
        bail!("lariat did not make it, and nothing was computed in it");
    }
    RecordedSettings::of(recording)?
        .context("the settings that it was made with are not in it (lariat.toml), as without the rest of the chain running")
}

/// Returns true if this machine computes like the recording's machine, as far as known.
fn is_same_machine(about: &About) -> bool {
    let cpu = Machine::this().cpu;
    about.get("arch") == Some(std::env::consts::ARCH)
        && cpu.is_some()
        && about.get("cpu") == cpu.as_deref()
}

/// Settings of a recording, in all versions that were in force while it was made.
struct Versions<'a> {
    recording: &'a Recording,
    first: &'a RecordedSettings,
    others: BTreeMap<u32, RecordedSettings>,
}

impl Versions<'_> {
    /// Settings with which the messages of a frame were made.
    fn get(&mut self, version: u32, frame: u64) -> Result<&Settings> {
        if version == self.first.settings.version {
            return Ok(&self.first.settings);
        }
        let found = match self.others.entry(version) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(unknown) => {
                let settings = self.first.of_version(self.recording, version)?;
                unknown.insert(settings.with_context(|| {
                    format!("frame {frame} was made by settings {version}, which are not in it")
                })?)
            }
        };
        Ok(&found.settings)
    }
}

/// A check, message by message.
pub(super) struct Check<'a> {
    versions: Versions<'a>,
    /// Settings version, and number of restarts, of extract and fit at the last message.
    of_extract: [u32; 2],
    of_fit: [u32; 2],
    stages: Stages,
    decoders: [Decoder; 2],
    comparer: Comparer,
    rule: Rule,
    /// Allowed distance from the recorded curves, in pixels; `None` if they must be equal.
    within_px: Option<f64>,
    /// Counters of the last messages.
    extracted: Option<u64>,
    fitted: Option<u64>,
    frames: u64,
    centerlines: u64,
    descriptors: u64,
    skipped: u64,
    largest_px: f64,
    extract_time: Duration,
    fit_time: Duration,
    difference: Option<Shown>,
}

impl<'a> Check<'a> {
    pub(super) fn new(
        recorded: &'a RecordedSettings,
        recording: &'a Recording,
        within_px: Option<f64>,
    ) -> Result<Self> {
        let begins = [recorded.settings.version, 0];
        let rule = match is_same_machine(recording.about()) {
            true => Rule::Bits,
            false => Rule::Within(OTHER_MACHINE_PX),
        };
        Ok(Self {
            versions: Versions {
                recording,
                first: recorded,
                others: BTreeMap::new(),
            },
            of_extract: begins,
            of_fit: begins,
            stages: Stages::new(&recorded.settings)?,
            decoders: Default::default(),
            comparer: Comparer::new(rule),
            rule,
            within_px,
            extracted: None,
            fitted: None,
            frames: 0,
            centerlines: 0,
            descriptors: 0,
            skipped: 0,
            largest_px: 0.0,
            extract_time: Duration::ZERO,
            fit_time: Duration::ZERO,
            difference: None,
        })
    }

    pub(super) fn whole(&mut self, recording: &Recording) -> Result<()> {
        let mut frames = Gather::new(recording, Span::default())?;
        while let Some(gathered) = frames.next()? {
            self.frames += u64::from(gathered.frame().is_some());
            if let Some(recorded) = gathered.centerlines() {
                self.extract(gathered, recorded)?;
            }
            if let (None, Some(recorded)) = (&self.difference, gathered.descriptors()) {
                self.fit(gathered.centerlines(), recorded)?;
            }
            if self.difference.is_some() {
                return Ok(());
            }
        }
        if self.centerlines == 0 {
            bail!("there are no centerlines in it whose frames are in it too");
        }
        Ok(())
    }

    fn extract(&mut self, gathered: &Gathered, recorded: &Centerlines) -> Result<()> {
        let trace = recorded.trace;
        let (count, frame) = (trace.extracted, trace.sequence);
        let before = self.extracted.replace(count);
        let restarts = trace.restarts()[1];
        let [version_before, restarts_before] = self.of_extract;
        self.of_extract = [trace.settings, restarts.into()];
        if count == 1 && before.is_some() {
            // The whole chain was restarted.
            let settings = self.versions.get(trace.settings, frame)?;
            self.stages.restart_extract(settings)?;
        } else if u32::from(restarts) != restarts_before {
            let settings = self.versions.get(trace.settings, frame)?;
            self.stages.replace_extract(settings)?;
        } else if trace.settings != version_before {
            let settings = self.versions.get(trace.settings, frame)?;
            self.stages.change_extract(settings)?;
        }
        if count != 1 && self.within_px.is_none() {
            follows(before, count).with_context(|| {
                format!("what extract saw before frame {frame} is not all in it (--within PX compares it all the same)")
            })?;
        }
        let needs_masks = self.stages.needs_masks();
        let prepared = prepare(gathered, &mut self.decoders).and_then(|prepared| {
            if needs_masks && !prepared.has_mask() && !prepared.is_blank() {
                bail!("its mask was not recorded");
            }
            let is_jpeg = gathered
                .frame()
                .is_some_and(|frame| matches!(frame.pixels, Pixels::Jpeg | Pixels::Other));
            if is_jpeg && self.within_px.is_none() {
                bail!("a JPEG is not the image that extract saw (--within PX compares it all the same)");
            }
            Ok(prepared)
        });
        let prepared = match (prepared, self.within_px) {
            (Ok(prepared), _) => prepared,
            (Err(_), Some(_)) => {
                self.skipped += 1;
                return Ok(());
            }
            (Err(why), None) => return Err(why.context(format!("extract saw frame {frame}"))),
        };
        self.stages.extract(&prepared, trace);
        self.extract_time += self.stages.extract_time;
        self.centerlines += 1;
        let now = &self.stages.centerlines;
        let difference = match self.within_px {
            None => self.comparer.centerlines(recorded, now),
            Some(most) => {
                let distance = distance::between(recorded, now);
                self.largest_px = self.largest_px.max(distance);
                (distance > most).then(|| beside(distance))
            }
        };
        self.report("centerlines", frame, difference);
        Ok(())
    }

    fn fit(&mut self, seen: Option<&Centerlines>, recorded: &Descriptors) -> Result<()> {
        let trace = recorded.trace;
        let (count, frame) = (trace.fitted, trace.sequence);
        let before = self.fitted.replace(count);
        let restarts = trace.restarts()[2];
        let [version_before, restarts_before] = self.of_fit;
        self.of_fit = [trace.settings, restarts.into()];
        if count == 1 && before.is_some() || u32::from(restarts) != restarts_before {
            let settings = self.versions.get(trace.settings, frame)?;
            self.stages.restart_fit(settings)?;
        } else if trace.settings != version_before {
            let settings = self.versions.get(trace.settings, frame)?;
            self.stages.change_fit(settings)?;
        }
        if count != 1 && self.within_px.is_none() {
            follows(before, count).with_context(|| {
                format!("what fit was sent before frame {frame} is not all in it (--within PX compares it all the same)")
            })?;
        }
        let Some(seen) = seen else {
            if self.within_px.is_none() {
                bail!("fit was sent centerlines of frame {frame}, and they are not in it");
            }
            self.skipped += 1;
            return Ok(());
        };
        self.stages.fit(seen, trace);
        self.fit_time += self.stages.fit_time;
        self.descriptors += 1;
        let now = &self.stages.descriptors;
        let difference = match self.within_px {
            None => self.comparer.descriptors(recorded, now),
            Some(most) => {
                let distance = distance::between_control_points(recorded, now);
                self.largest_px = self.largest_px.max(distance);
                (distance > most).then(|| beside(distance))
            }
        };
        self.report("descriptors", frame, difference);
        Ok(())
    }

    fn report(&mut self, what: &'static str, sequence: u64, difference: Option<Difference>) {
        self.difference = difference.map(|difference| Shown {
            sequence,
            what,
            field: difference.field,
            recorded: difference.recorded,
            now: difference.now,
            distance: difference.distance,
        });
    }

    pub(super) fn outcome(self, took: Duration) -> Outcome {
        let us = |time: Duration, count: u64| 1e6 * time.as_secs_f64() / count.max(1) as f64;
        Outcome {
            rule: match (self.within_px, self.rule) {
                (Some(px), _) => format!("{px} px"),
                (None, Rule::Bits) => "bits".to_owned(),
                (None, Rule::Within(px)) => format!("{px:e} px"),
            },
            frames: self.frames,
            centerlines: self.centerlines,
            descriptors: self.descriptors,
            skipped: self.skipped,
            largest_px: self.largest_px.max(self.comparer.largest),
            frames_per_s: self.centerlines as f64 / took.as_secs_f64(),
            extract_us: us(self.extract_time, self.centerlines),
            fit_us: us(self.fit_time, self.descriptors),
            difference: self.difference,
        }
    }
}

/// # Errors
/// Returns an error if the recording lacks a message between the two.
fn follows(before: Option<u64>, count: u64) -> Result<()> {
    match before {
        None if count == 1 => Ok(()),
        None => bail!(
            "it begins in the middle of a run: {} messages were before it",
            count - 1
        ),
        Some(before) if count == before + 1 => Ok(()),
        Some(before) => bail!(
            "the recorder did not get messages {} to {}",
            before + 1,
            count - 1
        ),
    }
}

fn beside(distance: f64) -> Difference {
    Difference {
        field: "the ropes' places".to_owned(),
        recorded: "as they were".to_owned(),
        now: match distance.is_finite() {
            true => format!("up to {distance:.3} away from them"),
            false => "not the same ropes".to_owned(),
        },
        distance,
    }
}

fn text(file: &str, outcome: &Outcome, about: &About, within_px: Option<f64>) -> String {
    let mut lines = Vec::new();
    let Outcome {
        centerlines,
        descriptors,
        ..
    } = outcome;
    if outcome.rule != "bits" && within_px.is_none() {
        let of = |key| about.get(key).unwrap_or("unknown");
        lines.push(format!(
            "made on another machine ({}, {}): results are the same within {}",
            of("cpu"),
            of("arch"),
            outcome.rule
        ));
    }
    match &outcome.difference {
        None => {
            let how = match (&outcome.rule[..], outcome.largest_px) {
                ("bits", _) => "the same to the bit".to_owned(),
                (rule, largest) => format!("the same within {rule} (at most {largest:e} apart)"),
            };
            lines.push(format!(
                "{file}: {centerlines} centerlines and {descriptors} descriptors computed again are {how}"
            ));
        }
        Some(Shown {
            sequence,
            what,
            field,
            recorded,
            now,
            distance,
        }) => {
            lines.push(format!(
                "{file}: the {what} of frame {sequence} are not the same:"
            ));
            lines.push(format!(
                "  {field}: recorded {recorded}, now {now}, {distance:e} apart"
            ));
            lines.push(format!(
                "before it {centerlines} centerlines and {descriptors} descriptors were looked at"
            ));
        }
    }
    if outcome.skipped > 0 {
        lines.push(format!("{} could not be computed again", outcome.skipped));
    }
    lines.push(format!(
        "{:.0} frames/s: extract took {:.0} µs a frame, fit {:.1} µs, the rest was reading",
        outcome.frames_per_s, outcome.extract_us, outcome.fit_us
    ));
    let width = layout::width();
    let folded = lines.iter().map(|line| match line.strip_prefix("  ") {
        Some(line) => format!("  {}\n", hanging(line, 4, width)),
        None => hanging(line, 2, width) + "\n",
    });
    folded.collect()
}

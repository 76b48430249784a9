//! `lariat info`: the contents of a recording, from its index.

use crate::recording::{RecordingArgs, shown};
use crate::versioned::Versioned;
use anyhow::{Context, Result};
use clap::Args;
use lariat_chain::layout::{self, Column, Table, hanging};
use lariat_chain::output::print;
use lariat_chain::recorded::{CALIBRATION, PLANE, RecordedSettings};
use lariat_record::{Entry, Losses, Recording, Span};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::process::ExitCode;

/// Describe a recording
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    #[command(flatten)]
    recording: RecordingArgs,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Everything that is printed.
#[derive(Debug, Serialize)]
struct Info {
    file: String,
    bytes: u64,
    /// True if the recording was closed.
    closed: bool,
    /// Metadata: rig, release, machine, and how the recording was made.
    about: BTreeMap<String, String>,
    /// Log time of the first message, in nanoseconds of Unix time.
    start_ns: u64,
    duration_s: f64,
    frames: u64,
    /// Mean rate between the first and the last frame.
    frames_per_s: Option<f64>,
    topics: Vec<Topic>,
    /// Last recorded losses.
    losses: Option<Lost>,
    attachments: Vec<String>,
    /// Settings that differ from the defaults; `null` if the recording has none that this release
    /// understands.
    settings: Option<BTreeMap<String, String>>,
}

#[derive(Debug, Serialize)]
struct Topic {
    name: String,
    schema: String,
    messages: u64,
    per_s: f64,
    /// Uncompressed size of its messages, in bytes.
    bytes: u64,
}

/// Losses on each link and by the recorder.
#[derive(Debug, Serialize)]
struct Lost {
    source: u64,
    capture: u64,
    extract: u64,
    bridge: u64,
    fit: u64,
    dropped_frames: u64,
    dropped_centerlines: u64,
    dropped_descriptors: u64,
    dropped_truth: u64,
    dropped_masks: u64,
}

impl From<&Losses> for Lost {
    fn from(losses: &Losses) -> Self {
        Self {
            source: losses.source,
            capture: losses.capture,
            extract: losses.extract,
            bridge: losses.bridge,
            fit: losses.fit,
            dropped_frames: losses.dropped_frames,
            dropped_centerlines: losses.dropped_centerlines,
            dropped_descriptors: losses.dropped_descriptors,
            dropped_truth: losses.dropped_truth,
            dropped_masks: losses.dropped_masks,
        }
    }
}

impl Lost {
    fn rows(&self) -> [(&'static str, u64); 10] {
        [
            ("at the source", self.source),
            ("between capture and extract", self.capture),
            ("between extract and fit", self.extract),
            ("over the bridge", self.bridge),
            ("between fit and the recorder", self.fit),
            ("frames not recorded", self.dropped_frames),
            ("centerlines not recorded", self.dropped_centerlines),
            ("descriptors not recorded", self.dropped_descriptors),
            ("truth not recorded", self.dropped_truth),
            ("masks not recorded", self.dropped_masks),
        ]
    }
}

/// Runs `lariat info`.
///
/// # Errors
/// Returns an error if the recording cannot be read.
pub(crate) fn run(args: InfoArgs) -> Result<ExitCode> {
    let recording = args.recording.open()?;
    let file = shown(&args.recording.file);
    let info = Info::of(&recording, file.clone()).with_context(|| file)?;
    if args.json {
        print(&format!(
            "{}\n",
            serde_json::to_string(&Versioned::first(&info))?
        ))?;
    } else {
        print(&info.text())?;
    }
    Ok(ExitCode::SUCCESS)
}

impl Info {
    fn of(recording: &Recording, file: String) -> Result<Self> {
        let (start_ns, end_ns) = recording.times_ns();
        let duration_s = end_ns.saturating_sub(start_ns) as f64 / 1e9;
        let (frames, ends) = recording.frame_times_ns(Span::default())?;
        let rate = |count: u64, s: f64| (count > 0 && s > 0.0).then(|| count as f64 / s);
        let frames_s = ends.map(|[first, last]| last.saturating_sub(first) as f64 / 1e9);
        let topics = recording.topics()?.into_iter().map(|topic| Topic {
            name: topic.name,
            schema: topic.schema,
            messages: topic.messages,
            per_s: rate(topic.messages, duration_s).unwrap_or(0.0),
            bytes: topic.bytes,
        });
        let settings = RecordedSettings::of(recording).unwrap_or_else(|why| {
            eprintln!("lariat: {why:#}");
            None
        });
        let entries = recording.about().entries();
        Ok(Self {
            file,
            bytes: recording.size(),
            closed: recording.cut_off().is_none(),
            about: entries
                .map(|(key, value)| (key.to_owned(), value.to_owned()))
                .collect(),
            start_ns,
            duration_s,
            frames,
            frames_per_s: frames_s.and_then(|s| rate(frames.saturating_sub(1), s)),
            topics: topics.collect(),
            losses: last_losses(recording)?,
            attachments: recording.attachments().map(str::to_owned).collect(),
            settings: settings.as_ref().map(changed),
        })
    }

    fn text(&self) -> String {
        let mut text = String::new();
        let about = |key: &str| self.about.get(key).map_or("unknown", |value| value);
        let ended = if self.closed { "" } else { ", not closed" };
        let width = layout::width();
        let _ = writeln!(text, "{}: {}{ended}", self.file, size(self.bytes));
        if self.about.is_empty() {
            let _ = writeln!(text, "not made by lariat");
        } else {
            let sentence = format!(
                "rig {}, recorded by lariat {} on {} ({})",
                about("rig"),
                about("version"),
                about("cpu"),
                about("arch")
            );
            let _ = writeln!(text, "{}", hanging(&sentence, 2, width));
        }
        let pace = self.frames_per_s;
        let pace = pace.map_or(String::new(), |fps| format!(" at {fps:.2} a second"));
        let _ = writeln!(
            text,
            "{}, {:.3} s, {} frames{pace}",
            date(self.start_ns),
            self.duration_s,
            self.frames
        );
        self.write_topics(&mut text);
        if let Some(losses) = &self.losses {
            let lost: Vec<_> = losses.rows().into_iter().filter(|(_, n)| *n > 0).collect();
            if lost.is_empty() {
                let _ = writeln!(text, "\nnothing was lost, on no link");
            } else {
                let _ = writeln!(text, "\nlost");
            }
            for (name, count) in lost {
                let _ = writeln!(text, "  {count} {name}");
            }
        }
        if let Some(settings) = &self.settings {
            match settings.is_empty() {
                true => text.push_str("\nall settings were the defaults\n"),
                false => text.push_str("\nsettings other than the defaults\n"),
            }
            for (key, value) in settings {
                let line = format!("{key} = {}", shortened(value));
                let _ = writeln!(text, "  {}", hanging(&line, 4, width));
            }
        }
        if !self.attachments.is_empty() {
            let list = format!("in it: {}", self.attachments.join(", "));
            let _ = writeln!(text, "\n{}", hanging(&list, 2, width));
        }
        text
    }

    fn write_topics(&self, text: &mut String) {
        let columns = vec![
            Column::words("topic"),
            Column::figures("messages"),
            Column::figures("a second"),
            Column::figures("size"),
            Column::words("of"),
        ];
        let row = |topic: &Topic| {
            vec![
                topic.name.clone(),
                topic.messages.to_string(),
                format!("{:.2}", topic.per_s),
                size(topic.bytes),
                topic.schema.clone(),
            ]
        };
        let rows: Vec<_> = self.topics.iter().map(row).collect();
        let _ = write!(text, "\n{}", Table::text(columns, &rows, layout::width()));
    }
}

/// Settings that differ from the defaults. The recording contains the files that they name.
fn changed(recorded: &RecordedSettings) -> BTreeMap<String, String> {
    let mut changed: BTreeMap<_, _> = recorded.settings.changed().collect();
    for (key, name) in [("camera.calibration", CALIBRATION), ("camera.plane", PLANE)] {
        if let Some(value) = changed.get_mut(key) {
            *value = format!("{name} in the recording");
        }
    }
    changed
}

/// Last recorded losses. They are recorded at most once a second, so only the end is searched.
fn last_losses(recording: &Recording) -> Result<Option<Lost>> {
    let mut last = None;
    let mut messages = recording.losses()?;
    loop {
        match messages.next() {
            Ok(Some(Entry::Losses(losses))) => last = Some(Lost::from(losses)),
            Ok(Some(_)) => {}
            Ok(None) => return Ok(last),
            // Each message has the total so far, so one unreadable message does not matter.
            Err(_) => {}
        }
    }
}

fn size(bytes: u64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 999.95 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    match unit {
        0 => format!("{bytes} B"),
        _ => format!("{value:.1} {}", units[unit]),
    }
}

/// Formats a time as date and time in UTC, by the civil calendar (Hinnant, *chrono-compatible
/// low-level date algorithms*).
fn date(unix_ns: u64) -> String {
    let s = unix_ns / 1_000_000_000;
    let (days, s) = (s / 86_400, s % 86_400);
    let shifted = days + 719_468;
    let (era, day) = (shifted / 146_097, shifted % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = 400 * era + year + u64::from(month <= 2);
    format!(
        "{year:04}-{month:02}-{day:02} {:02}:{:02}:{:02} UTC",
        s / 3600,
        s / 60 % 60,
        s % 60
    )
}

/// Shortens a setting's value to one line. A long list of files is cut (`--json` prints it whole).
fn shortened(value: &str) -> String {
    const LONGEST: usize = 100;
    match value.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} …", &value[..end]),
        None => value.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(date(0), "1970-01-01 00:00:00 UTC");
        // A leap day, and the second before it.
        assert_eq!(date(951_782_399_000_000_000), "2000-02-28 23:59:59 UTC");
        assert_eq!(date(951_782_400_000_000_000), "2000-02-29 00:00:00 UTC");
        assert_eq!(date(1_700_000_000_000_000_000), "2023-11-14 22:13:20 UTC");
    }

    #[test]
    fn sizes_have_four_digits_at_most() {
        assert_eq!(size(999), "999 B");
        assert_eq!(size(999_949), "999.9 kB");
        assert_eq!(size(999_951), "1.0 MB");
        assert_eq!(size(12_345_678_901), "12.3 GB");
    }
}

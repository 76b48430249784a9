//! What is printed about a picture: a JSON object a line for programs, a table for people.

use crate::descriptor_json::{Descriptor, thousandths};
use clap::ValueEnum;
use lariat_extract::Status;
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;

/// What `lariat trace` prints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Aligned columns for people
    Table,
    /// A JSON object a line, one for each picture
    Jsonl,
}

/// All that is known about one picture. The keys are part of what users build on.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) image: String,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) curves: Vec<CurveReport>,
    pub(super) crossings: Vec<CrossingReport>,
    /// What the automatic mask is unsure of.
    pub(super) notices: Vec<NoticeReport>,
    pub(super) timing_us: Timing,
}

/// One rope.
#[derive(Debug, Serialize)]
pub(super) struct CurveReport {
    pub(super) track: u32,
    pub(super) status: &'static str,
    pub(super) closed: bool,
    /// Whether the first and the last point lie where the rope leaves the image.
    pub(super) border: [bool; 2],
    pub(super) length_px: f64,
    pub(super) width_px: f64,
    pub(super) points: Vec<[f64; 2]>,
    /// The width at each point.
    pub(super) widths_px: Vec<f64>,
    /// Which of the points something else lies over.
    pub(super) hidden: Vec<usize>,
    /// How long ago it was seen last, in ms: 0 but for a lost rope.
    pub(super) age_ms: f64,
    /// Its passes over and under itself, from its first point on.
    pub(super) crossing_sequence: String,
    /// Whether it comes out straight when its ends are drawn apart; `null`: undecided.
    pub(super) pulls_straight: Option<bool>,
    pub(super) descriptor: Descriptor,
}

/// Where a strand lies over a strand.
#[derive(Debug, Serialize)]
pub(super) struct CrossingReport {
    pub(super) at: [f64; 2],
    pub(super) over: StrandReport,
    pub(super) under: StrandReport,
    pub(super) confidence: f64,
}

/// Why the mask may be wrong.
#[derive(Debug, Serialize)]
pub(super) struct NoticeReport {
    /// A short name, for programs.
    pub(super) kind: &'static str,
    /// A sentence that says what to do.
    pub(super) text: String,
}

/// A place on a rope.
#[derive(Debug, Serialize)]
pub(super) struct StrandReport {
    pub(super) track: u32,
    /// Normalized arc length.
    pub(super) rho: f64,
}

/// How long each step took, µs.
#[derive(Debug, Default, Serialize)]
pub(super) struct Timing {
    pub(super) decode: f64,
    pub(super) follow: f64,
    pub(super) mask: f64,
    pub(super) skeleton: f64,
    pub(super) graph: f64,
    pub(super) points: f64,
    pub(super) fit: f64,
    pub(super) total: f64,
}

impl Timing {
    /// To the nanosecond, the clock's own step.
    pub(super) fn rounded(self) -> Self {
        Self {
            decode: thousandths(self.decode),
            follow: thousandths(self.follow),
            mask: thousandths(self.mask),
            skeleton: thousandths(self.skeleton),
            graph: thousandths(self.graph),
            points: thousandths(self.points),
            fit: thousandths(self.fit),
            total: thousandths(self.total),
        }
    }
}

/// How a curve's status is written.
pub(super) fn status_name(status: Status) -> &'static str {
    match status {
        Status::Ok => "ok",
        Status::Partial => "partial",
        Status::Lost => "lost",
        Status::Doubtful => "doubtful",
    }
}

impl Report {
    pub(super) fn write_json(&self, output: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer(&mut *output, self)?;
        output.write_all(b"\n")
    }

    /// At how many crossings a rope is one of the two strands, or both.
    fn crossings_of(&self, track: u32) -> usize {
        let is_one = |crossing: &&CrossingReport| {
            [crossing.over.track, crossing.under.track].contains(&track)
        };
        self.crossings.iter().filter(is_one).count()
    }
}

/// A table that grows by a row a rope, with as wide a first column as all the names need.
pub(super) struct Table {
    name_width: usize,
    has_heading: bool,
    /// Of the last two columns of figures.
    unit: &'static str,
}

impl Table {
    /// Longer names are shown by their end.
    const LONGEST_NAME: usize = 48;

    pub(super) fn new(images: &[PathBuf], unit: &'static str) -> Self {
        let longest = images
            .iter()
            .map(|path| path.to_string_lossy().chars().count())
            .max();
        Self {
            name_width: longest
                .unwrap_or(0)
                .clamp("image".len(), Self::LONGEST_NAME),
            has_heading: false,
            unit,
        }
    }

    pub(super) fn write(&mut self, report: &Report, output: &mut impl Write) -> io::Result<()> {
        let width = self.name_width;
        self.head(output)?;
        let name = self.shortened(&report.image);
        let size = format!("{}×{}", report.width, report.height);
        let time_ms = report.timing_us.total / 1e3;
        if report.curves.is_empty() {
            let no_rope = "no rope";
            return writeln!(
                output,
                "{name:<width$}  {size:>9}  {:>4}  {no_rope:<7}  {:>63}{time_ms:>8.1}",
                "-", ""
            );
        }
        for (index, curve) in report.curves.iter().enumerate() {
            let is_first = index == 0;
            let (name, size) = if is_first {
                (&name[..], &size[..])
            } else {
                ("", "")
            };
            let time = if is_first {
                format!("{time_ms:.1}")
            } else {
                String::new()
            };
            writeln!(
                output,
                "{name:<width$}  {size:>9}  {:>4}  {:<7}  {:>9.1}  {:>8.1}  {:>9}  {:>5}  {:>7.2}  {:>7.2}  {time:>8}",
                curve.track,
                curve.status,
                curve.length_px,
                curve.width_px,
                report.crossings_of(curve.track),
                curve.descriptor.order,
                curve.descriptor.rms,
                curve.descriptor.max,
            )?;
            if !curve.crossing_sequence.is_empty() {
                let pulls = match curve.pulls_straight {
                    Some(true) => "pulls straight",
                    Some(false) => "knotted",
                    None => "pulls straight or not: undecided",
                };
                let sequence = &curve.crossing_sequence;
                writeln!(output, "{:<width$}  {:>9}  {sequence}: {pulls}", "", "")?;
            }
        }
        Ok(())
    }

    /// The heading, before the first row.
    fn head(&mut self, output: &mut impl Write) -> io::Result<()> {
        let width = self.name_width;
        if std::mem::replace(&mut self.has_heading, true) {
            return Ok(());
        }
        writeln!(
            output,
            "{:<width$}  {:>9}  {:>4}  {:<7}  {:>9}  {:>8}  {:>9}  {:>5}  {:>7}  {:>7}  {:>8}",
            "image",
            "size",
            "rope",
            "status",
            "length px",
            "width px",
            "crossings",
            "order",
            format!("rms {}", self.unit),
            format!("max {}", self.unit),
            "time ms"
        )
    }

    fn shortened(&self, name: &str) -> String {
        let excess = name.chars().count().saturating_sub(self.name_width);
        if excess == 0 {
            return name.to_owned();
        }
        let end: String = name.chars().skip(excess + 1).collect();
        format!("…{end}")
    }
}

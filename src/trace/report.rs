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
    pub(super) timing_us: Timing,
}

/// One rope.
#[derive(Debug, Serialize)]
pub(super) struct CurveReport {
    pub(super) track: u32,
    pub(super) status: &'static str,
    pub(super) closed: bool,
    pub(super) length_px: f64,
    pub(super) width_px: f64,
    pub(super) points: Vec<[f64; 2]>,
    pub(super) descriptor: Descriptor,
}

/// How long each step took, µs.
#[derive(Debug, Default, Serialize)]
pub(super) struct Timing {
    pub(super) decode: f64,
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
    }
}

impl Report {
    pub(super) fn write_json(&self, output: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer(&mut *output, self)?;
        output.write_all(b"\n")
    }
}

/// A table that grows by a row a rope, with as wide a first column as all the names need.
pub(super) struct Table {
    name_width: usize,
    has_heading: bool,
}

impl Table {
    /// Longer names are shown by their end.
    const LONGEST_NAME: usize = 48;

    pub(super) fn new(images: &[PathBuf]) -> Self {
        let longest = images
            .iter()
            .map(|path| path.to_string_lossy().chars().count())
            .max();
        Self {
            name_width: longest
                .unwrap_or(0)
                .clamp("image".len(), Self::LONGEST_NAME),
            has_heading: false,
        }
    }

    pub(super) fn write(&mut self, report: &Report, output: &mut impl Write) -> io::Result<()> {
        let width = self.name_width;
        if !self.has_heading {
            self.has_heading = true;
            writeln!(
                output,
                "{:<width$}  {:>9}  {:>4}  {:<7}  {:>9}  {:>8}  {:>5}  {:>7}  {:>7}  {:>8}",
                "image",
                "size",
                "rope",
                "status",
                "length px",
                "width px",
                "order",
                "rms px",
                "max px",
                "time ms"
            )?;
        }
        let name = self.shortened(&report.image);
        let size = format!("{}×{}", report.width, report.height);
        let time_ms = report.timing_us.total / 1e3;
        if report.curves.is_empty() {
            let no_rope = "no rope";
            return writeln!(
                output,
                "{name:<width$}  {size:>9}  {:>4}  {no_rope:<7}  {:>52}{time_ms:>8.1}",
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
                "{name:<width$}  {size:>9}  {:>4}  {:<7}  {:>9.1}  {:>8.1}  {:>5}  {:>7.2}  {:>7.2}  {time:>8}",
                curve.track,
                curve.status,
                curve.length_px,
                curve.width_px,
                curve.descriptor.order,
                curve.descriptor.rms_px,
                curve.descriptor.max_px,
            )?;
        }
        Ok(())
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

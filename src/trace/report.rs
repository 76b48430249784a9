//! Output about a picture: a JSON object per line for programs, a table for people.

use crate::descriptor_json::{Descriptor, thousandths};
use crate::trace::frames::Shown;
use crate::versioned::Versioned;
use lariat_chain::confidence;
use lariat_chain::layout::{self, Column, hanging};
use lariat_extract::{Crossing, CrossingSequence, Scene};
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;

/// Complete result of one picture. Users rely on these keys.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) image: String,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) curves: Vec<CurveReport>,
    pub(super) crossings: Vec<CrossingReport>,
    /// Doubts about the automatic mask.
    pub(super) notices: Vec<NoticeReport>,
    pub(super) timing_us: Timing,
}

/// One rope.
#[derive(Debug, Serialize)]
pub(super) struct CurveReport {
    pub(super) track: u32,
    pub(super) status: &'static str,
    pub(super) closed: bool,
    /// True where the rope leaves the image at its first and its last point.
    pub(super) border: [bool; 2],
    /// Confidence that it is a rope, complete and in order, from 0 to 1.
    pub(super) confidence: f64,
    pub(super) length_px: f64,
    pub(super) width_px: f64,
    pub(super) points: Vec<[f64; 2]>,
    /// Width at each point.
    pub(super) widths_px: Vec<f64>,
    /// Indices of the points that something else covers.
    pub(super) hidden: Vec<usize>,
    /// Time since it was last seen, in ms; 0 unless the rope is lost.
    pub(super) age_ms: f64,
    /// Sequence of its passes over and under itself, from its first point on.
    pub(super) crossing_sequence: String,
    /// True if it becomes straight when its ends are pulled apart; `null`: undecided.
    pub(super) pulls_straight: Option<bool>,
    pub(super) descriptor: Descriptor,
}

/// A crossing of two strands.
#[derive(Debug, Serialize)]
pub(super) struct CrossingReport {
    pub(super) at: [f64; 2],
    pub(super) over: StrandReport,
    pub(super) under: StrandReport,
    pub(super) confidence: f64,
}

/// Reason why the mask may be wrong.
#[derive(Debug, Serialize)]
pub(super) struct NoticeReport {
    /// A short name, for programs.
    pub(super) kind: &'static str,
    /// A sentence that says what to do.
    pub(super) text: String,
}

/// A position on a rope.
#[derive(Debug, Serialize)]
pub(super) struct StrandReport {
    pub(super) track: u32,
    /// Normalized arc length.
    pub(super) rho: f64,
}

/// Time of each step, in µs.
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
    /// Rounds to the nanosecond, the resolution of the clock.
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

impl Report {
    /// Makes the report of a picture, with a descriptor for each curve. The extractor's part of the
    /// picture begins at `origin`.
    pub(super) fn of(
        shown: &Shown,
        scene: &Scene,
        origin: [usize; 2],
        descriptors: Vec<Descriptor>,
        timing_us: Timing,
    ) -> Self {
        let curves = descriptors.into_iter().enumerate();
        let crossings = scene.crossings.iter();
        let origin = origin.map(|c| c as f32);
        Self {
            image: shown.name.display().to_string(),
            width: shown.picture.width(),
            height: shown.picture.height(),
            curves: curves
                .map(|(index, descriptor)| curve_report(scene, origin, index, descriptor))
                .collect(),
            crossings: crossings
                .map(|crossing| crossing_report(scene, origin, crossing))
                .collect(),
            notices: Vec::new(),
            timing_us,
        }
    }

    pub(super) fn write_json(&self, output: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer(&mut *output, &Versioned::first(self))?;
        output.write_all(b"\n")
    }

    /// Number of crossings in which the rope is one of the two strands, or both.
    fn crossings_of(&self, track: u32) -> usize {
        let is_one = |crossing: &&CrossingReport| {
            [crossing.over.track, crossing.under.track].contains(&track)
        };
        self.crossings.iter().filter(is_one).count()
    }
}

/// Makes the report of a curve. The extractor's part of the picture begins at `origin`.
fn curve_report(
    scene: &Scene,
    origin: [f32; 2],
    index: usize,
    descriptor: Descriptor,
) -> CurveReport {
    let curve = &scene.curves[index];
    let sequence = CrossingSequence::of(scene, index);
    let rounded = |x: &f32| thousandths((*x).into());
    CurveReport {
        track: curve.track,
        status: curve.status.name(),
        closed: curve.closed,
        border: curve.border,
        confidence: rounded(&curve.confidence),
        length_px: rounded(&curve.length_px),
        width_px: rounded(&curve.width_px),
        points: curve
            .points
            .iter()
            .map(|p| [0, 1].map(|axis| rounded(&(p[axis] + origin[axis]))))
            .collect(),
        widths_px: curve.widths_px.iter().map(rounded).collect(),
        hidden: (0..curve.points.len())
            .filter(|&i| curve.hidden.get(i) == Some(&true))
            .collect(),
        age_ms: curve.age_ns as f64 / 1e6,
        crossing_sequence: sequence.to_string(),
        pulls_straight: sequence.pulls_straight(),
        descriptor,
    }
}

fn crossing_report(scene: &Scene, origin: [f32; 2], crossing: &Crossing) -> CrossingReport {
    let strand = |curve: usize, rho: f32| StrandReport {
        track: scene.curves[curve].track,
        // A tenth of a pixel on a rope of a thousand pixels.
        rho: (f64::from(rho) * 1e4).round() / 1e4,
    };
    CrossingReport {
        at: [0, 1].map(|axis| thousandths((crossing.at[axis] + origin[axis]).into())),
        over: strand(crossing.over, crossing.over_rho),
        under: strand(crossing.under, crossing.under_rho),
        confidence: thousandths(crossing.confidence.into()),
    }
}

/// A table that grows by one row per rope.
pub(super) struct Table {
    table: layout::Table,
    has_heading: bool,
    width: usize,
    has_colours: bool,
}

impl Table {
    /// `unit`: unit of the fit errors. `has_colours`: low confidence is printed in yellow.
    pub(super) fn new(images: &[PathBuf], unit: &'static str, has_colours: bool) -> Self {
        let names = images
            .iter()
            .map(|path| path.to_string_lossy().chars().count());
        let width = layout::width();
        let columns = vec![
            Column::words("image").wide(names.max().unwrap_or(0)),
            Column::figures("size")
                .wide("4096×3072".chars().count())
                .rank(4),
            Column::figures("rope"),
            Column::words("status").wide("doubtful".len()),
            Column::figures("conf."),
            Column::figures("long px").wide("1234.5".len()),
            Column::figures("wide px"),
            Column::figures("crossings").rank(2),
            Column::figures("points"),
            Column::words("fit").wide("coarse".len()),
            Column::figures(format!("rms {unit}")),
            Column::figures(format!("max {unit}")).rank(1),
            Column::figures("ms").wide("1234.5".len()).rank(3),
        ];
        Self {
            table: layout::Table::new(columns, width),
            has_heading: false,
            width,
            has_colours,
        }
    }

    pub(super) fn write(&mut self, report: &Report, output: &mut impl Write) -> io::Result<()> {
        if !std::mem::replace(&mut self.has_heading, true) {
            output.write_all(self.table.head().as_bytes())?;
        }
        let mut first = [
            report.image.clone(),
            format!("{}×{}", report.width, report.height),
            format!("{:.1}", report.timing_us.total / 1e3),
        ];
        if report.curves.is_empty() {
            let [name, size, time] = first;
            let none = String::new();
            let row = [
                &name, &size, "-", "no rope", &none, &none, &none, &none, &none, &none, &none,
                &none, &time,
            ];
            return output.write_all(self.table.row(row).as_bytes());
        }
        for curve in &report.curves {
            // A picture's name appears once.
            let [name, size, time] = std::mem::take(&mut first);
            let is_doubted = self.has_colours && confidence::is_low(curve.confidence);
            let paint: Option<layout::Paint> = is_doubted.then_some(layout::yellow);
            let row = self.table.painted_row([
                (name, None),
                (size, None),
                (curve.track.to_string(), None),
                (
                    confidence::status_word(curve.status, curve.confidence).to_owned(),
                    paint,
                ),
                (format!("{:.2}", curve.confidence), paint),
                (format!("{:.1}", curve.length_px), None),
                (format!("{:.1}", curve.width_px), None),
                (report.crossings_of(curve.track).to_string(), None),
                (curve.descriptor.control_points.len().to_string(), None),
                (
                    curve
                        .descriptor
                        .quality
                        .map_or("", |quality| quality.fit)
                        .to_owned(),
                    None,
                ),
                (format!("{:.2}", curve.descriptor.rms), None),
                (format!("{:.2}", curve.descriptor.max), None),
                (time, None),
            ]);
            output.write_all(row.as_bytes())?;
            if !curve.crossing_sequence.is_empty() {
                let pulls = match curve.pulls_straight {
                    Some(true) => "pulls straight",
                    Some(false) => "knotted",
                    None => "pulls straight or not: undecided",
                };
                let text = format!("  {}: {pulls}", curve.crossing_sequence);
                writeln!(output, "  {}", hanging(&text, 4, self.width))?;
            }
        }
        Ok(())
    }
}

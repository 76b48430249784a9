//! Figures of one run.

use lariat_sink::{Distances, Lost, Options, Sink};
use lariat_wire::{Centerlines, Descriptors, Status};
use serde::{Serialize, Serializer};
use std::collections::BTreeSet;
use std::time::Duration;

/// Column of one run, both while it is computed and when it is complete.
#[derive(Debug, Serialize)]
pub(in crate::replay) struct Figures {
    #[serde(skip)]
    sink: Sink,
    /// Frames with descriptors.
    pub(in crate::replay) frames: u64,
    /// Number of these frames in which no rope was found.
    pub(in crate::replay) frames_without_rope: u64,
    /// Distances from the truth, or from the recorded result, in pixels.
    pub(in crate::replay) centerline_px: Distances,
    pub(in crate::replay) curve_px: Distances,
    /// Mean over all curves, in the descriptors' unit.
    pub(in crate::replay) rms: Option<f64>,
    /// Frames that were lost.
    pub(in crate::replay) lost: Lost,
    /// Track numbers of all ropes.
    #[serde(serialize_with = "count")]
    pub(in crate::replay) ropes: BTreeSet<u32>,
    /// Number of ropes over all frames, by status.
    pub(in crate::replay) ropes_ok: u64,
    pub(in crate::replay) ropes_partial: u64,
    pub(in crate::replay) ropes_doubtful: u64,
    pub(in crate::replay) ropes_lost: u64,
    /// Times on this machine, measured now.
    pub(in crate::replay) extract_us: Spread,
    pub(in crate::replay) fit_us: Spread,
    #[serde(skip)]
    rms_sum: f64,
}

fn count<S: Serializer>(ropes: &BTreeSet<u32>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u64(ropes.len() as u64)
}

/// A distribution of times, in microseconds.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(in crate::replay) struct Spread {
    pub(in crate::replay) p50: Option<f64>,
    pub(in crate::replay) p99: Option<f64>,
}

/// Times of the frames of a run.
#[derive(Debug, Default)]
pub(super) struct Times {
    extract: Vec<Duration>,
    fit: Vec<Duration>,
}

impl Times {
    pub(super) fn add(&mut self, extract: Duration, fit: Duration) {
        self.extract.push(extract);
        self.fit.push(fit);
    }
}

fn spread(mut times: Vec<Duration>) -> Spread {
    times.sort_unstable();
    let at = |share: f64| {
        let place = (share * times.len() as f64) as usize;
        let time = times.get(place.min(times.len().saturating_sub(1)))?;
        Some((1e8 * time.as_secs_f64()).round() / 100.0)
    };
    Spread {
        p50: at(0.5),
        p99: at(0.99),
    }
}

impl Figures {
    pub(super) fn new() -> Self {
        Self {
            sink: Sink::new(Options::default()),
            frames: 0,
            frames_without_rope: 0,
            centerline_px: Distances::default(),
            curve_px: Distances::default(),
            rms: None,
            lost: Lost::default(),
            ropes: BTreeSet::new(),
            ropes_ok: 0,
            ropes_partial: 0,
            ropes_doubtful: 0,
            ropes_lost: 0,
            extract_us: Spread::default(),
            fit_us: Spread::default(),
            rms_sum: 0.0,
        }
    }

    pub(super) fn truth(&mut self, truth: &Centerlines) {
        self.sink.truth(truth);
    }

    pub(super) fn centerlines(&mut self, seen: &Centerlines) {
        self.sink.centerlines(seen);
    }

    pub(super) fn descriptors(&mut self, shapes: &Descriptors) {
        self.sink.descriptors(shapes, shapes.trace.fitted_ns);
        self.frames += 1;
        let mut seen = 0;
        for rope in shapes.curves() {
            self.ropes.insert(rope.track);
            let counter = match rope.status() {
                Some(Status::Ok) => &mut self.ropes_ok,
                Some(Status::Partial) => &mut self.ropes_partial,
                Some(Status::Doubtful) => &mut self.ropes_doubtful,
                _ => {
                    self.ropes_lost += 1;
                    continue;
                }
            };
            *counter += 1;
            seen += 1;
            self.rms_sum += rope.rms;
        }
        self.frames_without_rope += u64::from(seen == 0);
    }

    pub(super) fn finish(mut self, times: Times) -> Self {
        let report = self.sink.report();
        let summary = report.summary();
        self.centerline_px = summary.error_px.centerline;
        self.curve_px = summary.error_px.curve;
        self.lost = summary.frames.lost;
        let seen = self.ropes_ok + self.ropes_partial + self.ropes_doubtful;
        self.rms = (seen > 0).then(|| self.rms_sum / seen as f64);
        self.extract_us = spread(times.extract);
        self.fit_us = spread(times.fit);
        self
    }
}

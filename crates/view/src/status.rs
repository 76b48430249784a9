//! The state of the rig, four times per second, as JSON for the page.

use std::collections::VecDeque;

use lariat_sink::{Micros, Step};
use lariat_wire::{Trace, WireError};
use serde::Serialize;

use crate::gather::Gatherer;
use crate::recent::Recent;
use crate::view::{Losses, StageRow, StepRow, View};

/// Bars of the histogram per octave of latency, and the lowest latency in it: from 62.5 µs to a
/// second.
const BARS_PER_OCTAVE: f64 = 4.0;
const LEAST_US: f64 = 62.5;
const BARS: usize = 4 * 14;
/// Seconds in the strip.
const STRIP: usize = 60;
const SECOND_NS: u64 = 1_000_000_000;

/// The message to the page.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
struct Status<'a> {
    #[serde(rename = "type")]
    kind: &'static str,
    version: &'static str,
    rig: Option<&'a str>,
    /// Set if a recording is shown, not a rig.
    film: Option<&'a Film>,
    /// Reason, if there is nothing to show.
    obstacle: Option<&'a str>,
    lossless: bool,
    shared_mb: Option<f64>,
    fps: Option<f64>,
    age_s: Option<f64>,
    stages: Vec<Stage<'a>>,
    window_s: u64,
    steps: Vec<StepSaid>,
    limit: Option<String>,
    lost: Lost,
    histogram: Histogram,
    /// Median and 99th percentile for each of the last seconds, in µs, the newest last; null for a
    /// second without frames.
    strip: Vec<Option<[f64; 2]>>,
    notices: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Stage<'a> {
    stage: &'a str,
    pid: u32,
    cpu_percent: Option<f64>,
    own_mb: Option<f64>,
    fps: Option<f64>,
}

#[derive(Debug, Serialize)]
struct StepSaid {
    name: &'static str,
    wait: bool,
    whole: bool,
    p50: f64,
    p90: f64,
    p99: f64,
    max: f64,
}

#[derive(Debug, Serialize)]
struct Lost {
    source: u64,
    capture: u64,
    extract: u64,
    bridge: u64,
}

#[derive(Debug, Serialize)]
struct Histogram {
    least_us: f64,
    bars_per_octave: f64,
    counts: Vec<u32>,
}

/// A recording that is shown.
#[derive(Debug, Serialize)]
pub(crate) struct Film {
    pub(crate) name: String,
    pub(crate) frames: u64,
}

/// Makes one status after another.
#[derive(Debug, Default)]
pub(crate) struct Reporter {
    strip: VecDeque<Option<[f64; 2]>>,
    strip_due_ns: u64,
    /// Error from reading the rig, if there was one.
    trouble: Option<String>,
}

impl Reporter {
    /// Notes that part of the rig cannot be read, although there are descriptors.
    pub(crate) fn note(&mut self, error: &WireError) {
        self.trouble = Some(error.to_string());
    }

    /// Returns the status if the rig cannot be read at all.
    pub(crate) fn failed(error: &WireError) -> String {
        let view = View {
            obstacle: Some(error.to_string()),
            ..View::default()
        };
        Self::default().said(&view, Histogram::of(&[]), None, None)
    }

    /// Returns the status of a recording, from the traces of its frames.
    pub(crate) fn of_film(film: &Film, traces: &[Trace]) -> String {
        let mut recent = Recent::default();
        traces.iter().for_each(|trace| recent.add(trace));
        let mut reporter = Self::default();
        // Each place of the strip covers the same number of frames.
        let whole: Vec<f64> = recent.fitted_us(0);
        let part = whole.len().div_ceil(STRIP).max(1);
        reporter
            .strip
            .extend(whole.chunks(part).map(|part| middle_and_end(part.to_vec())));
        let view = View {
            steps: recent.since(0),
            ..View::default()
        };
        reporter.said(&view, Histogram::of(&whole), None, Some(film))
    }

    /// Returns the status now. `notice` is the doubt of the extraction.
    pub(crate) fn report(
        &mut self,
        gatherer: &Gatherer,
        notice: Option<String>,
        now_ns: u64,
    ) -> String {
        let view = gatherer.view(now_ns);
        if now_ns >= self.strip_due_ns {
            self.strip_due_ns = now_ns + SECOND_NS;
            let second = gatherer.fitted_us(now_ns.saturating_sub(SECOND_NS));
            self.strip.push_back(middle_and_end(second));
            if self.strip.len() > STRIP {
                self.strip.pop_front();
            }
        }
        let recent = gatherer.fitted_us(now_ns.saturating_sub(view.window_s * SECOND_NS));
        self.said(&view, Histogram::of(&recent), notice, None)
    }

    fn said(
        &self,
        view: &View,
        histogram: Histogram,
        notice: Option<String>,
        film: Option<&Film>,
    ) -> String {
        let status = Status {
            kind: "status",
            version: env!("CARGO_PKG_VERSION"),
            rig: view.rig.as_deref(),
            film,
            obstacle: view.obstacle.as_deref(),
            lossless: view.is_lossless,
            shared_mb: view.shared_mb,
            fps: view.stages.iter().rev().find_map(|row| row.frames_per_s),
            age_s: view.shape.as_ref().map(|shape| shape.age_s),
            stages: view.stages.iter().map(Stage::of).collect(),
            window_s: view.window_s,
            steps: view.steps.iter().map(StepSaid::of).collect(),
            limit: limit(&view.steps),
            lost: Lost::of(view.lost),
            histogram,
            strip: self.strip.iter().copied().collect(),
            notices: self.trouble.iter().cloned().chain(notice).collect(),
        };
        serde_json::to_string(&status).unwrap_or_else(|_| "{}".to_owned())
    }
}

impl<'a> Stage<'a> {
    fn of(row: &'a StageRow) -> Self {
        Self {
            stage: &row.stage,
            pid: row.pid,
            cpu_percent: row.cpu_percent,
            own_mb: row.own_mb,
            fps: row.frames_per_s,
        }
    }
}

impl StepSaid {
    fn of(row: &StepRow) -> Self {
        Self {
            name: row.step.label(),
            wait: row.step.is_wait(),
            whole: row.step == Step::Fitted,
            p50: row.p50,
            p90: row.p90,
            p99: row.p99,
            max: row.max,
        }
    }
}

impl Lost {
    fn of(lost: Losses) -> Self {
        Self {
            source: lost.source,
            capture: lost.capture,
            extract: lost.extract,
            bridge: lost.bridge,
        }
    }
}

impl Histogram {
    fn of(times_us: &[f64]) -> Self {
        let mut counts = vec![0; BARS];
        for us in times_us {
            let place = (us.max(LEAST_US) / LEAST_US).log2() * BARS_PER_OCTAVE;
            counts[(place as usize).min(BARS - 1)] += 1;
        }
        Self {
            least_us: LEAST_US,
            bars_per_octave: BARS_PER_OCTAVE,
            counts,
        }
    }
}

/// Returns the median and the 99th percentile; `None` without times.
fn middle_and_end(mut times: Vec<f64>) -> Option<[f64; 2]> {
    times.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| times.get(((times.len() as f64 * share).ceil() as usize).max(1) - 1);
    Some([*at(0.5)?, *at(0.99)?])
}

/// Names the part that takes most of the whole time, in words.
fn limit(steps: &[StepRow]) -> Option<String> {
    let whole = steps.iter().find(|row| row.step == Step::Fitted)?;
    let parts = steps.iter().filter(|row| row.step != Step::Fitted);
    let wait: f64 = parts
        .clone()
        .filter(|row| row.step.is_wait())
        .map(|row| row.p50)
        .sum();
    let works = parts.filter(|row| !row.step.is_wait());
    let longest = works.max_by(|a, b| a.p50.total_cmp(&b.p50))?;
    let (name, us) = match wait > longest.p50 {
        true => ("waiting for the next stage", wait),
        false => (longest.step.label(), longest.p50),
    };
    let [us, whole_us] = [us, whole.p50].map(|us| Micros(Some(us)).named());
    Some(format!("{name}, {us} of {whole_us}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_latency_stands_in_the_bar_of_its_octave() {
        let counts = Histogram::of(&[1.0, 62.5, 125.0, 125.1, 1e9]).counts;
        assert_eq!((counts[0], counts[4], counts[BARS - 1]), (2, 2, 1));
    }

    #[test]
    fn what_takes_longest_is_named() {
        let row = |step, p50| StepRow {
            step,
            p50,
            p90: p50,
            p99: p50,
            max: p50,
        };
        let mut steps = vec![
            row(Step::Fitted, 500.0),
            row(Step::Extract, 200.0),
            row(Step::WaitFit, 150.0),
        ];
        assert_eq!(limit(&steps).as_deref(), Some("extract, 200 µs of 500 µs"));
        steps.push(row(Step::WaitExtract, 90.0));
        assert_eq!(
            limit(&steps).as_deref(),
            Some("waiting for the next stage, 240 µs of 500 µs")
        );
        assert_eq!(limit(&[]), None);
    }

    #[test]
    fn a_second_without_frames_has_no_percentiles() {
        assert_eq!(middle_and_end(vec![]), None);
        assert_eq!(middle_and_end(vec![3.0, 1.0, 2.0]), Some([2.0, 3.0]));
    }
}

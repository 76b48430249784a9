//! `lariat topic delay`: the latency of frames, in total and for each step.
//!
//! Descriptors carry the stamps of all stages, so they give all steps whenever they are read. The
//! time until a reader has a message is the exception: `--in-hand` waits for each message, as a
//! control loop does.

use std::time::Duration;

use anyhow::Result;
use lariat_sink::{Micros, Step, Times};
use lariat_wire::{Rig, members};
use serde::{Serialize, Serializer};

use super::probe::Any;
use super::watch::Meter;
use crate::versioned::Versioned;

/// Times since the start, because percentiles need many samples.
pub(super) struct Delay {
    is_in_hand: bool,
    /// True before the first message, which may be arbitrarily old for a late reader.
    first: bool,
    messages: u64,
    steps: Vec<(Step, Times)>,
}

impl Delay {
    pub(super) fn new(is_in_hand: bool) -> Self {
        let steps = Step::ALL.into_iter();
        let shown =
            steps.filter(|step| is_in_hand || !matches!(step, Step::Received | Step::WaitSink));
        Self {
            is_in_hand,
            first: true,
            messages: 0,
            steps: shown.map(|step| (step, Times::default())).collect(),
        }
    }
}

/// Name of a step in JSON, as in a report's `summary.json`.
fn key(step: Step) -> &'static str {
    match step {
        Step::Received => "total",
        Step::Fitted => "fitted",
        Step::Capture => "capture",
        Step::WaitExtract => "wait_extract",
        Step::Extract => "extract",
        Step::WaitFit => "wait_fit",
        Step::Fit => "fit",
        Step::WaitSink => "wait_reader",
    }
}

#[derive(Serialize)]
struct Figures<'a> {
    rig: &'a str,
    channel: &'static str,
    messages: u64,
    latency_us: Steps<'a>,
    /// Possible error of the stamps, for a rig that a bridge brings here.
    #[serde(skip_serializing_if = "Option::is_none")]
    clock_bound_us: Option<f64>,
}

/// Possible error of the rig's stamps in µs, if a bridge brings the rig here.
fn clock_bound_us(rig: &Rig) -> Option<f64> {
    lariat_view::clock_bound_us(&members().ok()?, rig)
}

/// An object with one key for each step, in order.
struct Steps<'a>(&'a [(Step, Times)]);

impl Serialize for Steps<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let entry = |(step, times): &(Step, Times)| (key(*step), Percentiles::of(times));
        serializer.collect_map(self.0.iter().map(entry))
    }
}

#[derive(Serialize)]
struct Percentiles {
    p50: Option<f64>,
    p90: Option<f64>,
    p99: Option<f64>,
    p999: Option<f64>,
    max: Option<f64>,
}

impl Percentiles {
    fn of(times: &Times) -> Self {
        Self {
            p50: times.quantile_us(0.5),
            p90: times.quantile_us(0.9),
            p99: times.quantile_us(0.99),
            p999: times.quantile_us(0.999),
            max: times.quantile_us(1.0),
        }
    }
}

impl Meter for Delay {
    fn is_woken(&self) -> bool {
        self.is_in_hand
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_secs(5))
    }

    fn see(&mut self, message: Any, now_ns: u64) -> Result<String> {
        let is_first = std::mem::replace(&mut self.first, false);
        if message.is_blank() || is_first && self.is_in_hand {
            return Ok(String::new());
        }
        self.messages += 1;
        for (step, times) in &mut self.steps {
            if let Some(ns) = step.ns(message.trace(), now_ns) {
                times.add(ns);
            }
        }
        Ok(String::new())
    }

    fn report(&mut self, rig: &Rig, json: bool) -> Result<String> {
        if json {
            let figures = Figures {
                rig: rig.as_str(),
                channel: lariat_wire::DESCRIPTORS.name(),
                messages: self.messages,
                latency_us: Steps(&self.steps),
                clock_bound_us: clock_bound_us(rig),
            };
            return Ok(serde_json::to_string(&Versioned::first(figures))? + "\n");
        }
        let mut text = format!(
            "{:<20}     p50     p90     p99   p99.9     max   of {} frames\n",
            "latency, µs", self.messages
        );
        for (step, times) in &self.steps {
            let indent = match step {
                Step::Received | Step::Fitted => "",
                step if step.is_wait() => "    ",
                _ => "  ",
            };
            let label = match step {
                Step::WaitSink => "wait for reader",
                step => step.label(),
            };
            let Percentiles {
                p50,
                p90,
                p99,
                p999,
                max,
            } = Percentiles::of(times);
            let [p50, p90, p99, p999, max] = [p50, p90, p99, p999, max].map(Micros);
            let label = format!("{indent}{label}");
            text += &format!("{label:<20} {p50:>7} {p90:>7} {p99:>7} {p999:>7} {max:>7}\n");
        }
        if let Some(us) = clock_bound_us(rig) {
            text += &format!(
                "± {} of clock: a bridge brings this rig from another machine\n",
                Micros(Some(us)).named()
            );
        }
        text.push('\n');
        Ok(text)
    }
}

//! The slowest frames of a run, and the times of their steps.

use crate::figure::Micros;
use crate::latency::{Latency, Row};
use crate::passage::Passage;
use crate::saved::{RestoreError, Saved, Saving, sound};
use crate::step::Step;
use std::cmp::Reverse;
use std::fmt::{self, Write};

/// Number of frames kept.
const KEPT: usize = 20;

/// The frames with the longest time from exposure to reception. Adding another frame allocates
/// nothing.
#[derive(Debug, Clone)]
pub(crate) struct Slowest {
    passages: Vec<Passage>,
}

impl Slowest {
    pub(crate) fn new() -> Self {
        Self {
            passages: Vec::with_capacity(KEPT),
        }
    }

    pub(crate) fn add(&mut self, passage: Passage) {
        if self.passages.len() < KEPT {
            self.passages.push(passage);
            return;
        }
        let quickest = self.passages.iter_mut().min_by_key(|kept| total_ns(kept));
        if let Some(quickest) = quickest.filter(|kept| total_ns(kept) < total_ns(&passage)) {
            *quickest = passage;
        }
    }

    pub(crate) fn save(&self, to: &mut Saving) {
        to.number(self.passages.len() as u64);
        self.passages.iter().for_each(|passage| passage.save(to));
    }

    pub(crate) fn restore(from: &mut Saved) -> Result<Self, RestoreError> {
        let mut slowest = Self::new();
        for _ in 0..sound(from.number()?, |&count| count <= KEPT as u64)? {
            slowest.add(Passage::restore(from)?);
        }
        Ok(slowest)
    }

    /// Returns a table of the slowest frames, slowest first. It shows the steps in microseconds,
    /// and names the step that exceeded its median most. `start_ns` is the arrival time of the
    /// first message.
    pub(crate) fn table(&self, latency: &Latency, start_ns: u64) -> Result<String, fmt::Error> {
        let mut passages = self.passages.clone();
        passages.sort_unstable_by_key(|kept| (Reverse(total_ns(kept)), kept.trace.sequence));
        let us = |ns: u64| Micros(Some(ns as f64 / 1e3));
        let mut text = String::new();
        writeln!(
            text,
            "The slowest frames, µs; last, which step took most beyond its median.\n"
        )?;
        write!(text, "{:>8} {:>8}", "frame", "after, s")?;
        for step in ways() {
            let label = match step {
                Step::Received => "total",
                step if step.is_wait() => "wait",
                step => step.label(),
            };
            write!(text, " {label:>7}")?;
        }
        writeln!(text)?;
        for passage in &passages {
            let after_ns = passage.received_ns.saturating_sub(start_ns);
            let frame = passage.trace.sequence;
            write!(text, "{frame:>8} {:>8.3}", after_ns as f64 / 1e9)?;
            for step in ways() {
                write!(text, " {:>7}", us(passage.ns(step)))?;
            }
            let median_ns =
                |step| latency.row(Row::Way(step)).quantile_us(0.5).unwrap_or(0.0) * 1e3;
            let beyond_ns = |step: &Step| passage.ns(*step) as f64 - median_ns(*step);
            let most = ways()
                .skip(1)
                .max_by(|a, b| beyond_ns(a).total_cmp(&beyond_ns(b)));
            if let Some(step) = most {
                let half = Micros(Some(median_ns(step) / 1e3));
                write!(text, "  {}: half take {half} at most", step.label())?;
            }
            writeln!(text)?;
        }
        Ok(text)
    }
}

/// Returns the total and its steps.
fn ways() -> impl Iterator<Item = Step> {
    Step::ALL.into_iter().filter(|step| *step != Step::Fitted)
}

fn total_ns(passage: &Passage) -> u64 {
    passage.ns(Step::Received)
}

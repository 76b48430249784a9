//! How it goes just now, in one line.

use crate::latency::histogram;
use crate::losses::Ledger;
use hdrhistogram::Histogram;
use std::fmt::Write;

/// The figures of the line are those of the last whole interval of about a second: 0.9 s, so that a caller who comes
/// once a second, and a little early, is shown a new one each time.
const INTERVAL_NS: u64 = 900_000_000;

/// Longest latency the line tells from longer ones: 10 s.
const LONGEST_NS: u64 = 10_000_000_000;

/// One interval's figures.
#[derive(Debug, Clone, Copy, Default)]
struct Figures {
    frames_per_s: Option<f64>,
    p50_ns: Option<u64>,
    p99_ns: Option<u64>,
}

/// The line, and what it is made of.
#[derive(Debug)]
pub(crate) struct Live {
    since_ns: Option<u64>,
    frames: u64,
    curves: usize,
    total_ns: Histogram<u64>,
    figures: Figures,
    whole: bool,
    line: String,
}

impl Live {
    pub(crate) fn new() -> Self {
        Self {
            since_ns: None,
            frames: 0,
            curves: 0,
            // Two digits are more than the eye takes in, and a tenth of the memory to clear.
            total_ns: histogram(LONGEST_NS, 2),
            figures: Figures::default(),
            whole: false,
            line: String::with_capacity(256),
        }
    }

    /// A message came, with this many curves seen.
    pub(crate) fn received(&mut self, curves: usize, total_ns: Option<u64>, received_ns: u64) {
        self.since_ns.get_or_insert(received_ns);
        self.frames += 1;
        self.curves = curves;
        if let Some(total_ns) = total_ns {
            self.total_ns.saturating_record(total_ns);
        }
    }

    /// The line at this moment.
    pub(crate) fn line(&mut self, now_ns: u64, ledger: &Ledger) -> &str {
        self.line.clear();
        let _ = write!(self.line, "{} {}", now_ns, ledger.received_count());
        &self.line
    }
}

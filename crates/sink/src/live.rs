//! The live line: the current state of the chain.

use crate::error::Comparison;
use crate::figure::{Figure, Micros};
use crate::losses::Ledger;
use crate::times::Times;
use std::fmt::Write;

/// Length of the interval that the figures of the line cover. At 0.9 s, a caller that asks once a
/// second, and sometimes a little early, gets new figures each time.
const INTERVAL_NS: u64 = 900_000_000;

/// Longest latency that the line distinguishes from longer ones: 10 s.
const LONGEST_NS: u64 = 10_000_000_000;

/// Figures of one interval.
#[derive(Debug, Clone, Copy, Default)]
struct Figures {
    frames_per_s: Option<f64>,
    p50_us: Option<f64>,
    p99_us: Option<f64>,
    error_px: Option<f64>,
}

/// The line and its data.
#[derive(Debug)]
pub(crate) struct Live {
    /// Start of the interval.
    since_ns: Option<u64>,
    frames: u64,
    curves: usize,
    total: Times,
    /// Sum and number of the errors before the interval.
    errors_before: (f64, u64),
    /// Figures of the last complete interval.
    figures: Option<Figures>,
    line: String,
}

impl Live {
    /// `error` holds the errors before the first interval.
    pub(crate) fn new(error: &Comparison) -> Self {
        Self {
            since_ns: None,
            frames: 0,
            curves: 0,
            // Two digits are more than the eye can follow, and take a tenth of the memory to clear.
            total: Times::new(LONGEST_NS, 2),
            errors_before: error.nearest.sum(),
            figures: None,
            line: String::with_capacity(256),
        }
    }

    /// Notes a message with this many visible curves.
    pub(crate) fn received(&mut self, curves: usize, total_ns: Option<u64>, received_ns: u64) {
        // The first message starts the first interval. Each later message ends a frame period,
        // which is counted.
        match self.since_ns {
            None => self.since_ns = Some(received_ns),
            Some(_) => self.frames += 1,
        }
        self.curves = curves;
        if let Some(total_ns) = total_ns {
            self.total.add(total_ns);
        }
    }

    /// Returns the current line.
    pub(crate) fn line(&mut self, now_ns: u64, ledger: &Ledger, error: &Comparison) -> &str {
        let since_ns = *self.since_ns.get_or_insert(now_ns);
        let elapsed_ns = now_ns.saturating_sub(since_ns);
        let figures = if elapsed_ns >= INTERVAL_NS {
            let figures = self.figures(elapsed_ns, error);
            self.since_ns = Some(now_ns);
            self.frames = 0;
            self.total.clear();
            self.errors_before = error.nearest.sum();
            *self.figures.insert(figures)
        } else {
            // Until the first interval is complete, show the part of it that has passed.
            self.figures
                .unwrap_or_else(|| self.figures(elapsed_ns, error))
        };
        self.write(figures, ledger);
        &self.line
    }

    fn figures(&self, elapsed_ns: u64, error: &Comparison) -> Figures {
        let (sum, count) = error.nearest.sum();
        let (sum_before, count_before) = self.errors_before;
        Figures {
            frames_per_s: (elapsed_ns > 0).then(|| self.frames as f64 * 1e9 / elapsed_ns as f64),
            p50_us: self.total.quantile_us(0.5),
            p99_us: self.total.quantile_us(0.99),
            error_px: (count > count_before)
                .then(|| (sum - sum_before) / (count - count_before) as f64),
        }
    }

    fn write(&mut self, figures: Figures, ledger: &Ledger) {
        self.line.clear();
        // Writing to a string cannot fail.
        let _ = write!(
            self.line,
            "{:>5}/s  p50 {:>8}  p99 {:>8}  {} received, {} lost  {} {}",
            Figure(figures.frames_per_s),
            Micros(figures.p50_us).named(),
            Micros(figures.p99_us).named(),
            ledger.received_count(),
            ledger.lost().total(),
            self.curves,
            if self.curves == 1 { "curve" } else { "curves" },
        );
        if figures.error_px.is_some() {
            let _ = write!(self.line, "  {} px off", Figure(figures.error_px));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_message::Trace;

    fn receive(live: &mut Live, ledger: &mut Ledger, number: u64, received_ns: u64) {
        let trace = Trace {
            sequence: number,
            captured: number,
            extracted: number,
            fitted: number,
            ..Trace::EMPTY
        };
        ledger.received(&trace, received_ns);
        live.received(1, Some(500_000), received_ns);
    }

    #[test]
    fn the_line_shows_the_last_whole_second() {
        let (mut live, mut ledger) = (Live::new(&Comparison::new()), Ledger::new(true));
        let error = Comparison::new();
        assert_eq!(
            live.line(7, &ledger, &error),
            "    –/s  p50     – µs  p99     – µs  0 received, 0 lost  0 curves"
        );
        for number in 1..=100 {
            receive(&mut live, &mut ledger, number, number * 10_000_000);
        }
        let line = live.line(1_000_000_007, &ledger, &error).to_owned();
        assert_eq!(
            line,
            "  100/s  p50   500 µs  p99   500 µs  100 received, 0 lost  1 curve"
        );
        // In the middle of the next second, the figures stay and the counts change.
        receive(&mut live, &mut ledger, 102, 1_020_000_000);
        let line = live.line(1_100_000_000, &ledger, &error);
        assert!(line.starts_with("  100/s"), "{line}");
        assert!(line.contains("101 received, 1 lost"), "{line}");
    }

    #[test]
    fn a_chain_that_has_stalled_shows_no_frames() {
        let (mut live, mut ledger) = (Live::new(&Comparison::new()), Ledger::new(true));
        let error = Comparison::new();
        receive(&mut live, &mut ledger, 1, 10);
        live.line(1_000_000_000, &ledger, &error);
        let line = live.line(2_000_000_000, &ledger, &error);
        assert!(line.starts_with("    0/s  p50     – µs  "), "{line}");
    }
}

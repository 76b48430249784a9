//! The sink itself: messages in, figures out.

use crate::latency::{Latency, Row};
use crate::live::Live;
use crate::losses::{Arrival, Ledger};
use crate::summary::{Deadline, Distances, Errors, Frames, Latencies, Spread, Summary};
use crate::{FinalCounts, Machine, Options, Report};
use hdrhistogram::Histogram;
use lariat_wire::{Centerlines, Descriptors, Status};

/// Counts, times and checks what comes out of a chain.
///
/// It knows neither clock nor service: whoever receives the messages says when. Once made, it allocates nothing for a
/// message.
#[derive(Debug)]
pub struct Sink {
    options: Options,
    ledger: Ledger,
    latency: Latency,
    with_curve: u64,
    missed: u64,
    live: Live,
}

impl Sink {
    /// A sink that has seen nothing.
    pub fn new(options: Options) -> Self {
        Self {
            options,
            ledger: Ledger::new(options.from_start),
            latency: Latency::new(),
            with_curve: 0,
            missed: 0,
            live: Live::new(),
        }
    }

    /// One descriptors message, and when it was in the reader's hands. One that came before is not counted again.
    pub fn descriptors(&mut self, message: &Descriptors, received_ns: u64) {
        let arrival = self.ledger.received(&message.trace);
        if arrival == Arrival::Stale {
            return;
        }
        let seen = message
            .curves()
            .iter()
            .filter(|curve| matches!(curve.status(), Some(Status::Ok | Status::Partial)))
            .count();
        self.with_curve += u64::from(seen > 0);
        // The first message of a late joiner may have waited for it: its age is not the chain's.
        let timed = self.options.from_start || arrival == Arrival::Next;
        let total_ns = if timed {
            self.latency.record(&message.trace, received_ns)
        } else {
            None
        };
        if let (Some(total_ns), Some(deadline_ns)) = (total_ns, self.options.deadline_ns()) {
            self.missed += u64::from(total_ns > deadline_ns);
        }
        self.live.received(seen, total_ns, received_ns);
    }

    /// One centerlines message, for its error against the truth.
    pub fn centerlines(&mut self, _message: &Centerlines) {}

    /// The true centerlines of one frame, of a source that knows them.
    pub fn truth(&mut self, _message: &Centerlines) {}

    /// What the stages say they sent in all, known when the chain has stopped.
    pub fn finish(&mut self, sent: FinalCounts) {
        self.ledger.finish(sent);
    }

    /// How it goes just now, in one line without its end. To be called about once a second for lines, or ten times a
    /// second for one line in place.
    pub fn live_line(&mut self, now_ns: u64) -> &str {
        self.live.line(now_ns, &self.ledger)
    }

    /// What has been seen so far, on this machine.
    pub fn report(&self) -> Report {
        self.report_on(Machine::this())
    }

    /// What has been seen so far, for the machine that is given.
    pub fn report_on(&self, machine: Machine) -> Report {
        Report {
            summary: self.summary(machine),
            latency: self.latency.clone(),
            restarts: self.ledger.restarts(),
        }
    }

    fn summary(&self, machine: Machine) -> Summary {
        let spread = |row| spread(self.latency.row(row));
        let deadline_ns = self.options.deadline_ns();
        Summary {
            schema: 1,
            frames: Frames {
                published: self.ledger.published(),
                received: self.ledger.received_count(),
                with_curve: self.with_curve,
                lost: self.ledger.lost(),
            },
            latency_us: Latencies {
                total: spread(Row::Total),
                capture: spread(Row::Capture),
                extract: spread(Row::Extract),
                fit: spread(Row::Fit),
                wait_extract: spread(Row::WaitExtract),
                wait_fit: spread(Row::WaitFit),
                wait_sink: spread(Row::WaitSink),
            },
            error_px: Errors {
                centerline: Distances::default(),
                curve: Distances::default(),
            },
            deadline: Deadline {
                us: deadline_ns.map(|ns| microseconds(ns as f64)),
                missed: deadline_ns.map(|_| self.missed),
            },
            machine,
        }
    }
}

/// The figures of a histogram of nanoseconds.
fn spread(histogram: &Histogram<u64>) -> Spread {
    if histogram.is_empty() {
        return Spread::default();
    }
    let at = |quantile| {
        // A bucket's upper edge may lie past the largest value in it.
        let ns = histogram.value_at_quantile(quantile).min(histogram.max());
        Some(microseconds(ns as f64))
    };
    Spread {
        p50: at(0.5),
        p90: at(0.9),
        p99: at(0.99),
        p999: at(0.999),
        max: Some(microseconds(histogram.max() as f64)),
        mean: Some(microseconds(histogram.mean())),
    }
}

/// Nanoseconds in microseconds, to a hundredth.
fn microseconds(ns: f64) -> f64 {
    (ns / 10.0).round() / 100.0
}

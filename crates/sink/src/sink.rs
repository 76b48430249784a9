//! The sink itself: messages in, figures out.

use crate::latency::{Latency, Row};
use crate::live::Live;
use crate::losses::{Arrival, Ledger};
use crate::report::Facts;
use crate::step::Step;
use crate::summary::{Deadline, Errors, Frames, Latencies, Summary};
use crate::timeline::Timeline;
use crate::times::to_hundredths;
use crate::truth::{Truth, is_seen};
use crate::{FinalCounts, Machine, Options, Report};
use lariat_message::{Centerlines, Descriptors};

/// Counts, times and checks what comes out of a chain.
///
/// It knows neither clock nor service: whoever receives the messages says when. Once made, it allocates nothing for a
/// message.
#[derive(Debug)]
pub struct Sink {
    options: Options,
    ledger: Ledger,
    latency: Latency,
    timeline: Timeline,
    truth: Truth,
    with_curve: u64,
    blank: u64,
    missed: u64,
    span_ns: Option<(u64, u64)>,
    finished: Option<FinalCounts>,
    live: Live,
}

impl Sink {
    /// A sink that has seen nothing.
    pub fn new(options: Options) -> Self {
        Self {
            options,
            ledger: Ledger::new(options.from_start),
            latency: Latency::new(),
            timeline: Timeline::new(),
            truth: Truth::new(),
            with_curve: 0,
            blank: 0,
            missed: 0,
            span_ns: None,
            finished: None,
            live: Live::new(),
        }
    }

    /// One descriptors message, and when it was in the reader's hands. One that came before is not counted again.
    pub fn descriptors(&mut self, message: &Descriptors, received_ns: u64) {
        let arrival = self.ledger.received(&message.trace, received_ns);
        if arrival == Arrival::Stale {
            return;
        }
        let seen = message
            .curves()
            .iter()
            .filter(|curve| is_seen(curve.status()))
            .count();
        self.with_curve += u64::from(seen > 0);
        // Without an image there is nothing that was exposed.
        let is_blank = message.width == 0;
        self.blank += u64::from(is_blank);
        // The first message of a late joiner may have waited for it: its age is not the chain's.
        let timed = !is_blank && (self.options.from_start || arrival == Arrival::Next);
        let total_ns = if timed {
            self.latency.record(&message.trace, received_ns)
        } else {
            None
        };
        if timed {
            self.timeline.add(&message.trace, received_ns);
        }
        if let (Some(total_ns), Some(deadline_ns)) = (total_ns, self.options.deadline_ns()) {
            self.missed += u64::from(total_ns > deadline_ns);
        }
        let first_ns = self.span_ns.map_or(received_ns, |(first_ns, _)| first_ns);
        self.span_ns = Some((first_ns, received_ns));
        self.live.received(seen, total_ns, received_ns);
        self.truth.descriptors(message);
    }

    /// One centerlines message, for its error against the truth.
    pub fn centerlines(&mut self, message: &Centerlines) {
        self.truth.centerlines(message);
    }

    /// The true centerlines of one frame, of a source that knows them; before or after what was measured in it.
    pub fn truth(&mut self, message: &Centerlines) {
        self.truth.truth(message);
    }

    /// What the stages say they sent in all, known when the chain has stopped.
    pub fn finish(&mut self, sent: FinalCounts) {
        self.ledger.finish(sent);
        self.finished = Some(sent);
    }

    /// How it goes just now, in one line without its end. To be called about once a second for lines, or ten times a
    /// second for one line in place.
    pub fn live_line(&mut self, now_ns: u64) -> &str {
        let error = match self.truth.centerline.frames {
            0 => &self.truth.curve,
            _ => &self.truth.centerline,
        };
        self.live.line(now_ns, &self.ledger, error)
    }

    /// How many frames so far, and where they went.
    pub fn frames(&self) -> Frames {
        Frames {
            published: self.ledger.published(),
            received: self.ledger.received_count(),
            with_curve: self.with_curve,
            lost: self.ledger.lost(),
        }
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
            timeline: self.timeline.clone(),
            centerline: self.truth.centerline.clone(),
            curve: self.truth.curve.clone(),
            facts: Facts {
                period_ns: self.options.period_ns,
                from_start: self.options.from_start,
                span_ns: self.span_ns,
                restarts: self.ledger.restarts(),
                stale: self.ledger.stale(),
                blank: self.blank,
                unknown_basis: self.truth.unknown_basis,
                elsewhere: self.truth.elsewhere,
                finished: self.finished,
            },
        }
    }

    fn summary(&self, machine: Machine) -> Summary {
        let spread = |row| self.latency.row(row).spread();
        let deadline_ns = self.options.deadline_ns();
        Summary {
            schema: 1,
            frames: self.frames(),
            latency_us: Latencies {
                total: spread(Row::Way(Step::Received)),
                capture: spread(Row::Way(Step::Capture)),
                extract: spread(Row::Way(Step::Extract)),
                fit: spread(Row::Way(Step::Fit)),
                wait_extract: spread(Row::Way(Step::WaitExtract)),
                wait_fit: spread(Row::Way(Step::WaitFit)),
                wait_sink: spread(Row::Way(Step::WaitSink)),
            },
            error_px: Errors {
                centerline: self.truth.centerline.nearest.distances(),
                curve: self.truth.curve.nearest.distances(),
            },
            deadline: Deadline {
                us: deadline_ns.map(|ns| to_hundredths(ns as f64 / 1e3)),
                missed: deadline_ns.map(|_| self.missed),
            },
            machine,
        }
    }
}

//! The tally behind a report: everything that was counted, timed and compared until now. It can be
//! saved and continued.

use crate::counts::Counts;
use crate::error::Compared;
use crate::latency::{Latency, Row};
use crate::losses::Arrival;
use crate::passage::Passage;
use crate::receipt::Receipt;
use crate::report::Facts;
use crate::saved::{self, Kind, RestoreError};
use crate::slowest::Slowest;
use crate::step::Step;
use crate::summary::{Deadline, Depth, Errors, Frames, Latencies, Summary};
use crate::timeline::Timeline;
use crate::times::to_hundredths;
use crate::{FinalCounts, Machine, Options, Report};

/// Everything that was counted, timed and compared in a run until now.
///
/// A [`Sink`](crate::Sink) contains one. A second tally that takes the same [receipts](Receipt),
/// and from time to time [the comparisons](Self::take_comparisons), gives the same results. A
/// thread can use it to write reports while the sink receives.
#[derive(Debug, Clone)]
pub struct Tally {
    options: Options,
    pub(crate) counts: Counts,
    latency: Latency,
    timeline: Timeline,
    slowest: Slowest,
    missed: u64,
    pub(crate) compared: Compared,
    finished: Option<FinalCounts>,
}

impl Tally {
    /// Creates an empty tally.
    pub fn new(options: Options) -> Self {
        Self {
            options,
            counts: Counts::new(options.from_start),
            latency: Latency::new(),
            timeline: Timeline::new(),
            slowest: Slowest::new(),
            missed: 0,
            compared: Compared::new(),
            finished: None,
        }
    }

    /// Counts and times one message. A repeated message is not counted again. Allocates nothing.
    ///
    /// Returns the total latency in nanoseconds, if it counts and is known.
    pub fn count(&mut self, receipt: &Receipt) -> (Arrival, Option<u64>) {
        let arrival = self.counts.count(receipt);
        let Receipt {
            trace, received_ns, ..
        } = receipt;
        let timed = match arrival {
            Arrival::Stale => return (arrival, None),
            // The first message of a late joiner may have waited for it, so its age says nothing
            // about the chain.
            Arrival::First => self.options.from_start,
            Arrival::Resumed => false,
            Arrival::Next => true,
        };
        if !timed || receipt.is_blank {
            return (arrival, None);
        }
        let total_ns = self.latency.record(trace, *received_ns);
        let passage = Passage {
            trace: *trace,
            received_ns: *received_ns,
        };
        self.timeline.add(passage);
        if total_ns.is_some() {
            self.slowest.add(passage);
        }
        if let (Some(total_ns), Some(deadline_ns)) = (total_ns, self.options.deadline_ns()) {
            self.missed += u64::from(total_ns > deadline_ns);
        }
        (arrival, total_ns)
    }

    /// Copies the comparisons that another tally has made since the last call. Allocates nothing,
    /// and copies only what has changed.
    pub fn take_comparisons(&mut self, from: &Self) {
        self.compared.follow(&from.compared);
    }

    pub(crate) fn finish(&mut self, sent: FinalCounts) {
        self.counts.ledger.finish(sent);
        self.finished = Some(sent);
    }

    /// Returns the number of frames until now, and the losses.
    pub fn frames(&self) -> Frames {
        let ledger = &self.counts.ledger;
        Frames {
            published: ledger.published(),
            received: ledger.received_count(),
            with_curve: self.counts.with_curve,
            lost: ledger.lost(),
            at_restart: ledger.at_restart(),
        }
    }

    /// Returns the report of this run until now, for the given machine.
    pub fn report_on(&self, machine: Machine) -> Report {
        let ledger = &self.counts.ledger;
        Report {
            summary: self.summary(machine),
            latency: self.latency.clone(),
            timeline: self.timeline.clone(),
            slowest: self.slowest.clone(),
            compared: self.compared.clone(),
            facts: Facts {
                period_ns: self.options.period_ns,
                from_start: self.options.from_start,
                span_ns: self.counts.span_ns,
                restarts: ledger.restarts(),
                stale: ledger.stale(),
                blank: self.counts.blank,
                finished: self.finished,
            },
        }
    }

    fn summary(&self, machine: Machine) -> Summary {
        let spread = |row| self.latency.row(row).spread();
        let deadline_ns = self.options.deadline_ns();
        Summary {
            schema: 2,
            finished: self.finished.is_some(),
            frames: self.frames(),
            depth: self.finished.as_ref().and_then(Depth::of),
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
                centerline: self.compared.centerline.nearest.distances(),
                curve: self.compared.curve.nearest.distances(),
            },
            deadline: Deadline {
                us: deadline_ns.map(|ns| to_hundredths(ns as f64 / 1e3)),
                missed: deadline_ns.map(|_| self.missed),
            },
            machine,
        }
    }

    /// Appends the tally to a buffer. It takes some kilobytes, and about 60 kB for the stamps of
    /// 1,000 frames. The final totals of the stages are not included, because a tally that has them
    /// is not continued.
    pub fn save(&self, into: &mut Vec<u8>) {
        saved::save(Kind::Tally, into, |to| {
            self.counts.save(to);
            to.number(self.missed);
            self.latency.save(to);
            self.timeline.save(to);
            self.slowest.save(to);
            self.compared.save(to);
        });
    }

    /// Reads the output of [`save`](Self::save). `options` are those in force from now on.
    ///
    /// # Errors
    /// Returns an error if the bytes are incomplete or come from another release.
    pub fn restore(options: Options, bytes: &[u8]) -> Result<Self, RestoreError> {
        let mut from = saved::open(Kind::Tally, bytes)?;
        let tally = Self {
            options,
            counts: Counts::restore(&mut from, options.from_start)?,
            missed: from.count()?,
            latency: Latency::restore(&mut from)?,
            timeline: Timeline::restore(&mut from)?,
            slowest: Slowest::restore(&mut from)?,
            compared: Compared::restore(&mut from)?,
            finished: None,
        };
        from.end()?;
        Ok(tally)
    }

    /// Appends only the counts to a buffer, without times and comparisons. They take about 100
    /// bytes and are meant to be saved with each message. Allocates only if the buffer grows.
    pub fn save_counts(&self, into: &mut Vec<u8>) {
        saved::save(Kind::Counts, into, |to| self.counts.save(to));
    }

    /// Replaces the counts by the output of [`save_counts`](Self::save_counts).
    ///
    /// # Errors
    /// Fails like [`restore`](Self::restore).
    pub fn restore_counts(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut from = saved::open(Kind::Counts, bytes)?;
        let counts = Counts::restore(&mut from, self.options.from_start)?;
        from.end()?;
        self.counts = counts;
        Ok(())
    }

    /// Continues from the counts of a sink that has ended. All messages that fit sent before the
    /// next received message count as lost with that sink. The next received message may have
    /// waited, so it is not timed.
    #[must_use]
    pub fn resumed(mut self) -> Self {
        self.counts.ledger.resume();
        self.latency.resume();
        self
    }
}

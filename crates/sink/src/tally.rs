//! All that a report says of a run: what was counted, timed and compared so far. It can be saved, and gone on with.

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

/// What was counted, timed and compared of a run so far.
///
/// A [`Sink`](crate::Sink) has one. A second one that is told the same [receipts](Receipt), and now and then
/// [what was compared](Self::take_comparisons), says the same: for a thread that writes reports while the sink receives.
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
    /// Of nothing.
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

    /// Counts and times one message. A message that came before is not counted again. Allocates nothing.
    ///
    /// Returns the whole way in nanoseconds, if it counts and is known.
    pub fn count(&mut self, receipt: &Receipt) -> (Arrival, Option<u64>) {
        let arrival = self.counts.count(receipt);
        let Receipt {
            trace, received_ns, ..
        } = receipt;
        let timed = match arrival {
            Arrival::Stale => return (arrival, None),
            // The first message of a late joiner may have waited for it: its age is not the chain's.
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

    /// Takes over what another has compared with the truth since the last time. Allocates nothing, and copies only where
    /// something came.
    pub fn take_comparisons(&mut self, from: &Self) {
        self.compared.follow(&from.compared);
    }

    pub(crate) fn finish(&mut self, sent: FinalCounts) {
        self.counts.ledger.finish(sent);
        self.finished = Some(sent);
    }

    /// How many frames so far, and where they went.
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

    /// What has been seen so far, for the machine that is given.
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

    /// Writes all of it behind what is in a buffer: some kilobytes, and some 60 for the stamps of 1,000 frames. What the stages said at the end is not in it: a tally that has it is not gone on with.
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

    /// Reads what [`save`](Self::save) wrote. `options`: those that hold from now on.
    ///
    /// # Errors
    /// The bytes are not whole, or of another release.
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

    /// Writes the counts alone, without what is timed and compared, behind what is in a buffer: some 100 bytes, to be written with
    /// each message. Allocates only where the buffer grows.
    pub fn save_counts(&self, into: &mut Vec<u8>) {
        saved::save(Kind::Counts, into, |to| self.counts.save(to));
    }

    /// Takes over counts that [`save_counts`](Self::save_counts) wrote.
    ///
    /// # Errors
    /// As of [`restore`](Self::restore).
    pub fn restore_counts(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut from = saved::open(Kind::Counts, bytes)?;
        let counts = Counts::restore(&mut from, self.options.from_start)?;
        from.end()?;
        self.counts = counts;
        Ok(())
    }

    /// Goes on where a sink stopped that is gone: what fit sent from then until the next message counts as lost with that one,
    /// and that message, which may have waited, is not timed.
    #[must_use]
    pub fn resumed(mut self) -> Self {
        self.counts.ledger.resume();
        self.latency.resume();
        self
    }
}

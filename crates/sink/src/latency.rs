//! Latency of a frame: one HDR histogram for each step, and one for the total.
//!
//! Every stage stamps its own beginning and end, so work and waiting are separated frame by frame.
//! The steps are the differences of neighboring stamps and add up to the total. A stamp of 0 is
//! unknown, and its steps are left out. A stamp before its predecessor makes a step of 0, never a
//! negative or huge one, and is counted.

use crate::saved::{RestoreError, Saved, Saving};
use crate::step::Step;
use crate::times::{LONGEST_NS, Times};
use lariat_message::Trace;

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Row {
    /// A step, or the total.
    Way(Step),
    /// The total without the work of extraction and fit: the cost of the chain itself.
    Overhead,
    /// The three waits together: the overhead without the lateness of capture.
    Links,
    /// Irregularity with which descriptors arrive.
    Jitter,
}

/// Number of rows.
const ROWS: usize = Step::ALL.len() + 3;

impl Row {
    /// Returns all rows, in the order of the table.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let way = Step::ALL.into_iter().map(Self::Way);
        way.chain([Self::Overhead, Self::Links, Self::Jitter])
    }

    /// Returns the name of the row's `.hgrm` file, which is also its key in `summary.json` if it
    /// appears there.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Way(Step::Received) => "total",
            Self::Way(Step::Fitted) => "fitted",
            Self::Way(Step::Capture) => "capture",
            Self::Way(Step::WaitExtract) => "wait_extract",
            Self::Way(Step::Extract) => "extract",
            Self::Way(Step::WaitFit) => "wait_fit",
            Self::Way(Step::Fit) => "fit",
            Self::Way(Step::WaitSink) => "wait_sink",
            Self::Overhead => "overhead",
            Self::Links => "links",
            Self::Jitter => "jitter",
        }
    }

    fn place(self) -> usize {
        match self {
            Self::Way(step) => step as usize,
            Self::Overhead => ROWS - 3,
            Self::Links => ROWS - 2,
            Self::Jitter => ROWS - 1,
        }
    }
}

/// The histograms of all rows.
#[derive(Debug, Clone)]
pub(crate) struct Latency {
    rows: [Times; ROWS],
    saturated: u64,
    backwards: u64,
    previous: Option<(u64, u64)>,
}

impl Latency {
    pub(crate) fn new() -> Self {
        Self {
            rows: std::array::from_fn(|_| Times::default()),
            saturated: 0,
            backwards: 0,
            previous: None,
        }
    }

    /// Returns the durations of a row.
    pub(crate) fn row(&self, row: Row) -> &Times {
        &self.rows[row.place()]
    }

    /// Returns the number of times that exceed the range of the histograms.
    pub(crate) fn saturated(&self) -> u64 {
        self.saturated
    }

    /// Returns the number of messages with a stamp before its predecessor.
    pub(crate) fn backwards(&self) -> u64 {
        self.backwards
    }

    /// Forgets the previous message, because the next one does not follow it directly.
    pub(crate) fn resume(&mut self) {
        self.previous = None;
    }

    pub(crate) fn save(&self, to: &mut Saving) {
        self.rows.iter().for_each(|row| row.save(to));
        to.numbers([self.saturated, self.backwards]);
        to.optional(self.previous.map(<[u64; 2]>::from));
    }

    pub(crate) fn restore(from: &mut Saved) -> Result<Self, RestoreError> {
        let mut latency = Self::new();
        for row in &mut latency.rows {
            row.restore(from)?;
        }
        (latency.saturated, latency.backwards) = (from.count()?, from.count()?);
        latency.previous = from.optional()?.map(<(u64, u64)>::from);
        Ok(latency)
    }

    /// Records one message. Returns the total in nanoseconds, if it is known.
    pub(crate) fn record(&mut self, trace: &Trace, received_ns: u64) -> Option<u64> {
        let mut backwards = false;
        for step in Step::ALL {
            if let Some((from, to)) = step.ends_ns(trace, received_ns) {
                backwards |= to < from;
                self.add(Row::Way(step), to.saturating_sub(from));
            }
        }
        self.backwards += u64::from(backwards);
        self.without_work(trace, received_ns);
        self.jitter(trace.exposed_ns, received_ns);
        (trace.exposed_ns != 0).then(|| received_ns.saturating_sub(trace.exposed_ns))
    }

    /// Records the total without the work. This is done frame by frame, because a difference of
    /// percentiles is not a percentile of the differences.
    fn without_work(&mut self, trace: &Trace, received_ns: u64) {
        let stamps = [
            trace.exposed_ns,
            trace.captured_ns,
            trace.extract_started_ns,
            trace.extracted_ns,
            trace.fit_started_ns,
            trace.fitted_ns,
        ];
        if stamps.contains(&0) {
            return;
        }
        let work_ns = trace.extracted_ns.saturating_sub(trace.extract_started_ns)
            + trace.fitted_ns.saturating_sub(trace.fit_started_ns);
        for (row, from_ns) in [
            (Row::Overhead, trace.exposed_ns),
            (Row::Links, trace.captured_ns),
        ] {
            let way_ns = received_ns.saturating_sub(from_ns);
            // Times beyond the range of a histogram are already counted with the total.
            self.rows[row.place()].add(way_ns.saturating_sub(work_ns));
        }
    }

    /// Records the period jitter |(Rᵢ − Rᵢ₋₁) − (Sᵢ − Sᵢ₋₁)|: the difference between the time from
    /// one reception to the next and the time between their exposures. It is the interarrival
    /// jitter of RFC 3550, section 6.4.1. The exposures of a paced source are one nominal period
    /// apart, or a multiple of it where frames were lost. A loss therefore does not count as
    /// jitter.
    fn jitter(&mut self, exposed_ns: u64, received_ns: u64) {
        if exposed_ns == 0 {
            self.previous = None;
            return;
        }
        if let Some((exposed_before, received_before)) = self.previous {
            let exposures = i128::from(exposed_ns) - i128::from(exposed_before);
            let receptions = i128::from(received_ns) - i128::from(received_before);
            let deviation = (receptions - exposures).unsigned_abs();
            self.add(Row::Jitter, u64::try_from(deviation).unwrap_or(u64::MAX));
        }
        self.previous = Some((exposed_ns, received_ns));
    }

    fn add(&mut self, row: Row, ns: u64) {
        self.saturated += u64::from(ns > LONGEST_NS);
        self.rows[row.place()].add(ns);
    }
}

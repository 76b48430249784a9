//! Where the time of a frame went: one HDR histogram for each piece of the way, and one for the whole.
//!
//! Because every stage stamps its own beginning and end, work and waiting are told apart frame by frame: the pieces are
//! the differences of neighbouring stamps and add up to the whole. A stamp that is 0 is not known, and its pieces are
//! left out; one that lies before its predecessor makes a piece of 0, never a negative or giant one, and is counted.

use crate::step::Step;
use crate::times::{LONGEST_NS, Times};
use lariat_message::Trace;

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Row {
    /// Exposed → received: the whole way.
    Total,
    /// Exposed → fitted: without the way to the reader.
    Fitted,
    /// Exposed → captured.
    Capture,
    /// Captured → extract begins.
    WaitExtract,
    /// Extract begins → extracted.
    Extract,
    /// Extracted → fit begins.
    WaitFit,
    /// Fit begins → fitted.
    Fit,
    /// Fitted → received.
    WaitSink,
    /// The whole way without the work of extraction and fit: what the chain itself costs.
    Overhead,
    /// The three waits together: the overhead without how late capture was.
    Links,
    /// How unevenly descriptors come.
    Jitter,
}

impl Row {
    /// All rows, as they stand in the table.
    pub(crate) const ALL: [Self; 11] = [
        Self::Total,
        Self::Fitted,
        Self::Capture,
        Self::WaitExtract,
        Self::Extract,
        Self::WaitFit,
        Self::Fit,
        Self::WaitSink,
        Self::Overhead,
        Self::Links,
        Self::Jitter,
    ];

    /// The step of the way that it times; `None` if it is another figure.
    pub(crate) fn step(self) -> Option<Step> {
        match self {
            Self::Total => Some(Step::Received),
            Self::Fitted => Some(Step::Fitted),
            Self::Capture => Some(Step::Capture),
            Self::WaitExtract => Some(Step::WaitExtract),
            Self::Extract => Some(Step::Extract),
            Self::WaitFit => Some(Step::WaitFit),
            Self::Fit => Some(Step::Fit),
            Self::WaitSink => Some(Step::WaitSink),
            Self::Overhead | Self::Links | Self::Jitter => None,
        }
    }

    /// The row's name, as in `summary.json` where it stands there, and of its `.hgrm` file.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Total => "total",
            Self::Fitted => "fitted",
            Self::Capture => "capture",
            Self::WaitExtract => "wait_extract",
            Self::Extract => "extract",
            Self::WaitFit => "wait_fit",
            Self::Fit => "fit",
            Self::WaitSink => "wait_sink",
            Self::Overhead => "overhead",
            Self::Links => "links",
            Self::Jitter => "jitter",
        }
    }
}

/// The histograms of all rows.
#[derive(Debug, Clone)]
pub(crate) struct Latency {
    rows: [Times; Row::ALL.len()],
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

    /// The durations of a row.
    pub(crate) fn row(&self, row: Row) -> &Times {
        &self.rows[row as usize]
    }

    /// Times longer than the histograms reach.
    pub(crate) fn saturated(&self) -> u64 {
        self.saturated
    }

    /// Messages with a stamp that lies before its predecessor on the way.
    pub(crate) fn backwards(&self) -> u64 {
        self.backwards
    }

    /// Records one message. Returns the whole way in nanoseconds, if it is known.
    pub(crate) fn record(&mut self, trace: &Trace, received_ns: u64) -> Option<u64> {
        let mut backwards = false;
        for row in Row::ALL {
            let ends = row.step().and_then(|step| step.ends_ns(trace, received_ns));
            if let Some((from, to)) = ends {
                backwards |= to < from;
                self.add(row, to.saturating_sub(from));
            }
        }
        self.backwards += u64::from(backwards);
        self.without_work(trace, received_ns);
        self.jitter(trace.exposed_ns, received_ns);
        (trace.exposed_ns != 0).then(|| received_ns.saturating_sub(trace.exposed_ns))
    }

    /// Records what is left of the way when the work is taken off: frame by frame, as a difference of percentiles is not a percentile
    /// of the differences.
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
            // Longer than a histogram reaches: counted with the whole way already.
            self.rows[row as usize].add(way_ns.saturating_sub(work_ns));
        }
    }

    /// Records the period jitter: how much the time between two receptions differs from the time between their
    /// exposures, |(Rᵢ − Rᵢ₋₁) − (Sᵢ − Sᵢ₋₁)|, the interarrival jitter of RFC 3550, section 6.4.1. For a paced source
    /// the exposures are the nominal period apart, or whole multiples of it where frames were lost, so that a loss is
    /// not taken for jitter.
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
        self.rows[row as usize].add(ns);
    }
}

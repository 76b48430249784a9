//! The steps of a frame's latency, each between two neighboring stamps.

use lariat_message::Trace;

/// A step, or the total. The steps from [`Capture`](Self::Capture) on add up to
/// [`Received`](Self::Received).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Exposed → received: the total.
    Received,
    /// Exposed → fitted: without the transport to the reader.
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
}

impl Step {
    /// All steps, the total first.
    pub const ALL: [Self; 8] = [
        Self::Received,
        Self::Fitted,
        Self::Capture,
        Self::WaitExtract,
        Self::Extract,
        Self::WaitFit,
        Self::Fit,
        Self::WaitSink,
    ];

    /// Returns the name in tables.
    pub fn label(self) -> &'static str {
        match self {
            Self::Received => "exposed → received",
            Self::Fitted => "exposed → fitted",
            Self::Capture => "capture",
            Self::WaitExtract => "wait for extract",
            Self::Extract => "extract",
            Self::WaitFit => "wait for fit",
            Self::Fit => "fit",
            Self::WaitSink => "wait for sink",
        }
    }

    /// Returns true if no stage works during this step.
    pub fn is_wait(self) -> bool {
        matches!(self, Self::WaitExtract | Self::WaitFit | Self::WaitSink)
    }

    /// Returns the start and the end of the step in a frame's trace, in nanoseconds of
    /// `CLOCK_MONOTONIC`. Returns `None` if either is unknown. `received_ns` is the time of the
    /// message's reception, or 0 if that is unknown.
    pub fn ends_ns(self, trace: &Trace, received_ns: u64) -> Option<(u64, u64)> {
        let (from, to) = match self {
            Self::Received => (trace.exposed_ns, received_ns),
            Self::Fitted => (trace.exposed_ns, trace.fitted_ns),
            Self::Capture => (trace.exposed_ns, trace.captured_ns),
            Self::WaitExtract => (trace.captured_ns, trace.extract_started_ns),
            Self::Extract => (trace.extract_started_ns, trace.extracted_ns),
            Self::WaitFit => (trace.extracted_ns, trace.fit_started_ns),
            Self::Fit => (trace.fit_started_ns, trace.fitted_ns),
            Self::WaitSink => (trace.fitted_ns, received_ns),
        };
        (from != 0 && to != 0).then_some((from, to))
    }

    /// Returns the duration of the step in a frame, in nanoseconds. It is never negative.
    pub fn ns(self, trace: &Trace, received_ns: u64) -> Option<u64> {
        let (from, to) = self.ends_ns(trace, received_ns)?;
        Some(to.saturating_sub(from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_add_up_to_the_whole_way_and_an_unknown_stamp_leaves_its_own_out() {
        let mut trace = Trace {
            exposed_ns: 100,
            captured_ns: 110,
            extract_started_ns: 130,
            extracted_ns: 170,
            fit_started_ns: 250,
            fitted_ns: 410,
            ..Trace::EMPTY
        };
        let sum = |trace: &Trace| -> u64 {
            let steps = Step::ALL.iter().skip(2);
            steps.filter_map(|step| step.ns(trace, 730)).sum()
        };
        assert_eq!(Step::Received.ns(&trace, 730), Some(630));
        assert_eq!(sum(&trace), 630);
        assert_eq!(Step::Received.ns(&trace, 0), None);
        trace.extracted_ns = 0;
        assert_eq!(sum(&trace), 630 - 40 - 80);
        assert_eq!(Step::Extract.ns(&trace, 730), None);
    }
}

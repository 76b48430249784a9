//! Stamps of one frame, and the time of its reception.

use crate::saved::{RestoreError, Saved, Saving};
use crate::step::Step;
use lariat_message::Trace;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Passage {
    pub(crate) trace: Trace,
    pub(crate) received_ns: u64,
}

impl Passage {
    /// Returns the duration of a step in nanoseconds, or 0 if it is unknown.
    pub(crate) fn ns(&self, step: Step) -> u64 {
        step.ns(&self.trace, self.received_ns).unwrap_or(0)
    }

    pub(crate) fn save(&self, to: &mut Saving) {
        let Self { trace, received_ns } = self;
        to.numbers([
            trace.sequence,
            trace.captured,
            trace.extracted,
            trace.fitted,
            trace.exposed_ns,
            trace.captured_ns,
            trace.extract_started_ns,
            trace.extracted_ns,
            trace.fit_started_ns,
            trace.fitted_ns,
            *received_ns,
        ]);
    }

    pub(crate) fn restore(from: &mut Saved) -> Result<Self, RestoreError> {
        let [
            sequence,
            captured,
            extracted,
            fitted,
            exposed_ns,
            captured_ns,
            extract_started_ns,
            extracted_ns,
            fit_started_ns,
            fitted_ns,
            received_ns,
        ] = from.numbers()?;
        let trace = Trace {
            sequence,
            captured,
            extracted,
            fitted,
            exposed_ns,
            captured_ns,
            extract_started_ns,
            extracted_ns,
            fit_started_ns,
            fitted_ns,
            ..Trace::EMPTY
        };
        Ok(Self { trace, received_ns })
    }
}

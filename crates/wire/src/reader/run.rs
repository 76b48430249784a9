//! Detects restarts of the chain. After a restart, ropes are numbered again, so the same number
//! means a different rope.
//!
//! A new fit is a new writer. A new extract under the same fit counts from 1 again. It is detected
//! when its count decreases. If many messages were missed, the count may be higher again. It has
//! then grown by less than fit's own count, which reveals the restart, because fit cannot send more
//! than it receives. A stage that the chain restarts in place reports this (`Trace::restarts`),
//! continues counting, and keeps its ropes' numbers; the run is then the same.

use crate::Trace;

/// The transport's ID of a writer.
pub(crate) type WriterId = iceoryx2::identifiers::UniquePublisherId;

/// The chain's runs, counted by a reader.
#[derive(Debug, Default)]
pub(super) struct Runs {
    /// From 1; 0 before the first message.
    run: u64,
    last: Option<(WriterId, Trace)>,
    period_s: Option<f64>,
}

impl Runs {
    /// Processes the next message that was read.
    pub(super) fn follow(&mut self, writer: WriterId, trace: &Trace) {
        let last = self.last.replace((writer, *trace));
        let goes_on = last.filter(|(before, last)| {
            let is_same = *before == writer || trace.restarts()[2] != last.restarts()[2];
            is_same && goes_on(last, trace)
        });
        let Some((_, last)) = goes_on else {
            self.run += 1;
            self.period_s = None;
            return;
        };
        let (frames, ns) = (
            trace.fitted - last.fitted,
            trace.exposed_ns.saturating_sub(last.exposed_ns),
        );
        self.period_s = (ns > 0).then(|| ns as f64 * 1e-9 / frames as f64);
    }

    pub(super) fn run(&self) -> u64 {
        self.run
    }

    /// Time between the images of the last two frames of fit, s; `None` before the second frame of
    /// a run.
    pub(super) fn period_s(&self) -> Option<f64> {
        self.period_s
    }
}

/// Returns whether both messages come from the same run of extract and fit.
fn goes_on(last: &Trace, next: &Trace) -> bool {
    let fitted = next.fitted.checked_sub(last.fitted);
    let extracted = next.extracted.checked_sub(last.extracted);
    matches!((fitted, extracted), (Some(fitted @ 1..), Some(extracted)) if extracted >= fitted)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(extracted: u64, fitted: u64) -> Trace {
        Trace {
            extracted,
            fitted,
            ..Trace::EMPTY
        }
    }

    #[test]
    fn losses_between_the_stages_are_no_new_run() {
        assert!(goes_on(&trace(10, 8), &trace(11, 9)));
        assert!(goes_on(&trace(10, 8), &trace(40, 12)));
    }

    #[test]
    fn an_extract_that_counts_anew_is_a_new_run() {
        assert!(!goes_on(&trace(10, 8), &trace(1, 9)));
        // The new count already exceeds the old one when the next message is read.
        assert!(!goes_on(&trace(10, 10), &trace(50, 60)));
    }

    #[test]
    fn a_fit_that_counts_anew_is_a_new_run() {
        assert!(!goes_on(&trace(10, 8), &trace(11, 1)));
    }
}

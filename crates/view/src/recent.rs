//! Durations of the steps, in the frames of the last seconds.

use std::collections::VecDeque;

use lariat_sink::Step;
use lariat_wire::Trace;

use super::view::StepRow;

/// Steps whose ends are stamped in the messages, without those that end at a reader.
const STEPS: [Step; 6] = [
    Step::Fitted,
    Step::Capture,
    Step::WaitExtract,
    Step::Extract,
    Step::WaitFit,
    Step::Fit,
];

/// Maximum number of frames that are kept. It suffices for a minute of ten reads per second, each
/// of which takes all waiting frames.
const MOST: usize = 8192;

/// The frames of the last seconds.
#[derive(Debug, Default)]
pub(crate) struct Recent(VecDeque<(u64, [Option<u64>; STEPS.len()])>);

impl Recent {
    /// Adds a frame.
    pub(crate) fn add(&mut self, trace: &Trace) {
        if self.0.len() == MOST {
            self.0.pop_front();
        }
        let steps = STEPS.map(|step| step.ns(trace, 0));
        self.0.push_back((trace.fitted_ns, steps));
    }

    /// Drops frames before this time.
    pub(crate) fn forget_before(&mut self, ns: u64) {
        while self.0.front().is_some_and(|(at_ns, _)| *at_ns < ns) {
            self.0.pop_front();
        }
    }

    /// Returns the time from exposure to fit of each frame since `since_ns`, in µs.
    pub(crate) fn fitted_us(&self, since_ns: u64) -> Vec<f64> {
        let frames = self.0.iter().filter(|(at_ns, _)| *at_ns >= since_ns);
        let whole = frames.filter_map(|(_, steps)| steps[0]);
        whole.map(|ns| ns as f64 / 1e3).collect()
    }

    /// Returns the percentiles of the frames since `ns`; empty without frames.
    pub(crate) fn since(&self, ns: u64) -> Vec<StepRow> {
        let frames = self.0.iter().filter(|(at_ns, _)| *at_ns >= ns);
        let mut sorted = Vec::new();
        let row = |(place, step): (usize, Step)| {
            sorted.clear();
            sorted.extend(frames.clone().filter_map(|(_, steps)| steps[place]));
            sorted.sort_unstable();
            let most = *sorted.last()?;
            let us = |ns: u64| ns as f64 / 1e3;
            // The smallest one that this share of all does not exceed.
            let at =
                |share: f64| sorted[((sorted.len() as f64 * share).ceil() as usize).max(1) - 1];
            Some(StepRow {
                step,
                p50: us(at(0.5)),
                p90: us(at(0.9)),
                p99: us(at(0.99)),
                max: us(most),
            })
        };
        STEPS.into_iter().enumerate().filter_map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_of_the_last_seconds_only() {
        let mut recent = Recent::default();
        let frame = |fitted_ns: u64, took_ns: u64| Trace {
            exposed_ns: fitted_ns - took_ns,
            captured_ns: fitted_ns - took_ns + 1000,
            fitted_ns,
            ..Trace::EMPTY
        };
        recent.add(&frame(1_000_000_000, 900_000_000));
        (1..=100).for_each(|i| recent.add(&frame(2_000_000_000 + i, i * 10_000)));
        let rows = recent.since(1_500_000_000);
        assert_eq!(rows.len(), 2, "the other steps are not stamped");
        let whole = rows[0];
        assert_eq!(whole.step, Step::Fitted);
        assert_eq!((whole.p50, whole.p90), (500.0, 900.0));
        assert_eq!((whole.p99, whole.max), (990.0, 1000.0));
        assert_eq!(rows[1].max, 1.0);
        assert_eq!(recent.since(0)[0].max, 900_000.0);
        recent.forget_before(1_500_000_000);
        assert_eq!(recent.since(0)[0].max, 1000.0);
        assert!(recent.since(3_000_000_000).is_empty());
    }
}

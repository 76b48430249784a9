//! Converts the timestamps of a message from one clock to another, all by the same offset.

use lariat_wire::Trace;

use crate::clock::Offset;

/// Converts the timestamps of frames to this machine's clock, and keeps frames in order.
#[derive(Debug, Default)]
pub(crate) struct Stamps {
    /// The last frame's exposure on the other clock and on this one, and its arrival.
    last: Option<(u64, u64, u64)>,
}

impl Stamps {
    /// Converts all timestamps of a trace. No timestamp becomes later than the arrival,
    /// `arrived_ns`. Two consecutive messages of one frame get the same timestamps, so that readers
    /// recognize that they belong together.
    pub(crate) fn set(&mut self, trace: &mut Trace, offset: &Offset, mut arrived_ns: u64) {
        let there = trace.exposed_ns;
        let mut exposed_ns = offset.here(there).min(arrived_ns);
        // The offset changes as more is known about the clocks, but frames must stay in order.
        match self.last {
            Some((last_there, last_here, _)) if there > last_there => {
                exposed_ns = exposed_ns.max(last_here.saturating_add(1));
            }
            Some((last_there, last_here, last_arrived_ns)) if there == last_there => {
                (exposed_ns, arrived_ns) = (last_here, last_arrived_ns);
            }
            _ => {}
        }
        self.last = Some((there, exposed_ns, arrived_ns));
        let Trace {
            captured_ns,
            extract_started_ns,
            extracted_ns,
            fit_started_ns,
            fitted_ns,
            ..
        } = trace;
        for stamp in [
            captured_ns,
            extract_started_ns,
            extracted_ns,
            fit_started_ns,
            fitted_ns,
        ] {
            // 0 means unknown.
            if *stamp > 0 {
                let after = i128::from(*stamp) - i128::from(there);
                let here = i128::from(exposed_ns) + after;
                *stamp = u64::try_from(here.max(1))
                    .unwrap_or(u64::MAX)
                    .min(arrived_ns);
            }
        }
        trace.exposed_ns = if there > 0 { exposed_ns } else { 0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::{Clock, RoundTrip};

    /// Returns an offset of `ahead` ns, known to within `doubt` ns.
    fn offset(ahead: u64, doubt: u64) -> Offset {
        let mut clock = Clock::default();
        let asked = 1_000_000_000;
        clock.add(RoundTrip {
            asked,
            got: asked + doubt + ahead,
            sent: asked + doubt + ahead,
            heard: asked + 2 * doubt,
        });
        clock.offset().expect("known")
    }

    fn trace(exposed_ns: u64) -> Trace {
        Trace {
            exposed_ns,
            captured_ns: exposed_ns + 100,
            fitted_ns: exposed_ns + 900,
            ..Trace::EMPTY
        }
    }

    #[test]
    fn every_stamp_is_set_by_the_same_and_what_is_not_known_stays_so() {
        let mut stamps = Stamps::default();
        let mut trace = trace(6_000_001_000);
        stamps.set(&mut trace, &offset(5_000_000_000, 10), 1_000_002_500);
        assert_eq!(
            (trace.exposed_ns, trace.captured_ns, trace.fitted_ns),
            (1_000_001_000, 1_000_001_100, 1_000_001_900)
        );
        assert_eq!(trace.extracted_ns, 0);
    }

    #[test]
    fn no_stamp_is_of_later_than_its_arrival() {
        let mut stamps = Stamps::default();
        let mut trace = trace(6_000_001_000);
        stamps.set(&mut trace, &offset(5_000_000_000, 10), 1_000_001_050);
        assert_eq!(
            (trace.exposed_ns, trace.captured_ns, trace.fitted_ns),
            (1_000_001_000, 1_000_001_050, 1_000_001_050)
        );
    }

    #[test]
    fn two_messages_of_one_frame_have_the_same_stamps_whatever_is_learned_between_them() {
        let mut stamps = Stamps::default();
        let (mut first, mut second) = (trace(6_000_001_000), trace(6_000_001_000));
        stamps.set(&mut first, &offset(5_000_000_000, 10), 1_000_001_500);
        stamps.set(&mut second, &offset(5_000_000_400, 10), 1_000_001_950);
        assert_eq!(first, second);
    }

    #[test]
    fn frames_stay_in_their_order_when_the_offset_moves() {
        let mut stamps = Stamps::default();
        let (mut first, mut second) = (trace(6_000_001_000), trace(6_000_002_000));
        stamps.set(&mut first, &offset(5_000_000_000, 10), u64::MAX);
        stamps.set(&mut second, &offset(5_000_005_000, 10), u64::MAX);
        assert!(second.exposed_ns > first.exposed_ns);
        // Both the machine and its chain were restarted.
        let mut third = trace(5_900_000_000);
        stamps.set(&mut third, &offset(5_000_000_000, 10), u64::MAX);
        assert_eq!(third.exposed_ns, 900_000_000);
    }
}

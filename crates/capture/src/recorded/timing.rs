//! Decides when a recording's frames are shown: as far apart as their stamps, if a camera could
//! have produced these.
//!
//! Stamps jump where several sessions are in one recording or where a clock was set, which can also
//! make them run backward. Some drivers give every frame the same stamp. If it were played by such
//! stamps, a recording would stall or play all at once. Each implausible step is therefore
//! replaced, and each kind of fault is reported once.

use lariat_message::{FrameHeader, Trace};

use crate::ahead::Moment;

/// Maximum number of frames lost between two recorded ones. A larger step means that the numbering
/// restarted.
const MOST_LOST: u64 = u32::MAX as u64;
/// Longest step that is waited for. Ten seconds is the limit for keeping a user's attention on a
/// program that does not respond (J. Nielsen, *Usability Engineering*, 1993, section 5.5).
const LONGEST_NS: u64 = 10_000_000_000;
/// Maximum excess of the step between two stamps over the step between the same frames on the
/// recorder's clock. Queues between the camera and the recorder delay frames by less.
const MOST_AHEAD_NS: u64 = 1_000_000_000;
/// Period if no other is known, that of a common camera: a thirtieth of a second.
const USUAL_NS: u64 = 1_000_000_000 / 30;

/// Maps frames to times within their pass.
#[derive(Debug, Default)]
pub(super) struct Timing {
    last: Option<Last>,
    /// The last plausible step between two frames.
    period_ns: Option<u64>,
    said: [bool; 3],
    news: Option<String>,
}

/// The last frame read, shown or not, relative to the first frame of the pass.
#[derive(Debug, Clone, Copy)]
struct Last {
    sequence: u64,
    /// Number of frames of the source since the first frame of the pass.
    steps: u64,
    exposed_ns: u64,
    log_time_ns: u64,
    /// Time since the first frame of the pass.
    after_ns: u64,
}

/// Why the step between two stamps is implausible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    Jump,
    Back,
    Still,
}

impl Timing {
    /// Starts another pass.
    pub(super) fn restart(&mut self) {
        (self.last, self.period_ns) = (None, None);
    }

    /// Returns a sentence about replaced stamps, once.
    pub(super) fn take_news(&mut self) -> Option<String> {
        self.news.take()
    }

    /// Places the next frame in its pass. Returns `None` if the frame is left out. The recorder
    /// wrote it at `log_time_ns`.
    pub(super) fn place(
        &mut self,
        every: u64,
        frame: &FrameHeader,
        log_time_ns: u64,
    ) -> Option<Moment> {
        let Trace {
            sequence,
            exposed_ns,
            ..
        } = frame.trace;
        let (steps, after_ns) = match self.last {
            None => (0, 0),
            Some(last) => {
                // A source that restarted during the recording counts from 1 again.
                let step = sequence.checked_sub(last.sequence).unwrap_or(1);
                let step = if step > MOST_LOST { 1 } else { step.max(1) };
                let steps = last.steps.saturating_add(step);
                let step_ns = self.step_ns(last, step, exposed_ns, log_time_ns, steps);
                (steps, last.after_ns.saturating_add(step_ns))
            }
        };
        self.last = Some(Last {
            sequence,
            exposed_ns,
            log_time_ns,
            steps,
            after_ns,
        });
        steps.is_multiple_of(every).then_some(Moment {
            number: steps / every + 1,
            after_ns,
        })
    }

    /// Time from the last frame to this one, which is `step` frames of the source later.
    fn step_ns(
        &mut self,
        last: Last,
        step: u64,
        exposed_ns: u64,
        log_time_ns: u64,
        steps: u64,
    ) -> u64 {
        let stamped_ns = exposed_ns.saturating_sub(last.exposed_ns);
        let logged_ns = log_time_ns.saturating_sub(last.log_time_ns);
        let is_ahead = logged_ns > 0 && stamped_ns > logged_ns.saturating_add(MOST_AHEAD_NS);
        let fault = match stamped_ns {
            0 if exposed_ns < last.exposed_ns => Fault::Back,
            0 => Fault::Still,
            _ if stamped_ns > LONGEST_NS || is_ahead => Fault::Jump,
            _ => {
                self.period_ns = Some(stamped_ns / step);
                return stamped_ns;
            }
        };
        let is_logged = fault == Fault::Still && (1..=LONGEST_NS).contains(&logged_ns);
        let instead_ns = match is_logged {
            true => logged_ns,
            false => self.period_ns.unwrap_or(USUAL_NS).max(1),
        };
        if !std::mem::replace(&mut self.said[fault as usize], true) {
            let instead_ms = instead_ns as f64 / 1e6;
            let what = match fault {
                Fault::Jump => format!(
                    "is stamped {:.1} s after the one before it",
                    stamped_ns as f64 / 1e9
                ),
                Fault::Back => "is stamped before the one before it".to_owned(),
                Fault::Still => "has the stamp of the one before it".to_owned(),
            };
            self.news = Some(format!(
                "frame {} {what}: it is shown {instead_ms:.1} ms after it, and so are others like it (--fps max ignores the stamps)",
                steps + 1
            ));
        }
        instead_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// Times at which frames with these stamps and log times are shown, in ms, and the notices.
    fn shown(frames: &[(u64, u64)]) -> (Vec<u64>, Vec<String>) {
        let mut timing = Timing::default();
        let mut said = Vec::new();
        let place = |(index, &(stamp_ms, log_ms)): (usize, &(u64, u64))| {
            let mut header = FrameHeader::default();
            header.trace.sequence = 1 + index as u64;
            header.trace.exposed_ns = stamp_ms * MS;
            let moment = timing.place(1, &header, log_ms * MS).unwrap();
            said.extend(timing.take_news());
            moment.after_ns / MS
        };
        let shown = frames.iter().enumerate().map(place).collect();
        (shown, said)
    }

    #[test]
    fn a_gap_of_an_hour_is_shortened_to_a_period_and_said() {
        const H: u64 = 3_600_000;
        let (times, said) = shown(&[(0, 0), (33, 33), (H, 66), (H + 33, 99)]);
        assert_eq!(times, [0, 33, 66, 99]);
        assert_eq!(said.len(), 1);
        assert!(
            said[0].starts_with("frame 3 is stamped 3600.0 s after"),
            "{said:?}"
        );
        // The same if the recorder also waited that long.
        assert_eq!(
            shown(&[(0, 0), (33, 33), (H, H), (H + 33, H + 33)]).0,
            [0, 33, 66, 99]
        );
    }

    #[test]
    fn a_jump_that_the_recorders_clock_denies_is_shortened() {
        let (times, said) = shown(&[(0, 0), (33, 33), (5000, 66), (5033, 99), (9000, 133)]);
        assert_eq!(times, [0, 33, 66, 99, 132]);
        assert_eq!(said.len(), 1, "{said:?}");
    }

    #[test]
    fn a_pause_of_some_seconds_is_kept() {
        let (times, said) = shown(&[(0, 0), (33, 33), (5033, 5033)]);
        assert_eq!((times, said.len()), (vec![0, 33, 5033], 0));
    }

    #[test]
    fn equal_stamps_are_spread_by_the_recorders_clock_or_the_usual_rate() {
        let (times, said) = shown(&[(0, 0), (0, 40), (0, 80)]);
        assert_eq!(times, [0, 40, 80]);
        assert!(
            said[0].contains("has the stamp of the one before it"),
            "{said:?}"
        );
        assert_eq!(shown(&[(7, 7), (7, 7), (7, 7)]).0, [0, 33, 66]);
    }

    #[test]
    fn a_clock_that_was_set_back_goes_on_by_a_period() {
        let (times, said) = shown(&[(500, 0), (520, 20), (100, 40), (120, 60)]);
        assert_eq!(times, [0, 20, 40, 60]);
        assert!(
            said[0].contains("is stamped before the one before it"),
            "{said:?}"
        );
    }
}

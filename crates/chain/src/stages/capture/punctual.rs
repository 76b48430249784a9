//! Detects whether the kernel serves a source's timer late.

/// Length of the window over which late frames are counted, in frames.
const WINDOW: u32 = 1_000;
/// Number of late frames in a window above which lariat warns. It is 1 %, because p99 of the
/// latency then depends on the scheduler and not on the chain.
const TOO_MANY: u32 = WINDOW / 100;

/// Counts frames that were ready on time but sent more than a period late, because other programs
/// used the machine.
#[derive(Debug, Default)]
pub(super) struct Punctuality {
    frames: u32,
    late: u32,
    last_due_ns: Option<u64>,
    is_told: bool,
}

impl Punctuality {
    /// Adds a frame. Returns true, once, when too many are late.
    pub(super) fn is_starved(&mut self, ready_ns: u64, due_ns: u64, woken_ns: u64) -> bool {
        let last_due_ns = self.last_due_ns.replace(due_ns);
        let Some(period_ns) = last_due_ns.map(|last| due_ns.saturating_sub(last)) else {
            return false;
        };
        if self.frames == WINDOW {
            (self.frames, self.late) = (0, 0);
        }
        self.frames += 1;
        let is_late = ready_ns <= due_ns && woken_ns.saturating_sub(due_ns) > period_ns;
        self.late += u32::from(is_late);
        self.late > TOO_MANY && !std::mem::replace(&mut self.is_told, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the number of warnings for a source of 1,000 frames/s. In every hundred frames,
    /// `late_in_100` of them wake up late by `late_ns`.
    fn warnings(late_in_100: u64, late_ns: u64) -> usize {
        let mut punctuality = Punctuality::default();
        let is_told = |i: &u64| {
            let due_ns = i * 1_000_000;
            let woken_ns = due_ns
                + if i % 100 < late_in_100 {
                    late_ns
                } else {
                    60_000
                };
            punctuality.is_starved(due_ns - 200_000, due_ns, woken_ns)
        };
        (1..5_000).filter(is_told).count()
    }

    #[test]
    fn a_source_that_wakes_more_than_a_period_late_warns_once() {
        assert_eq!(warnings(2, 1_500_000), 1);
        assert_eq!(warnings(1, 1_500_000), 0);
        assert_eq!(warnings(100, 900_000), 0);
    }

    #[test]
    fn a_source_that_is_too_slow_itself_is_not_starved() {
        let mut punctuality = Punctuality::default();
        let is_told = (1..5_000)
            .any(|i| punctuality.is_starved(i * 1_000 + 900, i * 1_000, i * 1_000 + 5_000));
        assert!(!is_told);
    }
}

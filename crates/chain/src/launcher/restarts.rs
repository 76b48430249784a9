//! Decides when a fallen part restarts, and when the chain gives up.

use std::time::{Duration, Instant};

use super::child::Ending;
use crate::settings::{Restart, Run};

/// Pause before the second restart within the window. The first restart is immediate; each further
/// one doubles the pause.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(5);

/// Restarts within the window.
#[derive(Debug, Default)]
pub(super) struct Restarts {
    /// Times of the restarts.
    recent: Vec<Instant>,
}

/// The decision about a fallen part.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Restart the part at this time.
    Restart(Instant),
    /// End the chain.
    End,
    /// End the chain, because this many parts were restarted within the window.
    TooMany(u32),
}

impl Restarts {
    /// Decides what to do about a part that ended with `ending`. `is_done` is true if its work was
    /// done.
    pub(super) fn judge(
        &mut self,
        run: &Run,
        ending: Option<Ending>,
        is_done: bool,
        now: Instant,
    ) -> Verdict {
        let is_wanted = match run.restart {
            Restart::Never => false,
            Restart::OnFailure => !(is_done && ending == Some(Ending::Well)),
            Restart::Always => true,
        };
        if !is_wanted || !run.restarts_stages() {
            return Verdict::End;
        }
        self.recent
            .retain(|at| now.saturating_duration_since(*at) < run.restart_window);
        // An unattended chain never gives up.
        if self.recent.len() >= run.max_restarts as usize && !run.daemon {
            return Verdict::TooMany(run.max_restarts);
        }
        let pause = match self.recent.len() {
            0 => Duration::ZERO,
            before => {
                let doubled = FIRST_PAUSE.saturating_mul(1 << (before - 1).min(16));
                doubled.min(LONGEST_PAUSE)
            }
        };
        let at = now + pause;
        self.recent.push(at);
        Verdict::Restart(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(restart: Restart) -> Run {
        Run {
            restart,
            max_restarts: 4,
            restart_window: Duration::from_secs(10),
            ..Run::default()
        }
    }

    #[test]
    fn a_part_that_falls_again_and_again_is_started_after_longer_and_longer_and_then_no_more() {
        let run = run(Restart::OnFailure);
        let mut restarts = Restarts::default();
        let begin = Instant::now();
        let killed = Some(Ending::Killed(9));
        for pause_ms in [0, 100, 200, 400] {
            let at = begin + Duration::from_millis(pause_ms);
            assert_eq!(
                restarts.judge(&run, killed, false, begin),
                Verdict::Restart(at)
            );
        }
        let verdict = restarts.judge(&run, killed, false, begin);
        assert_eq!(verdict, Verdict::TooMany(4));
        // An old restart does not count.
        let later = begin + Duration::from_secs(11);
        let verdict = restarts.judge(&run, killed, false, later);
        assert_eq!(verdict, Verdict::Restart(later));
    }

    #[test]
    fn an_unattended_chain_retries_for_ever_at_the_longest_pause() {
        let run = Run {
            daemon: true,
            ..run(Restart::OnFailure)
        };
        let mut restarts = Restarts::default();
        let now = Instant::now();
        let mut judge = || restarts.judge(&run, Some(Ending::Failed(1)), false, now);
        assert_eq!(
            (0..20).map(|_| judge()).last(),
            Some(Verdict::Restart(now + LONGEST_PAUSE))
        );
    }

    #[test]
    fn it_is_restarted_if_that_was_asked_for() {
        let now = Instant::now();
        let judge = |run: &Run, ending, is_done| {
            Restarts::default().judge(run, Some(ending), is_done, now) == Verdict::Restart(now)
        };
        let never = run(Restart::Never);
        assert!(!judge(&never, Ending::Killed(9), false));
        let on_failure = run(Restart::OnFailure);
        assert!(judge(&on_failure, Ending::Failed(1), false));
        assert!(judge(&on_failure, Ending::Well, false));
        assert!(!judge(&on_failure, Ending::Well, true));
        let always = run(Restart::Always);
        assert!(judge(&always, Ending::Well, true));
        let fused = Run {
            fuse: true,
            ..always
        };
        assert!(!judge(&fused, Ending::Killed(9), false));
    }
}

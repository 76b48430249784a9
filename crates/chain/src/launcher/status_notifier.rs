//! Tells the service manager how the chain is: that it is up, at work, and with how many frames a second and ropes.

use std::time::{Duration, Instant};

use crate::notify::Notify;

/// How often it is told how the chain is.
const EVERY: Duration = Duration::from_secs(5);

/// What of the chain's work is seen from outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Signs {
    /// How many descriptors were sent.
    pub(super) fitted: u64,
    /// How often capture said that it waits.
    pub(super) beats: u64,
}

/// Who tells it.
pub(super) struct StatusNotifier {
    notify: Notify,
    last: Option<(Signs, Instant)>,
    /// At the last sign of life.
    fed: Option<(Signs, Instant)>,
}

impl StatusNotifier {
    pub(super) fn new() -> Self {
        Self::of(Notify::from_env())
    }

    fn of(notify: Notify) -> Self {
        Self {
            notify,
            last: None,
            fed: None,
        }
    }

    pub(super) fn ready(&mut self) {
        self.notify.ready();
    }

    /// Reports a fault. The line stays until the next one reports the frame rate.
    ///
    /// A chain that restarts its stages is alive, even while no frames come.
    pub(super) fn trouble(&mut self, line: &str) {
        self.notify.status(line);
        if self.notify.watchdog_period().is_some() {
            self.notify.watchdog();
        }
    }

    pub(super) fn stopping(&mut self) {
        self.notify.stopping();
    }

    /// How soon it wants to be called again, if anybody listens.
    pub(super) fn wait(&self) -> Option<Duration> {
        let wait = self.notify.watchdog_period().unwrap_or(EVERY) / 2;
        self.notify.is_heard().then_some(wait)
    }

    /// Tells how the chain is, if it is time. It lives as long as there are new signs: frames come, or a camera is waited for.
    pub(super) fn tell(&mut self, signs: Signs, now: Instant, ropes: impl FnOnce() -> usize) {
        if let Some(period) = self.notify.watchdog_period() {
            let (last, at) = *self.fed.get_or_insert((signs, now));
            if signs != last && now - at >= period / 2 {
                self.fed = Some((signs, now));
                self.notify.watchdog();
            }
        }
        let (last, at) = *self.last.get_or_insert((signs, now));
        if now - at >= EVERY {
            self.last = Some((signs, now));
            let frames = signs.fitted.saturating_sub(last.fitted) as f64;
            let per_s = frames / (now - at).as_secs_f64();
            let ropes = ropes();
            let s = if ropes == 1 { "" } else { "s" };
            self.notify
                .status(&format!("{per_s:.1} frames/s, {ropes} rope{s}"));
        }
    }
}

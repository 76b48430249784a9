//! Notifies the service manager of the chain's state: ready, alive, frames per second and number of
//! ropes.

use std::time::{Duration, Instant};

use crate::notify::Notify;

/// Interval between two status lines.
const EVERY: Duration = Duration::from_secs(5);

/// Signs of the chain's work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Signs {
    /// Number of descriptors sent.
    pub(super) fitted: u64,
    /// Number of times that capture reported that it is waiting.
    pub(super) beats: u64,
}

/// Sends the notifications.
pub(super) struct StatusNotifier {
    notify: Notify,
    last: Option<(Signs, Instant)>,
    /// Signs and time of the last watchdog notification.
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

    /// Reports a fault as the status line, which stays until the next report of the frame rate.
    ///
    /// A chain that restarts its stages counts as alive, even while no frames arrive.
    pub(super) fn trouble(&mut self, line: &str) {
        self.notify.status(line);
        if self.notify.watchdog_period().is_some() {
            self.notify.watchdog();
        }
    }

    pub(super) fn stopping(&mut self) {
        self.notify.stopping();
    }

    /// Returns the time until the next call is needed, if there is a service manager.
    pub(super) fn wait(&self) -> Option<Duration> {
        let wait = self.notify.watchdog_period().unwrap_or(EVERY) / 2;
        self.notify.is_heard().then_some(wait)
    }

    /// Reports the chain's state if it is due. The chain counts as alive while its signs change:
    /// frames arrive, or capture waits for a camera.
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

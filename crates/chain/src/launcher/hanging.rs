//! Detects and kills stages that make no progress while work waits for them.

use std::time::Instant;

use super::{Chain, Part};
use crate::stages::handover::Progress;

/// The last observed progress of a stage.
#[derive(Clone, Copy)]
pub(super) struct Watched {
    pub(super) progress: Progress,
    /// Start of the time without progress.
    pub(super) since: Instant,
}

impl Chain {
    /// Kills stages that make no progress while work waits for them, if the settings say to restart
    /// them.
    pub(super) fn strike_the_hanging(&mut self) {
        let run = &self.settings.run;
        if !run.restarts_stages() || run.lossless {
            return;
        }
        let now = Instant::now();
        let progress = Part::ALL.map(|part| self.handovers[part as usize].read());
        for part in [Part::Capture, Part::Extract, Part::Fit, Part::Sink] {
            let at = part as usize;
            let Some(child) = &self.children[at] else {
                continue;
            };
            let works = match part.before() {
                _ if !child.is_ready() => true,
                Some(before) if self.child(before).is_some() => {
                    progress[before as usize].sent.count > progress[at].taken
                }
                // The number of frames that an external writer sent is unknown.
                Some(_) => false,
                None => true,
            };
            let patience = match child.is_ready() {
                true => run.hang,
                false => run.start_limit,
            };
            let watched = &mut self.watched[at];
            if !works || progress[at] != watched.progress {
                *watched = Watched {
                    progress: progress[at],
                    since: now,
                };
            } else if child.ending().is_none() && now - watched.since > patience {
                eprintln!(
                    "lariat: {} has stood still for {} s while work waits for it, and is killed",
                    part.name(),
                    patience.as_secs_f64()
                );
                watched.since = now;
                child.strike();
            }
        }
    }
}

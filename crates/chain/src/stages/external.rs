//! Frames from an external process. The chain then lacks a capture stage, so extract performs its
//! duties.
//!
//! Extract knows when the chain has had the requested number of frames. It ends with `--frames` and
//! `--duration`, and after a signal it ignores frames that were captured later. It warns when no
//! frames arrive. It does not create blank frames, because the channel has only one writer and
//! readers detect stale data themselves (`Stale`). A writer that knows that its camera is blind
//! sends blank frames.
//!
//! Extract also reports the writer's counters at the start and the end of the chain (`taken` on its
//! status line). The loss accounting starts there.

use std::time::{Duration, Instant};

use lariat_wire::{FRAMES, Trace, now_ns};

use super::status::{Sent, Taken};
use crate::settings::Settings;
use crate::stop::Stop;

/// Minimum silence before a warning. A camera may pause for a long exposure in the dark, and a
/// program may pause for garbage collection.
const SHORTEST_SILENCE: Duration = Duration::from_secs(2);
/// A slow source counts as silent after this many of its periods.
const PERIODS: u32 = 3;

/// State of the writer.
pub(super) struct External {
    channel: String,
    /// Number of frames requested.
    most: u64,
    /// Running time requested.
    lasts: Option<Duration>,
    /// End of the running time.
    end: Option<Instant>,
    before_first: Option<[u64; 2]>,
    last: Trace,
    /// Number of frames that the writer sent, according to its counter.
    published: u64,
    /// When to warn of a silence; `None` after the warning.
    silent: Option<Instant>,
    stopped_ns: Option<u64>,
}

impl External {
    /// Returns the state if frames come from an external process.
    pub(super) fn of(settings: &Settings) -> Option<Self> {
        let now = Instant::now();
        settings.capture.is_external().then(|| Self {
            channel: settings
                .run
                .rig
                .parse()
                .map_or_else(|_| FRAMES.name().to_owned(), |rig| FRAMES.on(&rig)),
            most: settings.run.frames.unwrap_or(u64::MAX),
            lasts: settings.run.duration,
            end: settings
                .run
                .duration
                .and_then(|lasts| now.checked_add(lasts)),
            before_first: None,
            last: Trace::EMPTY,
            published: 0,
            silent: Some(now + SHORTEST_SILENCE),
            stopped_ns: None,
        })
    }

    /// Returns when to call [`wait_on`](Self::wait_on).
    pub(super) fn deadline(&self) -> Option<Instant> {
        [self.end, self.silent].into_iter().flatten().min()
    }

    /// Handles a deadline without a frame. Returns true if frames are still awaited.
    pub(super) fn wait_on(&mut self) -> bool {
        let now = Instant::now();
        if self.silent.is_some_and(|silent| now >= silent) {
            self.silent = None;
            let channel = &self.channel;
            if self.before_first.is_none() {
                tracing::warn!(
                    "no frame has come yet: start the program that writes {channel} (lariat.Writer(\"frames\") in Python)"
                );
            } else {
                let silence = Duration::from_nanos(now_ns().saturating_sub(self.last.captured_ns));
                tracing::warn!(
                    "no frame came for {:.1} s: is the program that writes {channel} still running? Readers have stale data meanwhile",
                    silence.as_secs_f64()
                );
            }
        }
        self.end.is_none_or(|end| now < end)
    }

    /// Returns true if this frame is one of those requested.
    pub(super) fn takes(&mut self, trace: &Trace, stop: &Stop) -> bool {
        // An external writer does not stop with the chain, so ignore frames that were captured
        // after the signal.
        if stop.asked() && trace.captured_ns > *self.stopped_ns.get_or_insert_with(now_ns) {
            return false;
        }
        let now = Instant::now();
        let is_first = self.before_first.is_none();
        if is_first {
            let before = [trace.sequence, trace.captured];
            self.before_first = Some(before.map(|count| count.saturating_sub(1)));
            self.end = self.lasts.and_then(|lasts| now.checked_add(lasts));
        } else if self.end.is_some_and(|end| now >= end) {
            return false;
        }
        if self.silent.is_none() && !is_first {
            tracing::info!("{}: frames come again", self.channel);
        }
        let pause = Duration::from_nanos(trace.captured_ns.saturating_sub(self.last.captured_ns));
        let pause = if is_first { Duration::ZERO } else { pause };
        self.silent = Some(now + SHORTEST_SILENCE.max(PERIODS * pause));
        // A writer that was restarted counts from 1 again.
        let advanced = trace.captured.checked_sub(self.last.captured);
        self.published += match advanced {
            _ if is_first => 1,
            Some(advanced @ 1..) => advanced,
            _ => trace.captured,
        };
        self.last = *trace;
        true
    }

    /// Returns true if as many frames were sent as requested.
    pub(super) fn has_all(&self) -> bool {
        self.published >= self.most
    }

    /// Returns what capture would report at the end.
    pub(super) fn taken(&self) -> Taken {
        Taken {
            before_first: self.before_first.unwrap_or_default(),
            last: Sent {
                count: self.last.captured,
                last_sequence: self.last.sequence,
            },
        }
    }
}

//! Frames that a process of the user's writes: what capture would see to is extract's then, as there is no capture.
//!
//! It knows when the chain has had what was asked for, where the writer's numbers stood when the chain began and when it ended,
//! and says when no frames come. It makes no frames of its own then: the channel has one writer, and readers see by themselves
//! how old what they know is (`Stale`). A writer that knows that its camera is blind says so with blank frames.
//!
//! Extract ends with `--frames` and `--duration`, takes nothing after a signal that was captured after it, and says where the writer's numbers stood
//! when the chain began and ended (`taken` on its status line), so that the ledger begins there.

use std::time::{Duration, Instant};

use lariat_wire::{FRAMES, Trace, now_ns};

use super::status::{Sent, Taken};
use crate::settings::Settings;
use crate::stop::Stop;

/// A camera may pause for an exposure in the dark, a program for a garbage collector.
const SHORTEST_SILENCE: Duration = Duration::from_secs(2);
/// A slow source is silent when so many of its periods are over.
const PERIODS: u32 = 3;

/// What is known of the writer.
pub(super) struct External {
    channel: String,
    /// How many frames are asked for.
    most: u64,
    /// For how long.
    lasts: Option<Duration>,
    /// When that is over.
    end: Option<Instant>,
    before_first: Option<[u64; 2]>,
    last: Trace,
    /// How many frames the writer sent, as far as its count says.
    published: u64,
    /// When a silence is to be told; `None` once it was.
    silent: Option<Instant>,
    stopped_ns: Option<u64>,
}

impl External {
    /// If that is where frames come from.
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

    /// When to ask [`wait_on`](Self::wait_on).
    pub(super) fn deadline(&self) -> Option<Instant> {
        [self.end, self.silent].into_iter().flatten().min()
    }

    /// No frame came until then. Whether one is still waited for.
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

    /// Whether this frame is one of those that were asked for.
    pub(super) fn takes(&mut self, trace: &Trace, stop: &Stop) -> bool {
        // A writer that is not the chain's goes on: frames that were made after the signal are not waited for.
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

    /// Whether as many frames were sent as were asked for.
    pub(super) fn has_all(&self) -> bool {
        self.published >= self.most
    }

    /// What capture would say at the end.
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

//! The view of a second rig's camera: the set of its centerlines that is nearest in time to a
//! frame.
//!
//! The other rig runs independently and is unaware that this rig reads its channel. A frame's
//! partner is known once fit has a view that is later than the frame, or at most half a period
//! earlier. Fit waits for such a view up to a deadline after the frame's capture. After a missed
//! deadline, fit does not wait for any frame until a view arrives again.

use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use anyhow::Context;
use lariat_wire::{CENTERLINES, Centerlines, Receiver, Rig, Trace, now_ns};

use super::Station;
use crate::settings::Camera;
use crate::stop::Stop;

/// Maximum time between a frame and its partner while the other camera's period is unknown.
const WITHIN: Duration = Duration::from_millis(20);

/// Reads the second camera's centerlines.
pub(super) struct SecondView {
    reader: Receiver<Centerlines>,
    rig: Rig,
    within: Option<Duration>,
    deadline: Duration,
    /// The last two views, newest first.
    seen: [Box<Centerlines>; 2],
    /// Number of views received, up to two.
    count: usize,
    /// The last two time steps between views. Lost views make a step longer, so the shorter one is
    /// used.
    steps_ns: [Option<u64>; 2],
    is_silent: bool,
    alone: u64,
    is_told: bool,
}

impl SecondView {
    /// Opens a reader on the second rig that the settings name.
    pub(super) fn open(settings: &Camera, station: &Station) -> anyhow::Result<Self> {
        let rig = settings.second_rig.as_deref();
        let rig: Rig = (rig
            .context("a second camera has a rig of its own: say which (--second-rig NAME)")?)
        .parse()?;
        // The other rig decides whether its sender waits.
        let reader = Receiver::create(&station.domain, &rig, &CENTERLINES, None)?;
        Ok(Self {
            reader,
            rig,
            within: settings.second_within,
            deadline: settings.depth_deadline,
            seen: [Box::new(Centerlines::EMPTY), Box::new(Centerlines::EMPTY)],
            count: 0,
            steps_ns: [None; 2],
            is_silent: false,
            alone: 0,
            is_told: false,
        })
    }

    /// Returns the second camera's view at the time of the frame, waiting for it if necessary. If
    /// no view is near enough, counts the frame and returns `None`.
    pub(super) fn of(
        &mut self,
        frame: &Trace,
        stop: &Stop,
    ) -> anyhow::Result<Option<&Centerlines>> {
        self.wait_for(frame, stop)?;
        let apart_ns = |seen: &Centerlines| seen.trace.exposed_ns.abs_diff(frame.exposed_ns);
        let nearest = (0..self.count).min_by_key(|&at| apart_ns(&self.seen[at]));
        let within_ns = match (self.within, self.period_ns()) {
            (Some(within), _) => within.as_nanos() as u64,
            (None, Some(period_ns)) => period_ns / 5 * 3,
            (None, None) => WITHIN.as_nanos() as u64,
        };
        let found = nearest.filter(|&at| apart_ns(&self.seen[at]) <= within_ns);
        self.alone += u64::from(found.is_none());
        // Warn only once, because a fault in every frame would fill the screen.
        if found.is_none() && !std::mem::replace(&mut self.is_told, true) {
            let why = match nearest {
                Some(at) => format!(
                    "what rig {} saw nearest to it was {:.1} ms away, and {:.1} ms are allowed (second_within_us)",
                    self.rig,
                    apart_ns(&self.seen[at]) as f64 / 1e6,
                    within_ns as f64 / 1e6
                ),
                None => format!(
                    "nothing came of rig {} within {:?} of its capture (depth_deadline_us). Is it running (`lariat run --rig {0} ...`)?",
                    self.rig, self.deadline
                ),
            };
            tracing::warn!(
                "frame {} is described in the image only: {why}",
                frame.sequence
            );
        }
        Ok(found.map(|at| &*self.seen[at]))
    }

    /// Returns the number of frames without a partner.
    pub(super) fn alone(&self) -> u64 {
        self.alone
    }

    fn period_ns(&self) -> Option<u64> {
        self.steps_ns.into_iter().flatten().min()
    }

    fn wait_for(&mut self, frame: &Trace, stop: &Stop) -> anyhow::Result<()> {
        let age = Duration::from_nanos(now_ns().saturating_sub(frame.captured_ns));
        let deadline = Instant::now() + self.deadline.saturating_sub(age);
        loop {
            let half_ns = self.period_ns().unwrap_or(0) / 2;
            if self.count > 0 && self.seen[0].trace.exposed_ns + half_ns >= frame.exposed_ns {
                return Ok(());
            }
            if let Some(message) = self.reader.next()? {
                self.take(&message);
                continue;
            }
            let is_late = Instant::now() >= deadline;
            if is_late || self.is_silent || stop.asked() {
                self.is_silent |= is_late;
                return Ok(());
            }
            self.reader.sleep(Some(deadline), Some(stop.as_fd()))?;
        }
    }

    fn take(&mut self, message: &Centerlines) {
        self.is_silent = false;
        // Ignore a frame without an image.
        if message.width == 0 {
            return;
        }
        self.seen.swap(0, 1);
        self.seen[0].copy_meant(message);
        let [now, before] = &self.seen;
        if self.count > 0 {
            let step_ns = now.trace.exposed_ns.checked_sub(before.trace.exposed_ns);
            self.steps_ns = [step_ns, self.steps_ns[0]];
        }
        self.count = (self.count + 1).min(2);
    }
}

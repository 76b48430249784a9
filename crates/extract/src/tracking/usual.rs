//! The usual length of a rope, from the lengths at which it was seen.

use super::tips;
use crate::scene::{Curve, Status};

/// Number of frames, and tolerance in widths. If a rope keeps one length for that long while
/// nothing hides it, this becomes its usual length, whatever that was before.
const STEADY: (u32, f32) = (8, 1.0);

#[derive(Debug, Default)]
pub(super) struct UsualLength {
    pub(super) px: f32,
    /// Number of frames in which both of its ends were free. A length taken by `note_steady`
    /// counts, too.
    sure_frames: u32,
    /// True if both ends were free in the last full extraction.
    is_free: bool,
    /// True if nothing was hidden in the last full extraction.
    is_plain: bool,
    /// Number of consecutive frames in which nothing hid the rope and it had this length.
    steady_frames: u32,
    steady_px: f32,
}

impl UsualLength {
    /// The usual length of a rope about which nothing else is known.
    pub(super) fn of(px: f32) -> Self {
        Self {
            px,
            ..Self::default()
        }
    }

    /// Returns whether the whole rope was ever seen.
    pub(super) fn is_sure(&self) -> bool {
        self.sure_frames > 0
    }

    /// Records whether a full extraction saw both ends free, and the whole rope in plain sight.
    pub(super) fn look(&mut self, is_free: bool, is_plain: bool) {
        (self.is_free, self.is_plain) = (is_free, is_plain);
    }

    /// Moves the usual length toward the visible length, by a limited share of it. A single wrong
    /// frame then has little effect, but a rope that stays short is not treated as hidden forever.
    /// Ends that are on something count least.
    pub(super) fn note(&mut self, curve: &Curve) {
        self.note_steady(curve);
        let off_px = curve.length_px - self.px;
        let is_alike = off_px.abs() <= tips::LEAST_WIDTHS * curve.width_px;
        let pace = match (self.is_free, curve.status) {
            (true, Status::Ok) => {
                self.sure_frames = self.sure_frames.saturating_add(1);
                // The first few frames are averaged.
                (1.0 / self.sure_frames as f32).max(0.005)
            }
            // The length of a hidden part is uncertain.
            (true, _) if curve.hidden.contains(&true) => 0.0005,
            (true, _) => 0.005,
            // A tip on top of something may be measured too short or too long by this much.
            (false, _) if is_alike => 0.0,
            (false, Status::Ok) => 0.0005,
            (false, _) => 0.002,
        };
        let step = curve.length_px / self.px.max(1.0) - 1.0;
        self.px *= 1.0 + step.clamp(-pace, pace);
    }

    /// Takes over a length that the rope has had for long enough in plain sight. Two ropes may have
    /// been extracted as one, or one as two.
    fn note_steady(&mut self, curve: &Curve) {
        let is_alike = |px: f32| (curve.length_px - px).abs() <= STEADY.1 * curve.width_px;
        if self.is_plain && is_alike(self.steady_px) {
            self.steady_frames += 1;
        } else {
            (self.steady_frames, self.steady_px) = (0, curve.length_px);
        }
        if self.steady_frames >= STEADY.0 && !is_alike(self.px) {
            self.px = self.steady_px;
            self.sure_frames = self.steady_frames;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_kept_in_plain_sight_outdoes_what_the_rope_was_taken_for() {
        let seen = |is_plain| {
            let mut usual = UsualLength::of(600.0);
            let curve = Curve {
                length_px: 300.0,
                width_px: 8.0,
                ..Curve::default()
            };
            usual.look(false, is_plain);
            (0..=STEADY.0).for_each(|_| usual.note(&curve));
            usual.px
        };
        assert_eq!(seen(true), 300.0);
        // Something may hide the rest.
        assert!(seen(false) > 590.0, "{}", seen(false));
    }
}

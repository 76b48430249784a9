//! The length that a rope usually has, from the lengths at which it is seen.

use super::tips;
use crate::scene::{Curve, Status};

/// Frames for which a rope has one length, to within so many widths, while nothing hides any of it: then that is its length, whatever
/// it was taken for before.
const STEADY: (u32, f32) = (8, 1.0);

#[derive(Debug, Default)]
pub(super) struct UsualLength {
    pub(super) px: f32,
    /// Frames in which both of its ends lay freely, or that it was taken from.
    sure_frames: u32,
    /// Whether they did when last all of an image was looked at, and whether nothing hid any of it then.
    is_free: bool,
    is_plain: bool,
    /// For how many frames in a row nothing hid it and it had this length.
    steady_frames: u32,
    steady_px: f32,
}

impl UsualLength {
    /// That of a rope of which no more is known than this length.
    pub(super) fn of(px: f32) -> Self {
        Self {
            px,
            ..Self::default()
        }
    }

    /// Whether all of the rope was ever seen.
    pub(super) fn is_sure(&self) -> bool {
        self.sure_frames > 0
    }

    /// Says what an image that was looked at whole tells of the rope's ends, and of what may hide it.
    pub(super) fn look(&mut self, is_free: bool, is_plain: bool) {
        (self.is_free, self.is_plain) = (is_free, is_plain);
    }

    /// Lets it follow what is seen, slowly: one frame that is wrong means nothing, and a rope that stays short is a shorter view of it,
    /// not half hidden for ever. Ends that lie upon something say next to nothing of it.
    pub(super) fn note(&mut self, curve: &Curve) {
        self.note_steady(curve);
        let off_px = curve.length_px - self.px;
        let is_alike = off_px.abs() <= tips::LEAST_WIDTHS * curve.width_px;
        let pace = match (self.is_free, curve.status) {
            (true, Status::Ok) => {
                self.sure_frames = self.sure_frames.saturating_add(1);
                // Of the first few, the mean.
                (1.0 / self.sure_frames as f32).max(0.005)
            }
            // How long the hidden part is, nobody sees.
            (true, _) if curve.hidden.contains(&true) => 0.0005,
            (true, _) => 0.005,
            // A tip that lies upon something is read so much too short or too long: the rope is not.
            (false, _) if is_alike => 0.0,
            (false, Status::Ok) => 0.0005,
            (false, _) => 0.002,
        };
        let step = curve.length_px / self.px.max(1.0) - 1.0;
        self.px *= 1.0 + step.clamp(-pace, pace);
    }

    /// Takes a length that the rope has had for long enough in plain sight: what was read as one rope was two, or the other way round.
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

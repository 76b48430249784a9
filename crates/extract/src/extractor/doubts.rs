//! Which of the curves may be no ropes.

use super::Extractor;
use crate::confidence::{self, Known};
use crate::image::Image;
use crate::notice::Notice;
use crate::options::{Mask, Options};
use crate::scene::{Curve, Status};
use crate::tracking::plausible::Surroundings;

/// Thinner ropes have no inside that could be read: their confidence is low, and says nothing of the scene.
const THINNEST_PX: f32 = 3.0;

impl Extractor {
    /// Says of the first `seen` curves which may be no ropes, and how sure it is of each.
    pub(super) fn doubt(&mut self, image: &Image, seen: usize) {
        // Who asks for fewer ropes than that wants the longest.
        let is_crowded = self.is_crowded && self.options.ropes == Options::default().ropes;
        self.doubt = is_crowded.then_some(Notice::TooMany);
        // A mask that the user gave knows its ropes, and nothing is said of it.
        if self.masker.cut.is_some() || self.masker.notice.is_some() {
            self.doubt_ropes(image, seen);
        }
        let is_noticed = !matches!(self.masker.notice, None | Some(Notice::OwnShadow));
        let mut is_unsure = false;
        self.evidence.clear();
        for curve in &mut self.curves[..seen] {
            let known = Known {
                is_doubted: curve.status == Status::Doubtful,
                is_noticed,
                is_elsewhere: self.options.mask == Mask::External,
            };
            let evidence = confidence::evidence(image, curve, known);
            self.evidence.push(evidence);
            curve.confidence = evidence.confidence();
            self.tracker.note_confidence(curve.track, curve.confidence);
            let is_below = curve.confidence < self.options.min_confidence;
            is_unsure |= is_below && curve.width_px >= THINNEST_PX;
        }
        self.doubt = self.doubt.or(is_unsure.then_some(Notice::Unsure));
    }

    fn doubt_ropes(&mut self, image: &Image, seen: usize) {
        let surroundings = Surroundings {
            image,
            background: &self.masker.background,
            mask: &self.masker.mask,
            shadows: &self.masker.shadows,
        };
        let of = (&self.curves[..seen], &self.looks[..]);
        let is_known = |curve: &Curve| self.tracker.is_known(curve.track);
        surroundings.doubt(of, is_known, &mut self.doubts);
        for (curve, doubt) in self.curves.iter_mut().zip(&self.doubts) {
            if self.tracker.weigh(curve.track, doubt.is_some()) {
                curve.status = Status::Doubtful;
                self.doubt = self.doubt.or(*doubt);
            }
        }
    }
}

//! Which of the curves may be no ropes.

use super::Extractor;
use crate::confidence::{self, Known};
use crate::image::Image;
use crate::notice::Notice;
use crate::options::{Mask, Options};
use crate::scene::{Curve, Status};
use crate::tracking::plausible::Surroundings;
use crate::tracking::track::Tracker;

/// Thinner ropes have no inside that could be read: their confidence is low, and says nothing of the scene.
const THINNEST_PX: f32 = 3.0;

/// What is found by its shape and less likely than one in ten is not reported.
const UNLIKELY: f32 = 0.1;

impl Extractor {
    /// Drops those of this image's curves that are hardly ropes, where the mask was made by shape: it is of all that is long and
    /// even.
    pub(super) fn drop_unlikely(&mut self, image: &Image) {
        if !self.masker.is_sought {
            return;
        }
        let seen = self.count;
        self.find_doubts(image, seen, |_, _| false);
        self.count = 0;
        for i in 0..seen {
            let known = Known {
                is_doubted: self.doubts[i].is_some(),
                is_noticed: true,
                is_elsewhere: false,
            };
            let evidence = confidence::evidence(image, &self.curves[i], known);
            if evidence.confidence() >= UNLIKELY {
                self.curves.swap(self.count, i);
                self.looks.swap(self.count, i);
                self.count += 1;
            }
        }
    }

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
        self.find_doubts(image, seen, |tracker, curve| tracker.is_known(curve.track));
        for (curve, doubt) in self.curves.iter_mut().zip(&self.doubts) {
            if self.tracker.weigh(curve.track, doubt.is_some()) {
                curve.status = Status::Doubtful;
                self.doubt = self.doubt.or(*doubt);
            }
        }
    }

    /// What each of the first `seen` curves may be instead of a rope, those aside that are known.
    fn find_doubts(
        &mut self,
        image: &Image,
        seen: usize,
        is_known: impl Fn(&Tracker, &Curve) -> bool,
    ) {
        let surroundings = Surroundings {
            image,
            background: &self.masker.background,
            mask: &self.masker.mask,
            shadows: &self.masker.shadows,
        };
        let of = (&self.curves[..seen], &self.looks[..]);
        let is_known = |curve: &Curve| is_known(&self.tracker, curve);
        surroundings.doubt(of, is_known, &mut self.doubts);
    }
}

//! Which of the curves may be no ropes.

use super::Extractor;
use crate::confidence::{self, Maker, Prior};
use crate::image::Image;
use crate::mask::Masker;
use crate::notice::Notice;
use crate::options::{Mask, Options};
use crate::scene::{Curve, Status};
use crate::tracking::plausible::Surroundings;
use crate::tracking::track::Tracker;

/// Thinner ropes have no inside that could be read: their confidence is low, and says nothing of the scene.
pub(super) const THINNEST_PX: f32 = 3.0;

/// What the network finds and is less likely right than one in fifty is not reported, unless all that is found is asked for.
const UNLIKELY: f32 = 0.02;
/// Nor, beside a rope that is this sure, or while one is known that was, what is less likely right than that: such a curve is a piece
/// of the rope with something else, or something else, and would take the rope's number and shape along. What is new beside one that
/// is known must be as sure.
pub(super) const SURE: f32 = 0.5;
const UNLIKELY_BESIDE: f32 = 0.2;

/// Difference from the table at which a rope must not be hidden by noise: a quarter of all 256 levels.
const HIDDEN: f32 = 64.0;

/// What is known of all curves of a mask.
pub(super) fn known<'a>(masker: &'a Masker, options: &Options) -> Prior<'a> {
    let by_network = masker.is_of_network();
    Prior {
        is_doubted: false,
        maker: match options.mask {
            Mask::External => Maker::Elsewhere,
            Mask::Hsv(..) => Maker::Color,
            _ if by_network => Maker::Network,
            _ => Maker::Own,
        },
        sees_covers: options.mask == Mask::Auto && !by_network,
        likely: by_network.then_some(&masker.seeker.likely),
        ..Prior::default()
    }
}

/// So many things that may be no ropes are clutter; a single one is reported, as doubtful.
const MUCH: usize = 2;

impl Extractor {
    /// Drops those of this image's curves that are hardly ropes, where the network found them, or saw none there.
    pub(super) fn drop_unlikely(&mut self, image: &Image) {
        if !self.masker.is_sought && !self.answer.leaves_out() {
            return;
        }
        self.weigh(image);
        let seen = self.count;
        let is_sure = |curve: &Curve| curve.confidence >= SURE;
        let knows_sure = self.tracker.knows_some(SURE);
        let has_sure = knows_sure || self.curves[..seen].iter().any(is_sure);
        self.count = 0;
        for i in 0..seen {
            let curve = &self.curves[i];
            let unlikely = match has_sure {
                false => UNLIKELY,
                true if self.masker.is_sought && knows_sure && !self.tracker.may_know(curve) => {
                    SURE
                }
                true => UNLIKELY_BESIDE,
            };
            let is_asked = self.masker.is_sought || self.is_unlikely_thing(i);
            if !is_asked || curve.confidence >= unlikely.min(self.options.min_confidence) {
                self.curves.swap(self.count, i);
                self.appearances.swap(self.count, i);
                self.count += 1;
            }
        }
    }

    /// Whether curve `i`, as weighed, is hardly a rope for what it appearances like. A piece of a rope appearances like the rope.
    pub(super) fn is_unlikely_thing(&self, i: usize) -> bool {
        self.curves[i].confidence < UNLIKELY_BESIDE && self.doubts[i].is_some()
    }

    /// Says of each of this image's curves how sure it is.
    pub(super) fn weigh(&mut self, image: &Image) {
        self.find_doubts(image, self.count, |_, _| false);
        let known = known(&self.masker, &self.options);
        for (i, doubt) in self.doubts.iter().enumerate().take(self.count) {
            let known = Prior {
                is_doubted: doubt.is_some(),
                ..known
            };
            let curves = &self.curves[..self.count];
            let evidence = confidence::evidence(image, (curves, i), known);
            self.curves[i].confidence = evidence.confidence();
        }
    }

    /// Whether what differs from the table, though that seems plain, is not ropes alone: all of it something else, or much of it.
    pub(super) fn is_cluttered(&mut self, image: &Image) -> bool {
        if self.options.mask != Mask::Auto || self.masker.is_sought {
            return false;
        }
        self.find_doubts(image, self.count, |_, _| false);
        let has_something = !self.masker.strips.used.is_empty();
        match self.count {
            _ if self.has_wide => {
                self.masker.doubts_itself(Notice::TooWide);
                true
            }
            0 if has_something => self.masker.doubts_itself(Notice::UnevenTable),
            0 => self.masker.doubts_noise(HIDDEN),
            _ if self.doubts.iter().flatten().count() < MUCH => false,
            _ => {
                self.masker.doubts_itself(Notice::UnevenTable);
                true
            }
        }
    }

    /// Says of the first `seen` curves which may be no ropes, and how sure it is of each.
    pub(super) fn doubt(&mut self, image: &Image, seen: usize) {
        // Who asks for fewer ropes than that wants the longest.
        let is_crowded = self.is_crowded && self.options.ropes == Options::default().ropes;
        self.doubt = None;
        // A mask that the user gave knows its ropes, and nothing is said of it.
        if self.masker.cut.is_some() || self.masker.notice.is_some() {
            self.doubt_ropes(image, seen);
        }
        let mut is_unsure = false;
        self.evidence.clear();
        for i in 0..seen {
            let curve = &self.curves[i];
            let of_it = (self.crossings.iter())
                .filter(|crossing| crossing.over == i || crossing.under == i);
            let known = Prior {
                is_doubted: curve.status == Status::Doubtful,
                left_out: self.remainder.beside(curve),
                crossings: of_it.count(),
                ..known(&self.masker, &self.options)
            };
            let evidence = confidence::evidence(image, (&self.curves[..seen], i), known);
            self.evidence.push(evidence);
            let sure = evidence.confidence();
            self.tracker.note_confidence(curve.track, sure);
            let curve = &mut self.curves[i];
            curve.confidence = sure;
            let is_below = curve.confidence < self.options.min_confidence;
            is_unsure |= is_below && curve.width_px >= THINNEST_PX;
        }
        self.doubt = (self.doubt)
            .or(is_unsure.then_some(Notice::Unsure))
            .or(is_crowded.then_some(Notice::TooMany));
    }

    /// The most important notice about this image's curves. An image without a curve has the notice about its table, if any.
    pub(super) fn notice(&self) -> Option<Notice> {
        let is_seen = |curve: &Curve| curve.status != Status::Lost;
        let sees_some = self.curves[..self.count].iter().any(is_seen);
        let of_mask = self
            .masker
            .notice
            .filter(|&notice| !sees_some || notice.is_of_ropes());
        self.doubt.or(of_mask)
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
        let of = (&self.curves[..seen], &self.appearances[..]);
        let is_known = |curve: &Curve| is_known(&self.tracker, curve);
        surroundings.doubt(of, is_known, &mut self.doubts);
    }
}

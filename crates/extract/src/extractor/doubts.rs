//! Finds the curves that may not be ropes.

use super::Extractor;
use crate::confidence::{self, Context, Evidence, Maker};
use crate::image::Image;
use crate::mask::cast::Cast;
use crate::mask::{MaskSource, Masker};
use crate::notice::Notice;
use crate::options::{Mask, Options};
use crate::scene::{Curve, Status};
use crate::tracking::plausible::Surroundings;
use crate::tracking::track::Tracker;

/// Minimum width of a rope with a readable inside. The confidence of a thinner one is low, but
/// tells nothing about the scene.
pub(super) const THINNEST_PX: f32 = 3.0;

/// Minimum confidence of the network's curves: one in fifty. Less likely ones are only reported if
/// the options ask for everything.
const UNLIKELY: f32 = 0.02;
/// Minimum confidence of a rope that counts as certain. While one is visible or known, a curve of
/// less than `UNLIKELY_BESIDE` is not reported either. It is another object, perhaps with a
/// fragment of the rope, and would take over the rope's number and shape. A new curve next to a
/// known rope must be as certain.
pub(super) const SURE: f32 = 0.5;
const UNLIKELY_BESIDE: f32 = 0.2;

/// Difference from the table at which noise must not hide a rope: a quarter of all 256 levels.
const HIDDEN: f32 = 64.0;

/// The judgement of an image's curves.
#[derive(Debug, Default)]
pub(super) struct Judgement {
    /// For each curve, a notice if it may be something else than a rope.
    pub(super) doubts: Vec<Option<Notice>>,
    /// The evidence for each reported curve.
    pub(super) evidence: Vec<Evidence>,
    /// The most important doubt about the reported curves.
    pub(super) doubt: Option<Notice>,
}

/// The context of all curves of a mask.
pub(super) fn context(masker: &Masker) -> Context<'_> {
    let source = masker.mask.source;
    let is_seen = source.is_seen_by_network();
    Context {
        maker: match source {
            MaskSource::Table { .. } | MaskSource::Network { is_blind: true } => Maker::Own,
            MaskSource::Color => Maker::Color,
            MaskSource::Network { .. } => Maker::Network,
            MaskSource::External => Maker::Elsewhere,
        },
        sees_covers: source.is_table(),
        likely: is_seen.then_some(&masker.seeker.likely),
        ..Context::default()
    }
}

/// Minimum number of doubtful objects that are clutter. A single doubtful object is reported, with
/// a notice.
const MUCH: usize = 2;

impl Extractor {
    /// Drops this image's unlikely curves, if they are the network's or the network saw no rope
    /// there.
    pub(super) fn drop_unlikely(&mut self, image: &Image) {
        if !self.masker.mask.source.is_network() && !self.answer.leaves_out() {
            return;
        }
        self.weigh(image);
        let seen = self.found.count;
        let is_sure = |curve: &Curve| curve.confidence >= SURE;
        let knows_sure = self.tracker.knows_some(SURE);
        let has_sure = knows_sure || self.found.curves[..seen].iter().any(is_sure);
        self.found.count = 0;
        for i in 0..seen {
            let curve = &self.found.curves[i];
            let unlikely = match has_sure {
                false => UNLIKELY,
                true if self.masker.mask.source.is_network()
                    && knows_sure
                    && !self.tracker.may_know(curve) =>
                {
                    SURE
                }
                true => UNLIKELY_BESIDE,
            };
            let is_asked = self.masker.mask.source.is_network() || self.is_unlikely_thing(i);
            if !is_asked || curve.confidence >= unlikely.min(self.options.min_confidence) {
                self.found.curves.swap(self.found.count, i);
                self.found.appearances.swap(self.found.count, i);
                self.found.count += 1;
            }
        }
    }

    /// Returns whether curve `i`, as weighed, is unlikely to be a rope because of its looks. A
    /// fragment of a rope looks like the rope.
    pub(super) fn is_unlikely_thing(&self, i: usize) -> bool {
        self.found.curves[i].confidence < UNLIKELY_BESIDE && self.judgement.doubts[i].is_some()
    }

    /// Computes the confidence of each of this image's curves.
    pub(super) fn weigh(&mut self, image: &Image) {
        self.find_doubts(image, self.found.count, |_, _| false);
        let context = context(&self.masker);
        for (i, doubt) in self
            .judgement
            .doubts
            .iter()
            .enumerate()
            .take(self.found.count)
        {
            let context = Context {
                is_doubted: doubt.is_some(),
                ..context
            };
            let curves = self.found.seen();
            let evidence = confidence::evidence(image, (curves, i), context);
            self.found.curves[i].confidence = evidence.confidence();
        }
    }

    /// Returns whether all or much of the difference from a table that seems plain is something
    /// other than ropes.
    pub(super) fn is_cluttered(&mut self, image: &Image) -> bool {
        if self.options.mask != Mask::Auto || self.masker.mask.source.is_network() {
            return false;
        }
        self.find_doubts(image, self.found.count, |_, _| false);
        let has_something = !self.masker.mask.strips.used.is_empty();
        match self.found.count {
            _ if self.found.has_wide => {
                self.masker.doubts_itself(Notice::TooWide);
                true
            }
            0 if has_something => self.masker.doubts_itself(Notice::UnevenTable),
            0 => self.masker.doubts_noise(HIDDEN),
            _ if self.judgement.doubts.iter().flatten().count() < MUCH => false,
            _ => {
                self.masker.doubts_itself(Notice::UnevenTable);
                true
            }
        }
    }

    /// Finds which of the first `seen` curves may not be ropes, and the confidence of each.
    pub(super) fn doubt(&mut self, image: &Image, seen: usize) {
        // A user who asks for fewer ropes than the default wants the longest.
        let is_crowded = self.found.is_crowded && self.options.ropes == Options::default().ropes;
        self.judgement.doubt = None;
        // A mask from the user is trusted, so its ropes cause no such notice.
        if self.masker.mask.source.is_table() || self.masker.mask.notice.is_some() {
            self.doubt_ropes(image, seen);
        }
        let mut is_unsure = false;
        self.judgement.evidence.clear();
        for i in 0..seen {
            let curve = &self.found.curves[i];
            let of_it = (self.crossings.iter())
                .filter(|crossing| crossing.over == i || crossing.under == i);
            let context = Context {
                is_doubted: curve.status == Status::Doubtful,
                left_out: self.found.remainder.beside(curve),
                crossings: of_it.count(),
                ..context(&self.masker)
            };
            let evidence = confidence::evidence(image, (&self.found.curves[..seen], i), context);
            self.judgement.evidence.push(evidence);
            let sure = evidence.confidence();
            self.tracker.note_confidence(curve.track, sure);
            let curve = &mut self.found.curves[i];
            curve.confidence = sure;
            let is_below = curve.confidence < self.options.min_confidence;
            is_unsure |= is_below && curve.width_px >= THINNEST_PX;
        }
        self.judgement.doubt = (self.judgement.doubt)
            .or(is_unsure.then_some(Notice::Unsure))
            .or(is_crowded.then_some(Notice::TooMany));
    }

    /// The most important notice about this image's curves. An image without a curve has the notice
    /// about its table, if any.
    pub(super) fn notice(&self) -> Option<Notice> {
        let is_seen = |curve: &Curve| curve.status != Status::Lost;
        let sees_some = self.found.seen().iter().any(is_seen);
        let of_mask = self
            .masker
            .mask
            .notice
            .filter(|&notice| !sees_some || notice.is_of_ropes());
        self.judgement.doubt.or(of_mask)
    }

    fn doubt_ropes(&mut self, image: &Image, seen: usize) {
        self.find_doubts(image, seen, |tracker, curve| tracker.is_known(curve.track));
        for (curve, doubt) in self.found.curves.iter_mut().zip(&self.judgement.doubts) {
            if self.tracker.weigh(curve.track, doubt.is_some()) {
                curve.status = Status::Doubtful;
                self.judgement.doubt = self.judgement.doubt.or(*doubt);
            }
        }
    }

    /// Finds what each of the first `seen` curves may be instead of a rope, except for known ones.
    fn find_doubts(
        &mut self,
        image: &Image,
        seen: usize,
        is_known: impl Fn(&Tracker, &Curve) -> bool,
    ) {
        let surroundings = Surroundings {
            image,
            background: &self.masker.background,
            mask: &self.masker.mask.bits,
            maybe_shadow: (self.masker.mask.cast == Cast::Maybe)
                .then_some(&self.masker.shadows.plane),
        };
        let of = (&self.found.curves[..seen], &self.found.appearances[..]);
        let is_known = |curve: &Curve| is_known(&self.tracker, curve);
        surroundings.doubt(of, is_known, &mut self.judgement.doubts);
    }
}

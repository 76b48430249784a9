//! Decides, by the judge's verdicts, which curves are reported and with what notice.

use super::Extractor;
use super::hypothesis::{SURE, UNLIKELY, is_thing};
use crate::image::Image;
use crate::judge::{Context, Evidence, Maker};
use crate::mask::cast::Cast;
use crate::mask::{MaskSource, Masker};
use crate::notice::Notice;
use crate::options::Options;
use crate::scene::Status;

/// Minimum width of a rope with a readable inside. The confidence of a thinner one is low, but
/// tells nothing about the scene.
pub(super) const THINNEST_PX: f32 = 3.0;
/// Minimum confidence of a curve: one in fifty. Less likely ones are only reported if the options
/// ask for everything.
const LEAST: f32 = 0.02;

/// The context in which the judge sees a mask's curves.
pub(super) fn context<'a>(image: &'a Image<'a>, masker: &'a Masker) -> Context<'a> {
    let mask = &masker.mask;
    Context {
        image,
        maker: match mask.source {
            MaskSource::Table { .. } => Maker::Own,
            MaskSource::Color => Maker::Color,
            MaskSource::Network => Maker::Network,
            MaskSource::External => Maker::Elsewhere,
        },
        table: mask.source.is_table().then_some(&masker.background),
        cast: (mask.cast == Cast::Maybe).then_some(&masker.shadows.plane),
        likely: (mask.source.is_network()).then_some(&masker.seeker.likely),
    }
}

impl Extractor {
    /// Drops this image's curves that are probably something other than ropes, if the network saw
    /// ropes elsewhere, or nothing at those curves. A new curve of the network next to a known rope
    /// must be sure: it may include a fragment of the rope, and would take over its number.
    pub(super) fn drop_unlikely(&mut self) {
        let is_network = self.masker.mask.source.is_network();
        if !is_network && !self.answer.denies() {
            return;
        }
        let knows_sure = self.tracker.knows_some(SURE);
        let has_sure = knows_sure || self.found.seen().iter().any(|c| c.confidence >= SURE);
        let seen = std::mem::take(&mut self.found.count);
        for i in 0..seen {
            let curve = &self.found.curves[i];
            let is_new = is_network && knows_sure && !self.tracker.may_know(curve);
            let least = match has_sure || !is_network {
                true if is_new || self.found.is_thing(i) => SURE,
                true if is_network => UNLIKELY,
                _ => LEAST,
            };
            if curve.confidence >= least.min(self.options.min_confidence) {
                self.found.curves.swap(self.found.count, i);
                self.found.appearances.swap(self.found.count, i);
                self.found.count += 1;
            } else {
                let is_likely = curve.confidence >= UNLIKELY || !self.found.is_thing(i);
                self.found.has_dropped |= is_network && is_likely;
            }
        }
    }

    /// Judges the first `seen` curves, with what their tracks and crossings add.
    pub(super) fn judge(&mut self, seen: usize) {
        let sees_covers = self.masker.mask.source.is_table();
        // A user who asks for fewer ropes than the default wants the longest.
        let is_crowded = self.found.is_crowded && self.options.ropes == Options::default().ropes;
        let (mut doubt, mut is_unsure) = (None, self.found.has_dropped);
        self.found.appearances.truncate(seen);
        let curves = self.found.curves.iter_mut();
        for (i, (curve, look)) in curves.zip(&mut self.found.appearances).enumerate() {
            let crossings = self.crossings.iter();
            let of_it = crossings.filter(|crossing| crossing.over == i || crossing.under == i);
            look.evidence.track(curve, of_it.count(), sees_covers);
            let verdict = look.evidence.verdict(self.tracker.is_known(curve.track));
            curve.confidence = verdict.confidence;
            if self.tracker.weigh(curve.track, is_thing(verdict)) {
                curve.status = Status::Doubtful;
                doubt = doubt.or(verdict.other.notice());
            }
            self.tracker.note_confidence(curve.track, curve.confidence);
            let is_below = curve.confidence < self.options.min_confidence;
            is_unsure |= is_below && curve.width_px >= THINNEST_PX;
        }
        self.doubt = doubt
            .or(is_unsure.then_some(Notice::Unsure))
            .or(is_crowded.then_some(Notice::TooMany));
    }

    /// The most important notice about this image's curves. An image without a curve has the notice
    /// about its table, if any.
    pub(super) fn notice(&self) -> Option<Notice> {
        let is_seen = |status: Status| status != Status::Lost;
        let sees_some = self.found.seen().iter().any(|curve| is_seen(curve.status));
        let of_mask = self.masker.mask.notice;
        let of_mask = of_mask.filter(|&notice| !sees_some || notice.is_of_ropes());
        // A rope of almost the table's color is doubted because of it.
        match of_mask {
            Some(Notice::LikeTheTable) => of_mask,
            _ => self.doubt.or(of_mask),
        }
    }

    /// The evidence behind the confidence of each curve, in the curves' order, for calibration. It
    /// belongs to the last image with a full extraction, without lost ropes.
    pub fn evidence(&self) -> impl Iterator<Item = &Evidence> {
        self.found.appearances.iter().map(|look| &look.evidence)
    }
}

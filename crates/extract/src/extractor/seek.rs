//! Decides when to run the network: if the table is not plain, if there is more on it than ropes,
//! or if the curves found there are uncertain.

use super::hypothesis::SURE;
use super::judgement::THINNEST_PX;
use super::{Extractor, Step};
use crate::image::Image;
use crate::notice::Notice;
use crate::options::{Mask, Method};
use crate::scene::Curve;

/// Number of images to skip after the network found nothing better. The network takes as long as
/// about ten images with a rope.
const IN_VAIN: u32 = 15;
/// Number of full extractions for which the network's answer is used.
const TAKEN: u32 = 30;
/// Minimum gain in confidence for the ropes in one mask to replace those in another. Ropes in the
/// network's mask replace those of a table that seems plain, and ropes in the automatic mask
/// replace those of picked colors.
pub(crate) const SURER: f32 = 0.2;
/// Minimum number of doubtful objects that are clutter. A single doubtful object is reported, with
/// a notice.
const MUCH: usize = 2;
/// Difference from the table at which noise must not hide a rope: a quarter of all 256 levels.
const HIDDEN: f32 = 64.0;

/// The network's last answer, if it applies to further images.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Answer {
    /// No answer that applies.
    #[default]
    None,
    /// The network found nothing better, and is skipped for this many images. If it `denies` what
    /// else is there, unlikely objects are left out.
    InVain { images: u32, denies: bool },
    /// The network found ropes, on a pattern or with higher confidence. It runs first on this many
    /// images.
    Ropes { images: u32, are_surer: bool },
}

impl Answer {
    /// Returns whether the network found no rope at unlikely objects.
    pub(super) fn denies(self) -> bool {
        matches!(self, Self::InVain { denies, .. } if denies)
    }

    /// Returns whether the network's ropes were surer than those found without it.
    fn was_surer(self) -> bool {
        matches!(self, Self::Ropes { are_surer, .. } if are_surer)
    }
}

impl Extractor {
    /// Runs the steps of a full extraction, with the mask that the image needs.
    pub(super) fn look(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        if self.goes_on_seeking(image, after) {
            return;
        }
        self.masker.run(image, &self.options.mask);
        self.trace_best(image, after);
        let was_surer = self.answer.was_surer();
        if let Answer::Ropes { .. } = self.answer {
            self.answer = Answer::None;
        }
        let is_cluttered = self.is_cluttered();
        let is_asked = is_cluttered || self.is_unsure(was_surer);
        if is_asked && !self.is_passed_over() {
            self.ask_as_well(image, is_cluttered, after);
        }
        // A pattern is permanent.
        if self.masker.mask.notice == Some(Notice::CheckeredTable) && self.is_found_by_network() {
            let (images, are_surer) = (TAKEN, false);
            self.answer = Answer::Ropes { images, are_surer };
        }
    }

    /// Runs the network if it found the ropes of the last images. Returns whether there are ropes.
    fn goes_on_seeking(&mut self, image: &Image, after: &mut dyn FnMut(Step)) -> bool {
        let Answer::Ropes { images, .. } = &mut self.answer else {
            return false;
        };
        if *images == 0 {
            return false;
        }
        *images -= 1;
        self.masker.seek_instead(image);
        self.trace(image, None, after);
        self.is_found_by_network()
    }

    fn is_found_by_network(&self) -> bool {
        self.masker.mask.source.is_network() && self.found.count > 0
    }

    /// Returns whether the network is skipped once more because it found nothing better.
    pub(super) fn is_passed_over(&mut self) -> bool {
        match &mut self.answer {
            Answer::InVain {
                images: images @ 1..,
                ..
            } => {
                *images -= 1;
                true
            }
            _ => false,
        }
    }

    /// Returns whether all or much of the difference from a table that seems plain is something
    /// other than ropes.
    fn is_cluttered(&mut self) -> bool {
        if self.options.mask != Mask::Auto || self.masker.mask.source.is_network() {
            return false;
        }
        let count = self.found.count;
        let has_something = !self.masker.mask.strips.used.is_empty();
        match count {
            _ if self.found.has_wide => {
                self.masker.doubts_itself(Notice::TooWide);
                true
            }
            0 if has_something => self.masker.doubts_itself(Notice::UnevenTable),
            0 => self.masker.doubts_noise(HIDDEN),
            _ if (0..count).filter(|&i| self.found.is_thing(i)).count() < MUCH => false,
            _ => {
                self.masker.doubts_itself(Notice::UnevenTable);
                true
            }
        }
    }

    /// Returns whether the automatic mask of a table that seems plain has given a rope that is
    /// uncertain or may be something else. This is checked while no rope is known yet, and after
    /// the network was surer. Clusterings are compared on one mask, so they are exempt.
    fn is_unsure(&self, was_surer: bool) -> bool {
        let is_asked = self.options.mask == Mask::Auto && self.options.method == Method::Skeleton;
        if !is_asked || self.masker.mask.source.is_network() {
            return false;
        }
        if !was_surer && self.tracker.knows_some(0.0) {
            return false;
        }
        // A bridged rope is uncertain because of its cover, about which the network knows no more.
        let is_weak = |curve: &Curve| {
            let is_bridged = curve.hidden.contains(&true);
            curve.confidence < SURE && curve.width_px >= THINNEST_PX && !is_bridged
        };
        self.found.seen().iter().any(is_weak)
    }

    /// Runs the network as well, and keeps the better hypothesis. On clutter, that is the network's
    /// if it has any rope. If it is not the network's, the network is skipped for a while. If it is
    /// sure of its ropes, what else may not be a rope is then dropped.
    fn ask_as_well(&mut self, image: &Image, is_cluttered: bool, after: &mut dyn FnMut(Step)) {
        let looks = self.found.appearances.iter();
        let is_covered = looks
            .take(self.found.count)
            .any(|look| look.covered.contains(&true));
        std::mem::swap(&mut self.found, &mut self.other);
        let mut denies = false;
        if self.masker.seek_as_well(image) {
            self.trace(image, None, after);
            self.drop_unlikely();
            denies = self.is_found_by_network()
                && self
                    .found
                    .seen()
                    .iter()
                    .all(|curve| curve.confidence >= SURE);
            let least = self.other.score() + SURER * self.found.length_px();
            // If ropes end at an object on top of them, the network sees the same ropes but not the
            // object.
            let sees_more = !is_covered || self.found.count != self.other.count;
            let is_better = is_cluttered || self.found.score() > least && sees_more;
            if self.found.count > 0 && is_better {
                let (images, are_surer) = (TAKEN, !is_cluttered);
                self.answer = Answer::Ropes { images, are_surer };
                return;
            }
        }
        self.masker.take_back();
        std::mem::swap(&mut self.found, &mut self.other);
        let images = IN_VAIN;
        self.answer = Answer::InVain { images, denies };
    }
}

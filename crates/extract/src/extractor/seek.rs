//! Decides when to run the network: if the table is not plain, if there is more on it than ropes,
//! or if the curves found there are uncertain.

use super::doubts::{SURE, THINNEST_PX};
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

/// The network's last answer, if it applies to further images.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Answer {
    /// No answer that applies.
    #[default]
    None,
    /// The network found nothing better, and is skipped for this many images.
    InVain(u32),
    /// The network found ropes, on a pattern or with higher confidence. It runs first on this many
    /// images.
    Ropes { images: u32, are_surer: bool },
    /// The network found no rope at an unlikely object, which is left out for this many images.
    NoRope(u32),
}

impl Answer {
    /// The answer that applies to the next image, as long as the network has not run on it.
    fn next(self) -> Self {
        match self {
            Self::NoRope(images @ 2..) => Self::NoRope(images - 1),
            Self::NoRope(_) | Self::Ropes { .. } => Self::None,
            Self::None | Self::InVain(_) => self,
        }
    }

    /// Returns whether the answer was better than the result without the network.
    fn was_better(self) -> bool {
        matches!(
            self,
            Self::NoRope(_)
                | Self::Ropes {
                    are_surer: true,
                    ..
                }
        )
    }

    /// Returns whether unlikely objects are left out.
    pub(super) fn leaves_out(self) -> bool {
        matches!(self, Self::NoRope(_))
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
        let last = self.answer;
        self.answer = last.next();
        if self.is_cluttered(image) {
            self.seek(image, after);
        } else if !self.answer.leaves_out() && self.is_unsure(image, last) {
            self.ask_as_well(image, after);
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
        self.masker.mask.source.is_seen_by_network() && self.found.count > 0
    }

    /// Returns whether the network is skipped once more because it found nothing better.
    pub(super) fn is_passed_over(&mut self) -> bool {
        match &mut self.answer {
            Answer::InVain(images @ 1..) => {
                *images -= 1;
                true
            }
            _ => false,
        }
    }

    /// Looks for ropes with the network. After a failure, it is skipped for a while.
    fn seek(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        let is_all_doubted =
            self.found.has_wide || self.judgement.doubts.iter().all(Option::is_some);
        if is_all_doubted && self.is_passed_over() {
            // The network found that they are not ropes.
            self.found.count = 0;
            return;
        }
        if self.masker.seek_on_table(image) {
            self.trace(image, None, after);
        }
        if self.found.count == 0 {
            self.answer = Answer::InVain(IN_VAIN);
        }
    }

    /// Returns whether the automatic mask of a table that seems plain has given a rope that is
    /// uncertain or may be something else. This is checked while no rope is known yet, and after
    /// the network was better. Clusterings are compared on one mask, so they are exempt.
    fn is_unsure(&mut self, image: &Image, last: Answer) -> bool {
        let is_asked = self.options.mask == Mask::Auto && self.options.method == Method::Skeleton;
        if !is_asked || self.masker.mask.source.is_network() || self.found.count == 0 {
            return false;
        }
        if !last.was_better() && self.tracker.knows_some(0.0) {
            return false;
        }
        self.weigh(image);
        // A bridged rope is uncertain because of its cover, about which the network knows no more.
        let is_bridged = |curve: &Curve| curve.hidden.contains(&true);
        let is_weak = |(curve, doubt): (&Curve, &Option<Notice>)| {
            let is_unsure = curve.confidence < SURE || doubt.is_some();
            is_unsure && curve.width_px >= THINNEST_PX && !is_bridged(curve)
        };
        let mut weighed = self.found.seen().iter().zip(&self.judgement.doubts);
        weighed.any(is_weak)
    }

    /// Runs the network as well, and keeps the more confident result. If that is not the network's,
    /// the network is skipped for a while. If the network is confident of as many ropes as were
    /// found without it, those are kept, because they are more precise. Everything else that may
    /// not be a rope is then dropped.
    fn ask_as_well(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        if self.is_passed_over() {
            return;
        }
        self.answer = Answer::InVain(IN_VAIN);
        let (own, count) = (self.found.mean_confidence(), self.found.count);
        let is_sure = |curve: &&Curve| curve.confidence >= SURE;
        let sure = self.found.curves[..count].iter().filter(is_sure).count();
        let unlikely = (0..count).filter(|&i| self.is_unlikely_thing(i)).count();
        let is_split = sure > 0 && unlikely > 0 && sure + unlikely == count;
        let is_covered = self
            .found
            .appearances
            .iter()
            .any(|look| look.covered.contains(&true));
        std::mem::swap(&mut self.found, &mut self.other);
        if self.masker.seek_as_well(image) {
            self.trace(image, None, after);
            self.drop_unlikely(image);
            let are_sure = self.found.seen().iter().all(|c| is_sure(&c));
            let is_told = are_sure && self.masker.mask.source.is_seen_by_network();
            let is_witness = is_told && is_split && self.found.count == sure;
            let is_surer = self.found.mean_confidence() > own + SURER;
            // If ropes end at an object on top of them, the network sees the same ropes but not the
            // object.
            let sees_more = !is_covered || self.found.count != count;
            if is_witness {
                self.answer = Answer::NoRope(TAKEN);
            } else if is_told && is_surer && sees_more {
                let (images, are_surer) = (TAKEN, true);
                self.answer = Answer::Ropes { images, are_surer };
                return;
            }
        }
        self.masker.take_back();
        std::mem::swap(&mut self.found, &mut self.other);
    }
}

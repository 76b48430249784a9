//! When the network is asked where ropes are: where there is no plain table, more on it than ropes, or what is found there is unsure.

use super::doubts::{SURE, THINNEST_PX};
use super::{Extractor, Step};
use crate::image::Image;
use crate::notice::Notice;
use crate::options::{Mask, Method};
use crate::scene::Curve;

/// Frames after the network was asked in vain until it is asked again: it takes as long as some ten images with a rope.
const FRAMES_TO_WAIT: u32 = 15;
/// Images that are extracted whole by the network at once, after one in which it found ropes on a pattern, or surer ones; or without what
/// is hardly a rope, after one in which it saw none there.
const FRAMES_KNOWN: u32 = 30;
/// By how much the network's ropes must be surer than those of a table that seems plain, to be taken instead.
const SURER: f32 = 0.2;

impl Extractor {
    /// The steps of an image that is extracted whole, with the mask that it asks for.
    pub(super) fn look(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        if self.goes_on_seeking(image, after) {
            return;
        }
        self.masker.run(image, &self.options.mask);
        self.trace(image, after);
        let was_surer = std::mem::take(&mut self.is_network_surer);
        if self.is_cluttered(image) {
            self.seek(image, after);
        } else {
            let was_witness = self.frames_witnessed > 0;
            self.frames_witnessed = self.frames_witnessed.saturating_sub(1);
            if self.frames_witnessed == 0 && self.is_unsure(image, was_surer || was_witness) {
                self.ask_as_well(image, after);
            }
        }
        // What covers a table passes, and so does its shade; a pattern stays.
        let is_patterned = self.masker.notice == Some(Notice::CheckeredTable);
        let is_known = (is_patterned || self.is_network_surer) && self.is_found_by_network();
        self.frames_known = if is_known { FRAMES_KNOWN } else { 0 };
    }

    /// Gives the image to the network where the last ones had a pattern. Whether there are ropes.
    fn goes_on_seeking(&mut self, image: &Image, after: &mut dyn FnMut(Step)) -> bool {
        if self.frames_known == 0 {
            return false;
        }
        self.frames_known -= 1;
        self.masker.seek_instead(image);
        self.trace(image, after);
        self.is_found_by_network()
    }

    fn is_found_by_network(&self) -> bool {
        self.masker.is_sought && !self.masker.is_blind && self.count > 0
    }

    /// Looks for ropes with the network; where that was in vain, not soon again.
    fn seek(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        let is_all_doubted = self.has_wide || self.doubts.iter().all(Option::is_some);
        if is_all_doubted && self.frames_to_wait > 0 {
            self.frames_to_wait -= 1;
            // It said that they are none.
            self.count = 0;
            return;
        }
        if self.masker.seek_on_table(image) {
            self.trace(image, after);
        }
        if self.count == 0 {
            self.frames_to_wait = FRAMES_TO_WAIT;
        }
    }

    /// Whether the automatic mask of what seems a plain table has given a rope that is not sure, and no rope is known yet, or the network
    /// was surer the last time. Clusterings are compared on one mask.
    fn is_unsure(&mut self, image: &Image, was_surer: bool) -> bool {
        let is_asked = self.options.mask == Mask::Auto && self.options.method == Method::Skeleton;
        if !is_asked || self.masker.is_sought || self.count == 0 {
            return false;
        }
        if !was_surer && self.tracker.knows_some(0.0) {
            return false;
        }
        self.weigh(image);
        // One that is bridged is unsure for what covers it, of which the network knows no more.
        let is_bridged = |curve: &Curve| curve.hidden.contains(&true);
        let is_weak = |curve: &Curve| {
            curve.confidence < SURE && curve.width_px >= THINNEST_PX && !is_bridged(curve)
        };
        self.curves[..self.count].iter().any(is_weak)
    }

    /// Asks the network as well, and takes what is surer; where that is not the network's, it is not soon asked again. Where it is sure of as
    /// many ropes as are sure without it, those stay, as they are drawn finer, and what else there is and may be none goes.
    fn ask_as_well(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        if self.frames_to_wait > 0 {
            self.frames_to_wait -= 1;
            return;
        }
        let (own, count) = (self.mean_confidence(), self.count);
        let is_sure = |curve: &&Curve| curve.confidence >= SURE;
        let sure = self.curves[..count].iter().filter(is_sure).count();
        let unlikely = (0..count).filter(|&i| self.is_unlikely_thing(i)).count();
        let is_parted = sure > 0 && unlikely > 0 && sure + unlikely == count;
        let is_covered = self.looks.iter().any(|look| look.covered.contains(&true));
        if self.masker.seek_on_table(image) {
            self.trace(image, after);
            self.drop_unlikely(image);
            let are_sure = self.curves[..self.count].iter().all(|c| is_sure(&c));
            let is_told = are_sure && !self.masker.is_blind;
            let is_witness = is_told && is_parted && self.count == sure;
            let is_surer = self.mean_confidence() > own + SURER;
            // Of what ends at a thing that lies on it it sees the same, but not the thing.
            let sees_more = !is_covered || self.count != count;
            self.is_network_surer = is_told && is_surer && sees_more && !is_witness;
            self.frames_witnessed = if is_witness { FRAMES_KNOWN } else { 0 };
        }
        if !self.is_network_surer {
            let is_answered = self.frames_witnessed > 0;
            self.frames_to_wait = if is_answered { 0 } else { FRAMES_TO_WAIT };
            self.masker.run(image, &self.options.mask);
            self.trace(image, after);
        }
    }

    /// How sure this image's curves are in the mean, each by its length; 0 of none.
    fn mean_confidence(&self) -> f32 {
        let curves = self.curves[..self.count].iter();
        let (sum, length_px) = curves.fold((0.0, 0.0), |(sum, length_px), curve| {
            (
                sum + curve.confidence * curve.length_px,
                length_px + curve.length_px,
            )
        });
        sum / f32::max(length_px, 1.0)
    }
}

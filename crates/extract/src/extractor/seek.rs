//! When the network is asked where ropes are: where there is no plain table, more on it than ropes, or what is found there is unsure.

use super::doubts::{SURE, THINNEST_PX};
use super::{Extractor, Step};
use crate::image::Image;
use crate::notice::Notice;
use crate::options::{Mask, Method};
use crate::scene::Curve;

/// So many images go by after the network was asked in vain: it takes as long as some ten images with a rope.
const IN_VAIN: u32 = 15;
/// And so many in which it is taken at its word, of those that are extracted whole.
const TAKEN: u32 = 30;
/// The least difference in confidence at which the ropes in one mask replace those in another: the network's replace those of a table
/// that seems plain, and the automatic mask's replace those of picked colours.
pub(crate) const SURER: f32 = 0.2;

/// What the network last said, as far as it goes for images to come.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Answer {
    /// Nothing that does.
    #[default]
    None,
    /// Nothing better: so many images are not given to it.
    InVain(u32),
    /// Ropes, on a pattern or surer ones: so many images are given to it at once.
    Ropes { images: u32, are_surer: bool },
    /// None there where something is hardly a rope: that is left out of so many images.
    NoRope(u32),
}

impl Answer {
    /// What goes for the next image, which it was not given.
    fn next(self) -> Self {
        match self {
            Self::NoRope(images @ 2..) => Self::NoRope(images - 1),
            Self::NoRope(_) | Self::Ropes { .. } => Self::None,
            Self::None | Self::InVain(_) => self,
        }
    }

    /// Whether it was better than what is seen without the network.
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

    /// Whether what is hardly a rope is left out.
    pub(super) fn leaves_out(self) -> bool {
        matches!(self, Self::NoRope(_))
    }
}

impl Extractor {
    /// The steps of an image that is extracted whole, with the mask that it asks for.
    pub(super) fn look(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        if self.goes_on_seeking(image, after) {
            return;
        }
        self.masker.run(image, &self.options.mask);
        self.read(image, after);
        let last = self.answer;
        self.answer = last.next();
        if self.is_cluttered(image) {
            self.seek(image, after);
        } else if !self.answer.leaves_out() && self.is_unsure(image, last) {
            self.ask_as_well(image, after);
        }
        // A pattern stays.
        if self.masker.notice == Some(Notice::CheckeredTable) && self.is_found_by_network() {
            let (images, are_surer) = (TAKEN, false);
            self.answer = Answer::Ropes { images, are_surer };
        }
    }

    /// Gives the image to the network where it found the last ones' ropes. Whether there are ropes.
    fn goes_on_seeking(&mut self, image: &Image, after: &mut dyn FnMut(Step)) -> bool {
        let Answer::Ropes { images, .. } = &mut self.answer else {
            return false;
        };
        if *images == 0 {
            return false;
        }
        *images -= 1;
        self.masker.seek_instead(image);
        self.trace(image, after);
        self.is_found_by_network()
    }

    fn is_found_by_network(&self) -> bool {
        self.masker.is_of_network() && self.count > 0
    }

    /// Whether the network is passed over once more, as it was asked in vain.
    pub(super) fn is_passed_over(&mut self) -> bool {
        match &mut self.answer {
            Answer::InVain(images @ 1..) => {
                *images -= 1;
                true
            }
            _ => false,
        }
    }

    /// Looks for ropes with the network; where that was in vain, not soon again.
    fn seek(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        let is_all_doubted = self.has_wide || self.doubts.iter().all(Option::is_some);
        if is_all_doubted && self.is_passed_over() {
            // It said that they are none.
            self.count = 0;
            return;
        }
        if self.masker.seek_on_table(image) {
            self.trace(image, after);
        }
        if self.count == 0 {
            self.answer = Answer::InVain(IN_VAIN);
        }
    }

    /// Returns true if the automatic mask of a table that seems plain has given a rope that is unsure or may be something else. The
    /// question is asked while no rope is known yet, and after the network knew better. Clusterings are compared on one mask.
    fn is_unsure(&mut self, image: &Image, last: Answer) -> bool {
        let is_asked = self.options.mask == Mask::Auto && self.options.method == Method::Skeleton;
        if !is_asked || self.masker.is_sought || self.count == 0 {
            return false;
        }
        if !last.was_better() && self.tracker.knows_some(0.0) {
            return false;
        }
        self.weigh(image);
        // One that is bridged is unsure for what covers it, of which the network knows no more.
        let is_bridged = |curve: &Curve| curve.hidden.contains(&true);
        let is_weak = |(curve, doubt): (&Curve, &Option<Notice>)| {
            let is_unsure = curve.confidence < SURE || doubt.is_some();
            is_unsure && curve.width_px >= THINNEST_PX && !is_bridged(curve)
        };
        let mut weighed = self.curves[..self.count].iter().zip(&self.doubts);
        weighed.any(is_weak)
    }

    /// Asks the network as well, and takes what is surer; where that is not the network's, it is not soon asked again. Where it is sure of as
    /// many ropes as are sure without it, those stay, as they are drawn finer, and what else there is and may be none goes.
    fn ask_as_well(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        if self.is_passed_over() {
            return;
        }
        self.answer = Answer::InVain(IN_VAIN);
        let (own, count) = (self.mean_confidence(), self.count);
        let is_sure = |curve: &&Curve| curve.confidence >= SURE;
        let sure = self.curves[..count].iter().filter(is_sure).count();
        let unlikely = (0..count).filter(|&i| self.is_unlikely_thing(i)).count();
        let is_split = sure > 0 && unlikely > 0 && sure + unlikely == count;
        let is_covered = self
            .appearances
            .iter()
            .any(|look| look.covered.contains(&true));
        if self.masker.seek_on_table(image) {
            self.trace(image, after);
            self.drop_unlikely(image);
            let are_sure = self.curves[..self.count].iter().all(|c| is_sure(&c));
            let is_told = are_sure && self.masker.is_of_network();
            let is_witness = is_told && is_split && self.count == sure;
            let is_surer = self.mean_confidence() > own + SURER;
            // Of what ends at a thing that lies on it it sees the same, but not the thing.
            let sees_more = !is_covered || self.count != count;
            if is_witness {
                self.answer = Answer::NoRope(TAKEN);
            } else if is_told && is_surer && sees_more {
                let (images, are_surer) = (TAKEN, true);
                self.answer = Answer::Ropes { images, are_surer };
                return;
            }
        }
        self.masker.run(image, &self.options.mask);
        self.read(image, after);
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

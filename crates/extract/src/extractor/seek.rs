//! When the network is asked where ropes are: where there is no plain table, or more on it than ropes.

use super::{Extractor, Step};
use crate::image::Image;
use crate::notice::Notice;

/// Frames after the network was asked in vain until it is asked again: it takes as long as some ten images with a rope.
const FRAMES_TO_WAIT: u32 = 15;
/// Images that are extracted whole by the network at once, after one in which it found ropes on a pattern.
const FRAMES_KNOWN: u32 = 30;

impl Extractor {
    /// The steps of an image that is extracted whole, with the mask that it asks for.
    pub(super) fn look(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        if self.goes_on_seeking(image, after) {
            return;
        }
        self.masker.run(image, &self.options.mask);
        self.trace(image, after);
        if self.is_cluttered(image) {
            self.seek(image, after);
        }
        // What covers a table passes, and so does its shade; a pattern stays.
        let is_patterned = self.masker.notice == Some(Notice::CheckeredTable);
        let is_known = is_patterned && self.is_found_by_network();
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
        let is_all_doubted = self.doubts.iter().all(Option::is_some);
        if is_all_doubted && self.frames_to_wait > 0 {
            self.frames_to_wait -= 1;
            // It said that they are none.
            self.count = 0;
            return;
        }
        if self.masker.seek_instead(image) {
            self.trace(image, after);
        }
        if self.count == 0 {
            self.frames_to_wait = FRAMES_TO_WAIT;
        }
    }
}

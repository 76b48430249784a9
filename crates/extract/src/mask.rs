//! The first step: from an image to one bit a pixel, rope or not, cleaned of specks and pinholes.

use crate::background::Background;
use crate::bits::{BitPlane, left_of, right_of};
use crate::components::Components;
use crate::difference::Differencer;
use crate::plane::Plane;
use crate::threshold::Cut;
use crate::whole::Mender;
use crate::{Image, Mask, hsv, threshold};

/// The largest share of the image that ropes may cover; more means that the ranges or the light
/// are wrong, and a "skeleton" of it would mean nothing.
const MOST_COVERED: f32 = 0.6;

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Masker {
    background: Background,
    differencer: Differencer,
    components: Components,
    mender: Mender,
    original: BitPlane,
    /// How unlike the table each pixel is (255 and 0 when the mask is by color ranges).
    pub(crate) difference: Plane,
    /// The mask.
    pub(crate) mask: BitPlane,
    /// The rope's width as guessed from area and outline of the mask, in pixels.
    pub(crate) width_px: f32,
}

impl Masker {
    /// Makes the mask of `image`. An image without rope, or one that is no picture of ropes, gets
    /// an empty mask.
    pub(crate) fn run(&mut self, image: &Image, how: &Mask) {
        let mut found = None;
        match how {
            Mask::Auto => {
                self.background.estimate(image);
                self.differencer
                    .difference(image, &self.background, &mut self.difference);
                let cut = threshold::choose(&self.difference, self.background.noise);
                threshold::apply(&self.difference, cut.rope, &mut self.mask);
                found = Some(cut);
            }
            Mask::Hsv(ranges) => hsv::apply(image, ranges, &mut self.difference, &mut self.mask),
        }
        if !self.clean(image, found) {
            self.mask.resize(image.width(), image.height());
        }
    }

    /// Drops specks and fills pinholes; false when the mask is no picture of ropes.
    fn clean(&mut self, image: &Image, cut: Option<Cut>) -> bool {
        let pixels = self.mask.width() * self.mask.height();
        smooth(&mut self.mask, &mut self.original);
        let area = self.mask.count();
        if area == 0 || area as f32 > MOST_COVERED * pixels as f32 {
            return false;
        }
        if let Some(cut) = cut {
            self.mender.mend(
                image,
                &self.background,
                cut,
                &mut self.difference,
                &mut self.mask,
            );
        }
        self.width_px = width_from_outline(&self.mask, self.mask.count());
        let square = self.width_px * self.width_px;
        // A rope is longer than wide; a hole smaller than half a width squared is shine or dirt.
        let (speck, hole) = ((2.0 * square).max(12.0) as u32, (0.4 * square) as u32);
        self.components.drop_specks(&mut self.mask, speck).is_ok()
            && self.components.fill_holes(&mut self.mask, hole).is_ok()
    }
}

/// Takes pixels without two neighbors in a row or column away and fills single unset pixels, all
/// words at once: most of the noise, before anything counts pieces.
fn smooth(mask: &mut BitPlane, original: &mut BitPlane) {
    original.copy_from(mask);
    let (words, height) = (mask.words_per_row(), mask.height());
    let last = mask.last_word_mask();
    for y in 0..height {
        for i in 0..words {
            let row = original.row(y);
            let (w, e) = (left_of(row, i), right_of(row, i));
            let n = if y > 0 { original.row(y - 1)[i] } else { 0 };
            let s = if y + 1 < height {
                original.row(y + 1)[i]
            } else {
                0
            };
            let filled = row[i] | n & s & w & e;
            // A lone pixel has no neighbor by a side: it goes.
            let mut word = filled & (n | s | w | e);
            if i + 1 == words {
                word &= last;
            }
            mask.row_mut(y)[i] = word;
        }
    }
}

/// A long shape's width is twice its area over its outline; sides of pixels overstate the outline of
/// a slanted edge by 4/π in the mean.
fn width_from_outline(mask: &BitPlane, area: usize) -> f32 {
    let mut sides = 0usize;
    for y in 0..mask.height() {
        let row = mask.row(y);
        for i in 0..row.len() {
            sides += (row[i] & !left_of(row, i)).count_ones() as usize;
            sides += (row[i] & !right_of(row, i)).count_ones() as usize;
            let above = if y > 0 { mask.row(y - 1)[i] } else { 0 };
            sides += 2 * (row[i] & !above).count_ones() as usize;
        }
    }
    2.0 * area as f32 / (sides as f32 * std::f32::consts::FRAC_PI_4).max(1.0)
}

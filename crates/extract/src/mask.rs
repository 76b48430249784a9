//! The first step: from an image to one bit a pixel, rope or not, cleaned of specks and pinholes.

use crate::background::Background;
use crate::bits::{BitPlane, left_of, right_of};
use crate::components::Components;
use crate::difference::Differencer;
use crate::doubt::{Doubter, Evidence};
use crate::kernels::Kernels;
use crate::plane::Plane;
use crate::threshold::Cut;
use crate::whole::Mender;
use crate::{Image, Mask, Notice, PixelFormat, hsv, threshold};
use thiserror::Error;

/// The largest share of the image that ropes may cover; more means that the ranges or the light
/// are wrong, and a "skeleton" of it would mean nothing.
const MOST_COVERED: f32 = 0.6;

/// From this level on a pixel of a mask made elsewhere is rope: the upper half of its bytes.
const ROPE_LEVEL: u8 = 128;

/// Why a mask that was made elsewhere cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MaskError {
    /// The mask has another size than the image.
    #[error(
        "the mask is {}×{} pixels and its image {}×{}: give each image a mask of its own size",
        .mask[0], .mask[1], .image[0], .image[1]
    )]
    Size {
        /// Width and height of the mask, in pixels.
        mask: [usize; 2],
        /// Width and height of the image, in pixels.
        image: [usize; 2],
    },
    /// The mask has more than one channel.
    #[error("the mask is {0:?}: give one byte a pixel (Gray8), 255 for rope and 0 for the rest")]
    Format(PixelFormat),
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Masker {
    kernels: Kernels,
    background: Background,
    differencer: Differencer,
    components: Components,
    mender: Mender,
    original: BitPlane,
    doubter: Doubter,
    /// How unlike the table each pixel is (255 and 0 when the mask is by color ranges, the mask's own bytes when it
    /// was made elsewhere).
    pub(crate) difference: Plane,
    /// The mask.
    pub(crate) mask: BitPlane,
    /// The rope's width as guessed from area and outline of the mask, in pixels.
    pub(crate) width_px: f32,
    /// What the automatic mask is unsure of.
    pub(crate) notice: Option<Notice>,
}

impl Masker {
    /// Makes the mask of `image`. An image without rope, or one that is no picture of ropes, gets
    /// an empty mask.
    pub(crate) fn run(&mut self, image: &Image, how: &Mask) {
        let mut chosen = None;
        match how {
            Mask::Auto => {
                self.background.estimate(image);
                let noise = self.background.noise;
                let levels = self.differencer.run(
                    image,
                    &self.background,
                    threshold::faint(noise),
                    &mut self.difference,
                    &mut self.mender.faint,
                );
                let cut = threshold::choose(&levels, noise);
                let (kernels, faint) = (&self.kernels, &self.mender.faint);
                threshold::apply_within(kernels, &self.difference, cut.rope, faint, &mut self.mask);
                self.mend(image, cut);
                chosen = Some(cut);
            }
            Mask::Hsv(ranges) => hsv::apply(image, ranges, &mut self.difference, &mut self.mask),
            Mask::External => {
                self.difference.resize(image.width(), image.height());
                self.mask.resize(image.width(), image.height());
            }
        }
        self.clean_or_empty();
        self.notice = chosen.and_then(|cut| self.judge(image, cut));
    }

    /// What to say about an automatic mask.
    fn judge(&mut self, image: &Image, cut: Cut) -> Option<Notice> {
        let evidence = Evidence {
            image,
            background: &self.background,
            difference: &self.difference,
            floor: threshold::floor(self.background.noise),
            cut,
            mask: &self.mask,
        };
        self.doubter.judge(&evidence, &mut self.components)
    }

    /// Takes the mask of `image` that somebody else made. Its edges are where it passes through half of the rope's own
    /// level, so that one of probabilities is as good between pixels as an image.
    ///
    /// # Errors
    /// When it is no `Gray8` of the image's size.
    pub(crate) fn take(&mut self, image: &Image, mask: &Image) -> Result<(), MaskError> {
        if mask.format() != PixelFormat::Gray8 {
            return Err(MaskError::Format(mask.format()));
        }
        let size = |of: &Image| [of.width(), of.height()];
        if size(mask) != size(image) {
            return Err(MaskError::Size {
                mask: size(mask),
                image: size(image),
            });
        }
        self.difference.resize(mask.width(), mask.height());
        for y in 0..mask.height() {
            self.difference.row_mut(y).copy_from_slice(mask.row(y));
        }
        threshold::apply(&self.kernels, &self.difference, ROPE_LEVEL, &mut self.mask);
        self.clean_or_empty();
        self.notice = None;
        Ok(())
    }

    fn clean_or_empty(&mut self) {
        if !self.clean() {
            let (width, height) = (self.mask.width(), self.mask.height());
            self.mask.resize(width, height);
        }
    }

    /// Takes what is set in `cover` out of the mask and the difference, as if the table lay there.
    pub(crate) fn take_out(&mut self, cover: &BitPlane) {
        for y in 0..self.mask.height() {
            let words = self.mask.row_mut(y).iter_mut().zip(cover.row(y));
            words.for_each(|(word, &out)| *word &= !out);
            for (x, level) in self.difference.row_mut(y).iter_mut().enumerate() {
                if cover.row(y)[x / 64] >> (x % 64) & 1 == 1 {
                    *level = 0;
                }
            }
        }
        if !self.clean() {
            self.mask.resize(cover.width(), cover.height());
        }
    }

    /// Adds what the cut left out of the ropes.
    fn mend(&mut self, image: &Image, cut: Cut) {
        smooth(&mut self.mask, &mut self.original);
        let pixels = self.mask.width() * self.mask.height();
        let area = self.mask.count();
        if area > 0 && area as f32 <= MOST_COVERED * pixels as f32 {
            let (table, difference) = (&self.background, &mut self.difference);
            self.mender
                .mend(image, table, cut, difference, &mut self.mask);
        }
    }

    /// Drops specks and fills pinholes; false when the mask is no picture of ropes.
    fn clean(&mut self) -> bool {
        let pixels = self.mask.width() * self.mask.height();
        smooth(&mut self.mask, &mut self.original);
        let area = self.mask.count();
        if area == 0 || area as f32 > MOST_COVERED * pixels as f32 {
            return false;
        }
        self.width_px = width_from_outline(&self.mask, area);
        let square = self.width_px * self.width_px;
        // A rope is longer than wide; a hole smaller than half a width squared is shine or dirt.
        let (speck, hole) = ((2.0 * square).max(12.0) as u32, (0.4 * square) as u32);
        self.components.drop_specks(&mut self.mask, speck).is_ok()
            && self.components.fill_holes(&mut self.mask, hole).is_ok()
    }
}

/// The mask of `image` as extraction takes it, cleaned: 255 for rope and 0 for the rest, a byte a pixel, row by row.
///
/// All 0 if it is no picture of ropes, and with [`Mask::External`]. For looking at: allocates.
pub fn mask_of(image: &Image, how: &Mask) -> Vec<u8> {
    let mut masker = Masker::default();
    masker.run(image, how);
    let mask = &masker.mask;
    let pixels = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| if mask.get(x as i32, y as i32) { 255 } else { 0 })
        .collect()
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

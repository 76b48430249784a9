//! Hysteresis: restores the parts of a rope that the cut left out because their color is close to
//! the table's.
//!
//! A highlight as light as the table splits a dark rope lengthwise. The dark dashes of a coarse
//! twist cut into its side. Such places are narrower than the rest of the rope, and this is how
//! they are found. Around them, and only there, fainter pixels also count as rope: all that exceed
//! the table's noise, as in Canny's edges ("A computational approach to edge detection", 1986).
//! Slits between them are closed. Only what restores the rope's own width is kept in the end.
//!
//! A rope of constant width is left unchanged. Blurred edges and shadows next to it, which are also
//! faint, therefore stay out.

use super::background::Background;
use super::shadow::{self, DARKEST};
use super::threshold::Cut;
use super::widths::Widths;
use crate::bitmap::bits::BitPlane;
use crate::bitmap::morphology::Morphology;
use crate::bitmap::pieces::Pieces;
use crate::bitmap::strips::{Blocks, Strips};
use crate::image::Image;
use crate::image::gray::GrayPlane;

/// The rope's width is the median by area of the widths along it. Its edges' blur is what faint
/// pixels add at the quantile `LEAST`.
const MIDDLE: f32 = 0.5;
const LEAST: f32 = 0.08;
/// Quantile of the thickness that faint pixels add. Above it, they count as more than an edge's
/// blur.
const USUAL: f32 = 0.3;
/// A place is thin if a disc of this share of the rope's width does not fit in it.
const THIN: f32 = 0.86;
/// Faint pixels farther than this from the ropes, in widths, do not belong to them. If they number
/// more than `RINGING` per pixel of the ropes' length, they are traces of JPEG. Uncompressed
/// pictures do not have them.
const APART: f32 = 0.5;
const RINGING: f32 = 0.02;
/// Half the maximum width of a slit that is closed without a trace of rope in it, in rope widths.
const SLIT: f32 = 0.2;
/// Objects wider than this share of the picture's shorter side, such as an arm, are left unchanged.
/// Restoring their width would take time and gain nothing.
const WIDEST: f32 = 1.0 / 6.0;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Hysteresis {
    morphology: Morphology,
    pub(crate) pieces: Pieces,
    widths: Widths,
    /// Pixels that exceed the table's noise, found with the difference. In the end, shadows are
    /// removed.
    pub(crate) faint: BitPlane,
    weak: Strips,
    /// Places where the rope is thin; later, their surroundings too.
    thin: Strips,
    wider: Strips,
    fits: Strips,
    /// Blocks close enough to a thin place to be processed.
    window: Blocks,
}

impl Hysteresis {
    /// Adds to `mask`, which is `difference` at the `cut`, the parts that its ropes lack. `rows` is
    /// the same mask row by row, without these additions.
    ///
    /// The difference of the added pixels is lifted to the ropes' mean, so that their outer edges
    /// are found.
    pub(crate) fn extend(
        &mut self,
        image: &Image,
        background: &Background,
        cut: Cut,
        difference: &mut GrayPlane,
        (mask, rows): (&mut Strips, &BitPlane),
    ) {
        self.reserve(mask);
        shadow::clear(image, background, DARKEST, &mut self.faint, rows);
        self.weak.take(&self.faint);
        self.widths.take((mask, rows), (&self.weak, &self.faint));
        let (width_px, fringe_px) = self.rope_width();
        let across = (THIN * width_px).round() as usize;
        let widest_px = WIDEST * rows.width().min(rows.height()) as f32;
        if across < 3 || width_px > widest_px {
            return;
        }
        if !self.find_thin(mask, across, width_px, fringe_px) {
            return;
        }
        let rings = self.rings(mask, width_px);
        let slit = ((SLIT * width_px) as usize).max(1);
        // No later step looks farther from a place where something may be added.
        let reach = (2 * slit).max(across + fringe_px) + 1;
        self.window.near(&self.thin, reach);
        self.wider.take_within(mask, &self.window);
        self.wider
            .zip_within(&self.weak, &self.thin, |m, w, t| m | w & t);
        self.fits.take_within(&self.wider, &self.window);
        self.morphology.close_within(&mut self.fits, slit);
        self.wider
            .zip_within(&self.fits, &self.thin, |m, c, t| m | c & t);
        // Keep what now has the rope's width, plus the corners that a disc does not reach.
        self.fits.take_within(&self.wider, &self.window);
        self.morphology.open(&mut self.fits, across);
        self.morphology.dilate_within(&mut self.fits, fringe_px);
        self.wider
            .zip_within(&self.fits, mask, |w, f, m| w & f & !m);
        self.drop_fringe(mask, slit, fringe_px);
        if rings {
            // A tip has traces in front of it that are as wide as the rope. Only what is between
            // parts of the mask is added.
            self.fits.take_within(mask, &self.window);
            self.morphology.close_within(&mut self.fits, across / 2);
            self.wider.zip_within(&self.fits, mask, |w, f, _| w & f);
        }
        self.wider.tighten();
        lift(difference, &self.wider, cut.level);
        mask.add(&self.wider);
    }

    /// Keeps only the part of a mask that a disc `across` pixels wide covers.
    pub(super) fn open(&mut self, mask: &mut Strips, across: usize) {
        self.morphology.open(mask, across);
    }

    /// Allocates all memory for a new image size at once. Otherwise, the first thin rope in a later
    /// image would allocate some.
    pub(super) fn reserve(&mut self, mask: &Strips) {
        if self.fits.shape == mask.shape {
            return;
        }
        for plane in [&mut self.thin, &mut self.wider, &mut self.fits] {
            plane.resize(&mask.shape);
        }
        self.window.resize(&mask.shape);
        self.morphology.reserve(mask);
    }

    /// Removes added pixels that are only as thick as the faint fringe of a sharp edge, unless they
    /// fill a slit in the rope. A disc also finds thin places at the corners of a tip.
    fn drop_fringe(&mut self, mask: &Strips, slit: usize, fringe_px: usize) {
        self.thin.take_within(mask, &self.window);
        self.morphology.close_within(&mut self.thin, slit);
        self.fits.take_within(&self.wider, &self.window);
        self.morphology.open(&mut self.fits, 2 * fringe_px);
        self.morphology.dilate_within(&mut self.fits, 1);
        self.wider
            .zip_within(&self.fits, &self.thin, |w, f, c| w & (f | c));
    }

    /// Width of the ropes in pixels, 0 without ropes, and width of the faint fringe of their edges.
    ///
    /// There are also faint pixels next to a blurred edge. The blur is what the faint pixels add
    /// where they add least. The rope's width is what they reach elsewhere, minus the blur.
    fn rope_width(&mut self) -> (f32, usize) {
        let edges_px = self.widths.edge(LEAST);
        let width_px = self.widths.width(MIDDLE) - edges_px;
        let fringe_px = (0.5 * self.widths.edge(USUAL)).ceil().max(1.0);
        (width_px, fringe_px as usize)
    }

    /// Returns whether there are many faint pixels apart from the ropes, relative to the ropes'
    /// length. JPEG leaves such pixels next to everything sharp. Pixels that a rope lacks would be
    /// adjacent to it.
    fn rings(&mut self, mask: &Strips, width_px: f32) -> bool {
        let apart = (APART * width_px).ceil() as usize + 1;
        self.fits.copy_from(mask);
        self.morphology.dilate(&mut self.fits, apart);
        self.wider.copy_from(&self.weak);
        self.wider.zip(&self.fits, mask, |w, f, _| w & !f);
        let length_px = mask.count() as f32 / width_px;
        self.wider.count() as f32 > RINGING * length_px
    }

    /// Finds the places where the rope is thin and everything around them that could be rope.
    /// Returns false without such places.
    fn find_thin(&mut self, mask: &Strips, across: usize, width_px: f32, fringe_px: usize) -> bool {
        self.fits.copy_from(mask);
        self.morphology.open(&mut self.fits, across);
        if fringe_px == 1 {
            // A single step reaches the mask's pixels directly from its own blocks.
            self.morphology.dilate_within(&mut self.fits, 1);
        } else {
            self.morphology.dilate(&mut self.fits, fringe_px);
        }
        self.thin.copy_from(mask);
        self.thin.zip(&self.fits, mask, |m, f, _| m & !f);
        let least = (0.5 * width_px) as u32;
        if self.pieces.drop_specks(&mut self.thin, least).is_err() || self.thin.count() == 0 {
            return false;
        }
        let beside = (0.7 * width_px).ceil() as usize;
        self.window.near(&self.thin, beside);
        self.thin.used.copy_from(&self.window);
        self.morphology.dilate_within(&mut self.thin, beside);
        true
    }
}

/// Lifts the difference of the `added` pixels to `level`, so that the rope's edges are found where
/// these pixels end.
pub(super) fn lift(difference: &mut GrayPlane, added: &Strips, level: u8) {
    added.for_each_word(|y, strip, mut word| {
        let row = difference.row_mut(y);
        while word != 0 {
            let value = &mut row[64 * strip + word.trailing_zeros() as usize];
            *value = level.max(*value);
            word &= word - 1;
        }
    });
}

#[cfg(test)]
mod tests {
    use crate::image::{Image, PixelFormat};
    use crate::mask::Masker;
    use crate::options::Mask;

    const SIZE: [usize; 2] = [400, 100];
    const TABLE: [u8; 3] = [200, 196, 190];
    const ROPE: [u8; 3] = [40, 60, 120];

    /// A picture of boxes, given by their columns, rows and color.
    fn picture(boxes: &[([usize; 2], [usize; 2], [u8; 3])]) -> Vec<u8> {
        let mut pixels = TABLE.repeat(SIZE[0] * SIZE[1]);
        for &([left, right], [top, bottom], color) in boxes {
            for y in top..bottom {
                for x in left..right {
                    pixels[3 * (y * SIZE[0] + x)..][..3].copy_from_slice(&color);
                }
            }
        }
        pixels
    }

    fn masked(pixels: &[u8]) -> Masker {
        let image = Image::new(pixels, SIZE[0], SIZE[1], 3 * SIZE[0], PixelFormat::Rgb8);
        let mut masker = Masker::default();
        masker.run(&image.expect("a whole image"), &Mask::Auto);
        masker
    }

    #[test]
    fn a_highlight_of_the_tables_color_does_not_split_the_rope() {
        let masker = masked(&picture(&[
            ([40, 360], [40, 52], ROPE),
            ([100, 200], [43, 46], TABLE),
        ]));
        for x in 45..355 {
            assert!((41..51).all(|y| masker.mask.bits.get(x, y)), "column {x}");
            let level = masker.mask.difference.row(44)[x as usize];
            assert!(level > 100, "column {x}: {level}");
        }
    }

    #[test]
    fn a_pale_side_belongs_to_the_rope() {
        // 35 levels off the table in blue alone: far below the cut, and not a shadow.
        let pale = [200, 196, 225];
        let masker = masked(&picture(&[
            ([40, 360], [40, 52], ROPE),
            ([100, 160], [40, 46], pale),
        ]));
        assert!((105..155).all(|x| masker.mask.bits.get(x, 41)));
    }

    #[test]
    fn a_shadow_beside_the_rope_does_not() {
        let shadow = TABLE.map(|level| (f32::from(level) * 0.8) as u8);
        let masker = masked(&picture(&[
            ([40, 360], [40, 52], ROPE),
            ([40, 360], [52, 58], shadow),
        ]));
        assert!((40..360).all(|x| !masker.mask.bits.get(x, 53)));
    }

    #[test]
    fn the_table_between_two_strands_stays_table() {
        let masker = masked(&picture(&[
            ([40, 360], [30, 40], ROPE),
            ([40, 360], [42, 52], ROPE),
        ]));
        for x in 40..360 {
            assert!((40..42).all(|y| !masker.mask.bits.get(x, y)), "column {x}");
        }
    }

    #[test]
    fn a_rope_of_one_width_is_left_as_it_is() {
        let masker = masked(&picture(&[([40, 360], [40, 52], ROPE)]));
        assert_eq!(masker.mask.bits.count(), 320 * 12);
    }
}

//! The first step: from an image to one bit per pixel, rope or not, without specks and pinholes.

use super::background::Background;
use super::cast::{Cast, Shadows};
use super::diagnosis::{self, Diagnosis, Evidence};
use super::difference::Differencer;
use super::hsv::Selector;
use super::hysteresis::Hysteresis;
use super::level;
use super::neural;
use super::outline::{outline, width_from_outline};
use super::rims::Rims;
use super::rope_mask::{MaskSource, RopeMask};
use super::seams::Seams;
use super::seeker::Seeker;
use super::smoothed::Smoother;
use super::threshold::{self, Cut, Levels};
use crate::bitmap::bits::BitPlane;
use crate::bitmap::neighbors::{self, Around, Rule};
use crate::bitmap::strips::Strips;
use crate::image::gray::GrayPlane;
use crate::image::kernels::Kernels;
use crate::image::unpack::Unpacker;
use crate::image::{Image, PixelFormat, Region};
use crate::notice::Notice;
use crate::options::Mask;
use crate::scene::MOST_CROSSINGS;
use lariat_network::Network;
use std::num::NonZeroU8;
use std::sync::Arc;
use thiserror::Error;

/// Maximum share of the image that ropes may cover. With more, the ranges or the light are wrong,
/// and a skeleton would be meaningless.
const MOST_COVERED: f32 = 0.6;

/// Maximum number of holes minus pieces in a mask by color or from elsewhere. At this number, ropes
/// would cross four times as often as is reported. A net has more.
const MOST_HOLES: i64 = 4 * MOST_CROSSINGS as i64;

/// Maximum share of the picture's border that is in the mask. Above it, the mask there is not rope.
const FRAMED: f32 = 0.18;

/// Minimum width of the remainder between two seams to count as a strand, as a share of the
/// strand's width, and its minimum area in widths squared.
const THINNEST: f32 = 0.3;
const SPECK: f32 = 0.5;

/// Minimum level of a rope pixel.
const ROPE_LEVEL: u8 = 128;

/// Reason why a mask that was made elsewhere cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MaskError {
    /// The mask and the image have different sizes.
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
    /// All pixels of the mask have this level, which is not 0.
    #[error(
        "the mask has the level {0} everywhere, and so shows no rope: give a mask that is 0 on the background"
    )]
    OneLevel(u8),
}

/// Returns whether a notice says that differences from the table may not be ropes.
fn is_no_plain_table(notice: Notice) -> bool {
    use Notice::*;
    matches!(notice, CheckeredTable | UnevenTable | Covered)
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Masker {
    kernels: Kernels,
    pub(crate) background: Background,
    differencer: Differencer,
    levels: Levels,
    selector: Selector,
    hysteresis: Hysteresis,
    smoother: Smoother,
    rims: Rims,
    smoothed: Strips,
    diagnosis: Diagnosis,
    /// The ropes' own shadow, which is removed from the mask if it is certain.
    pub(crate) shadows: Shadows,
    pub(crate) seeker: Seeker,
    seams: Seams,
    /// The difference and the mask before they were [cut at their seams](Self::cut_seams).
    pub(crate) whole: (GrayPlane, BitPlane),
    /// The mask of the image.
    pub(crate) mask: RopeMask,
    /// The mask from before the network was run as well.
    aside: RopeMask,
}

impl Masker {
    /// Sets another network.
    pub(crate) fn use_network(&mut self, network: Arc<Network>) {
        self.seeker.use_network(network);
    }

    /// Makes the mask of `image`. The mask is empty unless the image shows ropes.
    pub(crate) fn run(&mut self, image: &Image, how: &Mask) {
        match how {
            Mask::Auto => self.run_on_table(image),
            Mask::Network => {
                self.mask.notice = None;
                self.seek(image, Region::whole(image));
            }
            Mask::Hsv(ranges) => {
                let (inside, bits) = (&mut self.mask.difference, &mut self.mask.bits);
                self.selector.run(image, ranges, inside, bits);
                self.take_bits(MaskSource::Color);
            }
            Mask::External => {
                self.mask.difference.resize(image.width(), image.height());
                self.mask.bits.resize(image.width(), image.height());
                self.take_bits(MaskSource::External);
            }
        }
    }

    /// Makes the mask from the difference from the table. If the table is not plain, the network makes
    /// it.
    fn run_on_table(&mut self, image: &Image) {
        self.background.estimate(image);
        let noise = self.background.noise;
        let (difference, faint) = (&mut self.mask.difference, &mut self.hysteresis.faint);
        let least = threshold::faint(noise);
        let levels = &mut self.levels;
        (self.differencer).run(image, &self.background, least, difference, faint, levels);
        let cut = threshold::choose(levels, noise);
        if diagnosis::covers_much(cut) {
            // The network is asked in any case.
            self.mask.bits.resize(image.width(), image.height());
            self.mask.empty();
        } else {
            self.cut_out(image, cut);
        }
        self.mask.source = MaskSource::Table {
            cut: cut.rope,
            is_smoothed: false,
        };
        self.mask.cast = Cast::None;
        self.mask.notice = self.judge(image, cut);
        if self.mask.notice == Some(Notice::LikeTheTable) && self.is_noisy() {
            self.take_smoothed(image);
        }
        if self.mask.notice.is_none() && self.is_framed() {
            self.mask.notice = Some(Notice::UnevenTable);
        }
        if self.mask.notice.is_some_and(is_no_plain_table) {
            self.seek(image, Region::whole(image));
        }
        self.mask.differs = self.mask.bits.bounds();
        if self.mask.notice.is_none() && !self.mask.is_empty() {
            self.take_shadows_out(image);
        }
    }

    /// Returns whether much of the picture's border is in the mask, which means that the table ends
    /// in the picture.
    fn is_framed(&self) -> bool {
        let mask = &self.mask.bits;
        let (width, height) = (mask.width(), mask.height());
        let ones = |row: &[u64]| row.iter().map(|word| word.count_ones()).sum::<u32>();
        let ends = |y: i32| u32::from(mask.get(0, y)) + u32::from(mask.get(width as i32 - 1, y));
        let sides: u32 = (0..height as i32).map(ends).sum();
        let border = ones(mask.row(0)) + ones(mask.row(height - 1)) + sides;
        border as f32 > FRAMED * 2.0 * (width + height) as f32
    }

    /// Replaces the mask with the ropes that the network finds in the part `within` of the image.
    fn seek(&mut self, image: &Image, within: Region) {
        self.seeker.run(image, within, &mut self.mask.difference);
        let notice = self.mask.notice;
        self.take_levels(ROPE_LEVEL);
        self.mask.notice = notice;
        self.mask.source = MaskSource::Network;
        self.seeker.has_found = !self.mask.is_empty();
    }

    /// Forgets whether the network has found ropes.
    pub(crate) fn forget(&mut self) {
        self.seeker.has_found = false;
    }

    /// Marks an automatic mask as doubtful if it was trusted but held no rope. Returns whether it
    /// was marked.
    pub(crate) fn doubts_itself(&mut self, why: Notice) -> bool {
        let seemed_sure = self.mask.notice.is_none() && self.mask.source.is_table();
        if seemed_sure {
            self.mask.notice = Some(why);
        }
        seemed_sure
    }

    /// Marks an empty automatic mask as noisy if the noise would hide a rope that differs from the
    /// table by `level`. Returns whether it was marked.
    pub(crate) fn doubts_noise(&mut self, level: f32) -> bool {
        let is_hidden = threshold::floor(self.background.noise) > level;
        let seemed_sure = self.mask.notice.is_none() && self.mask.source.is_table() && is_hidden;
        if seemed_sure {
            self.mask.notice = Some(Notice::Noisy);
        }
        seemed_sure
    }

    /// Searches the whole image for ropes with the network instead. Returns whether it found
    /// anything.
    pub(crate) fn seek_instead(&mut self, image: &Image) -> bool {
        self.seek(image, Region::whole(image));
        !self.mask.is_empty()
    }

    /// Searches for ropes with the network where this image differs from a table that seemed plain.
    /// Returns whether it found anything.
    pub(crate) fn seek_on_table(&mut self, image: &Image) -> bool {
        let differs = self
            .mask
            .differs
            .clone()
            .map(|part| neural::grown(part, image));
        self.seek(image, differs.unwrap_or(Region::whole(image)));
        !self.mask.is_empty()
    }

    /// Does the same, but keeps the mask for [`take_back`](Self::take_back).
    pub(crate) fn seek_as_well(&mut self, image: &Image) -> bool {
        std::mem::swap(&mut self.mask, &mut self.aside);
        self.mask.differs.clone_from(&self.aside.differs);
        self.mask.notice = self.aside.notice;
        self.seek_on_table(image)
    }

    /// Restores the mask from before [`seek_as_well`](Self::seek_as_well).
    pub(crate) fn take_back(&mut self) {
        std::mem::swap(&mut self.mask, &mut self.aside);
    }

    /// Cuts the mask out of the difference, then adds the parts of the ropes that the cut leaves
    /// out.
    fn cut_out(&mut self, image: &Image, cut: Cut) {
        let (kernels, strips) = (&self.kernels, &mut self.mask.strips);
        let faint = &self.hysteresis.faint;
        threshold::apply_within(kernels, &self.mask.difference, cut.rope, faint, strips);
        // The rows are written when the mask is extended.
        self.mask.bits.resize(image.width(), image.height());
        self.extend(image, cut);
        self.clean_or_empty();
        let mask = (&self.mask.bits, self.mask.strips.count());
        if Rims::are_there(image, &self.background, mask) {
            let mask = (&mut self.mask.strips, &self.mask.bits);
            let difference = (&mut self.mask.difference, cut.level);
            (self.rims).fill(image, &self.background, mask, difference);
            self.clean_or_empty();
        }
    }

    /// Returns whether the minimum cut is set by the table's noise.
    fn is_noisy(&self) -> bool {
        threshold::floor(self.background.noise) > threshold::LEVEL_FLOOR
    }

    /// Cuts the mask again from the smoothed picture, in case only noise hides the ropes.
    fn take_smoothed(&mut self, image: &Image) {
        let noise = (self.smoother).run(image, &self.background, &mut self.mask.difference);
        let least = threshold::faint(noise);
        let (levels, faint) = (&mut self.levels, &mut self.hysteresis.faint);
        faint.resize(image.width(), image.height());
        levels.clear(image.width(), image.height());
        for y in 0..image.height() {
            let row = self.mask.difference.row(y);
            (self.kernels.at_least)(row, least, faint.row_mut(y));
            levels.add(&self.kernels, y, row, faint.row(y));
            if levels.asks_table(y) {
                levels.add_table(row, least);
            }
        }
        levels.close();
        let cut = threshold::choose(levels, noise);
        self.cut_out(image, cut);
        let evidence = Evidence {
            image,
            background: &self.background,
            difference: &self.mask.difference,
            floor: threshold::floor(noise),
            cut,
            mask: &self.mask.strips,
        };
        let components = &mut self.hysteresis.pieces.components;
        self.mask.notice = self.diagnosis.notice(&evidence, components);
        self.mask.source = MaskSource::Table {
            cut: cut.rope,
            is_smoothed: true,
        };
    }

    /// Reserves the buffers that the picture drawn by the extractor's `prepare` does not use.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        self.shadows.reserve(width, height);
        self.seeker.reserve(width, height);
        self.seams.reserve(width, height);
        self.aside.reserve(width, height);
        self.whole.0.resize(width, height);
        self.whole.1.resize(width, height);
        self.hysteresis.reserve(&self.mask.strips);
        self.smoother.reserve(width);
        self.rims.reserve(&self.mask.strips, &self.mask.bits);
    }

    /// Removes the ropes' own shadow from an automatic mask.
    fn take_shadows_out(&mut self, image: &Image) {
        let mask = (&self.mask.bits, self.mask.strips.count());
        self.mask.cast = self.shadows.find(image, &self.background, mask);
        if self.mask.cast == Cast::Sure {
            let plane = std::mem::take(&mut self.shadows.plane);
            self.take_out(&plane);
            self.shadows.plane = plane;
            self.mask.notice = Some(Notice::OwnShadow);
        }
    }

    /// Prepares what images of this many pixels need.
    pub(crate) fn prepare(&mut self, how: &Mask, pixels: usize) {
        if let Mask::Hsv(ranges) = how {
            self.selector.prepare(ranges, pixels, false);
        }
    }

    /// Returns the notice about an automatic mask.
    fn judge(&mut self, image: &Image, cut: Cut) -> Option<Notice> {
        let floor = threshold::floor(self.background.noise);
        if !cut.is_sure(floor) || self.mask.is_empty() {
            self.differencer
                .fill(image, &self.background, &mut self.mask.difference);
        }
        let evidence = Evidence {
            image,
            background: &self.background,
            difference: &self.mask.difference,
            floor,
            cut,
            mask: &self.mask.strips,
        };
        let components = &mut self.hysteresis.pieces.components;
        self.diagnosis.notice(&evidence, components)
    }

    /// Takes a mask of `image` that was made elsewhere: rope from `level` on, or from the level
    /// that its histogram gives.
    ///
    /// Its edges are where it passes through half of the rope's own level. A mask of probabilities
    /// is therefore as good between pixels as an image.
    ///
    /// # Errors
    /// If the mask is not `Gray8` or differs from the image in size.
    pub(crate) fn take(
        &mut self,
        image: &Image,
        mask: &Image,
        level: Option<NonZeroU8>,
    ) -> Result<(), MaskError> {
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
        self.mask.difference.resize(mask.width(), mask.height());
        for y in 0..mask.height() {
            self.mask.difference.row_mut(y).copy_from_slice(mask.row(y));
        }
        let level = level.map_or_else(|| level::choose(&self.mask.difference), NonZeroU8::get);
        self.take_levels(level);
        Ok(())
    }

    /// Makes the mask from the levels in the difference: rope from `level` on.
    fn take_levels(&mut self, level: u8) {
        threshold::apply(
            &self.kernels,
            &self.mask.difference,
            level,
            &mut self.mask.bits,
        );
        self.take_bits(MaskSource::External);
    }

    /// Completes the mask from its bits, which are all rope.
    fn take_bits(&mut self, source: MaskSource) {
        self.mask.strips.take(&self.mask.bits);
        self.clean_or_empty();
        self.mask.source = source;
        self.mask.cast = Cast::None;
        self.mask.notice = self.leave_net_out();
    }

    /// Empties a mask that is a net, and returns a notice about it.
    fn leave_net_out(&mut self) -> Option<Notice> {
        let is_net = diagnosis::holes_beyond_pieces(&self.mask.strips) > MOST_HOLES;
        if is_net {
            self.mask.empty();
        }
        is_net.then_some(Notice::TooMany)
    }

    /// Cleans the mask. A mask that does not show ropes is emptied.
    fn clean_or_empty(&mut self) {
        if self.clean() {
            self.mask.strips.put(&mut self.mask.bits);
            self.mask.strips.tighten();
        } else {
            self.mask.empty();
        }
    }

    /// Removes the pixels of `occluder` from the mask and the difference, as if the table were
    /// there.
    pub(crate) fn take_out(&mut self, occluder: &BitPlane) {
        for y in 0..self.mask.bits.height() {
            let words = self.mask.bits.row_mut(y).iter_mut().zip(occluder.row(y));
            words.for_each(|(word, &out)| *word &= !out);
            let levels = self.mask.difference.row_mut(y);
            occluder.for_each_set(y, |x| levels[x] = 0);
        }
        self.mask.strips.take(&self.mask.bits);
        self.clean_or_empty();
    }

    /// Prepares the search for seams between the strands of the mask of `image`. The strands are
    /// about `width_px` wide.
    pub(crate) fn see_seams(&mut self, image: &Image, width_px: f32) {
        let (difference, mask) = &mut self.whole;
        difference.copy_from(&self.mask.difference);
        mask.copy_from(&self.mask.bits);
        self.seams.smooth(image, &self.mask.bits, width_px);
    }

    /// Cuts the mask and the difference at the seams, after [`see_seams`](Self::see_seams). A seam
    /// is where the light bends upward by `bent`, in standard deviations of the ropes' light.
    pub(crate) fn cut_seams(&mut self, width_px: f32, bent: f32) {
        self.seams.find(&self.mask.bits, bent);
        for y in 0..self.mask.bits.height() {
            let words = self
                .mask
                .bits
                .row_mut(y)
                .iter_mut()
                .zip(self.seams.plane.row(y));
            words.for_each(|(word, &seam)| *word &= !seam);
            let levels = self.mask.difference.row_mut(y);
            self.seams.plane.for_each_set(y, |x| levels[x] = 0);
        }
        self.mask.strips.take(&self.mask.bits);
        let across = (THINNEST * width_px).round().max(2.0) as usize;
        self.hysteresis.open(&mut self.mask.strips, across);
        let speck = (SPECK * width_px * width_px) as u32;
        if self
            .hysteresis
            .pieces
            .drop_specks(&mut self.mask.strips, speck)
            .is_err()
        {
            self.mask.empty();
        }
        self.mask.strips.put(&mut self.mask.bits);
    }

    /// Undoes [`cut_seams`](Self::cut_seams).
    pub(crate) fn uncut(&mut self) {
        self.mask.difference.copy_from(&self.whole.0);
        self.mask.bits.copy_from(&self.whole.1);
        self.mask.strips.take(&self.mask.bits);
    }

    /// Adds the parts of the ropes that the cut left out.
    fn extend(&mut self, image: &Image, cut: Cut) {
        self.smooth();
        let pixels = self.mask.bits.width() * self.mask.bits.height();
        let area = self.mask.strips.count();
        if area > 0 && area as f32 <= MOST_COVERED * pixels as f32 {
            self.mask.strips.put(&mut self.mask.bits);
            // The noise is gone, so its blocks need no more work.
            self.mask.strips.tighten();
            let (table, difference) = (&self.background, &mut self.mask.difference);
            let mask = (&mut self.mask.strips, &self.mask.bits);
            self.hysteresis.extend(image, table, cut, difference, mask);
        }
    }

    /// Drops specks and fills pinholes. Returns false if the mask does not show ropes.
    fn clean(&mut self) -> bool {
        let pixels = self.mask.bits.width() * self.mask.bits.height();
        self.smooth();
        let (area, sides) = outline(&self.mask.strips);
        if area == 0 || area as f32 > MOST_COVERED * pixels as f32 {
            return false;
        }
        self.mask.width_px = width_from_outline(area, sides);
        let square = self.mask.width_px * self.mask.width_px;
        // A rope is longer than wide. A hole of less than half a squared width is shine or dirt.
        let (speck, hole) = ((2.0 * square).max(12.0) as u32, (0.4 * square) as u32);
        let pieces = &mut self.hysteresis.pieces;
        pieces.drop_specks(&mut self.mask.strips, speck).is_ok()
            && pieces.fill_holes(&mut self.mask.strips, hole).is_ok()
    }

    /// Removes pixels without a neighbor by a side and fills single unset pixels, whole words at
    /// once. This removes most of the noise before anything counts pieces.
    fn smooth(&mut self) {
        neighbors::step(Smooth, &mut self.mask.strips, &mut self.smoothed);
    }
}

/// The mask of `image` as extraction uses it, cleaned: 255 for rope and 0 for the rest, one byte
/// per pixel, row by row.
///
/// All 0 if the image does not show ropes, and with [`Mask::External`]. For inspection only:
/// allocates.
pub fn mask_of(image: &Image, how: &Mask) -> Vec<u8> {
    let (mut unpacker, mut masker) = <(Unpacker, Masker)>::default();
    masker.run(&unpacker.unpack(image), how);
    let mask = &masker.mask.bits;
    let pixels = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| if mask.get(x as i32, y as i32) { 255 } else { 0 })
        .collect()
}

/// The rule of [`Masker::smooth`].
struct Smooth;

impl Rule for Smooth {
    #[inline(always)]
    fn word(&self, around: &Around) -> u64 {
        let &Around {
            here, n, s, w, e, ..
        } = around;
        let filled = here | n & s & w & e;
        // A lone pixel lacks a neighbor by a side and is removed.
        filled & (n | s | w | e)
    }
}

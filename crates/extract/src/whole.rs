//! A rope made whole: what the cut left out of it because its color comes near the table's there.
//!
//! A highlight as light as the table splits a dark rope lengthwise; the dark dashes of a coarse twist are
//! bitten out of its side. Such places are narrower than the rope is elsewhere, and that is what is looked for:
//! around them, and only there, fainter pixels (those that stand out of the table's noise at all) count as rope too,
//! and slits between them are closed: hysteresis, as Canny's edges have it, "A computational approach to edge
//! detection" (1986). Of that stays what gives the rope its own width back. A rope that is as wide everywhere is left as
//! it is, so that blurred edges and shadows beside it, which are faint too, stay out.

use crate::background::Background;
use crate::bits::BitPlane;
use crate::components::for_each_run;
use crate::morphology::Morphology;
use crate::plane::Plane;
use crate::skeleton::half_width;
use crate::threshold::{self, Cut};
use crate::{Image, shadow};

/// Rows from one that the width is taken in to the next, and the most widths that are taken.
const STRIDE: usize = 3;
const MOST_WIDTHS: usize = 2048;
/// The rope's width is the median of the widths along it; its edges' blur is what faint pixels add at this quantile.
const MIDDLE: f32 = 0.5;
const LEAST: f32 = 0.08;
/// A place is thin when a disc this share of the rope's width across does not fit in.
const THIN: f32 = 0.86;
/// A disc does not reach into corners: this much farther a place still counts as reached.
const CORNER_PX: usize = 2;
/// Half of the widest slit that is closed without a trace of rope in it, in widths.
const SLIT: f32 = 0.2;
/// Ropes wider than this are not mended, in pixels: the widest that thinning brings to rest.
const WIDEST_PX: f32 = 128.0;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Mender {
    morphology: Morphology,
    /// Widths along the ropes and what faint pixels add to them, each with the length it stands for.
    widths: Vec<(f32, f32)>,
    edges: Vec<(f32, f32)>,
    weak: BitPlane,
    /// Where the rope is thin, then all around that.
    thin: BitPlane,
    wider: BitPlane,
    fits: BitPlane,
}

impl Mender {
    /// Adds to `mask`, which is `difference` at the `cut`, what its ropes lack, and lifts the difference of that to the
    /// ropes' mean, so that their outer edges are found.
    pub(crate) fn mend(
        &mut self,
        image: &Image,
        background: &Background,
        cut: Cut,
        difference: &mut Plane,
        mask: &mut BitPlane,
    ) {
        self.find_weak(image, background, cut, difference, mask);
        let (width_px, fringe_px) = self.rope_width(mask);
        let across = (THIN * width_px) as usize;
        if across < 3 || width_px > WIDEST_PX {
            return;
        }
        if !self.find_thin(mask, across, width_px) {
            return;
        }
        let slit = ((SLIT * width_px) as usize).max(1);
        self.wider.copy_from(mask);
        self.wider.zip(&self.weak, &self.thin, |m, w, t| m | w & t);
        self.fits.copy_from(&self.wider);
        self.morphology.close(&mut self.fits, slit);
        self.wider.zip(&self.fits, &self.thin, |m, c, t| m | c & t);
        // What has the rope's width now, with the corners that a disc does not reach.
        self.fits.copy_from(&self.wider);
        self.morphology.open(&mut self.fits, across);
        self.morphology.dilate(&mut self.fits, CORNER_PX);
        self.wider.zip(&self.fits, mask, |w, f, m| w & f & !m);
        self.drop_fringe(mask, slit, fringe_px);
        lift(difference, &self.wider, cut.level);
        let added = &self.wider;
        mask.zip(added, added, |m, a, _| m | a);
    }

    /// Takes out of what is to be added what is no thicker than the faint fringe of a sharp edge, and no slit in the rope:
    /// at the corners of a tip a disc finds thin places, too.
    fn drop_fringe(&mut self, mask: &BitPlane, slit: usize, fringe_px: usize) {
        self.thin.copy_from(mask);
        self.morphology.close(&mut self.thin, slit);
        self.fits.copy_from(&self.wider);
        self.morphology.open(&mut self.fits, fringe_px + 1);
        self.morphology.dilate(&mut self.fits, 1);
        self.wider
            .zip(&self.fits, &self.thin, |w, f, c| w & (f | c));
    }

    /// The width of the ropes in pixels; 0 when there is none.
    ///
    /// Faint pixels stand beside a blurred edge, too: what the faint ones add where they add least is that, and the
    /// rope's width is what they reach elsewhere, less it.
    fn rope_width(&mut self, mask: &BitPlane) -> (f32, usize) {
        self.widths.clear();
        self.edges.clear();
        for y in (0..mask.height()).step_by(STRIDE) {
            for_each_run(mask, y, true, |from, to| {
                if self.widths.len() == MOST_WIDTHS {
                    return;
                }
                // The middle of a run lies in the middle of a straight rope, however it slants; a run is the longer, the
                // more of a rope goes by between two rows.
                let sure_px = width_at(mask, (from + to) / 2, y);
                let (left, right) = run_around(self.weak.row(y), (from + to) / 2);
                let all_px = width_at(&self.weak, (left + right) / 2, y);
                let length = (to - from) as f32 / sure_px;
                self.widths.push((all_px, length));
                self.edges.push(((all_px - sure_px).max(0.0), length));
            });
        }
        let edges_px = quantile(&mut self.edges, LEAST);
        let width_px = quantile(&mut self.widths, MIDDLE) - edges_px;
        (width_px, (0.5 * edges_px).ceil().max(1.0) as usize)
    }

    /// Finds the faint pixels that are no shadow, and all that are sure.
    fn find_weak(
        &mut self,
        image: &Image,
        background: &Background,
        cut: Cut,
        difference: &Plane,
        mask: &BitPlane,
    ) {
        threshold::apply(difference, cut.faint, &mut self.weak);
        self.weak.zip(mask, mask, |w, m, _| w & !m);
        shadow::clear(image, background, &mut self.weak);
        self.weak.zip(mask, mask, |w, m, _| w | m);
    }

    /// Finds where the rope is thin, and all around it that could be rope.
    fn find_thin(&mut self, mask: &BitPlane, across: usize, width_px: f32) -> bool {
        self.fits.copy_from(mask);
        self.morphology.open(&mut self.fits, across);
        self.morphology.dilate(&mut self.fits, CORNER_PX);
        self.thin.copy_from(mask);
        self.thin.zip(&self.fits, mask, |m, f, _| m & !f);
        if self.thin.count() == 0 {
            return false;
        }
        self.morphology
            .dilate(&mut self.thin, (0.7 * width_px).ceil() as usize);
        true
    }
}

/// The width of the rope about a pixel in its middle. A run of an even number of pixels has none: half a pixel is lacking
/// there, a quarter in the mean.
fn width_at(mask: &BitPlane, x: usize, y: usize) -> f32 {
    2.0 * half_width(mask, x as i32, y as i32) + 0.25
}

/// The run of set pixels around pixel `x`, which is set.
fn run_around(row: &[u64], x: usize) -> (usize, usize) {
    let (mut from, mut to) = (x, x + 1);
    let get = |x: usize| row[x / 64] >> (x % 64) & 1 == 1;
    while from > 0 && get(from - 1) {
        from -= 1;
    }
    while to < 64 * row.len() && get(to) {
        to += 1;
    }
    (from, to)
}

/// The value below which `share` of the weights lie; 0 of nothing.
fn quantile(values: &mut [(f32, f32)], share: f32) -> f32 {
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let all: f32 = values.iter().map(|v| v.1).sum();
    let mut sum = 0.0;
    let found = values.iter().find(|(_, weight)| {
        sum += weight;
        sum >= share * all
    });
    found.map_or(0.0, |v| v.0)
}

/// Lifts the difference of the `added` pixels to `level`, so that the rope's edges are found where they end.
fn lift(difference: &mut Plane, added: &BitPlane, level: u8) {
    for y in 0..added.height() {
        for_each_run(added, y, true, |from, to| {
            for value in &mut difference.row_mut(y)[from..to] {
                *value = level.max(*value);
            }
        });
    }
}

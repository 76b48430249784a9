//! Ropes that are lighter than the table on one side and darker on the other, such as white ropes
//! on light gray.
//!
//! Such a rope does not differ from the table where its shading passes through the table's light.
//! The mask then has two or three ropes instead of one. This does not happen to ropes that are
//! lighter or darker as a whole. Therefore, if much of the mask is lighter than the table and some
//! is darker, what lies between the two is rope.

use super::background::Background;
use super::cast::for_each_some;
use super::hysteresis::lift;
use crate::bitmap::bits::BitPlane;
use crate::bitmap::morphology::Morphology;
use crate::bitmap::strips::Strips;
use crate::image::gray::GrayPlane;
use crate::image::{Image, color};

/// Number of mask pixels in the first sample, and in the second. The second is taken if at least
/// half of `LIGHTER` of the first are lighter than the table. `LIGHTER` and `DARKER` are the
/// minimum shares that are lighter and darker than the table. A highlight on a dark rope covers a
/// tenth.
const FIRST: usize = 64;
const GLANCE: usize = 400;
const LIGHTER: f32 = 0.4;
const DARKER: f32 = 0.08;
/// Maximum distance of a pixel that is filled in from the lighter and from the darker pixels.
const REACH: usize = 3;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Rims {
    morphology: Morphology,
    plane: BitPlane,
    light: Strips,
    dark: Strips,
    gap: Strips,
}

impl Rims {
    /// Reserves the buffers for planes of this one's shape.
    pub(crate) fn reserve(&mut self, mask: &Strips, rows: &BitPlane) {
        self.plane.copy_from(rows);
        for plane in [&mut self.light, &mut self.dark, &mut self.gap] {
            plane.resize(&mask.shape);
        }
        self.morphology.reserve(mask);
    }

    /// Returns whether much of the mask, in which `area` pixels are set, is lighter than the table
    /// and some is darker.
    pub(crate) fn are_there(
        image: &Image,
        background: &Background,
        (mask, area): (&BitPlane, usize),
    ) -> bool {
        let share = |wanted: usize| {
            let (mut light, mut all) = (0, 0);
            for_each_some(mask, area, wanted, |x, y| {
                light += usize::from(is_lighter(image, background, x, y));
                all += 1;
            });
            light as f32 / all.max(1) as f32
        };
        if share(FIRST) < 0.5 * LIGHTER {
            return false;
        }
        let share = share(GLANCE);
        share > LIGHTER && share < 1.0 - DARKER
    }

    /// Adds to `mask` what lies between its lighter and its darker pixels, and lifts the difference
    /// there to `level`. `rows` is the same mask row by row.
    pub(crate) fn fill(
        &mut self,
        image: &Image,
        background: &Background,
        (mask, rows): (&mut Strips, &BitPlane),
        (difference, level): (&mut GrayPlane, u8),
    ) {
        self.plane.copy_from(rows);
        for_each_some(rows, 1, 1, |x, y| {
            if !is_lighter(image, background, x, y) {
                self.plane.fill(y, x, x + 1, false);
            }
        });
        self.light.take(&self.plane);
        self.dark.copy_from(mask);
        self.dark
            .zip(&self.light, mask, |dark, light, _| dark & !light);
        self.morphology.dilate(&mut self.light, REACH);
        self.morphology.dilate(&mut self.dark, REACH);
        self.gap.copy_from(&self.light);
        self.gap
            .zip(&self.dark, mask, |light, dark, mask| light & dark & !mask);
        mask.add(&self.gap);
        lift(difference, &self.gap, level);
    }
}

fn is_lighter(image: &Image, background: &Background, x: usize, y: usize) -> bool {
    let (pixel, table) = (color::native(image, x, y), background.at(x, y));
    let channels = if color::is_yuv(image.format()) { 1 } else { 3 };
    let own: f32 = pixel[..channels]
        .iter()
        .map(|&level| f32::from(level))
        .sum();
    own > table[..channels].iter().sum()
}

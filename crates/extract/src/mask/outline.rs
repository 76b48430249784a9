//! Area and outline of a mask, and the rope's width that follows from them.

use crate::bitmap::strips::Strips;

/// Number of set pixels, and number of their sides that are on the outline.
pub(super) fn outline(mask: &Strips) -> (usize, usize) {
    lariat_portable::Arch::new().dispatch(Outline(mask))
}

/// Computes [`outline`]; compiled for each kind of machine.
struct Outline<'a>(&'a Strips);

impl lariat_portable::NullaryFnOnce for Outline<'_> {
    type Output = (usize, usize);

    #[inline(always)]
    fn call(self) -> (usize, usize) {
        let (words, stride) = (&self.0.words, self.0.shape.stride);
        let (mut area, mut sides) = (0, 0);
        for (from, count) in self.0.used.runs(&self.0.shape) {
            for at in from..from + count {
                let here = words[at];
                let west = here << 1 | words[at - stride] >> 63;
                let east = here >> 1 | words[at + stride] << 63;
                area += here.count_ones() as usize;
                sides += (here & !west).count_ones() as usize;
                sides += (here & !east).count_ones() as usize;
                // There are as many sides below as above.
                sides += 2 * (here & !words[at - 1]).count_ones() as usize;
            }
        }
        (area, sides)
    }
}

/// Width of a long shape: twice its area divided by its outline. Pixel sides overstate the outline
/// of a slanted edge by 4/π on average.
pub(super) fn width_from_outline(area: usize, sides: usize) -> f32 {
    2.0 * area as f32 / (sides as f32 * std::f32::consts::FRAC_PI_4).max(1.0)
}

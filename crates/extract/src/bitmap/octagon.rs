//! Structuring element of the morphology: an octagon composed of crosses and 3×3 squares. Their
//! order keeps its corners nearest to a circle (Adams, "Radial decomposition of discs and spheres",
//! CVGIP 55, 1993).

use super::neighbors::{Around, Rule};

/// Share of squares among the steps of an octagon whose diagonals are as long as its axes: s of r
/// steps, with s·√2 + (r − s)·√2/2 = r.
const SQUARES: f32 = std::f32::consts::SQRT_2 - 1.0;

/// Returns whether step `step` of an octagon is a square.
pub(super) fn is_square(step: usize) -> bool {
    let squares = |steps: usize| (SQUARES * steps as f32).round();
    squares(step + 1) > squares(step)
}

/// Dilation by a pixel and its four nearest neighbors.
pub(super) struct Cross;

impl Rule for Cross {
    #[inline(always)]
    fn word(&self, around: &Around) -> u64 {
        let &Around {
            here, n, s, w, e, ..
        } = around;
        here | n | s | w | e
    }
}

/// Dilation by a 3×3 square.
pub(super) struct Square;

impl Rule for Square {
    #[inline(always)]
    fn word(&self, around: &Around) -> u64 {
        let Around { nw, ne, sw, se, .. } = around;
        Cross.word(around) | nw | ne | sw | se
    }
}

/// Dilation by a 2×2 square, half a pixel to the right and down.
pub(super) struct ToBottomRight;

impl Rule for ToBottomRight {
    #[inline(always)]
    fn word(&self, around: &Around) -> u64 {
        let Around { here, n, w, nw, .. } = around;
        here | n | w | nw
    }
}

/// Dilation by the square of [`ToBottomRight`], turned by 180°. Eroding by it undoes the shift of
/// the other.
#[cfg(test)]
pub(super) struct ToTopLeft;

#[cfg(test)]
impl Rule for ToTopLeft {
    #[inline(always)]
    fn word(&self, around: &Around) -> u64 {
        let Around { here, s, e, se, .. } = around;
        here | s | e | se
    }
}

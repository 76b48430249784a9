//! What may be the table in shadow: pixels darker than the table there, and of its color.
//!
//! A shadow takes the same share of the light from every channel, so that the pixel is the table's color times a number
//! below one (Horprasert, Harwood and Davis, "A statistical approach for real-time robust background subtraction and
//! shadow detection", 1999). A gray rope on a gray table cannot be told from a shadow by this; nor can anything darker in
//! an image without color.

use crate::background::Background;
use crate::bits::BitPlane;
use crate::{Image, color};

/// A shadow leaves at least this share of the table's light; what is darker is a thing.
const DARKEST: f32 = 0.3;
/// How far a channel may lie from the shaded table's, in the table's noise, and at least in levels.
const NOISES: f32 = 3.0;
const LEVELS: f32 = 6.0;

/// Clears of `faint` what may be shadow.
pub(crate) fn clear(image: &Image, background: &Background, faint: &mut BitPlane) {
    let yuv = color::is_yuv(image.format());
    let tolerance = (NOISES * background.noise).max(LEVELS);
    for y in 0..faint.height() {
        let table = background.along(y);
        for i in 0..faint.words_per_row() {
            let mut word = faint.row(y)[i];
            while word != 0 {
                let bit = word & word.wrapping_neg();
                word ^= bit;
                let x = 64 * i + bit.trailing_zeros() as usize;
                let pixel = color::native(image, x, y).map(f32::from);
                if is_shade(pixel, table(x), yuv, tolerance) {
                    faint.row_mut(y)[i] &= !bit;
                }
            }
        }
    }
}

/// Whether `pixel` is `table` in less light.
fn is_shade(pixel: [f32; 3], table: [f32; 3], yuv: bool, tolerance: f32) -> bool {
    let light = |color: [f32; 3]| if yuv { color[0] } else { color.iter().sum() };
    let (own, all) = (light(pixel), light(table).max(1.0));
    if own >= all || own < DARKEST * all {
        return false;
    }
    let share = own / all;
    // U and V are measured from their middle.
    let zero = if yuv { [0.0, 128.0, 128.0] } else { [0.0; 3] };
    let shaded = std::array::from_fn(|c| zero[c] + share * (table[c] - zero[c]));
    color::distance(pixel, shaded, yuv) <= tolerance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_light_is_shade_and_another_color_is_not() {
        let table = [200.0, 190.0, 170.0];
        assert!(is_shade([100.0, 95.0, 85.0], table, false, 6.0));
        assert!(!is_shade([100.0, 120.0, 85.0], table, false, 6.0));
        assert!(!is_shade([240.0, 228.0, 204.0], table, false, 6.0));
        assert!(!is_shade([20.0, 19.0, 17.0], table, false, 6.0));
    }

    #[test]
    fn shade_takes_from_the_chroma_too() {
        let table = [180.0, 148.0, 118.0];
        assert!(is_shade([90.0, 138.0, 123.0], table, true, 6.0));
        assert!(!is_shade([90.0, 148.0, 118.0], table, true, 6.0));
    }
}

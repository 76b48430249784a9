//! The mask from ranges of hue, saturation and value.
//!
//! [`contains`] defines which colors the ranges contain. [`selector`] prepares the answers for all
//! colors and looks them up.

mod channels;
mod cube;
mod kernels;
mod outline;
mod selector;

pub(crate) use selector::Selector;

use crate::options::HsvRange;

/// Returns whether a color is in any of the ranges.
pub(crate) fn contains(ranges: &[HsvRange], rgb: [u8; 3]) -> bool {
    let (hue, saturation, value) = hsv(rgb);
    ranges
        .iter()
        .any(|range| holds(range, [hue, saturation, value]))
}

/// Returns whether a range contains this hue in degrees, saturation and value.
pub(crate) fn holds(range: &HsvRange, [hue, saturation, value]: [f32; 3]) -> bool {
    let within = |[low, high]: [f32; 2], v: f32| (low..=high).contains(&v);
    let [low, high] = range.hue_deg;
    let hue_fits = if low <= high {
        (low..=high).contains(&hue)
    } else {
        hue >= low || hue <= high
    };
    hue_fits && within(range.saturation, saturation) && within(range.value, value)
}

/// Hue in degrees (0 for a gray), saturation and value from 0 to 1.
pub(crate) fn hsv(rgb: [u8; 3]) -> (f32, f32, f32) {
    let [r, g, b] = rgb.map(|c| f32::from(c) / 255.0);
    let value = r.max(g).max(b);
    let chroma = value - r.min(g).min(b);
    if chroma == 0.0 {
        return (0.0, 0.0, value);
    }
    let sextant = if value == r {
        ((g - b) / chroma).rem_euclid(6.0)
    } else if value == g {
        (b - r) / chroma + 2.0
    } else {
        (r - g) / chroma + 4.0
    };
    (60.0 * sextant, chroma / value, value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_primary_colors_have_their_hues() {
        assert_eq!(hsv([255, 0, 0]), (0.0, 1.0, 1.0));
        assert_eq!(hsv([0, 255, 0]), (120.0, 1.0, 1.0));
        assert_eq!(hsv([0, 0, 255]), (240.0, 1.0, 1.0));
        assert_eq!(hsv([51, 51, 51]), (0.0, 0.0, 0.2));
    }

    #[test]
    fn a_hue_range_may_wrap_through_red() {
        let red = HsvRange {
            hue_deg: [350.0, 10.0],
            saturation: [0.5, 1.0],
            value: [0.0, 1.0],
        };
        assert!(contains(&[red], [200, 10, 30]));
        assert!(contains(&[red], [200, 30, 10]));
        assert!(!contains(&[red], [10, 200, 30]));
    }
}

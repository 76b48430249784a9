//! A curve among the other curves of its picture.

use crate::scene::Curve;
use crate::statistics::grade;

/// Color difference, in levels, and ratio of widths at which two curves begin to differ, and at
/// which they are of two kinds.
const LEVELS: (f32, f32) = (20.0, 60.0);
const WIDER: (f32, f32) = (1.2, 1.5);
/// Maximum ratio of lengths. A longer rope adds no evidence.
const LONGER: f32 = 8.0;
/// Maximum length of a small thing, as a share of the longest other curve.
const SMALL: f32 = 0.25;

/// Evidence about a curve from the other curves.
pub(super) struct Beside {
    /// 0 to 1 by the length of the longest other curve relative to this one, if it is of another kind.
    pub(super) lesser: f32,
    /// Number of other small things of this curve's kind.
    pub(super) alike: usize,
}

/// Compares curve `i` with the others. `levels` is the distance of two curves' colors.
pub(super) fn beside(curves: &[Curve], i: usize, levels: impl Fn(usize, usize) -> f32) -> Beside {
    let others = || (0..curves.len()).filter(|&k| k != i);
    let longest = others().max_by(|&a, &b| curves[a].length_px.total_cmp(&curves[b].length_px));
    let Some(longest) = longest else {
        let (lesser, alike) = (0.0, 0);
        return Beside { lesser, alike };
    };
    let unlike = |k: usize| {
        let width = curves[k].width_px / curves[i].width_px.max(1.0);
        let wider = width.max(1.0 / width.max(1e-3));
        grade(levels(k, i), LEVELS.0, LEVELS.1).max(grade(wider, WIDER.0, WIDER.1))
    };
    let times = curves[longest].length_px / curves[i].length_px.max(1.0);
    let longer = libm::logf(times.clamp(1.0, LONGER)) / libm::logf(LONGER);
    let is_small = |k: usize| curves[k].length_px < SMALL * curves[longest].length_px;
    let alike = others().filter(|&k| is_small(i) && is_small(k) && unlike(k) < 0.5);
    Beside {
        lesser: longer * unlike(longest),
        alike: alike.count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(length_px: f32, width_px: f32) -> Curve {
        Curve {
            length_px,
            width_px,
            ..Curve::default()
        }
    }

    fn lesser(curves: &[Curve], levels: f32) -> f32 {
        beside(curves, 1, |_, _| levels).lesser
    }

    #[test]
    fn a_curve_is_the_lesser_the_longer_and_the_less_alike_another_one_is() {
        let beside_one =
            |length_px, levels| lesser(&[curve(length_px, 8.0), curve(100.0, 8.0)], levels);
        let longer = [90.0, 120.0, 300.0, 700.0].map(|length_px| beside_one(length_px, 80.0));
        assert!(
            longer[0] == 0.0 && longer.is_sorted_by(|a, b| a < b),
            "{longer:?}"
        );
        let unlike = [10.0, 30.0, 50.0].map(|levels| beside_one(400.0, levels));
        assert!(
            unlike[0] == 0.0 && unlike.is_sorted_by(|a, b| a < b),
            "{unlike:?}"
        );
        // A wider rope is of another kind, whatever its color is.
        assert!(lesser(&[curve(400.0, 14.0), curve(100.0, 8.0)], 0.0) > 0.5);
        assert_eq!(beside(&[curve(400.0, 8.0)], 0, |_, _| 0.0).lesser, 0.0);
    }

    #[test]
    fn only_small_things_of_a_kind_are_counted() {
        let letters = [30.0, 35.0, 20.0].map(|length_px| curve(length_px, 5.0));
        let curves = [&[curve(400.0, 8.0), curve(300.0, 5.0)], &letters[..]].concat();
        assert_eq!(beside(&curves, 2, |_, _| 0.0).alike, 2);
        assert_eq!(beside(&curves, 1, |_, _| 0.0).alike, 0);
        assert_eq!(beside(&curves, 2, |_, _| 90.0).alike, 0);
    }
}

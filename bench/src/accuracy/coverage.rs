//! The share of the ropes that no curve follows, and the share of the curves that follow no rope.

use super::labels::Labels;
use super::spline::Sample;
use super::strip::{self, Ends};

/// Tolerance in pixels. A labeled pixel may be this much farther than half a width from a curve,
/// and a curve this far from the labels.
pub(super) const TOLERANCE_PX: f64 = 2.0;

/// Shares from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Coverage {
    /// Share of the labeled pixels that are farther than half a width + 2 px from every curve.
    pub(super) missed: f64,
    /// Share of the curves' samples, about a pixel apart, that are more than 2 px from every
    /// labeled pixel.
    pub(super) stray: f64,
}

/// Compares the curves with the labels. Connections and the identity of ropes are ignored.
pub(super) fn coverage(label: &Labels, splines: &[Vec<Sample>]) -> Coverage {
    let near = near(label, splines);
    let is_missed = |(&rope, &near): (&u8, &bool)| rope != 0 && !near;
    let missed = label
        .ropes
        .iter()
        .zip(&near)
        .filter(|&p| is_missed(p))
        .count();
    let samples = || splines.iter().flatten();
    let stray = samples().filter(|s| is_stray(label, s)).count();
    let share = |part: usize, all: usize| {
        if all == 0 {
            0.0
        } else {
            part as f64 / all as f64
        }
    };
    Coverage {
        missed: share(missed, label.area()),
        stray: share(stray, samples().count()),
    }
}

/// Returns for each pixel whether it is within half a width + 2 px of a curve.
pub(super) fn near(label: &Labels, splines: &[Vec<Sample>]) -> Vec<bool> {
    let mut near = vec![false; label.ropes.len()];
    let size = (label.width, label.height);
    for samples in splines {
        strip::each(size, samples, TOLERANCE_PX, Ends::Round, |hit| {
            near[hit.pixel] = true;
        });
    }
    near
}

fn is_stray(label: &Labels, sample: &Sample) -> bool {
    let [x, y] = sample.at;
    let around = |v: f64| (v - TOLERANCE_PX).ceil() as i64..=(v + TOLERANCE_PX).floor() as i64;
    let is_rope = |px: i64, py: i64| {
        let off = (px as f64 - x).hypot(py as f64 - y);
        off <= TOLERANCE_PX && label.at(px, py) != 0
    };
    !around(y).any(|py| around(x).any(|px| is_rope(px, py)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::{draw, tests::curve};
    use crate::accuracy::spline::through;

    #[test]
    fn of_a_half_found_rope_the_other_half_is_missed() {
        let whole = curve(&[[10.0, 20.0], [60.0, 20.0], [110.0, 20.0]], 9.0);
        let label = draw(std::slice::from_ref(&whole), &[], (120, 40));
        let none = Coverage::default();
        assert_eq!(coverage(&label, &[through(&whole)]), none);
        let half = curve(&[[10.0, 20.0], [35.0, 20.0], [60.0, 20.0]], 9.0);
        let found = coverage(&label, &[through(&half)]);
        // There are 101 columns. Those from 67 on are out of reach of a tip at 60 in every row, and
        // those from 65 on in some rows.
        assert!((0.43..0.46).contains(&found.missed), "{found:?}");
        assert_eq!(found.stray, 0.0);
        assert_eq!(coverage(&label, &[]).missed, 1.0);
    }

    #[test]
    fn a_curve_that_runs_off_its_rope_is_stray_there() {
        let half = curve(&[[10.0, 20.0], [35.0, 20.0], [60.0, 20.0]], 9.0);
        let label = draw(&[half], &[], (120, 40));
        let long = curve(&[[10.0, 20.0], [60.0, 20.0], [110.0, 20.0]], 9.0);
        let found = coverage(&label, &[through(&long)]);
        // There are 101 samples. Those from 63 to 110 have no labeled pixel within 2 px.
        assert!((found.stray - 48.0 / 101.0).abs() < 1e-9, "{found:?}");
        assert_eq!(found.missed, 0.0);
    }
}

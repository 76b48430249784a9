//! Tests whether each labeled rope has one whole curve of its own, and how well the curves'
//! confidence predicts it.

use std::fmt::Write;

use lariat_extract::Curve;

use super::assignment;
use super::labels::Labels;
use super::measure::Measured;
use super::spline::Sample;
use crate::reliability::Reliability;
use crate::right::{WHOLE, share_near};

/// Step between the rope pixels that are tested.
const PIXELS: usize = 7;
/// Range that curve widths are clamped to, px. Widths outside are unreliable.
const WIDTHS_PX: [f64; 2] = [3.0, 60.0];

/// Returns for each curve whether it is one whole rope of the label. No two curves are the same
/// rope.
///
/// A whole curve covers 93 % of the rope's pixels (within half a width + 2 px, at least 4 px). The
/// same share of its own length is on the rope (within 1.1 widths, at least 5 px).
pub(super) fn curves(label: &Labels, curves: &[Curve], splines: &[Vec<Sample>]) -> Vec<bool> {
    let lines: Vec<(f64, Vec<[f64; 2]>)> = (curves.iter().zip(splines))
        .map(|(curve, samples)| {
            let width_px = f64::from(curve.width_px).clamp(WIDTHS_PX[0], WIDTHS_PX[1]);
            (width_px, samples.iter().map(|sample| sample.at).collect())
        })
        .collect();
    let shares: Vec<Vec<f64>> = (label.numbers().into_iter())
        .map(|rope| {
            let pixels = pixels(label, rope);
            let share = |(width_px, line): &(f64, Vec<[f64; 2]>)| {
                let covered = share_near(&pixels, line, (0.5 * width_px + 2.0).max(4.0));
                covered.min(share_near(line, &pixels, (1.1 * width_px).max(5.0)))
            };
            lines.iter().map(share).collect()
        })
        .collect();
    let mut is_whole = vec![false; curves.len()];
    for (shares, curve) in shares.iter().zip(assignment::best(&shares)) {
        if let Some(curve) = curve {
            is_whole[curve] = shares[curve] >= WHOLE;
        }
    }
    is_whole
}

fn pixels(label: &Labels, rope: u8) -> Vec<[f64; 2]> {
    let all = label.ropes.iter().enumerate();
    let of_rope = all.filter(|&(_, &number)| number == rope);
    let places = of_rope.map(|(k, _)| [(k % label.width) as f64, (k / label.width) as f64]);
    places.step_by(PIXELS).collect()
}

/// Returns how many pictures of each set are right, how many wrong ones are silent, and how
/// reliable the confidence of all curves is.
pub(super) fn table(sets: &[(&str, Vec<Measured>)]) -> String {
    let percent = 100.0 * WHOLE;
    let mut out = format!(
        "\nwhole: a curve of its own covers {percent:.0} % of the rope's pixels, within half a width + 2 px, and lies on it for as much \
         of its length, within 1.1 widths;\nright: all ropes are whole, and no curve is left over; silent: wrong without a notice\n\n\
         {:<10} {:>6} {:>6} {:>7} {:>12}\n",
        "set", "images", "right", "silent", "whole ropes"
    );
    let mut row = |name: &str, images: &[&Measured]| {
        let count = |is: fn(&Measured) -> bool| images.iter().filter(|image| is(image)).count();
        let whole = (images.iter().flat_map(|image| &image.is_whole)).filter(|&&is_whole| is_whole);
        let ropes: usize = images.iter().map(|image| image.ropes).sum();
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{name:<10} {:>6} {:>6} {:>7} {:>12}",
            images.len(),
            count(Measured::is_right),
            count(|image| !image.is_right() && !image.has_notice),
            format!("{} of {ropes}", whole.count()),
        );
    };
    for (name, images) in sets {
        row(name, &images.iter().collect::<Vec<_>>());
    }
    let all: Vec<_> = sets.iter().flat_map(|(_, images)| images).collect();
    if sets.len() > 1 {
        row("all", &all);
    }
    let mut reliability = Reliability::default();
    for image in all {
        for (curve, &is_whole) in image.curves.iter().zip(&image.is_whole) {
            reliability.add(curve.confidence.into(), is_whole);
        }
    }
    format!("{out}\n{reliability}\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::{draw, tests::curve};
    use crate::accuracy::spline::through;

    fn whole(label: &Labels, found: &[Curve]) -> Vec<bool> {
        let splines: Vec<_> = found.iter().map(through).collect();
        curves(label, found, &splines)
    }

    #[test]
    fn a_rope_is_whole_in_one_piece_and_alone() {
        let bar =
            |from: f64, to: f64| curve(&[[from, 20.0], [0.5 * (from + to), 20.0], [to, 20.0]], 9.0);
        let label = draw(&[bar(10.0, 210.0)], &[], (240, 40));
        assert_eq!(whole(&label, &[bar(12.0, 208.0)]), [true]);
        assert_eq!(
            whole(&label, &[bar(10.0, 110.0), bar(112.0, 210.0)]),
            [false, false]
        );
        // The curve covers the rope, but continues over the table.
        assert_eq!(whole(&label, &[bar(10.0, 235.0)]), [false]);
        assert_eq!(
            whole(&label, &[bar(10.0, 210.0), bar(11.0, 209.0)])
                .iter()
                .filter(|&&is| is)
                .count(),
            1
        );
        assert!(whole(&label, &[]).is_empty());
    }
}

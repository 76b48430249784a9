//! Classification of the pixels where drawing and label disagree, so that lost DICE can be
//! attributed to causes.

use lariat_extract::{Crossing, Curve};

use super::coverage;
use super::labels::Labels;
use super::overlap::Overlap;
use super::spline::Sample;

/// Cause of a disagreement between drawing and label. The first variant that applies is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// A labeled pixel far from every curve: a fragment of rope was missed, or a corner was cut.
    Lost,
    /// Rope in both, but not the same rope: a wrong strand order, a wrong connection, or the edge
    /// between two ropes.
    Order,
    /// Within a width of a tip: the tip is too early, too late, or not square.
    Tip,
    /// Within a width and a half of a crossing.
    Crossing,
    /// A bend with a radius below twice the rope's width.
    Bend,
    /// Along a smooth stretch of rope: a wrong width, or a centerline off center.
    Side,
}

impl Cause {
    /// All causes, in order of precedence.
    pub(super) const ALL: [Cause; 6] = [
        Cause::Lost,
        Cause::Order,
        Cause::Tip,
        Cause::Crossing,
        Cause::Bend,
        Cause::Side,
    ];

    /// Returns a one-word name for tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Cause::Lost => "lost",
            Cause::Order => "order",
            Cause::Tip => "tip",
            Cause::Crossing => "crossing",
            Cause::Bend => "bend",
            Cause::Side => "side",
        }
    }
}

/// Number of pixels in which drawing and label disagree, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Disagreement {
    /// Pixels labeled as the rope but not drawn, in the order of [`Cause::ALL`].
    pub(super) lacking: [usize; 6],
    /// Pixels drawn as the rope but not labeled, in the order of [`Cause::ALL`].
    pub(super) excess: [usize; 6],
    /// Total length of curve along which an edge disagreement counts as [`Cause::Side`], in pixels.
    pub(super) side_px: f64,
}

impl Disagreement {
    /// Adds another image's counts.
    pub(super) fn add(&mut self, other: &Self) {
        for (sum, part) in self.lacking.iter_mut().zip(other.lacking) {
            *sum += part;
        }
        for (sum, part) in self.excess.iter_mut().zip(other.excess) {
            *sum += part;
        }
        self.side_px += other.side_px;
    }

    /// Returns how far the drawn edges are outside the labeled ones along smooth stretches, in
    /// pixels. This is the mean of both edges, and negative if they are inside.
    pub(super) fn edge_bias_px(&self) -> f64 {
        let side = Cause::Side as usize;
        let surplus = self.excess[side] as f64 - self.lacking[side] as f64;
        surplus / (2.0 * self.side_px).max(1.0)
    }
}

/// Results of an extraction.
pub(super) struct Found<'a> {
    pub(super) curves: &'a [Curve],
    pub(super) crossings: &'a [Crossing],
    /// Samples of the curves.
    pub(super) splines: &'a [Vec<Sample>],
    /// The curves drawn as labels.
    pub(super) drawn: &'a Labels,
}

/// Classifies the pixels in which the ropes' labels and the curves paired with them disagree.
pub(super) fn sort(label: &Labels, found: &Found, overlap: &Overlap) -> Disagreement {
    let near = coverage::near(label, found.splines);
    let mut sorted = Disagreement::default();
    let mut paired = [None; 256];
    for &(number, curve, _) in &overlap.ropes {
        paired[usize::from(number)] = curve;
    }
    let places: Vec<Vec<Cause>> = (0..found.curves.len()).map(|i| places(found, i)).collect();
    for (pixel, (&truth, &drawn)) in label.ropes.iter().zip(&found.drawn.ropes).enumerate() {
        let curve = paired[usize::from(truth)];
        if usize::from(drawn) == curve.map_or(0, |c| c + 1) && (truth == 0 || curve.is_some()) {
            continue;
        }
        let at = [(pixel % label.width) as f64, (pixel / label.width) as f64];
        let cause = |curve: usize| match (truth, drawn) {
            (1.., 1..) => Cause::Order,
            _ => places[curve][nearest(&found.splines[curve], at)],
        };
        if truth != 0 {
            let why = match curve {
                Some(curve) if near[pixel] => cause(curve),
                _ => Cause::Lost,
            };
            sorted.lacking[why as usize] += 1;
        }
        if drawn != 0 {
            sorted.excess[cause(usize::from(drawn) - 1) as usize] += 1;
        }
    }
    let lengths = found.splines.iter().zip(&places);
    sorted.side_px = lengths.map(|(s, p)| side_length(s, p)).sum();
    sorted
}

/// Returns the index of the sample nearest to `at`. `samples` must not be empty.
fn nearest(samples: &[Sample], at: [f64; 2]) -> usize {
    let off2 = |s: &Sample| (s.at[0] - at[0]).powi(2) + (s.at[1] - at[1]).powi(2);
    let nearest = samples.iter().enumerate();
    let nearest = nearest.min_by(|a, b| off2(a.1).total_cmp(&off2(b.1)));
    nearest.map_or(0, |(index, _)| index)
}

/// Returns, for each sample of curve `index`, the cause that its position suggests.
fn places(found: &Found, index: usize) -> Vec<Cause> {
    let (curve, samples) = (&found.curves[index], &found.splines[index]);
    let to_tip = |s: &Sample| match curve.closed {
        true => f64::INFINITY,
        false => s.rho.min(1.0 - s.rho) * f64::from(curve.length_px),
    };
    let crosses = |s: &Sample| {
        let here = |c: &&Crossing| c.over == index || c.under == index;
        found.crossings.iter().filter(here).any(|c| {
            let off = (f64::from(c.at[0]) - s.at[0]).hypot(f64::from(c.at[1]) - s.at[1]);
            off <= 3.0 * s.half_px
        })
    };
    let mut places: Vec<Cause> = Vec::with_capacity(samples.len());
    for (i, sample) in samples.iter().enumerate() {
        places.push(if to_tip(sample) <= 2.0 * sample.half_px {
            Cause::Tip
        } else if crosses(sample) {
            Cause::Crossing
        } else if radius_px(samples, i) < 4.0 * sample.half_px {
            Cause::Bend
        } else {
            Cause::Side
        });
    }
    places
}

/// Returns the radius of the circle through a sample and those half a width before and after it, in
/// pixels.
fn radius_px(samples: &[Sample], index: usize) -> f64 {
    let reach = (samples[index].half_px.round() as usize).max(2);
    let before = samples[index.saturating_sub(reach)].at;
    let behind = samples[(index + reach).min(samples.len() - 1)].at;
    let at = samples[index].at;
    let (a, b) = (
        [at[0] - before[0], at[1] - before[1]],
        [behind[0] - at[0], behind[1] - at[1]],
    );
    let chord = (behind[0] - before[0]).hypot(behind[1] - before[1]);
    let doubled_area = (a[0] * b[1] - a[1] * b[0]).abs();
    // Circumradius: R = abc / (4·area).
    a[0].hypot(a[1]) * b[0].hypot(b[1]) * chord / (2.0 * doubled_area).max(f64::MIN_POSITIVE)
}

/// Returns the total length of the segments that start at a sample with [`Cause::Side`].
fn side_length(samples: &[Sample], places: &[Cause]) -> f64 {
    let pieces = samples.windows(2).zip(places);
    pieces
        .filter(|(_, place)| **place == Cause::Side)
        .map(|(s, _)| (s[1].at[0] - s[0].at[0]).hypot(s[1].at[1] - s[0].at[1]))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::{draw, tests::curve};
    use crate::accuracy::overlap::overlap;
    use crate::accuracy::spline::through;

    fn bar(to: f64, width_px: f64) -> Curve {
        curve(
            &[[10.0, 20.0], [0.5 * (10.0 + to), 20.0], [to, 20.0]],
            width_px,
        )
    }

    fn sorted(truth: Curve, found: Curve) -> Disagreement {
        let size = (120, 40);
        let label = draw(&[truth], &[], size);
        let curves = [found];
        let splines = [through(&curves[0])];
        let drawn = draw(&curves, &[], size);
        let overlap = overlap(&label, &drawn, 1);
        let found = Found {
            curves: &curves,
            crossings: &[],
            splines: &splines,
            drawn: &drawn,
        };
        sort(&label, &found, &overlap)
    }

    #[test]
    fn a_rope_drawn_too_wide_disagrees_along_its_sides() {
        let sorted = sorted(bar(110.0, 9.0), bar(110.0, 11.0));
        assert_eq!(sorted.lacking, [0; 6]);
        assert!(sorted.excess[Cause::Side as usize] > 150);
        assert!((sorted.edge_bias_px() - 1.0).abs() < 0.03, "{sorted:?}");
    }

    #[test]
    fn a_tip_that_ends_early_lacks_pixels_there() {
        let sorted = sorted(bar(110.0, 9.0), bar(107.0, 9.0));
        let tip = Cause::Tip as usize;
        assert_eq!((sorted.lacking[tip], sorted.lacking.iter().sum()), (27, 27));
        assert_eq!(sorted.excess, [0; 6]);
    }

    #[test]
    fn what_is_far_from_every_curve_is_lost() {
        let sorted = sorted(bar(110.0, 9.0), bar(60.0, 9.0));
        assert!(sorted.lacking[Cause::Lost as usize] > 9 * 40);
        assert_eq!(sorted.excess, [0; 6]);
    }

    #[test]
    fn a_tight_bend_is_told_from_an_even_stretch() {
        let arc: Vec<_> = (0..30)
            .map(|i| (f64::from(i) * 0.1).sin_cos())
            .map(|(sin, cos)| [60.0 + 15.0 * cos, 2.0 + 15.0 * sin])
            .collect();
        let samples = through(&curve(&arc, 10.0));
        assert!((radius_px(&samples, samples.len() / 2) - 15.0).abs() < 0.5);
        let straight = through(&bar(110.0, 9.0));
        assert!(radius_px(&straight, 40) > 1e6);
    }
}

//! Ropes drawn from their points and widths in the form of labels: each pixel belongs to one rope
//! or to the table.

use lariat_extract::{Crossing, Curve};

use super::labels::Labels;
use super::spline::{self, Sample};
use super::strip::{self, Ends};

/// Explanation of the drawing rule, printed with the figures.
pub(super) const RULE: &str = "\
Drawn: a pixel is a rope's when its centre lies within half a width of the centripetal Catmull-Rom spline through the
points, the widths interpolated likewise; the ends are cut off square at the tips. Where two ropes cover a pixel it goes
to the one on top at their nearest reported crossing, as labels have it (to the one whose middle is nearer, if none is
reported). Labels that come from a colour threshold hold no truth for the width: DICE ranks how well it is drawn.";

/// Draws `curves`: rope i has the number i + 1. Curves from the 256th on are left out.
pub(super) fn draw(
    curves: &[Curve],
    crossings: &[Crossing],
    (width, height): (usize, usize),
) -> Labels {
    let mut drawn = Labels::empty(width, height);
    // Distance of each pixel from its owner's centerline, in half widths.
    let mut owned = vec![f64::INFINITY; width * height];
    for (index, curve) in curves.iter().enumerate().take(255) {
        let samples = beyond_the_border(spline::through(curve), curve);
        let mut depths = vec![f64::INFINITY; width * height];
        strip::each((width, height), &samples, 0.0, Ends::Flat, |hit| {
            let depth = hit.distance_px / hit.half_px.max(f64::MIN_POSITIVE);
            depths[hit.pixel] = depths[hit.pixel].min(depth);
        });
        for (pixel, &depth) in depths.iter().enumerate() {
            if depth == f64::INFINITY {
                continue;
            }
            let at = [(pixel % width) as f64, (pixel / width) as f64];
            let owner = usize::from(drawn.ropes[pixel]);
            let is_on_top = owner == 0
                || top(crossings, (index, owner - 1), at)
                    .map_or(depth < owned[pixel], |top| top == index);
            if is_on_top {
                drawn.ropes[pixel] = index as u8 + 1;
                owned[pixel] = depth;
            }
        }
    }
    drawn
}

/// Returns which of two ropes is on top at their crossing nearest to `at`, or `None` if they do not
/// cross.
fn top(crossings: &[Crossing], ropes: (usize, usize), at: [f64; 2]) -> Option<usize> {
    let off = |c: &Crossing| (f64::from(c.at[0]) - at[0]).hypot(f64::from(c.at[1]) - at[1]);
    crossings
        .iter()
        .filter(|c| (c.over, c.under) == ropes || (c.under, c.over) == ropes)
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .map(|c| c.over)
}

/// Continues a rope straight ahead where it leaves the image, so that its square end is out of
/// sight.
fn beyond_the_border(mut samples: Vec<Sample>, curve: &Curve) -> Vec<Sample> {
    let on = |tip: Sample, inner: Sample| {
        let along = [tip.at[0] - inner.at[0], tip.at[1] - inner.at[1]];
        let length = along[0].hypot(along[1]);
        let reach = 2.0 * tip.half_px / length.max(f64::MIN_POSITIVE);
        let at = [tip.at[0] + reach * along[0], tip.at[1] + reach * along[1]];
        Sample { at, ..tip }
    };
    if let [first, second, .., before, last] = samples[..] {
        if curve.border[1] {
            samples.push(on(last, before));
        }
        if curve.border[0] {
            samples.insert(0, on(first, second));
        }
    }
    samples
}

#[cfg(test)]
pub(in crate::accuracy) mod tests {
    use super::*;

    /// Returns an open rope of constant width through `points`.
    pub(in crate::accuracy) fn curve(points: &[[f64; 2]], width_px: f64) -> Curve {
        let steps = points.windows(2);
        let mut curve = Curve::default();
        curve.points = points.iter().map(|p| p.map(|v| v as f32)).collect();
        curve.widths_px = vec![width_px as f32; points.len()];
        curve.hidden = vec![false; points.len()];
        curve.confidence = 1.0;
        curve.width_px = width_px as f32;
        curve.length_px = steps
            .map(|s| (s[1][0] - s[0][0]).hypot(s[1][1] - s[0][1]) as f32)
            .sum();
        curve
    }

    /// Returns a crossing at the middle of both ropes.
    pub(in crate::accuracy) fn crossing(at: [f32; 2], over: usize, under: usize) -> Crossing {
        let mut crossing = Crossing::default();
        (crossing.at, crossing.over, crossing.under) = (at, over, under);
        (crossing.over_rho, crossing.under_rho) = (0.5, 0.5);
        crossing.confidence = 0.95;
        crossing
    }

    fn count(drawn: &Labels, rope: u8) -> usize {
        drawn.ropes.iter().filter(|&&r| r == rope).count()
    }

    #[test]
    fn a_straight_rope_is_a_rectangle_with_square_ends() {
        // Columns 10 to 50, and the rows whose centers are within 4.4 of row 20.
        let drawn = draw(
            &[curve(&[[10.0, 20.0], [30.0, 20.0], [50.0, 20.0]], 8.8)],
            &[],
            (60, 40),
        );
        assert_eq!(count(&drawn, 1), 41 * 9);
        assert_eq!([drawn.at(10, 16), drawn.at(50, 24)], [1, 1]);
        assert_eq!(
            [drawn.at(9, 20), drawn.at(51, 20), drawn.at(30, 15)],
            [0, 0, 0]
        );
    }

    #[test]
    fn a_ring_is_filled_all_around() {
        let points: Vec<_> = (0..40)
            .map(|i| (f64::from(i) * std::f64::consts::TAU / 40.0).sin_cos())
            .map(|(sin, cos)| [60.0 + 40.0 * cos, 60.0 + 40.0 * sin])
            .collect();
        let mut ring = curve(&points, 10.0);
        ring.closed = true;
        let drawn = draw(&[ring], &[], (120, 120));
        for y in 0..120 {
            for x in 0..120 {
                let radius = (f64::from(x) - 60.0).hypot(f64::from(y) - 60.0);
                let (is_in, is_out) = ((radius - 40.0).abs() < 4.9, (radius - 40.0).abs() > 5.1);
                let rope = drawn.at(i64::from(x), i64::from(y));
                assert!(!(is_in && rope == 0 || is_out && rope == 1), "{x} {y}");
            }
        }
    }

    #[test]
    fn the_pixels_of_a_crossing_are_the_upper_ropes() {
        let ropes = [
            curve(&[[5.0, 30.0], [30.0, 30.0], [55.0, 30.0]], 9.0),
            curve(&[[30.0, 5.0], [30.0, 30.0], [30.0, 55.0]], 9.0),
        ];
        for over in [0, 1] {
            let drawn = draw(&ropes, &[crossing([30.0, 30.0], over, 1 - over)], (60, 60));
            for (x, y) in [(30, 30), (27, 33), (33, 27)] {
                assert_eq!(usize::from(drawn.at(x, y)), over + 1);
            }
        }
    }

    #[test]
    fn a_rope_that_leaves_the_image_reaches_its_border() {
        let mut slanted = curve(&[[20.0, 40.0], [40.0, 20.0], [59.0, 1.0]], 12.0);
        let without = draw(std::slice::from_ref(&slanted), &[], (60, 60));
        slanted.border[1] = true;
        let with = draw(&[slanted], &[], (60, 60));
        assert_eq!([without.at(59, 0), with.at(59, 0)], [0, 1]);
    }
}

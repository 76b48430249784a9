//! The curve through a centerline's points: a centripetal Catmull-Rom spline (Yuksel, Schaefer and
//! Keyser, 2011), evaluated in steps of at most a pixel by the pyramid of Barry and Goldman (1988).
//! Half the width is interpolated as a third coordinate with the same knots.

use lariat_extract::Curve;

/// Maximum distance between a spline's samples, in pixels. A chord then deviates from a bend of
/// radius r by 1/(8r).
const STEP_PX: f64 = 1.0;

/// A sample of a rope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) at: [f64; 2],
    /// Half the rope's width at the sample, in pixels.
    pub(super) half_px: f64,
    /// Normalized arc length of the sample, from 0 to 1.
    pub(super) rho: f64,
}

/// Samples the whole curve from tip to tip. A closed curve ends where it starts.
pub(super) fn through(curve: &Curve) -> Vec<Sample> {
    let knots: Vec<[f64; 3]> = curve
        .points
        .iter()
        .zip(&curve.widths_px)
        .map(|(&[x, y], &width)| [f64::from(x), f64::from(y), 0.5 * f64::from(width)])
        .collect();
    let count = knots.len();
    if count < 2 {
        return Vec::new();
    }
    let knot = |i: i64| {
        let last = count as i64 - 1;
        if curve.closed {
            knots[i.rem_euclid(count as i64) as usize]
        } else if i < 0 {
            // A phantom point, mirrored beyond the tip: the spline starts as straight as possible.
            mirrored(knots[1], knots[0])
        } else if i > last {
            mirrored(knots[count - 2], knots[count - 1])
        } else {
            knots[i as usize]
        }
    };
    let spans = if curve.closed { count } else { count - 1 };
    let mut samples = Vec::new();
    for span in 0..spans {
        let around = [-1, 0, 1, 2].map(|offset| knot(span as i64 + offset));
        let steps = (distance(around[1], around[2]) / STEP_PX).ceil().max(1.0) as usize;
        let is_last = span + 1 == spans;
        for step in 0..steps + usize::from(is_last) {
            let share = step as f64 / steps as f64;
            let [x, y, half_px] = between(around, distance, share);
            samples.push(Sample {
                at: [x, y],
                half_px: half_px.max(0.0),
                rho: (span as f64 + share) / spans as f64,
            });
        }
    }
    samples
}

fn mirrored(p: [f64; 3], at: [f64; 3]) -> [f64; 3] {
    [2.0 * at[0] - p[0], 2.0 * at[1] - p[1], at[2]]
}

/// Returns the distance in the plane.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Evaluates the spline between the second point (`share` 0) and the third (`share` 1). `far`
/// measures the distance between points.
pub(crate) fn between(
    p: [[f64; 3]; 4],
    far: fn([f64; 3], [f64; 3]) -> f64,
    share: f64,
) -> [f64; 3] {
    let mut t = [0.0; 4];
    for i in 1..4 {
        // Centripetal: the knot intervals are square roots of the chords. Coincident points still
        // need an interval.
        t[i] = t[i - 1] + far(p[i - 1], p[i]).sqrt().max(1e-6);
    }
    let at = t[1] + share * (t[2] - t[1]);
    let mix = |a: [f64; 3], b: [f64; 3], from: f64, to: f64| {
        let share = (at - from) / (to - from);
        [0, 1, 2].map(|i| a[i] + share * (b[i] - a[i]))
    };
    let a = [0, 1, 2].map(|i| mix(p[i], p[i + 1], t[i], t[i + 1]));
    let b = [0, 1].map(|i| mix(a[i], a[i + 1], t[i], t[i + 2]));
    mix(b[0], b[1], t[1], t[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::tests::curve;

    #[test]
    fn the_spline_passes_through_every_point_and_width() {
        let points = [
            [3.0, 4.0],
            [20.0, 9.0],
            [33.0, 30.0],
            [20.0, 41.0],
            [7.0, 30.0],
        ];
        for closed in [false, true] {
            let mut curve = curve(&points, 8.0);
            curve.widths_px = vec![8.0, 9.0, 12.0, 7.0, 6.0];
            curve.closed = closed;
            let samples = through(&curve);
            for (point, width) in curve.points.iter().zip(&curve.widths_px) {
                let found = samples.iter().any(|s| {
                    let off = (s.at[0] - f64::from(point[0])).hypot(s.at[1] - f64::from(point[1]));
                    off < 1e-6 && (2.0 * s.half_px - f64::from(*width)).abs() < 1e-6
                });
                assert!(found, "{point:?}");
            }
            let last = samples[samples.len() - 1].at;
            let end = if closed { points[0] } else { points[4] };
            assert!((last[0] - end[0]).hypot(last[1] - end[1]) < 1e-6);
        }
    }

    #[test]
    fn points_on_a_circle_give_the_circle() {
        let points: Vec<_> = (0..24)
            .map(|i| (f64::from(i) * std::f64::consts::TAU / 24.0).sin_cos())
            .map(|(sin, cos)| [50.0 + 40.0 * cos, 50.0 + 40.0 * sin])
            .collect();
        let mut curve = curve(&points, 8.0);
        curve.closed = true;
        for sample in through(&curve) {
            let radius = (sample.at[0] - 50.0).hypot(sample.at[1] - 50.0);
            assert!((radius - 40.0).abs() < 0.02, "{radius}");
        }
    }

    #[test]
    fn a_straight_rope_is_sampled_straight_and_evenly() {
        let samples = through(&curve(&[[0.0, 5.0], [10.0, 5.0], [20.0, 5.0]], 4.0));
        assert_eq!(samples.len(), 21);
        for (i, sample) in samples.iter().enumerate() {
            assert!((sample.at[0] - i as f64).abs() < 1e-9 && (sample.at[1] - 5.0).abs() < 1e-9);
            assert!((sample.rho - i as f64 / 20.0).abs() < 1e-9);
        }
    }
}

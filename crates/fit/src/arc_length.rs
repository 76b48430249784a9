//! Normalized arc lengths measured along the points: `ρᵢ` is the length of the chords up to point
//! `i` divided by the length of all chords (the paper's equations 1 and 2, and the usual
//! chord-length parametrization).
//!
//! They are distinct, which is one of the conditions of a stable descriptor: points at the same `ρ`
//! would repeat a row of `B`.

use crate::fitter::MAX_COORDINATE_PX;

/// Why arc lengths could not be measured.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArcLengthError {
    /// Two neighbors coincide, or are so close that their computed arc lengths are equal.
    #[error(
        "points {first} and {second} are at the same place, so arc length does not tell them apart: leave one \
         of them out"
    )]
    Repeated {
        /// The earlier point, counted from 0.
        first: usize,
        /// The later point: the next one, or 0 after the last point of a closed curve.
        second: usize,
    },
    /// All points coincide.
    #[error(
        "all {points} points are at the same place, so there is no curve: give points along one"
    )]
    NoLength {
        /// Number of points.
        points: usize,
    },
    /// A coordinate is NaN, infinite or too large.
    #[error(
        "coordinate {axis} of point {index} is {value}, which is not a position in a picture: it must be finite and \
         below {MAX_COORDINATE_PX:e} px in size"
    )]
    NotAPoint {
        /// Index of the point, counted from 0.
        index: usize,
        /// Index of its coordinate, counted from 0.
        axis: usize,
        /// Its value.
        value: f64,
    },
}

/// Writes the normalized cumulative chord length of each point to `out`: 0 at the first, 1 at the
/// last. On a closed curve, the chord from the last point back to the first counts as well, so that
/// 1 would be the first point again. After an error, the contents of `out` are unspecified.
///
/// # Errors
/// Fails if neighbors or all points coincide (as for a single point), or if a coordinate is not a
/// position in a picture.
///
/// # Panics
/// If `out` is not as long as `points`.
pub(crate) fn rho<const D: usize>(
    points: &[[f64; D]],
    closed: bool,
    out: &mut [f64],
) -> Result<(), ArcLengthError> {
    assert_eq!(out.len(), points.len(), "one arc length for each point");
    for (index, point) in points.iter().enumerate() {
        for (axis, &value) in point.iter().enumerate() {
            // Also rejects NaN.
            if value.abs().partial_cmp(&MAX_COORDINATE_PX) != Some(std::cmp::Ordering::Less) {
                return Err(ArcLengthError::NotAPoint { index, axis, value });
            }
        }
    }
    let mut length = 0.0;
    for (i, sum) in out.iter_mut().enumerate() {
        if i > 0 {
            length += chord(&points[i - 1], &points[i]);
        }
        *sum = length;
    }
    if closed && let [first, .., last] = points {
        length += chord(last, first);
    }
    if length == 0.0 {
        let points = points.len();
        return Err(ArcLengthError::NoLength { points });
    }
    for sum in out.iter_mut() {
        *sum /= length;
    }
    // Compares the quotients, because two different sums may give the same quotient.
    if let Some(first) = out.windows(2).position(|pair| pair[0] >= pair[1]) {
        let second = first + 1;
        return Err(ArcLengthError::Repeated { first, second });
    }
    if closed && out.last() == Some(&1.0) {
        let first = out.len() - 1;
        return Err(ArcLengthError::Repeated { first, second: 0 });
    }
    Ok(())
}

/// Distance between two points. No square overflows below the largest coordinate.
fn chord<const D: usize>(from: &[f64; D], to: &[f64; D]) -> f64 {
    let mut squared = 0.0;
    for axis in 0..D {
        let step = to[axis] - from[axis];
        squared += step * step;
    }
    squared.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn measured(points: &[[f64; 2]], closed: bool) -> Result<Vec<f64>, ArcLengthError> {
        let mut out = vec![0.0; points.len()];
        rho(points, closed, &mut out).map(|()| out)
    }

    #[test]
    fn a_square_is_measured_along_its_sides() {
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let open = measured(&square, false).unwrap();
        for (rho, third) in open.iter().zip(0..) {
            assert!((rho - f64::from(third) / 3.0).abs() < 1e-15);
        }
        assert_eq!(measured(&square, true).unwrap(), [0.0, 0.25, 0.5, 0.75]);
    }

    #[test]
    fn it_works_in_three_dimensions() {
        let points = [[0.0, 0.0, 0.0], [1.0, 2.0, 2.0], [1.0, 2.0, 3.0]];
        let mut out = [0.0; 3];
        rho(&points, false, &mut out).unwrap();
        assert_eq!(out, [0.0, 0.75, 1.0]);
    }

    #[test]
    fn neighbours_at_one_place_are_named() {
        let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        let error = measured(&points, false).unwrap_err();
        assert_eq!(
            error,
            ArcLengthError::Repeated {
                first: 1,
                second: 2
            }
        );
        assert!(
            error
                .to_string()
                .starts_with("points 1 and 2 are at the same place")
        );
        // A chord so short that the arc length does not grow.
        let points = [[0.0, 0.0], [1e8, 0.0], [1e8, 1e-10]];
        assert_eq!(
            measured(&points, false),
            Err(ArcLengthError::Repeated {
                first: 1,
                second: 2
            })
        );
        // These two are neighbors only across the closing chord.
        let ring = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
        assert!(measured(&ring, false).is_ok());
        assert_eq!(
            measured(&ring, true),
            Err(ArcLengthError::Repeated {
                first: 3,
                second: 0
            })
        );
    }

    #[test]
    fn points_at_one_place_have_no_length() {
        for closed in [false, true] {
            let error = measured(&[[3.0, 4.0]; 5], closed).unwrap_err();
            assert_eq!(error, ArcLengthError::NoLength { points: 5 });
            assert_eq!(
                measured(&[[3.0, 4.0]], closed),
                Err(ArcLengthError::NoLength { points: 1 })
            );
            assert_eq!(
                measured(&[], closed),
                Err(ArcLengthError::NoLength { points: 0 })
            );
        }
    }

    #[test]
    fn what_is_no_place_in_a_picture_is_refused() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e9, -1e300] {
            let error = measured(&[[0.0, 0.0], [1.0, bad], [2.0, 0.0]], false).unwrap_err();
            assert!(
                matches!(
                    error,
                    ArcLengthError::NotAPoint {
                        index: 1,
                        axis: 1,
                        ..
                    }
                ),
                "{error}"
            );
        }
    }

    fn polyline() -> impl Strategy<Value = Vec<[f64; 2]>> {
        prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), 3..40)
    }

    proptest! {
        #[test]
        fn lengths_rise_from_0_to_1(points in polyline()) {
            let open = measured(&points, false).unwrap();
            prop_assert_eq!(open[0], 0.0);
            prop_assert_eq!(*open.last().unwrap(), 1.0);
            prop_assert!(open.windows(2).all(|pair| pair[0] < pair[1]));
            let closed = measured(&points, true).unwrap();
            prop_assert!(*closed.last().unwrap() < 1.0);
        }

        #[test]
        fn a_curve_read_backwards_has_its_lengths_backwards(points in polyline()) {
            let forwards = measured(&points, false).unwrap();
            let backwards: Vec<_> = points.iter().rev().copied().collect();
            let backwards = measured(&backwards, false).unwrap();
            for (forward, backward) in forwards.iter().zip(backwards.iter().rev()) {
                prop_assert!((forward + backward - 1.0).abs() < 1e-13);
            }
        }

        #[test]
        fn moving_turning_and_scaling_a_curve_changes_nothing(
            points in polyline(),
            angle in 0.0f64..6.3,
            scale in 1e-3f64..1e3,
            shift in prop::array::uniform2(-1e3f64..1e3),
        ) {
            let (sin, cos) = angle.sin_cos();
            let moved: Vec<_> = points
                .iter()
                .map(|[x, y]| {
                    [scale * (cos * x - sin * y) + shift[0], scale * (sin * x + cos * y) + shift[1]]
                })
                .collect();
            let (before, after) = (measured(&points, true).unwrap(), measured(&moved, true).unwrap());
            for (before, after) in before.iter().zip(&after) {
                prop_assert!((before - after).abs() < 1e-9, "{before} {after}");
            }
        }
    }
}

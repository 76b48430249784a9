//! Inserts knots into B-splines, and splits curves into Bezier pieces.

use super::OwnedCurve;
use crate::basis::{Basis, Knots, MAX_CONTROL_POINTS};
use crate::curve::{Curve, CurveError};

/// A Bezier piece of a curve.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct BezierPiece<const D: usize = 2> {
    /// ρ of the whole curve at which the piece begins.
    pub from: f64,
    /// ρ of the whole curve at which the piece ends.
    pub to: f64,
    /// Control points, with the piece's own ρ from 0 to 1.
    pub control_points: Vec<[f64; D]>,
    /// Weights of a rational curve; otherwise empty.
    pub weights: Vec<f64>,
}

/// Splits a curve into its Bezier pieces: those between a B-spline's knots or between feature
/// points. A Bezier curve has one piece. The center of mass is a point, and a Fourier series has no
/// pieces.
pub fn bezier_pieces<const D: usize>(curve: &Curve<'_, D>) -> Vec<BezierPiece<D>> {
    curve
        .pieces()
        .map(|piece| BezierPiece {
            from: piece.from,
            to: piece.to,
            control_points: if curve.weights().is_empty() {
                piece.points.to_vec()
            } else {
                curve.control_points().to_vec()
            },
            weights: curve.weights().to_vec(),
        })
        .collect()
}

/// Inserts a knot at `rho` into a B-spline, which stays the same curve (W. Boehm, *Inserting new
/// knots into B-spline curves*, Computer-Aided Design 12, 1980). Its knots are no longer even and
/// are part of the result.
///
/// # Errors
/// Fails if the curve is not a B-spline or already has 32 control points, if `rho` is not between 0
/// and 1, or if `rho` already has as many knots as the degree.
pub fn insert_knot<const D: usize>(
    curve: &Curve<'_, D>,
    rho: f64,
) -> Result<OwnedCurve<D>, CurveError> {
    let basis = curve.basis();
    let Basis::BSpline {
        degree,
        control_points: count,
        ..
    } = basis
    else {
        return Err(CurveError::NoKnots { basis });
    };
    let wider = Basis::BSpline {
        degree,
        control_points: count + 1,
        knots: Knots::Averaged,
    };
    if count == MAX_CONTROL_POINTS {
        return Err(CurveError::Size { basis: wider });
    }
    let old = curve.knots();
    let place = old.partition_point(|&knot| knot <= rho);
    let times = old.iter().filter(|&&knot| knot == rho).count();
    if !(0.0 < rho && rho < 1.0) || times >= degree {
        return Err(CurveError::Knot {
            index: place,
            knot: rho,
            degree,
        });
    }
    let span = place - 1;
    let mut knots = old.to_vec();
    knots.insert(place, rho);
    let points = curve.control_points();
    let control_points = (0..=count)
        .map(|i| {
            if i <= span - degree {
                points[i]
            } else if i > span - times {
                points[i - 1]
            } else {
                let share = (rho - old[i]) / (old[i + degree] - old[i]);
                std::array::from_fn(|axis| {
                    share * points[i][axis] + (1.0 - share) * points[i - 1][axis]
                })
            }
        })
        .collect();
    Ok(OwnedCurve {
        basis: wider,
        control_points,
        weights: Vec::new(),
        knots,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn spline() -> impl Strategy<Value = (usize, Vec<[f64; 2]>)> {
        (1usize..=7).prop_flat_map(|degree| {
            let point = prop::array::uniform2(-1e3f64..1e3);
            (Just(degree), prop::collection::vec(point, degree + 1..=24))
        })
    }

    fn even(degree: usize, points: &[[f64; 2]]) -> Curve<'_> {
        let basis = Basis::BSpline {
            degree,
            control_points: points.len(),
            knots: Knots::Uniform,
        };
        Curve::new(basis, points, &[], &[]).unwrap()
    }

    proptest! {
        #[test]
        fn knots_change_nothing_about_the_curve(
            (degree, points) in spline(),
            at in prop::collection::vec(0.01f64..0.99, 1..=8),
            rho in 0.0f64..=1.0,
        ) {
            let curve = even(degree, &points);
            let mut wider = OwnedCurve::from(&curve);
            for (i, at) in at.iter().enumerate() {
                // Inserts some of them at an existing knot.
                let at = if i % 2 == 0 { *at } else { 0.5 };
                match insert_knot(&wider.as_curve().unwrap(), at) {
                    Ok(more) => wider = more,
                    Err(error) => {
                        let often = wider.knots.iter().filter(|&&knot| knot == at).count();
                        prop_assert_eq!(often, degree, "{}", error);
                    }
                }
            }
            let found = wider.as_curve().unwrap().point(rho);
            let expected = curve.point(rho);
            prop_assert!((found[0] - expected[0]).hypot(found[1] - expected[1]) < 1e-9);
        }

        #[test]
        fn pieces_are_the_curve_between_its_knots(
            (degree, points) in spline(),
            at in 0.1f64..0.9,
            rho in 0.0f64..=1.0,
        ) {
            // One knot is not even.
            let curve = insert_knot(&even(degree, &points), at).unwrap_or_else(|_| {
                OwnedCurve::from(&even(degree, &points))
            });
            let curve = curve.as_curve().unwrap();
            let pieces = bezier_pieces(&curve);
            prop_assert_eq!(pieces[0].from, 0.0);
            prop_assert_eq!(pieces[pieces.len() - 1].to, 1.0);
            prop_assert!(pieces.windows(2).all(|pair| pair[0].to == pair[1].from));
            let mut functions = vec![0.0; curve.control_points().len()];
            for piece in &pieces {
                let there = piece.from + rho * (piece.to - piece.from);
                let found = Curve::bezier(&piece.control_points).unwrap().point(rho);
                // Uses Cox and de Boor's functions, independent of the pieces.
                curve.jacobian(there, &mut functions);
                for axis in 0..2 {
                    let weighed = curve.control_points().iter().zip(&functions);
                    let expected: f64 = weighed.map(|(p, b)| p[axis] * b).sum();
                    prop_assert!((found[axis] - expected).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn knots_that_cannot_be_are_refused() {
        let points: Vec<[f64; 2]> = (0..32).map(|i| [f64::from(i), 0.0]).collect();
        let curve = even(3, &points[..6]);
        for rho in [0.0, 1.0, -0.5, 2.0, f64::NAN] {
            assert!(matches!(
                insert_knot(&curve, rho),
                Err(CurveError::Knot { .. })
            ));
        }
        assert!(matches!(
            insert_knot(&even(3, &points), 0.5),
            Err(CurveError::Size { .. })
        ));
        let bezier = Curve::bezier(&points[..6]).unwrap();
        assert!(matches!(
            insert_knot(&bezier, 0.5),
            Err(CurveError::NoKnots { .. })
        ));
    }
}

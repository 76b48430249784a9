//! Random curves of every family.

use lariat_fit::{Basis, Knots, OwnedCurve};
use proptest::prelude::*;
use std::f64::consts::FRAC_1_SQRT_2;

fn sizes(most: usize) -> impl Strategy<Value = Basis> {
    let spline = (1usize..=5).prop_flat_map(move |degree| {
        (degree + 1..=most.max(degree + 1)).prop_map(move |control_points| Basis::BSpline {
            degree,
            control_points,
            knots: Knots::Uniform,
        })
    });
    prop_oneof![
        3 => (1..most).prop_map(|order| Basis::Bezier { order }),
        3 => spline,
        2 => (1..most).prop_map(|order| Basis::RationalBezier { order }),
        2 => (1..=most.div_ceil(2) - 1).prop_map(|harmonics| Basis::Fourier { harmonics }),
        1 => (2..=most).prop_map(|count| Basis::FeaturePoints { count }),
        1 => Just(Basis::CenterOfMass),
    ]
}

/// Any curve of at most this many control points, all in a picture.
pub(crate) fn any_curve(most: usize) -> impl Strategy<Value = OwnedCurve> {
    sizes(most).prop_flat_map(|basis| {
        let count = basis.control_points();
        let weighted = match basis {
            Basis::RationalBezier { .. } => count,
            _ => 0,
        };
        let point = prop::array::uniform2(0.0f64..640.0);
        (
            prop::collection::vec(point, count),
            prop::collection::vec(0.3f64..3.0, weighted),
        )
            .prop_map(move |(control_points, weights)| OwnedCurve {
                basis,
                control_points,
                weights,
                knots: vec![],
            })
    })
}

pub(crate) fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Weights 1, √½, 1 turn a parabola's control points into those of a circle (Piegl and Tiller,
/// section 7.2).
pub(crate) fn quarter_circle() -> OwnedCurve {
    OwnedCurve {
        basis: Basis::RationalBezier { order: 2 },
        control_points: vec![[50.0, 0.0], [50.0, 50.0], [0.0, 50.0]],
        weights: vec![1.0, FRAC_1_SQRT_2, 1.0],
        knots: vec![],
    }
}

pub(crate) fn circle() -> OwnedCurve {
    OwnedCurve {
        basis: Basis::Fourier { harmonics: 1 },
        control_points: vec![[300.0, 200.0], [50.0, 0.0], [0.0, 50.0]],
        weights: vec![],
        knots: vec![],
    }
}

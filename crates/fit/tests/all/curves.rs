//! Compares curves with SciPy's and geomdl's. `tests/curves.py` made the fixture.

use lariat_fit::{Basis, Curve, Knots, OwnedCurve, elevate_degree, insert_knot};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    let row = value.as_array().expect("the fixture holds lists");
    row.iter()
        .map(|number| number.as_f64().expect("of numbers"))
        .collect()
}

fn points<const D: usize>(value: &Value) -> Vec<[f64; D]> {
    let rows = value.as_array().expect("the fixture holds lists of points");
    rows.iter()
        .map(|row| numbers(row).try_into().expect("of as many numbers"))
        .collect()
}

fn fixture() -> Value {
    serde_json::from_str(include_str!("../curves.json")).unwrap()
}

fn cases<'a>(fixture: &'a Value, key: &str, count: usize) -> &'a [Value] {
    let cases = fixture[key].as_array().unwrap();
    assert_eq!(cases.len(), count, "{key}");
    cases
}

/// Derivatives grow with order and pieces, and so does their rounding error.
fn close<const D: usize>(found: &[f64; D], expected: &[f64; D], size: f64, about: &str) {
    for axis in 0..D {
        assert!(
            (found[axis] - expected[axis]).abs() < 1e-12 * size,
            "{about}: {found:?} {expected:?}"
        );
    }
}

fn assert_derivatives<const D: usize>(curve: &Curve<'_, D>, case: &Value, rhos: &[f64]) {
    for (rho, expected) in rhos.iter().zip(case["derivatives"].as_array().unwrap()) {
        for (k, expected) in points::<D>(expected).iter().enumerate() {
            let size = points::<D>(&case["control_points"])
                .iter()
                .flatten()
                .fold(1e3f64, |size, c| size.max(c.abs()));
            let rate = 2.0 * curve.control_points().len() as f64 * curve.basis().order() as f64;
            let about = format!("{} at {rho}, derivative {k}", curve.basis());
            let found = curve.derivative(*rho, k);
            close(&found, expected, size * rate.powi(k as i32), &about);
        }
    }
}

#[test]
fn b_splines_are_scipys() {
    let fixture = fixture();
    let rhos = numbers(&fixture["rho"]);
    for case in cases(&fixture, "splines", 7) {
        let control_points = points::<2>(&case["control_points"]);
        let knots = numbers(&case["knots"]);
        let basis = Basis::BSpline {
            degree: case["degree"].as_u64().unwrap() as usize,
            control_points: control_points.len(),
            knots: Knots::Averaged,
        };
        let curve = Curve::new(basis, &control_points, &[], &knots).unwrap();
        assert_derivatives(&curve, case, &rhos);
    }
}

#[test]
fn an_inserted_knot_is_geomdls() {
    let fixture = fixture();
    for case in cases(&fixture, "splines", 7) {
        let owned = OwnedCurve {
            control_points: points(&case["control_points"]),
            basis: Basis::BSpline {
                degree: case["degree"].as_u64().unwrap() as usize,
                control_points: case["control_points"].as_array().unwrap().len(),
                knots: Knots::Averaged,
            },
            weights: vec![],
            knots: numbers(&case["knots"]),
        };
        let inserted = &case["inserted"];
        let rho = inserted["rho"].as_f64().unwrap();
        let found = insert_knot(&owned.as_curve().unwrap(), rho).unwrap();
        assert_eq!(found.knots, numbers(&inserted["knots"]));
        let expected = points::<2>(&inserted["control_points"]);
        assert_eq!(found.control_points.len(), expected.len());
        for (found, expected) in found.control_points.iter().zip(&expected) {
            close(found, expected, 1e3, "inserted");
        }
    }
}

fn assert_bezier<const D: usize>(case: &Value, rhos: &[f64]) {
    let control_points = points::<D>(&case["control_points"]);
    let weights = numbers(&case["weights"]);
    let order = control_points.len() - 1;
    let basis = if weights.is_empty() {
        Basis::Bezier { order }
    } else {
        Basis::RationalBezier { order }
    };
    let curve = Curve::new(basis, &control_points, &weights, &[]).unwrap();
    assert_derivatives(&curve, case, rhos);
    let expected = points::<D>(&case["elevated"]);
    if weights.is_empty() {
        let found = elevate_degree(&control_points, 3);
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            close(found, expected, 1e3, "elevated");
        }
    }
}

#[test]
fn bezier_curves_are_geomdls() {
    let fixture = fixture();
    let rhos = numbers(&fixture["rho"]);
    for case in cases(&fixture, "beziers", 7) {
        match case["control_points"][0].as_array().unwrap().len() {
            2 => assert_bezier::<2>(case, &rhos),
            3 => assert_bezier::<3>(case, &rhos),
            other => panic!("a fixture of {other} dimensions"),
        }
    }
}

#[test]
fn lengths_are_those_of_scipys_quad() {
    let fixture = fixture();
    for case in cases(&fixture, "lengths", 3) {
        let control_points = points::<2>(&case["control_points"]);
        let curve = Curve::bezier(&control_points).unwrap();
        let lengths = numbers(&case["lengths"]);
        for (rho, expected) in numbers(&case["to"]).iter().zip(&lengths) {
            let found = curve.length_to(*rho);
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
            let fraction = expected / lengths[lengths.len() - 1];
            assert!((curve.rho_at_length(fraction) - rho).abs() < 1e-11);
        }
    }
}

#[test]
fn the_nearest_point_is_as_near_as_scipys() {
    let fixture = fixture();
    for case in cases(&fixture, "nearest", 3) {
        let control_points = points::<2>(&case["control_points"]);
        let curve = Curve::bezier(&control_points).unwrap();
        for case in case["cases"].as_array().unwrap() {
            let point: [f64; 2] = numbers(&case["point"]).try_into().unwrap();
            let expected = case["distance"].as_f64().unwrap();
            let found = curve.nearest(point).distance;
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
}

//! Compares all three solvers with `numpy.linalg.lstsq`. `tests/numpy_lstsq.py` made the fixture.

use lariat_fit::{Fitter, Options, Solver};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<[f64; 2]> {
    let rows = value.as_array().expect("the fixture holds lists of points");
    rows.iter()
        .map(|row| [0, 1].map(|axis| row[axis].as_f64().expect("and points of two numbers")))
        .collect()
}

#[test]
fn every_solver_equals_numpy() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("../numpy_lstsq.json")).unwrap();
    assert_eq!(cases.len(), 10);
    for case in &cases {
        let points = numbers(&case["points"]);
        let order = case["order"].as_u64().unwrap() as usize;
        let number = |key: &str| case[key].as_f64().unwrap();
        for solver in [Solver::Pinv, Solver::Cholesky, Solver::Qr] {
            let mut fitter =
                Fitter::new(Options::bezier(order).points(points.len()).solver(solver)).unwrap();
            let about = format!("order {order}, {} points, {solver}", points.len());

            // Singular values are accurate to ε times the largest, so the relative error of their
            // ratio is ε times the ratio.
            let condition = number("condition");
            assert!(
                (fitter.last().condition - condition).abs() < 1e-11 * condition * condition,
                "{about}: {} {condition}",
                fitter.last().condition
            );

            let fit = fitter.fit(&points).unwrap();
            let expected = numbers(&case["control_points"]);
            let size = expected
                .iter()
                .flatten()
                .fold(0.0f64, |size, c| size.max(c.abs()));
            assert_eq!(fit.control_points.len(), order + 1);
            for (p, q) in fit.control_points.iter().zip(&expected) {
                for axis in 0..2 {
                    assert!(
                        (p[axis] - q[axis]).abs() < 1e-9 * size,
                        "{about}: {p:?} {q:?}"
                    );
                }
            }
            for (ours, key) in [
                (fit.rms_px, "rms_px"),
                (fit.max_px, "max_px"),
                (fit.residual_variance, "residual_variance"),
            ] {
                // Residuals are differences of numbers of a few hundred px.
                assert!(
                    (ours - number(key)).abs() < 1e-9,
                    "{about}: {key} {ours} {}",
                    number(key)
                );
            }
        }
    }
}

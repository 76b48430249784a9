//! Compares B-splines with SciPy's and geomdl's. `tests/splines.py` made the fixture.

use lariat_fit::{Basis, Fitter, Knots, Options, Rho, Solver};
use serde_json::Value;

fn points(value: &Value) -> Vec<[f64; 2]> {
    serde_json::from_value(value.clone()).expect("a list of points")
}

#[test]
fn least_squares_splines_are_scipys_and_geomdls() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("../splines.json")).unwrap();
    assert_eq!(cases.len(), 8);
    for case in &cases {
        let (given, expected) = (points(&case["points"]), points(&case["control_points"]));
        let knots: Vec<f64> = serde_json::from_value(case["knots"].clone()).unwrap();
        // geomdl measures arc length chord by chord, averages knots and interpolates the ends.
        let by_geomdl = case["by"].as_str().unwrap().starts_with("geomdl");
        let basis = Basis::BSpline {
            degree: case["degree"].as_u64().unwrap() as usize,
            control_points: expected.len(),
            knots: if by_geomdl {
                Knots::Averaged
            } else {
                Knots::Uniform
            },
        };
        for solver in [Solver::Pinv, Solver::Cholesky, Solver::Qr] {
            let options = Options::default()
                .basis(basis)
                .points(given.len())
                .solver(solver)
                .pin_ends(by_geomdl)
                .rho(if by_geomdl { Rho::Measured } else { Rho::Even });
            let mut fitter = Fitter::new(options).unwrap();
            let fit = fitter.fit(&given).unwrap();
            assert_eq!(fit.knots.len(), knots.len());
            for (ours, theirs) in fit.knots.iter().zip(&knots) {
                assert!(
                    (ours - theirs).abs() < 1e-12,
                    "{basis}: {:?} {knots:?}",
                    fit.knots
                );
            }
            for (ours, theirs) in fit.control_points.iter().zip(&expected) {
                for axis in 0..2 {
                    let error = (ours[axis] - theirs[axis]).abs();
                    assert!(error < 1e-7, "{basis}, {solver}: {error:e}");
                }
            }
        }
    }
}

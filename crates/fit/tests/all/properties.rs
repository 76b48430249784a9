//! Properties of fits to every centerline.

use lariat_fit::{Basis, Fit, FitError, Fitter, FitterError, Options, Solver, bernstein, point_at};
use proptest::prelude::*;

const SOLVERS: [Solver; 3] = [Solver::Pinv, Solver::Cholesky, Solver::Qr];

fn fit_with(solver: Solver, order: usize, points: &[[f64; 2]]) -> Fit {
    let mut fitter =
        Fitter::new(Options::bezier(order).points(points.len()).solver(solver)).unwrap();
    fitter.fit(points).unwrap().clone()
}

fn fit(order: usize, points: &[[f64; 2]]) -> Fit {
    fit_with(Solver::Pinv, order, points)
}

/// Points on the Bezier curve of these control points.
fn sampled(control_points: &[[f64; 2]], points: usize) -> Vec<[f64; 2]> {
    (0..points)
        .map(|i| point_at(control_points, i as f64 / (points - 1) as f64))
        .collect()
}

fn size(control_points: &[[f64; 2]]) -> f64 {
    control_points
        .iter()
        .flatten()
        .fold(1.0, |size, c| c.abs().max(size))
}

/// The largest difference of two descriptors, relative to the size of the larger.
fn difference(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let largest = a
        .iter()
        .flatten()
        .zip(b.iter().flatten())
        .fold(0.0f64, |d, (a, b)| d.max((a - b).abs()));
    largest / size(a).max(size(b))
}

fn any_points(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<[f64; 2]>> {
    prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), count)
}

/// An order, and enough random points for it.
fn problem() -> impl Strategy<Value = (usize, Vec<[f64; 2]>)> {
    (1usize..=8).prop_flat_map(|order| (Just(order), any_points(2 * order + 2..257)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn the_three_solvers_agree((order, points) in problem()) {
        let [pinv, cholesky, qr] = SOLVERS.map(|solver| fit_with(solver, order, &points));
        for other in [cholesky, qr] {
            prop_assert!(difference(&pinv.control_points, &other.control_points) < 1e-9);
            prop_assert!((pinv.rms_px - other.rms_px).abs() < 1e-9 * 1e3);
            prop_assert!((pinv.max_px - other.max_px).abs() < 1e-9 * 1e3);
        }
    }

    #[test]
    fn a_bezier_curve_of_that_order_gives_its_own_control_points_back(
        control_points in any_points(2..10),
        extra in 0usize..200,
    ) {
        let points = sampled(&control_points, control_points.len() + extra);
        let found = fit(control_points.len() - 1, &points);
        prop_assert!(difference(&found.control_points, &control_points) < 1e-10);
        prop_assert!(found.max_px < 1e-9);
    }

    #[test]
    fn control_points_alone_are_those_of_the_fit((order, points) in problem()) {
        for solver in [Solver::Pinv, Solver::Qr] {
            let options = Options::bezier(order).points(points.len()).solver(solver);
            let mut fitter = Fitter::new(options).unwrap();
            let alone = fitter.control_points(&points).unwrap().to_vec();
            prop_assert_eq!(&alone, &fitter.fit(&points).unwrap().control_points);
        }
    }

    #[test]
    fn the_residuals_are_those_of_the_curve((order, points) in problem()) {
        let found = fit(order, &points);
        let curve = sampled(&found.control_points, points.len());
        let squared: Vec<f64> = curve
            .iter()
            .zip(&points)
            .map(|(f, c)| (f[0] - c[0]).powi(2) + (f[1] - c[1]).powi(2))
            .collect();
        let sum: f64 = squared.iter().sum();
        let freedom = 2.0 * (points.len() - order - 1) as f64;
        prop_assert!((found.rms_px - (sum / points.len() as f64).sqrt()).abs() < 1e-8);
        let largest = squared.iter().copied().fold(0.0, f64::max).sqrt();
        prop_assert!((found.max_px - largest).abs() < 1e-8);
        prop_assert!((found.residual_variance - sum / freedom).abs() < 1e-9 * (1.0 + sum));
    }

    /// The residual of a least-squares fit is orthogonal to every column of B, which is sufficient
    /// proof.
    #[test]
    fn no_change_of_a_control_point_brings_the_curve_nearer((order, points) in problem()) {
        let found = fit(order, &points);
        let curve = sampled(&found.control_points, points.len());
        let mut gradient = vec![[0.0; 2]; order + 1];
        let mut values = vec![0.0; order + 1];
        for (i, (f, c)) in curve.iter().zip(&points).enumerate() {
            bernstein(order, i as f64 / (points.len() - 1) as f64, &mut values);
            for (g, b) in gradient.iter_mut().zip(&values) {
                g[0] += b * (f[0] - c[0]);
                g[1] += b * (f[1] - c[1]);
            }
        }
        for g in gradient.iter().flatten() {
            prop_assert!(g.abs() < 1e-7, "{gradient:?}");
        }
    }

    #[test]
    fn a_moved_turned_and_scaled_rope_has_a_descriptor_moved_turned_and_scaled(
        (order, points) in problem(),
        map in prop::array::uniform6(-3.0f64..3.0),
    ) {
        let apply = |p: &[f64; 2]| [
            map[0] * p[0] + map[1] * p[1] + 100.0 * map[2],
            map[3] * p[0] + map[4] * p[1] + 100.0 * map[5],
        ];
        let moved: Vec<_> = points.iter().map(apply).collect();
        let expected: Vec<_> = fit(order, &points).control_points.iter().map(apply).collect();
        let found = fit(order, &moved).control_points;
        let scale = size(&fit(order, &points).control_points).max(size(&expected));
        for (p, q) in found.iter().flatten().zip(expected.iter().flatten()) {
            prop_assert!((p - q).abs() < 1e-10 * scale);
        }
    }

    #[test]
    fn a_rope_read_backwards_has_its_control_points_backwards((order, points) in problem()) {
        let forwards = fit(order, &points).control_points;
        let backwards: Vec<_> = points.iter().rev().copied().collect();
        let mut found = fit(order, &backwards).control_points;
        found.reverse();
        prop_assert!(difference(&forwards, &found) < 1e-13);
    }

    #[test]
    fn the_matrix_times_the_points_is_the_descriptor((order, points) in problem()) {
        for solver in SOLVERS {
            let options = Options::bezier(order).points(points.len()).solver(solver);
            let mut fitter = Fitter::new(options).unwrap();
            let product: Vec<[f64; 2]> = fitter
                .matrix()
                .row_iter()
                .map(|row| {
                    assert_eq!(row.ncols(), points.len());
                    [0, 1].map(|axis| row.iter().zip(&points).map(|(m, c)| m * c[axis]).sum())
                })
                .collect();
            let found = fitter.fit(&points).unwrap();
            prop_assert_eq!(product.len(), order + 1);
            prop_assert!(difference(&found.control_points, &product) < 1e-9);
        }
    }

    #[test]
    fn any_numbers_at_all_are_answered_or_refused(
        points in prop::collection::vec(prop::array::uniform2(prop::num::f64::ANY), 20),
    ) {
        let mut fitter = Fitter::new(Options::default().points(20)).unwrap();
        match fitter.fit(&points) {
            Ok(fit) => prop_assert!(fit.control_points.iter().flatten().all(|c| c.is_finite())),
            Err(FitError::NotAPoint { index, value }) => {
                prop_assert!(value.is_nan() || value.abs() >= 1e9);
                prop_assert!(points[..index].iter().flatten().all(|c| c.abs() < 1e9));
            }
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}

#[test]
fn a_smooth_curve_comes_back_from_any_order_that_is_not_refused() {
    // A cubic is also a curve of every higher order. The stated accuracy is 1e-6 of its size.
    let cubic = [
        [30.0, 40.0],
        [600.0, -200.0],
        [-300.0, 500.0],
        [610.0, 450.0],
    ];
    for solver in SOLVERS {
        for points in [9, 32, 33, 120, 256] {
            let mut highest = 0;
            for order in 3..points.min(32) {
                let options = Options::bezier(order).points(points).solver(solver);
                let Ok(mut fitter) = Fitter::new(options) else {
                    continue;
                };
                highest = order;
                let mut elevated = cubic.to_vec();
                while elevated.len() <= order {
                    elevated = elevate(&elevated);
                }
                let found = fitter.fit(&sampled(&cubic, points)).unwrap();
                let error = difference(&found.control_points, &elevated);
                assert!(
                    error < 1e-6,
                    "order {order}, {points} points, {solver}: {error:e}"
                );
            }
            assert!(highest >= 8, "{points} points, {solver}: {highest}");
        }
    }
}

/// The same curve with one control point more.
fn elevate(control_points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let count = control_points.len();
    (0..=count)
        .map(|j| {
            let share = j as f64 / count as f64;
            let before = control_points[j.saturating_sub(1)];
            let here = control_points[j.min(count - 1)];
            [0, 1].map(|axis| share * before[axis] + (1.0 - share) * here[axis])
        })
        .collect()
}

fn refusal(order: usize, points: usize, solver: Solver) -> String {
    match Fitter::new(Options::bezier(order).points(points).solver(solver)) {
        Ok(_) => panic!("order {order} with {points} points was taken"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn requests_that_cannot_be_met_say_what_can() {
    assert_eq!(
        refusal(0, 120, Solver::Pinv),
        "a curve cannot have order 0: choose one from 1 to 31"
    );
    assert_eq!(
        refusal(32, 120, Solver::Pinv),
        "a curve cannot have order 32: choose one from 1 to 31"
    );
    assert_eq!(
        refusal(8, 257, Solver::Pinv),
        "a centerline cannot have 257 points: choose from 2 to 256"
    );
    assert_eq!(
        refusal(8, 5, Solver::Pinv),
        "5 points cannot fix a Bezier curve of 9 control points: give at least 9 points, or \
         choose a Bezier curve of 5 control points"
    );
    assert_eq!(
        refusal(24, 120, Solver::Cholesky),
        "for a Bezier curve of 25 control points with 120 points the condition number is 7.74e6, and cholesky gives \
         trustworthy control points only up to 6.7e4: choose a Bezier curve of 18 control points, or the solver pinv or qr"
    );
    assert_eq!(
        refusal(31, 32, Solver::Qr),
        "for a Bezier curve of 32 control points with 32 points the condition number is 2.34e12, and qr gives trustworthy \
         control points only up to 4.5e9: choose a Bezier curve of 28 control points"
    );
}

#[test]
fn the_order_that_a_refusal_names_is_taken_and_the_next_is_not() {
    for solver in SOLVERS {
        for points in [2, 20, 32, 120] {
            for order in 1..=31usize.min(points - 1) {
                let options = Options::bezier(order).points(points).solver(solver);
                if let Err(FitterError::IllConditioned { nearest, .. }) = Fitter::new(options) {
                    let nearest = nearest.expect("a line is always well conditioned");
                    let with = |basis| Fitter::new(options.basis(basis));
                    assert!(with(nearest).is_ok(), "{options:?}");
                    let next = Basis::Bezier {
                        order: nearest.order() + 1,
                    };
                    assert!(with(next).is_err(), "{options:?}");
                }
            }
        }
    }
}

#[test]
fn another_number_of_points_is_refused() {
    let mut fitter = Fitter::new(Options::default()).unwrap();
    assert_eq!(
        fitter.fit(&[[1.0, 2.0]; 119]).unwrap_err().to_string(),
        "119 points were given to a fitter made for 120: resample the centerline, or make another fitter"
    );
}

#[test]
fn a_refused_fit_does_not_harm_the_next() {
    let mut fitter = Fitter::new(Options::default()).unwrap();
    let rope: Vec<[f64; 2]> = (0..120).map(|i| [i as f64, (i * i) as f64]).collect();
    let first = fitter.fit(&rope).unwrap().clone();
    let mut broken = rope.clone();
    broken[60][1] = f64::NAN;
    assert_eq!(
        fitter.fit(&broken).unwrap_err().to_string(),
        "point 60 has the coordinate NaN, which is not a position in a picture: all must be finite and below 1e9 px in \
         size"
    );
    assert_eq!(fitter.fit(&rope).unwrap(), &first);
}

#[test]
fn repeated_points_are_a_curve_that_stands_still() {
    let found = fit(4, &[[17.0, 23.0]; 40]);
    for p in found.control_points {
        assert!((p[0] - 17.0).abs() < 1e-12 && (p[1] - 23.0).abs() < 1e-12);
    }
    assert!(found.max_px < 1e-12);
}

//! Properties of every family of curves and every option.

use crate::dense::Dense;
use lariat_fit::{
    Basis, Fit, Fitter, FitterError, Knots, Options, Point, Solver, Weights, bernstein, point_at,
};
use lariat_portable::SplitMix64;
use proptest::prelude::*;

const SOLVERS: [Solver; 3] = [Solver::Pinv, Solver::Cholesky, Solver::Qr];

fn fit<const D: usize>(options: Options, points: &[[f64; D]]) -> Fit<D>
where
    [f64; D]: Point<D>,
{
    let points_given = options.points(points.len());
    let mut fitter = Fitter::<D>::in_dimensions(points_given).unwrap();
    fitter.fit(points).unwrap().clone()
}

fn any_points(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<[f64; 2]>> {
    prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), count)
}

/// Every basis that is a regression, of sizes that all solvers accept with 40 points or more.
fn regression() -> impl Strategy<Value = Basis> {
    prop_oneof![
        (1usize..=8).prop_map(|order| Basis::Bezier { order }),
        (1usize..=5, 0usize..10, any::<bool>()).prop_map(|(degree, more, averaged)| {
            Basis::BSpline {
                degree,
                control_points: degree + 1 + more,
                knots: if averaged {
                    Knots::Averaged
                } else {
                    Knots::Uniform
                },
            }
        }),
        (1usize..=6).prop_map(|harmonics| Basis::Fourier { harmonics }),
    ]
}

fn any_basis() -> impl Strategy<Value = Basis> {
    prop_oneof![
        8 => regression(),
        1 => (2usize..=20).prop_map(|count| Basis::FeaturePoints { count }),
        1 => Just(Basis::CenterOfMass),
    ]
}

/// A basis and options that apply to it.
fn request() -> impl Strategy<Value = Options> {
    (
        any_basis(),
        prop_oneof![Just(0.0), 1e-3f64..1e3],
        any::<bool>(),
    )
        .prop_map(|(basis, ridge, pin)| {
            let regression = !matches!(basis, Basis::FeaturePoints { .. } | Basis::CenterOfMass);
            Options::default()
                .basis(basis)
                .ridge(if regression { ridge } else { 0.0 })
                .pin_ends(pin && basis.has_ends())
        })
}

fn largest_difference<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.fold(0.0, |largest, (a, b)| (a - b).abs().max(largest))
}

fn size(points: &[[f64; 2]]) -> f64 {
    points
        .as_flattened()
        .iter()
        .fold(1.0, |size, c| c.abs().max(size))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn the_three_solvers_agree(options in request(), points in any_points(40..200)) {
        let [pinv, cholesky, qr] = SOLVERS.map(|solver| fit(options.solver(solver), &points));
        let scale = size(&pinv.control_points);
        for other in [cholesky, qr] {
            let error = largest_difference(&pinv.control_points, &other.control_points);
            prop_assert!(error < 1e-9 * scale, "{error:e}");
            prop_assert!((pinv.rms_px - other.rms_px).abs() < 1e-9 * scale);
            prop_assert!((pinv.max_px - other.max_px).abs() < 1e-9 * scale);
        }
    }

    #[test]
    fn a_moved_turned_and_scaled_rope_has_a_descriptor_moved_turned_and_scaled(
        options in request(),
        points in any_points(40..200),
        map in prop::array::uniform6(-3.0f64..3.0),
    ) {
        // The coefficients of a Fourier series are not points, except the first, so they do not
        // move with the points.
        let moves = |j: usize| f64::from(j == 0 || !options.basis.is_closed());
        let apply = |p: &[f64; 2], moved: f64| [
            map[0] * p[0] + map[1] * p[1] + 100.0 * moved * map[2],
            map[3] * p[0] + map[4] * p[1] + 100.0 * moved * map[5],
        ];
        let moved: Vec<_> = points.iter().map(|p| apply(p, 1.0)).collect();
        let before = fit(options, &points).control_points;
        let expected: Vec<_> =
            before.iter().enumerate().map(|(j, p)| apply(p, moves(j))).collect();
        let found = fit(options, &moved).control_points;
        let error = largest_difference(&found, &expected);
        prop_assert!(error < 1e-9 * size(&before).max(size(&expected)), "{error:e}");
    }

    #[test]
    fn each_axis_is_fitted_by_itself(options in request(), points in any_points(40..130)) {
        let lifted: Vec<[f64; 3]> = points.iter().map(|p| [p[0], 3.0 - p[0], p[1]]).collect();
        let (flat, found) = (fit(options, &points), fit(options, &lifted));
        let scale = size(&flat.control_points);
        for (j, (p, q)) in flat.control_points.iter().zip(&found.control_points).enumerate() {
            let lift = if j == 0 || !options.basis.is_closed() { 3.0 } else { 0.0 };
            for (one, other) in [(p[0], q[0]), (lift - p[0], q[1]), (p[1], q[2])] {
                prop_assert!((one - other).abs() < 1e-10 * scale);
            }
        }
    }

    #[test]
    fn pinned_ends_are_the_first_and_the_last_point(options in request(), points in any_points(40..200)) {
        prop_assume!(options.basis.has_ends());
        for solver in SOLVERS {
            let found = fit(options.pin_ends(true).solver(solver), &points);
            prop_assert!(largest_difference(&found.control_points[..1], &points[..1]) < 1e-9);
            let last = found.control_points.len() - 1;
            prop_assert!(largest_difference(&found.control_points[last..], &points[points.len() - 1..]) < 1e-9);
        }
    }

    #[test]
    fn a_rope_read_backwards_has_its_control_points_backwards(
        options in request(),
        points in any_points(40..200),
    ) {
        let even = !matches!(options.basis, Basis::Fourier { .. } | Basis::BSpline { knots: Knots::Averaged, .. });
        prop_assume!(even);
        let forwards = fit(options, &points).control_points;
        let backwards: Vec<_> = points.iter().rev().copied().collect();
        let mut found = fit(options, &backwards).control_points;
        found.reverse();
        prop_assert!(largest_difference(&forwards, &found) < 1e-12 * size(&forwards));
    }

    #[test]
    fn the_matrix_times_the_points_is_the_descriptor(options in request(), points in any_points(40..200)) {
        let mut fitter = Fitter::new(options.points(points.len())).unwrap();
        let found = fitter.fit(&points).unwrap().control_points.clone();
        let product: Vec<[f64; 2]> = fitter
            .matrix()
            .row_iter()
            .map(|row| [0, 1].map(|axis| row.iter().zip(&points).map(|(m, c)| m * c[axis]).sum()))
            .collect();
        prop_assert!(largest_difference(&found, &product) < 1e-9 * size(&found));
    }

    /// A ridge reduces the bending of the control polygon.
    #[test]
    fn a_ridge_bends_the_control_polygon_less(points in any_points(40..200), order in 2usize..9) {
        let bending = |fit: &Fit| -> f64 {
            let p = &fit.control_points;
            p.windows(3).map(|w| (0..2).map(|a| (w[0][a] - 2.0 * w[1][a] + w[2][a]).powi(2)).sum::<f64>()).sum()
        };
        let with = |ridge| fit(Options::bezier(order).ridge(ridge), &points);
        let (free, some, much) = (with(0.0), with(1.0), with(1e9));
        prop_assert!(bending(&some) <= bending(&free) * (1.0 + 1e-9));
        prop_assert!(free.rms_px <= some.rms_px * (1.0 + 1e-12));
        // As λ grows, the curve becomes the regression line.
        let line = fit(Options::bezier(1), &points);
        prop_assert!((much.rms_px - line.rms_px).abs() < 1e-3 * line.rms_px);
    }
}

fn arc(points: usize) -> Vec<[f64; 2]> {
    (0..points)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / points as f64).sin_cos();
            [300.0 + 80.0 * cos, 200.0 - 50.0 * sin]
        })
        .collect()
}

#[test]
fn an_ellipse_is_one_harmonic() {
    let found = fit(
        Options::default().basis(Basis::Fourier { harmonics: 3 }),
        &arc(120),
    );
    let expected = [
        [300.0, 200.0],
        [80.0, 0.0],
        [0.0, -50.0],
        [0.0, 0.0],
        [0.0, 0.0],
        [0.0, 0.0],
        [0.0, 0.0],
    ];
    assert!(largest_difference(&found.control_points, &expected) < 1e-11);
    assert!(found.max_px < 1e-11);
    // The functions are orthogonal on the grid, with squares N and N/2.
    assert!((found.condition - 2f64.sqrt()).abs() < 1e-12);
}

#[test]
fn the_size_is_what_the_points_ask_for() {
    let cubic = [
        [30.0, 40.0],
        [600.0, -200.0],
        [-300.0, 500.0],
        [610.0, 450.0],
    ];
    let mut noise = SplitMix64::new(7);
    let points: Vec<[f64; 2]> = (0..120)
        .map(|i| point_at(&cubic, i as f64 / 119.0).map(|c| c + 0.3 * noise.normal()))
        .collect();
    let options = Options::bezier(12).choose_size(true);
    assert_eq!(fit(options, &points).basis, Basis::Bezier { order: 3 });
    let exact: Vec<[f64; 2]> = (0..120)
        .map(|i| point_at(&cubic, i as f64 / 119.0))
        .collect();
    let found = fit(options, &exact);
    assert_eq!(found.basis, Basis::Bezier { order: 3 });
    assert_eq!(found.control_points.len(), 4);
    assert_eq!(found.covariance_factor.shape(), (4, 4));
    let named = fit(Options::bezier(3), &exact);
    assert_eq!(found, named);
    // One harmonic of seven.
    let basis = Basis::Fourier { harmonics: 7 };
    let found = fit(options.basis(basis), &arc(90));
    assert_eq!(found.basis, Basis::Fourier { harmonics: 1 });
}

#[test]
fn feature_points_are_points_of_the_rope_and_the_center_is_their_mean() {
    let rope: Vec<[f64; 2]> = (0..121).map(|i| [i as f64, (i * i) as f64]).collect();
    let basis = Basis::FeaturePoints { count: 5 };
    let options = Options::default().basis(basis);
    let found = fit(options, &rope);
    assert_eq!(found.control_points, [0, 30, 60, 90, 120].map(|i| rope[i]));
    let basis = Basis::CenterOfMass;
    let found = fit(options.basis(basis), &rope);
    assert!(largest_difference(&found.control_points, &[[60.0, 4820.0]]) < 1e-9);
}

#[test]
fn options_without_use_are_refused_with_what_to_do() {
    let refusal = |options: Options| match Fitter::new(options) {
        Ok(_) => panic!("{options:?} was taken"),
        Err(error @ FitterError::Option { .. }) => error.to_string(),
        Err(other) => panic!("{other}"),
    };
    let ring = Options::default()
        .basis(Basis::Fourier { harmonics: 4 })
        .pin_ends(true);
    assert_eq!(
        refusal(ring),
        "a Fourier series of 4 harmonics cannot be fitted with pinned ends: it has no outer control points; \
         leave them free"
    );
    let points = Options::default()
        .basis(Basis::FeaturePoints { count: 6 })
        .ridge(1.0);
    assert_eq!(
        refusal(points),
        "6 feature points cannot be fitted with a ridge: choose bezier, bspline or fourier, or no ridge"
    );
    let text = Fitter::new(Options::default().ridge(f64::NAN))
        .err()
        .unwrap()
        .to_string();
    assert_eq!(text, "invalid ridge NaN: it must be 0 or positive");
}

/// Checks that the covariance of 20,000 noisy draws of one centerline is the stated one, within 5
/// %.
fn covariance_holds(options: Options) {
    const DRAWS: usize = 20_000;
    let sigma = 0.4;
    let mut fitter = Fitter::new(options).unwrap();
    // A curve that the family represents exactly, so that only noise is left.
    let smooth: Vec<[f64; 2]> = (0..options.points)
        .map(|i| [50.0 + 4.0 * i as f64, 240.0 - 1.5 * i as f64])
        .collect();
    let smooth = if options.basis.is_closed() {
        arc(options.points)
    } else {
        smooth
    };
    let expected = fitter.fit(&smooth).unwrap().control_points.clone();
    let m = expected.len();
    let mut noise = SplitMix64::new(42);
    let mut empirical = vec![0.0; m * m];
    let (mut variance, mut noisy) = (0.0, smooth.clone());
    for _ in 0..DRAWS {
        for (to, from) in noisy.iter_mut().zip(&smooth) {
            *to = from.map(|c| c + sigma * noise.normal());
        }
        let found = fitter.fit(&noisy).unwrap();
        variance += found.residual_variance / DRAWS as f64;
        let errors: Vec<[f64; 2]> = (found.control_points.iter().zip(&expected))
            .map(|(p, q)| [p[0] - q[0], p[1] - q[1]])
            .collect();
        for (i, a) in errors.iter().enumerate() {
            for (j, b) in errors.iter().enumerate() {
                empirical[i * m + j] += (a[0] * b[0] + a[1] * b[1]) / (2 * DRAWS) as f64;
            }
        }
    }
    assert!(
        (variance / (sigma * sigma) - 1.0).abs() < 0.01,
        "{variance}"
    );
    let stated = &fitter.last().covariance_factor;
    for i in 0..m {
        for j in 0..m {
            let stated = |i: usize, j: usize| sigma * sigma * stated[(i, j)];
            // Relative to the two standard deviations, as a covariance may be 0.
            let scale = (stated(i, i) * stated(j, j)).sqrt();
            let error = (empirical[i * m + j] - stated(i, j)).abs();
            assert!(
                error < 0.05 * scale,
                "{options:?} {i} {j}: {error} of {scale}"
            );
        }
    }
}

#[test]
fn the_covariance_is_that_of_noisy_draws() {
    let plain = Options::default();
    covariance_holds(plain);
    covariance_holds(Options::bezier(6).pin_ends(true).points(60));
    covariance_holds(plain.ridge(3.0).points(60));
    let basis = Basis::BSpline {
        degree: 3,
        control_points: 8,
        knots: Knots::Uniform,
    };
    covariance_holds(plain.basis(basis).points(60));
    let basis = Basis::Fourier { harmonics: 3 };
    covariance_holds(plain.basis(basis).points(60));
}

#[test]
fn the_noise_gain_is_the_largest_standard_deviation() {
    let fitter = Fitter::new(Options::default()).unwrap();
    let fit = fitter.last();
    let m = fit.control_points.len();
    let largest = (0..m)
        .map(|j| fit.covariance_factor[(j, j)])
        .fold(0.0, f64::max);
    assert_eq!(fit.noise_gain(), largest.sqrt());
    // N equal points determine the mean to 1/√N.
    let basis = Basis::CenterOfMass;
    let fitter = Fitter::new(Options::default().basis(basis)).unwrap();
    assert!((fitter.last().noise_gain() - 1.0 / 120f64.sqrt()).abs() < 1e-15);
}

#[test]
fn the_condition_is_that_of_what_was_solved() {
    let rope: Vec<[f64; 2]> = (0..120)
        .map(|i| [3.0 * f64::from(i), f64::from(i * i) / 90.0])
        .collect();
    let even = Fitter::new(Options::default()).unwrap().last().condition;
    let mut fitter = Fitter::new(Options::default().weights(Weights::Given)).unwrap();
    // The rows of B with weights, and their singular values.
    let solved = |from: usize| {
        let b = Dense::from_fn(120 - from, 9, |i, j| {
            let mut row = [0.0; 9];
            bernstein(8, (from + i) as f64 / 119.0, &mut row);
            row[j]
        });
        let values = b.singular_values();
        values[0] / values[8]
    };
    assert!((even / solved(0) - 1.0).abs() < 1e-9);
    for hidden in [0, 6, 12] {
        let mut weights = [1.0; 120];
        weights[..hidden].fill(0.0);
        let found = fitter.fit_weighted(&rope, &weights).unwrap().condition;
        let ratio = found / solved(hidden);
        assert!(
            (0.7..1.42).contains(&ratio),
            "{hidden} hidden: {found}, {ratio}"
        );
    }
    assert!(solved(12) > 2.0 * solved(0), "hiding matters");
}

//! Fits never allocate, whatever the options; neither do filters and curves.
use lariat_fit::{
    Basis, Curve, CurveSpace, Filter, FilterOptions, Fitter, Knots, Line, MAX_CONTROL_POINTS,
    Noise, Options, RationalFitter, Resampler, Rho, Solver, SteadySize, Tolerance, Weights,
};
use lariat_test_support::allocations;

#[test]
fn a_fit_allocates_nothing() {
    for solver in [Solver::Pinv, Solver::Cholesky, Solver::Qr] {
        for (order, points) in [(1, 2), (3, 33), (8, 120), (12, 256)] {
            let mut fitter =
                Fitter::new(Options::bezier(order).points(points).solver(solver)).unwrap();
            let rope: Vec<[f64; 2]> = (0..points)
                .map(|i| [3.0 * i as f64, 100.0 * (0.1 * i as f64).sin()])
                .collect();
            let before = allocations();
            for _ in 0..3 {
                std::hint::black_box(fitter.fit(&rope).unwrap());
                std::hint::black_box(fitter.control_points(&rope).unwrap());
            }
            assert_eq!(
                allocations(),
                before,
                "order {order}, {points} points, {solver}"
            );
        }
    }
}

#[test]
fn points_at_equal_steps_again_and_their_noise_allocate_nothing() {
    for (basis, closed) in [
        (Basis::Bezier { order: 8 }, false),
        (Basis::Fourier { harmonics: 4 }, true),
    ] {
        let points: Vec<[f64; 2]> = (0..120)
            .map(|i| {
                let (sin, cos) = (0.05 * f64::from(i)).sin_cos();
                [300.0 * cos, 200.0 * sin + 0.1 * f64::from(i)]
            })
            .collect();
        let options = Options::bezier(8).basis(basis).points(120);
        let mut fitter = Fitter::new(options).unwrap();
        let mut line = Resampler::new();
        let mut covariances = [[[0.0; 2]; 2]; MAX_CONTROL_POINTS];
        let before = allocations();
        for _ in 0..3 {
            let even = line.resample(&points, closed).unwrap();
            std::hint::black_box(fitter.fit(even).unwrap());
            std::hint::black_box(fitter.propagate(
                &line,
                &[[[1.0, 0.0], [0.0, 1.0]]; 120],
                &mut covariances,
            ));
        }
        assert_eq!(allocations(), before);
        assert!(covariances[0][0][0] > 0.0);
    }
}

#[test]
fn a_filter_allocates_nothing() {
    let line = |count: usize| -> Vec<[f64; 2]> { (0..count).map(|i| [i as f64, 1.0]).collect() };
    let spaces = [9, 4, 32, 1].map(|count| CurveSpace::of_points(count).unwrap());
    let shapes = [9, 4, 32, 1].map(line);
    let covariance = [9usize, 4, 32, 1].map(|count| {
        let entry = |k: usize| {
            if k.is_multiple_of(count + 1) {
                2.0
            } else {
                0.5
            }
        };
        (0..count * count).map(entry).collect::<Vec<f64>>()
    });
    let mut filter = Filter::<2>::new(32, FilterOptions::default()).unwrap();
    let before = allocations();
    for frame in 0..40 {
        // Five shapes of each, so that the filter begins, continues, and changes to more and to
        // fewer control points.
        let k = frame / 5 % 4;
        let noise = if frame % 2 == 0 {
            Noise::Covariance(&covariance[k])
        } else {
            Noise::Even { variance_px2: 0.1 }
        };
        let t_ns = frame as u64 * 10_000_000;
        std::hint::black_box(filter.update(t_ns, &spaces[k], &shapes[k], noise).unwrap());
        std::hint::black_box(filter.predict(t_ns + 5_000_000).unwrap());
    }
    assert_eq!(allocations(), before);
}

#[test]
fn a_rational_fit_allocates_nothing() {
    for (order, points, pinned) in [
        (1, 2, false),
        (3, 33, true),
        (8, 120, false),
        (31, 256, true),
    ] {
        let mut fitter = RationalFitter::<2>::new(order, points, pinned);
        let rope: Vec<[f64; 2]> = (0..points)
            .map(|i| [3.0 * i as f64, 100.0 * (0.1 * i as f64).sin()])
            .collect();
        let before = allocations();
        for _ in 0..3 {
            std::hint::black_box(fitter.fit(&rope));
            std::hint::black_box(fitter.covariance_factor());
            std::hint::black_box(fitter.joint_covariance_factor());
        }
        assert_eq!(allocations(), before, "order {order}, {points} points");
    }
}

#[test]
fn no_basis_and_no_option_allocates() {
    let spline = |knots| Basis::BSpline {
        degree: 3,
        control_points: 9,
        knots,
    };
    let plain = Options::default();
    let of = |basis| plain.basis(basis);
    let requests = [
        of(spline(Knots::Uniform)),
        of(Basis::RationalBezier { order: 8 }),
        of(Basis::Fourier { harmonics: 4 }),
        of(Basis::FeaturePoints { count: 9 }),
        of(Basis::CenterOfMass),
        plain.choose_size(true),
        plain.ridge(1.0).pin_ends(true),
        of(spline(Knots::Averaged)).rho(Rho::Measured),
        plain.weights(Weights::Robust).choose_size(true),
    ];
    let ropes = [0.1, 0.02, 0.07].map(|bend| -> Vec<[f64; 2]> {
        (0..120)
            .map(|i| [3.0 * i as f64, 100.0 * (bend * i as f64).sin()])
            .collect()
    });
    for options in requests {
        let mut fitter = Fitter::new(options).unwrap();
        let before = allocations();
        for rope in &ropes {
            std::hint::black_box(fitter.fit(rope).unwrap());
        }
        assert_eq!(allocations(), before, "{options:?}");
    }
}

#[test]
fn a_steady_size_allocates_nothing_even_when_it_changes() {
    let bent = |bend: f64| -> Vec<[f64; 2]> {
        let point = |i| [3.0 * i as f64, 100.0 * (bend * i as f64).sin()];
        (0..120).map(point).collect()
    };
    let ropes = [bent(0.02), bent(0.2)];
    let mut fitter = Fitter::new(Options::auto(120, false)).unwrap();
    let mut size = SteadySize::default();
    let before = allocations();
    let mut resized = 0;
    for second in 0..4 {
        let line = Line::of(&ropes[usize::from(second > 1)]);
        let now_ns = second * 1_000_000_000;
        let judged = size.fit(&mut fitter, &line, Tolerance::default(), now_ns);
        resized += usize::from(judged.unwrap().is_resized);
    }
    assert_eq!(allocations(), before);
    assert_eq!(resized, 1);
}

#[test]
fn a_curve_allocates_nothing() {
    let control_points: Vec<[f64; 2]> = (0..17)
        .map(|i| [3.0 * f64::from(i), 100.0 * (0.7 * f64::from(i)).sin()])
        .collect();
    let points: Vec<[f64; 2]> = (0..120).map(|i| [0.4 * f64::from(i), 9.0]).collect();
    let weights = [1.5; 17];
    let mut samples = [[0.0; 2]; 50];
    let mut jacobian = [0.0; 17];
    let spline = Basis::BSpline {
        degree: 3,
        control_points: 17,
        knots: Knots::Uniform,
    };
    for basis in [
        Basis::Bezier { order: 16 },
        spline,
        Basis::RationalBezier { order: 16 },
        Basis::Fourier { harmonics: 8 },
        Basis::FeaturePoints { count: 17 },
    ] {
        let weights = match basis {
            Basis::RationalBezier { .. } => &weights[..],
            _ => &[],
        };
        let before = allocations();
        let curve = Curve::new(basis, &control_points, weights, &[]).unwrap();
        std::hint::black_box((
            curve.derivative(0.3, 2),
            curve.tangent(0.3),
            curve.curvature(0.3),
        ));
        std::hint::black_box((
            curve.length(),
            curve.rho_at_length(0.3),
            curve.bounding_box(),
        ));
        std::hint::black_box((curve.nearest([20.0, 30.0]), curve.distance_to(&points)));
        curve.sample_by_length(&mut samples);
        curve.jacobian(0.3, &mut jacobian);
        assert_eq!(allocations(), before, "{basis}");
    }
}

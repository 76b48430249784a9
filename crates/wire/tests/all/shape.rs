//! Compares the shapes that readers evaluate with the library that fits them.

use lariat_fit::{Fitter, Knots, Options};
use lariat_wire::{Basis, Descriptor, MAX_CONTROL_POINTS, NoShape, Shape, Status};
use proptest::prelude::*;

/// A descriptor as the fit stage writes it.
fn descriptor(
    basis: lariat_fit::Basis,
    control_points: &[[f64; 2]],
    weights: &[f64],
    knots: &[f64],
) -> Descriptor {
    let mut made = Descriptor::EMPTY;
    made.basis = match basis {
        lariat_fit::Basis::BSpline { .. } => Basis::BSpline,
        lariat_fit::Basis::RationalBezier { .. } => Basis::RationalBezier,
        lariat_fit::Basis::Fourier { .. } => Basis::Fourier,
        lariat_fit::Basis::FeaturePoints { .. } => Basis::FeaturePoints,
        lariat_fit::Basis::CenterOfMass => Basis::CenterOfMass,
        _ => Basis::Bezier,
    } as u32;
    let count = control_points.len();
    made.status = Status::Ok as u32;
    made.degree = basis.order() as u32;
    made.count = count as u32;
    made.samples = 120;
    made.control_points[..count].copy_from_slice(control_points);
    made.weights[..weights.len()].copy_from_slice(weights);
    if let lariat_fit::Basis::BSpline { degree, .. } = basis {
        let inner = &knots[degree + 1..count];
        made.knots[..inner.len()].copy_from_slice(inner);
    }
    made
}

fn basis() -> impl Strategy<Value = lariat_fit::Basis> {
    let spline = (1usize..=7).prop_flat_map(|degree| {
        (degree + 1..=MAX_CONTROL_POINTS).prop_map(move |control_points| {
            lariat_fit::Basis::BSpline {
                degree,
                control_points,
                knots: Knots::Uniform,
            }
        })
    });
    prop_oneof![
        (1usize..=31).prop_map(|order| lariat_fit::Basis::Bezier { order }),
        (1usize..=16).prop_map(|order| lariat_fit::Basis::RationalBezier { order }),
        (1usize..=15).prop_map(|harmonics| lariat_fit::Basis::Fourier { harmonics }),
        spline,
    ]
}

fn is_near(a: [f64; 2], b: [f64; 2], tolerance: f64) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) <= tolerance
}

proptest! {
    /// The two evaluate by different recurrences. They differ by some hundred ulp of the largest
    /// term, which grows with the order and, for each derivative, with the number of pieces.
    #[test]
    fn points_directions_and_bends_are_those_of_the_fitting_library(
        basis in basis(),
        control_points in prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), 32),
        weights in prop::collection::vec(0.2f64..5.0, 32),
        rho in -0.05f64..1.05,
    ) {
        let count = basis.control_points();
        let control_points = &control_points[..count];
        let weights = match basis {
            lariat_fit::Basis::RationalBezier { .. } => &weights[..count],
            _ => &[],
        };
        // Outside 0 to 1, a rational curve may go to infinity.
        let rho = if weights.is_empty() { rho } else { rho.clamp(0.0, 1.0) };
        let curve = lariat_fit::Curve::new(basis, control_points, weights, &[]).unwrap();
        let message = descriptor(basis, control_points, weights, curve.knots());
        let shape = Shape::of(&message).unwrap();
        let rate = match basis {
            lariat_fit::Basis::BSpline { degree, control_points, .. } => degree * (control_points - degree),
            lariat_fit::Basis::Fourier { harmonics } => 7 * harmonics,
            _ => 5 * count,
        } as f64;
        // Outside 0 to 1, Bernstein polynomials of both signs cancel: (1.1)³¹ times more error.
        let tolerance = 1e-10 * if (0.0..=1.0).contains(&rho) { 1.0 } else { 100.0 };
        prop_assert!(is_near(shape.point_at(rho), curve.point(rho), tolerance));
        prop_assert!(is_near(shape.derivative_at(rho), curve.derivative(rho, 1), tolerance * rate));
        let speed = curve.derivative(rho, 1);
        let speed = speed[0].hypot(speed[1]);
        prop_assume!(speed > 10.0);
        let (ours, theirs) = (shape.tangent_at(rho).unwrap(), curve.tangent(rho).unwrap());
        prop_assert!(is_near(ours, theirs, tolerance * rate / speed));
        let (ours, theirs) = (shape.curvature_at(rho).unwrap(), curve.curvature(rho).unwrap());
        let size = tolerance * rate * rate / speed.powi(2);
        prop_assert!((ours - theirs).abs() <= size * (1.0 + 1e3 * rate / speed), "{} {}", ours, theirs);
        let mut theirs = [0.0; MAX_CONTROL_POINTS];
        curve.jacobian(rho, &mut theirs);
        let ours = shape.jacobian_at(rho);
        prop_assert_eq!(ours.len(), count);
        for (ours, theirs) in ours.iter().zip(theirs) {
            prop_assert!((ours - theirs).abs() <= tolerance * 1e-2);
        }
    }
}

/// A wavy line of points with reproducible noise.
fn wave(count: usize, closed: bool) -> Vec<[f64; 2]> {
    let mut state = 1u64;
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 40) as f64 / f64::from(1u32 << 24) - 0.5
    };
    (0..count)
        .map(|i| {
            let t = i as f64 / if closed { count } else { count - 1 } as f64;
            let [x, y] = if closed {
                let (sin, cos) = (t * std::f64::consts::TAU).sin_cos();
                [320.0 + 150.0 * cos, 240.0 + 90.0 * sin]
            } else {
                [50.0 + 500.0 * t, 240.0 + 80.0 * (6.0 * t).sin()]
            };
            [x + noise(), y + noise()]
        })
        .collect()
}

/// A plain fit with `basis`, as a message, and its covariance.
fn fitted(basis: lariat_fit::Basis, change: impl Fn(&mut Options)) -> (Descriptor, Vec<f64>) {
    let mut options = Options::default().basis(basis);
    change(&mut options);
    let points = wave(options.points, basis.is_closed());
    let mut fitter = Fitter::new(options).unwrap();
    let fit = fitter.fit(&points).unwrap();
    let mut message = descriptor(basis, &fit.control_points, &fit.weights, &fit.knots);
    let count = fit.control_points.len();
    message.residual_variance = fit.residual_variance;
    let factor = fit.covariance_factor.row_iter().flat_map(|row| row.iter());
    let whole: Vec<f64> = factor.map(|c| c * fit.residual_variance).collect();
    for j in 0..count {
        let variance = whole[j * (count + 1)];
        message.covariances[j] = [variance, 0.0, variance];
    }
    (message, whole)
}

#[test]
fn the_covariance_of_all_control_points_is_that_of_the_regression() {
    for basis in [
        lariat_fit::Basis::Bezier { order: 8 },
        lariat_fit::Basis::Bezier { order: 14 },
        lariat_fit::Basis::BSpline {
            degree: 3,
            control_points: 13,
            knots: Knots::Uniform,
        },
        lariat_fit::Basis::Fourier { harmonics: 4 },
    ] {
        let (message, whole) = fitted(basis, |_| ());
        let shape = Shape::of(&message).unwrap();
        let covariance = shape.covariance();
        assert!(covariance.is_exact(), "{basis}");
        let count = shape.control_points().len();
        let mut matrix = vec![f64::NAN; covariance.size().pow(2)];
        covariance.write_to(&mut matrix);
        for j in 0..count {
            for k in 0..count {
                let scale = (whole[j * (count + 1)] * whole[k * (count + 1)]).sqrt();
                let entry = |r: usize, c: usize| matrix[(2 * j + r) * 2 * count + 2 * k + c];
                // The regression's own entries carry the square of B's condition number, 2·10³ at
                // order 14.
                let near = |a: f64, b: f64| (a - b).abs() < 1e-6 * scale;
                assert!(near(entry(0, 0), whole[j * count + k]), "{basis}: {j} {k}");
                assert!(near(entry(1, 1), whole[j * count + k]), "{basis}: {j} {k}");
                assert!(near(entry(0, 1), 0.0) && near(entry(1, 0), 0.0));
            }
        }
        // A point of the curve is a weighted sum of control points.
        for rho in [0.0, 0.3, 1.0] {
            let weights = shape.jacobian_at(rho);
            let pairs = (0..count).flat_map(|j| (0..count).map(move |k| (j, k)));
            let expected: f64 = pairs
                .map(|(j, k)| weights[j] * weights[k] * whole[j * count + k])
                .sum();
            let [xx, xy, yy] = shape.covariance_at(rho);
            assert!(
                (xx - expected).abs() < 1e-6 * expected,
                "{basis}: {xx} {expected}"
            );
            assert!((yy - expected).abs() < 1e-6 * expected && xy.abs() < 1e-9 * expected);
        }
    }
}

#[test]
fn a_covariance_that_is_not_the_plain_fits_says_so() {
    let (mut message, _) = fitted(lariat_fit::Basis::Bezier { order: 8 }, |options| {
        options.ridge = 1e-3;
    });
    assert!(!Shape::of(&message).unwrap().covariance().is_exact());
    let (plain, _) = fitted(lariat_fit::Basis::Bezier { order: 8 }, |_| ());
    message = plain;
    // On a tilted table the axes differ; each control point's own covariance stays that of the
    // message.
    for (j, covariance) in message.covariances.iter_mut().enumerate() {
        *covariance = [2.0 + j as f64, 0.5, 1.0];
    }
    let covariance = Shape::of(&message).unwrap().covariance();
    assert!(!covariance.is_exact());
    let [[xx, xy], [yx, yy]] = covariance.block(3, 3);
    for (found, said) in [(xx, 5.0), (xy, 0.5), (yx, 0.5), (yy, 1.0)] {
        assert!((found - said).abs() < 1e-12, "{found} {said}");
    }
    // The ends of a Bezier curve are control points.
    let [xx, xy, yy] = covariance.of_point(0.0);
    for (found, said) in [(xx, 2.0), (xy, 0.5), (yy, 1.0)] {
        assert!((found - said).abs() < 1e-9, "{found} {said}");
    }
}

#[test]
fn feature_points_and_the_center_are_no_curves_and_say_so() {
    let points = lariat_fit::Basis::FeaturePoints { count: 5 };
    let message = descriptor(points, &[[1.0, 2.0]; 5], &[], &[]);
    assert_eq!(Shape::of(&message).unwrap_err(), NoShape::FeaturePoints);
    let mass = descriptor(lariat_fit::Basis::CenterOfMass, &[[1.0, 2.0]], &[], &[]);
    assert_eq!(Shape::of(&mass).unwrap_err(), NoShape::CenterOfMass);
}

#[test]
fn numbers_that_make_no_curve_are_not_evaluated() {
    let spline = lariat_fit::Basis::BSpline {
        degree: 3,
        control_points: 7,
        knots: Knots::Uniform,
    };
    let (sound, _) = fitted(spline, |_| ());
    assert!(Shape::of(&sound).is_ok());
    let broken: [fn(&mut Descriptor); 11] = [
        |d| d.count = 0,
        |d| d.count = 33,
        |d| d.degree = 7,
        |d| d.degree = u32::MAX,
        |d| d.basis = 99,
        |d| d.samples = 6,
        // More samples than a message has; all of them would be evaluated.
        |d| d.samples = 257,
        |d| d.samples = u32::MAX,
        |d| d.control_points[6][1] = f64::NAN,
        |d| d.knots[1] = 0.1,
        |d| d.knots[2] = 1.0,
    ];
    for (case, break_it) in broken.iter().enumerate() {
        let mut message = sound;
        break_it(&mut message);
        let refused = Shape::of(&message).map(|_| ());
        assert_eq!(refused, Err(NoShape::Unreadable), "{case}");
    }
}

#[test]
fn a_direction_is_known_where_the_curve_stands_still() {
    let bezier = |points: &[[f64; 2]]| {
        let order = points.len() - 1;
        descriptor(lariat_fit::Basis::Bezier { order }, points, &[], &[])
    };
    // The first two control points coincide, and so do the last two.
    let message = bezier(&[[10.0, 10.0], [10.0, 10.0], [90.0, 50.0], [90.0, 50.0]]);
    let shape = Shape::of(&message).unwrap();
    let along = [80.0 / 8000f64.sqrt(), 40.0 / 8000f64.sqrt()];
    for rho in [0.0, 1.0] {
        assert!(is_near(shape.tangent_at(rho).unwrap(), along, 1e-12));
        assert_eq!(shape.curvature_at(rho), None);
    }
    let normal = shape.normal_at(0.0).unwrap();
    assert!(is_near(normal, [-along[1], along[0]], 1e-12));
    let message = bezier(&[[10.0, 10.0]; 4]);
    assert_eq!(Shape::of(&message).unwrap().tangent_at(0.5), None);
}

#[test]
fn a_circle_bends_towards_its_normal() {
    let mut message = Descriptor::EMPTY;
    message.basis = Basis::Fourier as u32;
    (message.degree, message.count, message.samples) = (1, 3, 120);
    // From (100 + 50, 80) towards greater y.
    message.control_points[..3].copy_from_slice(&[[100.0, 80.0], [50.0, 0.0], [0.0, 50.0]]);
    let shape = Shape::of(&message).unwrap();
    assert!(shape.is_closed());
    for i in 0..7 {
        let rho = i as f64 / 7.0;
        assert!((shape.curvature_at(rho).unwrap() - 1.0 / 50.0).abs() < 1e-12);
        let (point, normal) = (shape.point_at(rho), shape.normal_at(rho).unwrap());
        let center = [0, 1].map(|axis| point[axis] + 50.0 * normal[axis]);
        assert!(is_near(center, [100.0, 80.0], 1e-10));
    }
    let points = shape.points::<4>();
    assert!(
        is_near(points[3], shape.point_at(0.75), 1e-12),
        "once around, not to the first again"
    );
}

//! What becomes of one curve.

use super::*;
use crate::settings::Family;

/// A straight rope of 120 points from (100, 200), 2 px apart along x.
fn rope() -> Curve {
    let mut curve = Curve {
        track: 7,
        status: Status::Ok as u32,
        count: 120,
        ..Curve::EMPTY
    };
    for (i, point) in curve.points[..120].iter_mut().enumerate() {
        *point = [100.0 + 2.0 * i as f32, 200.0];
    }
    curve
}

fn described(settings: &settings::Fit, curve: &Curve) -> Descriptor {
    let mut descriptor = Descriptor::EMPTY;
    let mut fitter = CurveFitter::new(settings, 120).unwrap();
    fitter.describe(curve, 1, &mut descriptor).unwrap();
    descriptor
}

/// The y that is farthest from the rope's.
fn farthest(descriptor: &Descriptor) -> f64 {
    let offsets = descriptor
        .control_points()
        .iter()
        .map(|p| (p[1] - 200.0).abs());
    offsets.fold(0.0, f64::max)
}

#[test]
fn what_is_known_of_the_rope_goes_along() {
    let mut curve = rope();
    (curve.border, curve.age_ns, curve.length_px, curve.width_px) = (2, 5, 238.0, 12.5);
    let descriptor = described(&settings::Fit::default(), &curve);
    assert_eq!(
        [descriptor.track, descriptor.order, descriptor.count],
        [7, 8, 9]
    );
    assert_eq!(
        [descriptor.samples, descriptor.border, descriptor.filtered],
        [120, 2, 0]
    );
    assert_eq!(
        (descriptor.length_px, descriptor.width_px, descriptor.age_ns),
        (238.0, 12.5, 5)
    );
    assert_eq!(descriptor.basis(), Some(Basis::Bezier));
    assert!(farthest(&descriptor) < 1e-9);
    assert_eq!(descriptor.velocities_px_s[..9], [[0.0; 2]; 9]);
}

#[test]
fn a_closed_rope_is_a_fourier_series_whatever_the_basis() {
    let mut ring = rope();
    ring.closed = 1;
    for (i, point) in ring.points[..120].iter_mut().enumerate() {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / 120.0).sin_cos();
        *point = [300.0 + 80.0 * cos, 200.0 + 80.0 * sin];
    }
    for basis in [Family::Bezier, Family::Rational, Family::Points] {
        let settings = settings::Fit {
            basis,
            ..settings::Fit::default()
        };
        let descriptor = described(&settings, &ring);
        assert_eq!(descriptor.basis(), Some(Basis::Fourier));
        assert_eq!([descriptor.order, descriptor.count], [4, 9]);
        let [center, cosine, sine] = [0, 1, 2].map(|j| descriptor.control_points[j]);
        for (found, expected) in [
            (center, [300.0, 200.0]),
            (cosine, [80.0, 0.0]),
            (sine, [0.0, 80.0]),
        ] {
            assert!((found[0] - expected[0]).abs() < 1e-4 && (found[1] - expected[1]).abs() < 1e-4);
        }
    }
}

#[test]
fn a_splines_inner_knots_go_along() {
    let settings = settings::Fit {
        basis: Family::BSpline,
        ..settings::Fit::default()
    };
    let descriptor = described(&settings, &rope());
    assert_eq!(descriptor.basis(), Some(Basis::BSpline));
    assert_eq!([descriptor.order, descriptor.count], [3, 9]);
    let even = [1.0, 2.0, 3.0, 4.0, 5.0].map(|k| k / 6.0);
    assert_eq!(descriptor.knots[..5], even);
}

#[test]
fn with_the_robust_option_hidden_points_weigh_nothing() {
    let mut curve = rope();
    curve.status = Status::Partial as u32;
    curve.set_hidden((0..MAX_POINTS).map(|i| (40..70).contains(&i)));
    for point in &mut curve.points[40..70] {
        point[1] += 60.0;
    }
    let with = |robust| {
        let settings = settings::Fit {
            robust,
            ..settings::Fit::default()
        };
        described(&settings, &curve)
    };
    assert!(farthest(&with(false)) > 10.0);
    let descriptor = with(true);
    assert!(farthest(&descriptor) < 1e-6, "{}", farthest(&descriptor));
    assert_eq!(descriptor.hidden, 30);
    // Where too little is seen to tell the curve, what was bridged must do.
    curve.set_hidden((0..MAX_POINTS).map(|i| (5..115).contains(&i)));
    let settings = settings::Fit {
        robust: true,
        ..settings::Fit::default()
    };
    assert!(described(&settings, &curve).count == 9);
}

#[test]
fn the_filter_knows_how_fast_a_rope_moves() {
    let settings = settings::Fit {
        filter: true,
        ..settings::Fit::default()
    };
    let mut fitter = CurveFitter::new(&settings, 120).unwrap();
    let mut descriptor = Descriptor::EMPTY;
    // 30 frames/s, 90 px/s along x; another rope stands still.
    for frame in 0..30 {
        let exposed_ns = 1_000_000_000 + frame * 33_333_333;
        let mut moved = rope();
        for point in &mut moved.points[..120] {
            point[0] += 3.0 * frame as f32;
        }
        let mut still = rope();
        still.track = 8;
        fitter
            .describe(&still, exposed_ns, &mut descriptor)
            .unwrap();
        fitter
            .describe(&moved, exposed_ns, &mut descriptor)
            .unwrap();
    }
    assert_eq!(descriptor.filtered, 1);
    for velocity in &descriptor.velocities_px_s[..9] {
        assert!(
            (velocity[0] - 90.0).abs() < 1.0 && velocity[1].abs() < 1.0,
            "{velocity:?}"
        );
    }
    assert!((descriptor.control_points[0][0] - 187.0).abs() < 0.1);
    assert!(
        descriptor.variances_px2[..9]
            .iter()
            .all(|v| *v > 0.0 && *v < 1.0)
    );
}

//! The domain of a lens, and its derivatives.

use lariat_camera::{Camera, Lens, Mapping, Outside, Plane};
use proptest::prelude::*;

/// Plausible coefficients of calibrations. Each is 0 now and then.
fn coefficients() -> impl Strategy<Value = Vec<f64>> {
    let small = |most: f64| prop_oneof![1 => Just(0.0), 3 => -most..most];
    let polynomial = [small(0.5), small(0.3), small(0.01), small(0.01), small(0.1)];
    let rational = [small(0.5), small(0.3), small(0.1)];
    let prism = [small(0.02), small(0.01), small(0.02), small(0.01)];
    let tilt = [small(0.1), small(0.1)];
    (polynomial, rational, prism, tilt)
        .prop_map(|(a, b, c, d)| [&a[..], &b[..], &c[..], &d[..]].concat())
}

fn lens() -> impl Strategy<Value = Lens> {
    let fisheye = [-0.1..0.1, -0.05..0.05, -0.02..0.02, -0.01..0.01];
    prop_oneof![
        2 => coefficients().prop_filter_map("folds in the middle", |c| Lens::brown_conrady(&c)),
        1 => fisheye.prop_filter_map("folds in the middle", Lens::fisheye),
    ]
}

/// The derivative by differences of 10⁻⁶ in both directions. Its error is about 10⁻⁹, and larger
/// where the lens distorts strongly.
fn differences(map: impl Fn([f64; 2]) -> [f64; 2], [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
    let h = 1e-6;
    let along = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|i| (b[i] - a[i]) / (2.0 * h));
    let dx = along(map([x - h, y]), map([x + h, y]));
    let dy = along(map([x, y - h]), map([x, y + h]));
    [[dx[0], dy[0]], [dx[1], dy[1]]]
}

proptest! {
    #[test]
    fn what_is_bent_is_straightened_again(
        lens in lens(), share in 0.0..0.98, angle in 0.0..std::f64::consts::TAU,
    ) {
        let reach = share * lens.widest_deg().min(80.0).to_radians().tan();
        let ideal = [reach * angle.cos(), reach * angle.sin()];
        // A tilted sensor does not see what is behind it.
        if let Some(seen) = lens.distort(ideal) {
            let back = lens.undistort(seen.point);
            prop_assert!(back.is_some(), "{lens:?} {ideal:?}");
            let back = back.unwrap().point;
            let away = (back[0] - ideal[0]).hypot(back[1] - ideal[1]);
            // The closer to the fold, the less a place in the image says about the ray.
            let j = seen.jacobian;
            let least = (j[0][0] * j[1][1] - j[0][1] * j[1][0]).abs() / j.as_flattened().iter().fold(1.0f64, |m, x| m.max(x.abs()));
            prop_assert!(away < 1e-11 * (1.0 + reach) / least.min(1.0), "{away} {lens:?} {ideal:?}");
        }
    }

    #[test]
    fn a_lens_is_the_one_of_the_model_that_it_says(lens in lens()) {
        let (model, coefficients) = lens.model();
        let again = match (model, coefficients[..].try_into()) {
            ("equidistant", Ok(coefficients)) => Lens::fisheye(coefficients),
            _ => Lens::brown_conrady(&coefficients),
        };
        prop_assert_eq!(again, Some(lens));
        prop_assert!(model != "plumb_bob" || coefficients.len() == 5);
    }

    #[test]
    fn whatever_is_straightened_is_seen_there(lens in lens(), x in -3.0..3.0, y in -3.0..3.0) {
        if let Some(ideal) = lens.undistort([x, y]) {
            let seen = lens.distort(ideal.point).unwrap().point;
            prop_assert!((seen[0] - x).hypot(seen[1] - y) < 1e-11, "{seen:?}");
        }
    }

    #[test]
    fn derivatives_are_those_of_the_map(
        lens in lens(), share in 0.0..0.7, angle in 0.0..std::f64::consts::TAU,
    ) {
        let reach = share * lens.widest_deg().min(60.0).to_radians().tan();
        let ideal = [reach * angle.cos(), reach * angle.sin()];
        let camera = Camera::new([500.0, 520.0], [320.0, 240.0], lens, None).unwrap();
        let plane = Plane::from_homography([[0.9, 0.1, 3.0], [-0.1, 1.2, 5.0], [1e-4, 2e-4, 2.0]]).unwrap();
        let mapping = Mapping::new(Some(&camera), Some(&plane), [640, 480]).unwrap();
        let ideal = [500.0 * ideal[0] + 320.0, 520.0 * ideal[1] + 240.0];
        let Some(seen) = camera.distort(ideal) else { return Ok(()) };
        let Ok(place) = mapping.place(seen.point) else { return Ok(()) };
        let checks = [
            (seen.jacobian, differences(|p| camera.distort(p).unwrap().point, ideal)),
            (place.jacobian, differences(|p| mapping.place(p).unwrap().point, seen.point)),
        ];
        for (found, expected) in checks {
            let size = expected.as_flattened().iter().fold(1e-3f64, |m, x| m.max(x.abs()));
            for (a, b) in found.as_flattened().iter().zip(expected.as_flattened()) {
                prop_assert!((a - b).abs() < 2e-4 * size, "{found:?} {expected:?}");
            }
        }
    }

    #[test]
    fn no_coefficients_and_no_points_bring_it_down(
        coefficients in proptest::collection::vec(proptest::num::f64::ANY, 0..16), x in proptest::num::f64::ANY,
        y in proptest::num::f64::ANY,
    ) {
        if let Some(lens) = Lens::brown_conrady(&coefficients) {
            let _ = (lens.undistort([x, y]), lens.distort([x, y]));
        }
        if let [a, b, c, d, ..] = coefficients[..]
            && let Some(lens) = Lens::fisheye([a, b, c, d])
        {
            let _ = (lens.undistort([x, y]), lens.distort([x, y]));
        }
    }
}

#[test]
fn beyond_the_fold_a_pixel_is_refused() {
    // r (1 − 0.4 r²) has its maximum of 0.6086 at r = 0.9129.
    let lens = Lens::brown_conrady(&[-0.4, 0.0, 0.0, 0.0]).unwrap();
    let fold = (1.0f64 / 1.2).sqrt();
    assert!((lens.widest_deg().to_radians().tan() - fold).abs() < 1e-9);
    let highest = fold * (1.0 - 0.4 * fold * fold);
    let inside = lens.undistort([0.0, highest - 1e-6]).unwrap().point;
    assert!(inside[1] < fold && inside[1] > fold - 0.01);
    assert_eq!(lens.undistort([0.0, highest + 1e-6]), None);
    // The polynomial would fold this ray onto a pixel that shows another ray.
    assert_eq!(lens.distort([0.0, 1.2]), None);
    let camera = Camera::new([600.0; 2], [320.0, 240.0], lens, None).unwrap();
    let mapping = Mapping::new(Some(&camera), None, [640, 480]).unwrap();
    assert_eq!(mapping.place([0.0, 0.0]), Err(Outside::Lens));
    assert!(mapping.place([0.0, 240.0]).is_ok());
}

#[test]
fn beyond_the_horizon_there_is_no_table() {
    let camera = Camera::new([600.0; 2], [320.0, 240.0], Lens::IDEAL, None).unwrap();
    // The camera looks ahead, a meter above the table, so that the horizon is at the center of the
    // image.
    let quarter = std::f64::consts::FRAC_PI_2;
    let plane = Plane::from_pose([quarter, 0.0, 0.0], [0.0, 1000.0, 0.0], &camera).unwrap();
    let mapping = Mapping::new(Some(&camera), Some(&plane), [640, 480]).unwrap();
    for y in 0..480 {
        match mapping.place([320.0, f64::from(y)]) {
            Ok(place) => {
                assert!(y > 240);
                let back = mapping.pixel(place.point).unwrap();
                assert!((back[1] - f64::from(y)).abs() < 1e-6);
            }
            Err(why) => assert!(why == Outside::Horizon && y <= 240),
        }
    }
}

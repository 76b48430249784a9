//! Lengths, nearest points and distances of curves of every family.

use crate::any_curve;

use any_curve::{any_curve, apart, circle, quarter_circle};
use lariat_fit::{Basis, Curve, OwnedCurve};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

/// The nearest of many points.
fn brute(curve: &Curve, point: [f64; 2]) -> f64 {
    (0..=4000)
        .map(|i| apart(curve.point(f64::from(i) / 4000.0), point))
        .fold(f64::INFINITY, f64::min)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn no_point_of_a_curve_is_nearer_than_the_nearest(
        owned in any_curve(32),
        point in prop::array::uniform2(-100.0f64..740.0),
    ) {
        let curve = owned.as_curve().unwrap();
        let found = curve.nearest(point);
        prop_assert!((0.0..=1.0).contains(&found.rho));
        prop_assert_eq!(curve.point(found.rho), found.point);
        prop_assert!((apart(found.point, point) - found.distance).abs() < 1e-12);
        let seen = brute(&curve, point);
        prop_assert!(found.distance <= seen + 1e-6, "{} {seen}", found.distance);
    }

    #[test]
    fn a_point_of_the_curve_is_its_own_nearest(owned in any_curve(32), rho in 0.0f64..=1.0) {
        let curve = owned.as_curve().unwrap();
        prop_assert!(curve.nearest(curve.point(rho)).distance < 2e-6);
    }

    /// The direction to a nearest point that is not an end or a corner is perpendicular to the
    /// curve.
    #[test]
    fn the_way_to_the_nearest_point_is_upright(
        owned in any_curve(16),
        point in prop::array::uniform2(-100.0f64..740.0),
    ) {
        let curve = owned.as_curve().unwrap();
        let found = curve.nearest(point);
        let inside = owned.basis.is_closed() || (found.rho > 0.0 && found.rho < 1.0);
        let corner = curve.knots().contains(&found.rho);
        if let Some(tangent) = curve.tangent(found.rho) && inside && !corner {
            let away = [point[0] - found.point[0], point[1] - found.point[1]];
            let along = away[0] * tangent[0] + away[1] * tangent[1];
            let speed = curve.derivative(found.rho, 1);
            let speed = speed[0].hypot(speed[1]);
            // If the curve's speed is almost zero, ρ is less accurate.
            prop_assert!(along.abs() < 1e-9 * (1.0 + 1e3 / speed) * (1.0 + found.distance));
        }
    }

    #[test]
    fn the_box_holds_the_curve_and_touches_it(owned in any_curve(32)) {
        let curve = owned.as_curve().unwrap();
        let [low, high] = curve.bounding_box();
        let mut seen = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for i in 0..=5000 {
            let point = curve.point(f64::from(i) / 5000.0);
            for axis in 0..2 {
                seen[0][axis] = seen[0][axis].min(point[axis]);
                seen[1][axis] = seen[1][axis].max(point[axis]);
            }
        }
        for axis in 0..2 {
            prop_assert!(low[axis] <= seen[0][axis] + 1e-6 && high[axis] >= seen[1][axis] - 1e-6);
            // At least one point touches the box; of 5000 steps one is near, even with 32 corners.
            let size = high[axis] - low[axis];
            prop_assert!(low[axis] > seen[0][axis] - 1e-2 * size - 1e-9);
            prop_assert!(high[axis] < seen[1][axis] + 1e-2 * size + 1e-9);
        }
    }

    #[test]
    fn a_length_is_that_of_many_chords(owned in any_curve(16)) {
        let curve = owned.as_curve().unwrap();
        let seen: f64 = (0..10_000)
            .map(|i| [i, i + 1].map(|i| curve.point(f64::from(i) / 10_000.0)))
            .map(|[a, b]| apart(a, b))
            .sum();
        let length = curve.length();
        prop_assert!(length >= seen * (1.0 - 1e-12));
        // At each of 16 corners, chords miss at most one chord length.
        prop_assert!(length <= seen * (1.0 + 5e-3));
    }

    #[test]
    fn lengths_add_up_and_lead_back(owned in any_curve(16), fraction in 0.0f64..=1.0) {
        let curve = owned.as_curve().unwrap();
        let rho = curve.rho_at_length(fraction);
        let length = curve.length();
        // Random curves occasionally have near-cusps.
        prop_assert!((curve.length_to(rho) - fraction * length).abs() <= 1e-8 * length);
        prop_assert_eq!(curve.length_to(0.0), 0.0);
        prop_assert_eq!(curve.length_to(1.0), length);
    }

    #[test]
    fn samples_are_evenly_spaced(owned in any_curve(16), count in 1usize..50) {
        let curve = owned.as_curve().unwrap();
        let mut samples = vec![[0.0; 2]; count];
        curve.sample_by_length(&mut samples);
        let length = curve.length();
        prop_assert_eq!(samples[0], curve.point(0.0));
        for (i, sample) in samples.iter().enumerate() {
            let fraction = owned.basis.even_rho(i, count);
            let expected = curve.point(curve.rho_at_length(fraction));
            prop_assert!(apart(*sample, expected) <= 1e-9 * length.max(1.0));
        }
        if count > 1 && !owned.basis.is_closed() {
            prop_assert!(apart(samples[count - 1], curve.point(1.0)) <= 1e-9 * length);
        }
    }

    #[test]
    fn the_distance_of_points_is_that_of_their_nearest_points(
        owned in any_curve(12),
        noise in prop::collection::vec(prop::array::uniform2(-0.5f64..0.5), 30),
    ) {
        let curve = owned.as_curve().unwrap();
        let points: Vec<[f64; 2]> = noise
            .iter()
            .enumerate()
            .map(|(i, [x, y])| {
                let on = curve.point(owned.basis.even_rho(i, 30));
                [on[0] + x, on[1] + y]
            })
            .collect();
        let distance = curve.distance_to(&points);
        // Each distance is at most that at its ρ, and at least that from the whole curve.
        let (mut least, mut most) = (0.0, 0.0);
        for (i, &point) in points.iter().enumerate() {
            least += curve.nearest(point).distance.powi(2);
            most += apart(curve.point(owned.basis.even_rho(i, 30)), point).powi(2);
        }
        let (least, most) = ((least / 30.0f64).sqrt(), (most / 30.0f64).sqrt());
        prop_assert!(least - 1e-6 <= distance.rms && distance.rms <= most + 1e-6);
        prop_assert!(distance.max >= distance.rms);
    }
}

/// One search is Newton's method from a good guess, the other covers the whole curve.
#[test]
fn both_searches_agree_to_rounding() {
    let control_points = [
        [83.2, 239.9],
        [65.5, 317.5],
        [56.4, 392.0],
        [80.2, 452.9],
        [95.6, 460.0],
        [149.7, 422.1],
        [199.0, 349.1],
        [259.1, 263.1],
        [317.7, 189.4],
    ];
    let curve = Curve::bezier(&control_points).unwrap();
    for i in 0..=200 {
        let rho = f64::from(i) / 200.0;
        let on = curve.point(rho);
        for off in [
            [0.0, 0.0],
            [1e-7, -1e-7],
            [0.5, 0.3],
            [-2.0, 1.0],
            [-3.0, -6.0],
        ] {
            let point = [on[0] + off[0], on[1] + off[1]];
            let near = curve.distance_to_at([(point, rho)]).max;
            let nearest = curve.nearest(point).distance;
            assert!(
                (near - nearest).abs() < 1e-10,
                "{off:?} at {rho}: {near} {nearest}"
            );
        }
    }
}

/// On the far side of a circle the distance has its only maximum, and the search begins next to it.
#[test]
fn a_search_that_begins_on_a_hill_comes_down() {
    let circle = circle();
    let circle = circle.as_curve().unwrap();
    for i in 0..=100 {
        let rho = f64::from(i) / 100.0;
        let distance = circle.distance_to_at([([380.0, 200.0], rho)]);
        assert!(
            (distance.max - 30.0).abs() < 1e-10,
            "{rho}: {}",
            distance.max
        );
    }
}

#[test]
fn known_curves_have_their_known_lengths() {
    let (arc, circle) = (quarter_circle(), circle());
    let arc = arc.as_curve().unwrap();
    assert!((arc.length() / (50.0 * FRAC_PI_2) - 1.0).abs() < 1e-14);
    assert!((arc.length_to(0.5) / (25.0 * FRAC_PI_2) - 1.0).abs() < 1e-14);
    let circle = circle.as_curve().unwrap();
    assert!((circle.length() / (50.0 * TAU) - 1.0).abs() < 1e-14);
    let line = Curve::bezier(&[[0.0, 0.0], [300.0, 400.0]]).unwrap();
    assert!((line.length() - 500.0).abs() < 1e-12);
    // y = x² from 0 to 1: √5/2 + asinh(2)/4.
    let parabola = Curve::bezier(&[[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]).unwrap();
    let known = 5f64.sqrt() / 2.0 + 2f64.asinh() / 4.0;
    assert!((parabola.length() / known - 1.0).abs() < 1e-14);
    // (ρ², ρ³) from −1 to 1 has a cusp in the middle: 2 (13^(3/2) − 8)/27.
    let cusp = Curve::bezier(&[
        [1.0, -1.0],
        [-1.0 / 3.0, 1.0],
        [-1.0 / 3.0, -1.0],
        [1.0, 1.0],
    ])
    .unwrap();
    let known = 2.0 * (13f64.powf(1.5) - 8.0) / 27.0;
    assert!(
        (cusp.length() / known - 1.0).abs() < 1e-10,
        "{} {known}",
        cusp.length()
    );
}

#[test]
fn samples_of_a_circle_are_as_a_clock_has_them() {
    let circle = circle();
    let circle = circle.as_curve().unwrap();
    let mut samples = [[0.0; 2]; 12];
    circle.sample_by_length(&mut samples);
    for (hour, [x, y]) in samples.into_iter().enumerate() {
        let (sin, cos) = (TAU * hour as f64 / 12.0).sin_cos();
        assert!(apart([x, y], [300.0 + 50.0 * cos, 200.0 + 50.0 * sin]) < 1e-11);
    }
}

#[test]
fn in_space_all_is_as_in_the_plane() {
    // A straight line whose direction is (2, 2, 1)/3.
    let line = [[0.0, 0.0, 0.0], [100.0, 100.0, 50.0], [200.0, 200.0, 100.0]];
    let curve = Curve::bezier(&line).unwrap();
    assert!((curve.length() - 300.0).abs() < 1e-12);
    let found = curve.nearest([100.0 + 5.0, 100.0 - 5.0, 50.0]);
    assert!((found.distance - 50f64.sqrt()).abs() < 1e-12 && (found.rho - 0.5).abs() < 1e-12);
    assert_eq!(curve.bounding_box(), [line[0], line[2]]);
    let distance = curve.distance_to(&[
        [-3.0, 0.0, -4.0],
        [100.0, 100.0, 50.0],
        [200.0, 200.0, 106.0],
    ]);
    assert!((distance.max - 6.0).abs() < 1e-12);
    assert!((distance.rms - (61f64 / 3.0).sqrt()).abs() < 1e-12);
}

/// All points of the circle are equally near. Any is valid, but the search must end.
#[test]
fn the_middle_of_a_circle_is_its_radius_away() {
    let (arc, circle) = (quarter_circle(), circle());
    let found = circle.as_curve().unwrap().nearest([300.0, 200.0]);
    assert!((found.distance - 50.0).abs() < 1e-12);
    let found = arc.as_curve().unwrap().nearest([0.0, 0.0]);
    assert!((found.distance - 50.0).abs() < 1e-12);
    // Slightly off center, one point is the nearest by a small margin.
    let found = circle.as_curve().unwrap().nearest([300.0, 200.001]);
    assert!((found.distance - 49.999).abs() < 1e-10);
    assert!((found.rho - 0.25).abs() < 1e-6);
}

#[test]
fn the_ends_and_the_seam_are_points_like_others() {
    let curve = Curve::bezier(&[[0.0, 0.0], [50.0, 80.0], [100.0, 0.0]]).unwrap();
    let found = curve.nearest([-30.0, -40.0]);
    assert_eq!((found.rho, found.distance), (0.0, 50.0));
    assert_eq!(curve.nearest([130.0, -40.0]).rho, 1.0);
    let circle = circle();
    let circle = circle.as_curve().unwrap();
    for turn in [-1e-3, -1e-9, 0.0, 1e-9, 1e-3] {
        let (sin, cos) = (TAU * turn).sin_cos();
        let found = circle.nearest([300.0 + 80.0 * cos, 200.0 + 80.0 * sin]);
        assert!((found.distance - 30.0).abs() < 1e-11);
        let round = (found.rho - turn) - (found.rho - turn).round();
        assert!(round.abs() < 1e-11 && (0.0..1.0).contains(&found.rho));
    }
}

#[test]
fn a_curve_that_comes_back_is_near_with_the_right_strand() {
    // An S whose ends are 20 px from its middle.
    let polyline = OwnedCurve {
        basis: Basis::FeaturePoints { count: 4 },
        control_points: vec![[0.0, 0.0], [100.0, 0.0], [0.0, 20.0], [100.0, 20.0]],
        weights: vec![],
        knots: vec![],
    };
    let curve = polyline.as_curve().unwrap();
    let found = curve.nearest([10.0, 22.0]);
    assert!((found.distance - 2.0).abs() < 1e-12);
    assert!((found.rho - (2.0 + 0.1) / 3.0).abs() < 1e-12);
    // A corner.
    assert_eq!(curve.nearest([110.0, -5.0]).rho, 1.0 / 3.0);
    // Near its own ρ, a point is measured from its own strand.
    let near = curve.distance_to_at([([20.0, 4.0], 0.05)]);
    assert!((near.max - 4.0).abs() < 1e-12);
}

#[test]
fn what_is_no_number_has_no_distance_and_what_is_far_is_far() {
    let curve = Curve::bezier(&[[0.0, 0.0], [50.0, 80.0], [100.0, 0.0]]).unwrap();
    assert!(curve.nearest([f64::NAN, 0.0]).distance.is_nan());
    let distance = curve.distance_to(&[[0.0, 0.0], [f64::NAN, 0.0], [100.0, 0.0]]);
    assert!(distance.rms.is_nan() && distance.max.is_nan());
    assert!((curve.nearest([1e12, 0.0]).distance / 1e12 - 1.0).abs() < 1e-9);
    let none = curve.distance_to(&[]);
    assert_eq!((none.rms, none.max), (0.0, 0.0));
    let point = Curve::bezier(&[[3.0, 4.0]]).unwrap();
    assert_eq!(
        (point.length(), point.nearest([0.0, 0.0]).distance),
        (0.0, 5.0)
    );
    assert_eq!(point.bounding_box(), [[3.0, 4.0]; 2]);
    assert_eq!(point.rho_at_length(0.3), 0.3);
    let mut samples = [[0.0; 2]; 3];
    point.sample_by_length(&mut samples);
    assert_eq!(samples, [[3.0, 4.0]; 3]);
}

/// In the first quadrature of this nearly cusped curve, both sums agree, and are wrong by 2e-8.
#[test]
fn sums_that_agree_by_accident_are_not_taken() {
    let control_points = [
        [420.24291802304805, 330.0280824497833],
        [108.6366582694335, 555.3974257214593],
        [81.62994286061209, 405.302246701105],
        [439.2909359948557, 179.32027109465906],
        [532.0104013188839, 1.6730886567230168],
        [560.541900139079, 453.87198457751526],
        [548.4529984898381, 76.7765338477185],
        [368.15752013268104, 121.31339564332674],
        [250.1710710977909, 245.3329343715197],
        [285.32710441151204, 551.4066734521266],
        [635.7491127621498, 141.97809553198303],
        [287.81868278133874, 422.12314914085164],
        [30.769169782072787, 385.43464833414816],
        [454.7397846561284, 355.2220706341759],
        [629.0559146812959, 482.05140945657007],
        [574.0613011568424, 233.32206094504394],
    ];
    let basis = Basis::Bezier { order: 15 };
    let curve = Curve::new(basis, &control_points, &[], &[]).unwrap();
    let count = 1_000_000;
    let chords: f64 = (0..count)
        .map(|i| [i, i + 1].map(|i| curve.point(f64::from(i) / f64::from(count))))
        .map(|[a, b]| apart(a, b))
        .sum();
    // The sum of this many chords is shorter than the curve by a share of 1e-11.
    assert!((curve.length() - chords).abs() < 1e-10 * chords);
}

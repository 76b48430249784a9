//! Compares the nearest point with an exhaustive search.

use lariat_wire::{Basis, Centerline, CenterlinePoints, Descriptor, Shape};
use proptest::prelude::*;

/// Samples of the exhaustive search, many times as many as `nearest` uses for these curves.
const LOOKS: usize = 2_000;

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn curve(basis: Basis, points: &[[f64; 2]]) -> Descriptor {
    let mut rope = Descriptor::EMPTY;
    rope.basis = basis as u32;
    rope.count = points.len() as u32;
    rope.samples = 120;
    rope.degree = match basis {
        Basis::BSpline => 3,
        Basis::Fourier => (points.len() as u32 - 1) / 2,
        _ => points.len() as u32 - 1,
    };
    rope.control_points[..points.len()].copy_from_slice(points);
    if basis == Basis::BSpline {
        let inner = points.len() - 4;
        for (k, knot) in rope.knots[..inner].iter_mut().enumerate() {
            *knot = (k + 1) as f64 / (inner + 1) as f64;
        }
    }
    rope
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn no_point_of_a_curve_is_nearer_than_the_nearest(
        basis in prop::sample::select(vec![Basis::Bezier, Basis::BSpline, Basis::Fourier]),
        points in prop::collection::vec(prop::array::uniform2(0f64..1000.0), 9),
        point in prop::array::uniform2(-200f64..1200.0),
    ) {
        let rope = curve(basis, &points);
        let shape = Shape::of(&rope).unwrap();
        let nearest = shape.nearest(point);
        prop_assert!((0.0..=1.0).contains(&nearest.rho));
        prop_assert_eq!(nearest.point, shape.point_at(nearest.rho));
        prop_assert_eq!(nearest.distance, distance(nearest.point, point));
        for i in 0..=LOOKS {
            let rho = i as f64 / LOOKS as f64;
            let away = distance(shape.point_at(rho), point);
            prop_assert!(nearest.distance <= away + 1e-9, "{} at {}, {:?}", away, rho, nearest);
        }
        // Away from the ends, the line to the nearest point is perpendicular to the curve.
        if nearest.rho > 1e-6 && nearest.rho < 1.0 - 1e-6 && nearest.distance > 1.0 {
            let [tx, ty] = shape.tangent_at(nearest.rho).unwrap();
            let way = [point[0] - nearest.point[0], point[1] - nearest.point[1]];
            prop_assert!((tx * way[0] + ty * way[1]).abs() < 1e-3 * nearest.distance);
        }
    }

    #[test]
    fn no_point_of_a_centerline_is_nearer_than_the_nearest(
        steps in prop::collection::vec(prop::array::uniform2(-9f32..9.0), 1..=256),
        closed in 0u32..2,
        point in prop::array::uniform2(-100f64..100.0),
    ) {
        let mut line = CenterlinePoints::EMPTY;
        (line.count, line.closed) = (steps.len() as u32, closed);
        let mut at = [0.0; 2];
        for (to, step) in line.points.iter_mut().zip(&steps) {
            at = [at[0] + step[0], at[1] + step[1]];
            *to = at;
        }
        let line = Centerline::of(&line).unwrap();
        let nearest = line.nearest(point);
        prop_assert!(distance(nearest.point, line.point_at(nearest.rho)) < 1e-9);
        prop_assert_eq!(nearest.distance, distance(nearest.point, point));
        for i in 0..=LOOKS {
            let away = distance(line.point_at(i as f64 / LOOKS as f64), point);
            prop_assert!(nearest.distance <= away + 1e-9);
        }
        for (i, on) in line.points().iter().enumerate() {
            prop_assert!(distance(line.point_at(line.rho(i)), on.map(f64::from)) < 1e-9);
        }
    }
}

#[test]
fn on_a_ring_the_nearest_point_may_lie_across_the_seam() {
    // A circle around (100, 100) with radius 50, from (150, 100) towards y.
    let mut rope = curve(Basis::Fourier, &[[100.0, 100.0], [50.0, 0.0], [0.0, 50.0]]);
    rope.closed = 1;
    let nearest = Shape::of(&rope).unwrap().nearest([200.0, 99.0]);
    assert!(nearest.rho > 0.99 && nearest.rho < 1.0, "{nearest:?}");
    let from_the_center = distance([200.0, 99.0], [100.0, 100.0]);
    assert!((nearest.distance - (from_the_center - 50.0)).abs() < 1e-12);
}

#[test]
fn numbers_that_are_none_are_answered_all_the_same() {
    let rope = curve(Basis::Bezier, &[[0.0; 2], [1.0, 1.0], [2.0, 0.0]]);
    let shape = Shape::of(&rope).unwrap();
    assert!(shape.nearest([f64::NAN, 0.0]).distance.is_nan());
    let mut line = CenterlinePoints::EMPTY;
    (line.count, line.closed) = (u32::MAX, 1);
    line.points[7] = [f32::NAN; 2];
    let line = Centerline::of(&line).unwrap();
    assert_eq!(line.points().len(), 256);
    assert!(line.nearest([1.0, 0.0]).distance == 1.0);
    let _ = (
        line.point_at(f64::NAN),
        line.point_at(-1e300),
        line.point_at(f64::INFINITY),
    );
    let mut one = CenterlinePoints::EMPTY;
    one.count = 1;
    one.points[0] = [3.0, 4.0];
    let one = Centerline::of(&one).unwrap();
    assert_eq!(
        (one.point_at(0.7), one.nearest([0.0; 2]).distance),
        ([3.0, 4.0], 5.0)
    );
}

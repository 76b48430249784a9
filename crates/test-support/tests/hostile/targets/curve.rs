//! All queries that a controller may make of a rope.

use std::hint::black_box;

use lariat_wire::{
    Centerline, MAX_CONTROL_POINTS, MAX_POINTS, NoShape, Rope, Shape, Track, now_ns,
};

/// Positions on a curve and outside it for the queries.
pub(crate) const RHOS: [f64; 9] = [
    0.0,
    0.3,
    1.0,
    -1.0,
    2.0,
    1e300,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];
/// Points for nearest-point queries.
pub(crate) const POINTS: [[f64; 2]; 4] = [
    [0.0, 0.0],
    [120.0, 130.0],
    [1e300, -1e300],
    [f64::NAN, f64::INFINITY],
];

/// Makes all queries of a rope.
pub(crate) fn ask(rope: &Rope) {
    let count = rope.control_points().len();
    assert!(count <= MAX_CONTROL_POINTS, "{count}");
    assert!(rope.velocities().is_none_or(|v| v.len() == count));
    assert!((0.0..=1.0).contains(&rope.hidden()), "{}", rope.hidden());
    black_box((rope.age(), rope.exposed_ns(), rope.unit(), rope.fit()));
    black_box((rope.confidence(), rope.length(), rope.leaves_image()));
    black_box(Track::new(rope.track().run(), rope.track().number()));
    if let Some(line) = rope.centerline() {
        ask_line(line);
    }
    // A malformed rope is Absent and is not queried.
    match rope.shape() {
        Ok(shape) => ask_shape(&shape),
        Err(cause) => assert_ne!(cause, NoShape::Unreadable),
    }
    let exposed_ns = rope.exposed_ns();
    for t_ns in [
        0,
        exposed_ns,
        exposed_ns.saturating_add(200_000_000),
        now_ns(),
        u64::MAX,
    ] {
        match rope.predict(t_ns) {
            Ok(ahead) => {
                ask_shape(&ahead.shape());
                black_box(ahead.to_descriptor());
            }
            Err(cause) => assert!(!cause.to_string().is_empty()),
        }
    }
}

/// Makes all queries of a curve.
pub(crate) fn ask_shape(shape: &Shape) {
    let count = shape.control_points().len();
    assert!((1..=MAX_CONTROL_POINTS).contains(&count), "{count}");
    for rho in RHOS {
        black_box((shape.point_at(rho), shape.derivative_at(rho)));
        black_box((shape.tangent_at(rho), shape.normal_at(rho)));
        black_box((shape.curvature_at(rho), shape.covariance_at(rho)));
        assert_eq!(shape.jacobian_at(rho).len(), count);
    }
    for point in POINTS {
        let nearest = shape.nearest(point);
        assert!((0.0..=1.0).contains(&nearest.rho), "{}", nearest.rho);
    }
    black_box(shape.points::<5>());
    let covariance = shape.covariance();
    assert_eq!(covariance.size(), 2 * count);
    black_box((covariance.is_exact(), covariance.block(0, count - 1)));
    let mut matrix = [f64::NAN; 4 * MAX_CONTROL_POINTS * MAX_CONTROL_POINTS];
    covariance.write_to(&mut matrix);
}

/// Makes all queries of a centerline.
pub(crate) fn ask_line(line: Centerline) {
    let count = line.points().len();
    assert!((1..=MAX_POINTS).contains(&count), "{count}");
    assert_eq!(line.widths().len(), count);
    for rho in RHOS {
        black_box(line.point_at(rho));
    }
    for point in POINTS {
        black_box(line.nearest(point));
    }
    for i in [0, count - 1, count, MAX_POINTS, usize::MAX / 2] {
        black_box((line.is_hidden(i), line.rho(i)));
    }
}

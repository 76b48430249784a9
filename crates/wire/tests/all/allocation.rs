//! An open reader does not allocate, whatever arrives and whatever it is asked.

use std::time::{Duration, Instant};

use lariat_test_support::allocations;
use lariat_wire::*;

/// Everything a controller reads in one cycle, summed so that nothing is optimized away.
fn control(reader: &mut Reader, deadline: Option<Instant>) -> f64 {
    let frame = match deadline {
        Some(deadline) => reader.wait(deadline),
        None => reader.latest(),
    };
    let Seen::Fresh(rope) = frame.expect("readable").only_rope(Duration::from_secs(60)) else {
        return 0.0;
    };
    let shape = rope.shape().expect("a curve");
    let ahead = rope.predict(rope.exposed_ns() + 10_000_000);
    let ahead = ahead.map_or(0.0, |ahead| ahead.shape().covariance_at(0.5)[0]);
    let line = rope.centerline().expect("it has points");
    shape.point_at(0.5)[0]
        + shape.nearest([3.0, 4.0]).distance
        + line.point_at(0.5)[0]
        + line.nearest([3.0, 4.0]).rho
        + shape.tangent_at(0.5).map_or(0.0, |t| t[0])
        + shape.curvature_at(0.5).unwrap_or(0.0)
        + shape.jacobian_at(0.5)[0]
        + shape.covariance_at(0.5)[0]
        + ahead
}

#[test]
fn an_open_reader_allocates_nothing() {
    let name = format!("a{}", std::process::id());
    let domain = Domain::named(&name).expect("a domain");
    let rig = Rig::default();
    let mut reader = Reader::open_in(Domain::named(&name).expect("a domain"), &rig).expect("free");
    let writer = Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins)
        .expect("the only writer");
    let mut sum = 0.0;
    let mut allocated = 0;
    for frame in 1..=200u32 {
        let mut slot = writer.slot().expect("a slot");
        slot.trace.extracted = frame.into();
        slot.trace.fitted = frame.into();
        slot.trace.exposed_ns = now_ns();
        slot.trace.fitted_ns = now_ns();
        slot.count = 1;
        let rope = &mut slot.curves[0];
        *rope = Descriptor::EMPTY;
        (rope.degree, rope.count, rope.samples) = (8, 9, 120);
        (rope.filtered, rope.confidence) = (1, 1.0);
        for j in 0..9 {
            rope.control_points[j] = [j as f64, f64::from(frame)];
            rope.velocities[j] = [1.0, 2.0];
            rope.covariances[j] = [0.1, 0.0, 0.1];
        }
        let line = &mut slot.centerlines[0];
        (line.count, line.points[1]) = (2, [3.0, 4.0]);
        slot.send().expect("sent");
        // The transport's allocation for sending does not count.
        let before = allocations();
        if frame % 3 == 0 {
            sum += control(&mut reader, Some(Instant::now() + Duration::from_secs(10)));
            // Nothing arrives, so it sleeps.
            sum += control(&mut reader, Some(Instant::now()));
        }
        sum += control(&mut reader, None);
        sum += control(&mut reader, None);
        // In the first frames the reader connects and computes the control points' correlations.
        if frame > 2 {
            allocated += allocations() - before;
        }
    }
    assert!(sum.is_finite() && sum > 0.0);
    assert_eq!(allocated, 0);
    drop((writer, reader, domain));
    let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{name}"));
}

//! A rope as a chain sends it: nine control points and 120 points, moving a little with each
//! message.

use lariat_wire::{
    Basis, Descriptors, FitQuality, MAX_CONTROL_POINTS, MAX_CURVES, MAX_POINTS, Status, Unit,
};

/// Writes the `count`-th message of a chain that takes no time: all its [timestamps](stamp) are
/// `now_ns`.
pub(crate) fn write(message: &mut Descriptors, count: u64, now_ns: u64) {
    let trace = &mut message.trace;
    (
        trace.sequence,
        trace.captured,
        trace.extracted,
        trace.fitted,
    ) = (count, count, count, count);
    (message.width, message.height, message.count) = (1280, 1024, 1);
    message.unit = Unit::Pixel as u32;
    let (curve, line) = (&mut message.curves[0], &mut message.centerlines[0]);
    (curve.track, curve.basis, curve.degree, curve.count) = (0, Basis::BSpline as u32, 3, 9);
    (curve.samples, curve.status, curve.fit) = (120, Status::Ok as u32, FitQuality::Good as u32);
    (
        curve.rms,
        curve.max,
        curve.length,
        curve.width,
        curve.confidence,
    ) = (0.27, 0.74, 900.0, 12.3, 0.95);
    let swing = (count % 100) as f64;
    let at = |rho: f64| {
        [
            100.0 + 900.0 * rho,
            500.0 + swing * (7.0 * rho).sin() + 3.0 * (91.0 * rho).sin(),
        ]
    };
    for i in 0..9 {
        curve.control_points[i] = at(i as f64 / 8.0);
        curve.covariances[i] = [0.01 + 0.001 * i as f64, 0.0, 0.01];
    }
    for (i, knot) in curve.knots[..5].iter_mut().enumerate() {
        *knot = (i + 1) as f64 / 6.0;
    }
    line.count = 120;
    for i in 0..120 {
        line.points[i] = at(i as f64 / 119.0).map(|c| c as f32);
        line.widths[i] = 12.0 + (i as f32).sin();
    }
    stamp(message, now_ns);
}

/// Writes as many ropes, control points and points as a message holds, more than a datagram can
/// carry.
#[allow(dead_code, reason = "only tests use it")]
pub(crate) fn write_many(message: &mut Descriptors, count: u64, now_ns: u64) {
    write(message, count, now_ns);
    message.count = MAX_CURVES as u32;
    let lists = message.curves.iter_mut().zip(&mut message.centerlines);
    for (at, (curve, line)) in lists.enumerate() {
        (curve.track, curve.basis, curve.degree) = (at as u32, Basis::BSpline as u32, 3);
        (curve.count, curve.samples) = (MAX_CONTROL_POINTS as u32, MAX_POINTS as u32);
        (curve.status, curve.fit) = (Status::Ok as u32, FitQuality::Good as u32);
        for i in 0..MAX_CONTROL_POINTS {
            let along = (i as u64 * 31 + count) as f64;
            curve.control_points[i] = [along, (at as f64 + 1.0) / (along + 1.0)];
            curve.covariances[i] = [0.1 + along.sqrt(), 0.0, 0.1 + along.sqrt()];
            curve.knots[i] = 0.01 + i as f64 / 33.0;
        }
        line.count = MAX_POINTS as u32;
        for i in 0..MAX_POINTS {
            line.points[i] = [i as f32, (i * at) as f32];
            line.widths[i] = 12.0 + (i as f32).sin();
        }
    }
}

/// Stamps a message. The time is also stored in the variance of the residuals, which no bridge
/// changes. From there, a reader on the same machine gets the time to the nanosecond.
pub(crate) fn stamp(message: &mut Descriptors, now_ns: u64) {
    let trace = &mut message.trace;
    (
        trace.exposed_ns,
        trace.captured_ns,
        trace.extract_started_ns,
    ) = (now_ns, now_ns, now_ns);
    (trace.extracted_ns, trace.fit_started_ns, trace.fitted_ns) = (now_ns, now_ns, now_ns);
    message.curves[0].residual_variance = now_ns as f64;
}

/// Returns when a message of this rope was written.
pub(crate) fn written_ns(message: &Descriptors) -> u64 {
    message.curves[0].residual_variance as u64
}

//! A rope as a chain sends it: nine control points and 120 points, a little further each time.

use lariat_wire::{Basis, Descriptors, FitQuality, Status, Unit};

/// Writes the `count`-th message of a chain that was quick: all its [stamps](stamp) are `now_ns`.
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
    (curve.track, curve.basis, curve.order, curve.count) = (0, Basis::BSpline as u32, 3, 9);
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

/// Stamps a message. When that was is also said where no bridge looks, in the residuals' variance, so that a reader on the same machine knows it to the
/// nanosecond.
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

/// When a message of this rope was written.
pub(crate) fn written_ns(message: &Descriptors) -> u64 {
    message.curves[0].residual_variance as u64
}

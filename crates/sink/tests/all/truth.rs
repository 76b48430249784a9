//! Tests of errors relative to a truth at a known distance.

#[allow(dead_code, reason = "each test binary uses a part of it")]
use crate::chain;

use chain::{Chain, centerlines, descriptors, received_ns, straight};
use lariat_message::{Basis, Descriptor, Status, Trace, Unit};
use lariat_sink::{Distances, Errors, Options, Sink};
use std::f64::consts::TAU;

fn sink() -> Sink {
    Sink::new(Options {
        from_start: true,
        ..Options::default()
    })
}

fn errors(sink: &Sink) -> Errors {
    sink.report().summary().error_px
}

fn all(px: f64) -> Distances {
    Distances {
        mean: Some(px),
        p95: Some(px),
        p999: Some(px),
        max: Some(px),
    }
}

/// A straight Bezier curve at this height, along the rope of [`straight`].
fn straight_curve(y: f64) -> [[f64; 2]; 3] {
    [[100.0, y], [159.5, y], [219.0, y]]
}

fn close(found: Option<f64>, expected: f64, tolerance: f64) -> bool {
    found.is_some_and(|found| (found - expected).abs() <= tolerance)
}

#[test]
fn a_curve_beside_the_rope_is_that_far_from_it_whichever_message_comes_first() {
    let truth = |sink: &mut Sink, trace| sink.truth(&centerlines(trace, &[&straight(50.0)]));
    let measured = |sink: &mut Sink, trace: Trace| {
        sink.centerlines(&centerlines(trace, &[&straight(50.5)]));
        let curve = descriptors(trace, &[&straight_curve(49.75)]);
        sink.descriptors(&curve, received_ns(&trace));
    };
    for truth_first in [true, false] {
        let (mut sink, mut chain) = (sink(), Chain::default());
        let traces: Vec<_> = (0..30).filter_map(|_| chain.frame(None)).collect();
        for trace in &traces {
            if truth_first {
                truth(&mut sink, *trace);
            }
            measured(&mut sink, *trace);
        }
        if !truth_first {
            traces.iter().for_each(|trace| truth(&mut sink, *trace));
        }
        assert_eq!(errors(&sink).centerline, all(0.5));
        assert_eq!(errors(&sink).curve, all(0.25));
        assert!(sink.report().to_string().contains("30 frames"));
    }
}

#[test]
fn a_chain_many_frames_behind_still_finds_the_truth() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let traces: Vec<_> = (0..250).filter_map(|_| chain.frame(None)).collect();
    for trace in &traces {
        sink.truth(&centerlines(*trace, &[&straight(50.0)]));
    }
    for trace in &traces {
        sink.centerlines(&centerlines(*trace, &[&straight(50.5)]));
    }
    assert_eq!(errors(&sink).centerline, all(0.5));
    assert!(sink.report().to_string().contains("250 frames"));
}

#[test]
fn mean_p95_and_max_are_over_all_points_of_all_frames() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    for i in 1..=100 {
        let trace = chain.frame(None).unwrap();
        sink.truth(&centerlines(trace, &[&straight(50.0)]));
        let offset_px = i as f32 / 64.0;
        sink.centerlines(&centerlines(trace, &[&straight(50.0 + offset_px)]));
    }
    let found = errors(&sink).centerline;
    assert!(close(found.mean, 50.5 / 64.0, 1e-4), "{found:?}");
    assert!(close(found.p95, 95.0 / 64.0, 1.1e-3), "{found:?}");
    assert!(close(found.p999, 100.0 / 64.0, 1.1e-3), "{found:?}");
    assert!(close(found.max, 100.0 / 64.0, 1e-4), "{found:?}");
}

#[test]
fn a_curve_on_the_rope_that_ends_too_early_is_seen_only_point_by_point() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    sink.truth(&centerlines(trace, &[&straight(50.0)]));
    sink.centerlines(&centerlines(trace, &[&straight(50.0)[..60]]));
    assert_eq!(errors(&sink).centerline, all(0.0));
    let text = sink.report().to_string();
    // The far end is 60 px from the true one.
    let line = text
        .lines()
        .find(|line| line.contains("at the same ρ"))
        .unwrap();
    assert!(line.trim_end().ends_with("60.0"), "{text}");
}

#[test]
fn the_direction_of_a_curve_does_not_matter() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    let mut backwards = straight(50.0);
    backwards.reverse();
    sink.truth(&centerlines(trace, &[&straight(50.0)]));
    sink.centerlines(&centerlines(trace, &[&backwards]));
    let text = sink.report().to_string();
    let line = text
        .lines()
        .find(|line| line.contains("at the same ρ"))
        .unwrap();
    assert_eq!(line.split_whitespace().last(), Some("0"), "{text}");
}

#[test]
fn each_curve_is_held_against_the_rope_it_is_nearest_to() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    let ropes = [50.0, 80.0, 110.0].map(straight);
    sink.truth(&centerlines(trace, &[&ropes[0], &ropes[1], &ropes[2]]));
    let found = [110.5, 50.5, 79.5].map(straight);
    sink.centerlines(&centerlines(trace, &[&found[0], &found[1], &found[2]]));
    sink.descriptors(
        &descriptors(trace, &[&straight_curve(81.0)]),
        received_ns(&trace),
    );
    assert_eq!(errors(&sink).centerline, all(0.5));
    assert_eq!(errors(&sink).curve, all(1.0));
    let text = sink.report().to_string();
    assert!(text.contains("2 ropes had no curve of its own"), "{text}");
}

#[test]
fn a_bezier_curve_is_evaluated_between_its_control_points() {
    // B(ρ) = (100ρ, 100·2ρ(1 − ρ)): a parabola in its power form.
    let control_points = [[0.0, 0.0], [50.0, 100.0], [100.0, 0.0]];
    let parabola: Vec<_> = (0..256)
        .map(|i| {
            let rho = i as f32 / 255.0;
            [100.0 * rho, 200.0 * rho * (1.0 - rho)]
        })
        .collect();
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    sink.truth(&centerlines(trace, &[&parabola]));
    sink.descriptors(&descriptors(trace, &[&control_points]), received_ns(&trace));
    let found = errors(&sink).curve;
    // The polyline of 256 points is at most (h²/8)·|B″| = (1/255²/8)·400 ≈ 0.0008 px inside the
    // parabola.
    assert!(close(found.max, 0.0, 1e-3), "{found:?}");
}

#[test]
fn a_closed_rope_is_closed_in_the_truth_too() {
    let circle = |radius: f64, turn: f64| -> Vec<[f32; 2]> {
        (0..200)
            .map(|i| TAU * (i as f64 / 200.0 + turn))
            .map(|t| [(radius * t.cos()) as f32, (radius * t.sin()) as f32])
            .collect()
    };
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    let mut truth = centerlines(trace, &[&circle(100.0, 0.0)]);
    truth.curves[0].closed = 1;
    let mut measured = centerlines(trace, &[&circle(101.0, 0.3)]);
    measured.curves[0].closed = 1;
    sink.truth(&truth);
    sink.centerlines(&measured);
    let found = errors(&sink).centerline;
    assert!(close(found.mean, 1.0, 0.02), "{found:?}");
    assert!(close(found.max, 1.0, 0.02), "{found:?}");
}

#[test]
fn a_frame_with_a_rope_and_no_curve_is_counted_and_said() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let straight = straight(50.0);
    for missing in [false, true, true] {
        let trace = chain.frame(None).unwrap();
        let found: &[&[[f32; 2]]] = if missing { &[] } else { &[&straight] };
        sink.truth(&centerlines(trace, &[&straight]));
        sink.centerlines(&centerlines(trace, found));
    }
    let text = sink.report().to_string();
    assert!(
        text.contains("2 frames with a rope had no centerline."),
        "{text}"
    );
    assert_eq!(errors(&sink).centerline, all(0.0));
}

#[test]
fn a_lost_rope_s_last_known_shape_is_no_measurement() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    sink.truth(&centerlines(trace, &[&straight(50.0)]));
    let mut message = descriptors(trace, &[&straight_curve(90.0)]);
    message.curves[0].status = Status::Lost as u32;
    sink.descriptors(&message, received_ns(&trace));
    assert_eq!(errors(&sink).curve, Distances::default());
    assert_eq!(sink.frames().with_curve, 0);
    assert!(
        sink.report()
            .to_string()
            .contains("1 frame with a rope had no curve.")
    );
}

#[test]
fn a_curve_where_there_is_no_rope_is_said() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    sink.truth(&centerlines(trace, &[]));
    sink.centerlines(&centerlines(trace, &[&straight(50.0)]));
    assert_eq!(errors(&sink).centerline, Distances::default());
    assert!(
        sink.report()
            .to_string()
            .contains("1 centerline where there is no rope")
    );
}

#[test]
fn coordinates_that_are_no_numbers_are_no_curve() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    let mut broken = straight(50.0);
    broken[7][1] = f32::NAN;
    sink.truth(&centerlines(trace, &[&straight(50.0)]));
    sink.centerlines(&centerlines(trace, &[&broken]));
    let curve = [[0.0, f64::INFINITY], [1.0, 1.0]];
    sink.descriptors(&descriptors(trace, &[&curve]), received_ns(&trace));
    assert_eq!(errors(&sink).centerline, Distances::default());
    assert_eq!(errors(&sink).curve, Distances::default());
}

#[test]
fn a_basis_of_a_later_version_is_not_mistaken_for_one_of_this() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    let mut message = descriptors(trace, &[&straight_curve(50.0)]);
    message.curves[0].basis = 99;
    sink.truth(&centerlines(trace, &[&straight(50.0)]));
    sink.descriptors(&message, received_ns(&trace));
    assert_eq!(errors(&sink).curve, Distances::default());
    assert!(
        sink.report()
            .to_string()
            .contains("1 curve of a kind that this version does not know")
    );
}

/// Returns the mean distance of a curve from the straight rope 5 px below. `change` makes the curve
/// from a straight one.
fn mean_px(change: impl FnOnce(&mut Descriptor)) -> f64 {
    let (mut sink, mut chain) = (sink(), Chain::default());
    let trace = chain.frame(None).unwrap();
    let mut message = descriptors(trace, &[&straight_curve(50.0)]);
    change(&mut message.curves[0]);
    sink.truth(&centerlines(trace, &[&straight(55.0)]));
    sink.descriptors(&message, received_ns(&trace));
    errors(&sink).curve.mean.unwrap()
}

#[test]
fn every_basis_is_drawn_as_what_it_is() {
    let along = |descriptor: &mut Descriptor, shares: &[f64]| {
        let [first, last] = [100.0, 219.0];
        descriptor.count = shares.len() as u32;
        for (point, share) in descriptor.control_points.iter_mut().zip(shares) {
            *point = [first + share * (last - first), 50.0];
        }
    };
    let spline = mean_px(|descriptor| {
        descriptor.basis = Basis::BSpline as u32;
        descriptor.degree = 2;
        descriptor.knots[0] = 0.4;
        along(descriptor, &[0.0, 0.2, 0.7, 1.0]);
    });
    let rational = mean_px(|descriptor| {
        descriptor.basis = Basis::RationalBezier as u32;
        descriptor.degree = 2;
        descriptor.weights[1] = 3.0;
        along(descriptor, &[0.0, 0.5, 1.0]);
    });
    let points = mean_px(|descriptor| {
        descriptor.basis = Basis::FeaturePoints as u32;
        descriptor.degree = 1;
        along(descriptor, &[0.0, 0.3, 1.0]);
    });
    let mass = mean_px(|descriptor| {
        descriptor.basis = Basis::CenterOfMass as u32;
        descriptor.degree = 0;
        along(descriptor, &[0.5]);
    });
    for found in [spline, rational, points, mass] {
        assert!((found - 5.0).abs() < 1e-3, "{found}");
    }
    // a₀, then one harmonic that runs along the rope and back.
    let series = mean_px(|descriptor| {
        descriptor.basis = Basis::Fourier as u32;
        descriptor.degree = 1;
        descriptor.count = 3;
        descriptor.control_points[..3].copy_from_slice(&[[159.5, 50.0], [59.5, 0.0], [0.0, 0.0]]);
    });
    assert!((series - 5.0).abs() < 1e-3, "{series}");
}

#[test]
fn a_source_that_began_again_is_not_held_against_its_old_truth() {
    let mut sink = sink();
    // The truth of a frame that was lost.
    let old = Chain::default().frame(None).unwrap();
    sink.truth(&centerlines(old, &[&straight(300.0)]));
    // The same number an hour later.
    let new = Trace {
        exposed_ns: old.exposed_ns + 3_600_000_000_000,
        ..old
    };
    sink.centerlines(&centerlines(new, &[&straight(50.5)]));
    sink.truth(&centerlines(new, &[&straight(50.0)]));
    assert_eq!(errors(&sink).centerline, all(0.5));
}

#[test]
fn without_truth_there_is_no_error() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    for _ in 0..600 {
        let trace = chain.frame(None).unwrap();
        sink.centerlines(&centerlines(trace, &[&straight(50.0)]));
        sink.descriptors(
            &descriptors(trace, &[&straight_curve(50.0)]),
            received_ns(&trace),
        );
    }
    assert_eq!(errors(&sink).centerline, Distances::default());
    assert!(!sink.report().to_string().contains("error"));
}

#[test]
fn curves_in_millimetres_are_not_held_against_a_truth_in_pixels() {
    let (mut sink, mut chain) = (sink(), Chain::default());
    for trace in (0..30)
        .filter_map(|_| chain.frame(None))
        .collect::<Vec<_>>()
    {
        sink.truth(&centerlines(trace, &[&straight(50.0)]));
        sink.centerlines(&centerlines(trace, &[&straight(50.5)]));
        let mut curve = descriptors(trace, &[&straight_curve(900.0)]);
        curve.unit = Unit::Millimeter as u32;
        sink.descriptors(&curve, received_ns(&trace));
    }
    assert_eq!(errors(&sink).centerline, all(0.5));
    assert_eq!(errors(&sink).curve, Distances::default());
    let table = sink.report().to_string();
    let row = table.lines().find(|line| line.starts_with("  curve"));
    assert!(
        row.is_some_and(|row| row.contains('–') && row.contains("not in the image's pixels")),
        "{table}"
    );
}

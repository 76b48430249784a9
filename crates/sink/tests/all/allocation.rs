//! Tests that a sink allocates nothing for a message after its creation.
use crate::chain::{Chain, PERIOD_NS, Stage, centerlines, descriptors, received_ns, straight};
use lariat_sink::{FinalCounts, Options, Sink};
use lariat_test_support::allocations;

#[test]
fn no_message_allocates() {
    let mut sink = Sink::new(Options {
        period_ns: Some(PERIOD_NS),
        from_start: true,
        ..Options::default()
    });
    let mut chain = Chain::default();
    let ropes: Vec<_> = (0..8).map(|i| straight(50.0 + 20.0 * i as f32)).collect();
    let ropes: Vec<_> = ropes.iter().map(Vec::as_slice).collect();
    let control_points: Vec<_> = (0..32).map(|i| [100.0 + 4.0 * i as f64, 55.0]).collect();
    let curves = [control_points.as_slice(); 8];
    let mut truth = centerlines(lariat_message::Trace::EMPTY, &[]);
    let mut centerlines = centerlines(lariat_message::Trace::EMPTY, &[]);
    let mut descriptors = descriptors(lariat_message::Trace::EMPTY, &[]);
    let full = (
        crate::chain::centerlines(lariat_message::Trace::EMPTY, &ropes),
        crate::chain::descriptors(lariat_message::Trace::EMPTY, &curves),
    );
    let mut before = 0;
    for number in 0..400u64 {
        match number {
            // Warm: the first messages have arrived, and the first line was made.
            10 => before = allocations(),
            // Full messages arrive for the first time when the sink is already warm.
            100 => {
                (truth.count, truth.curves) = (full.0.count, full.0.curves);
                (centerlines.count, centerlines.curves) = (full.0.count, full.0.curves);
                (descriptors.count, descriptors.curves) = (full.1.count, full.1.curves);
            }
            _ => {}
        }
        let lost_before = (number % 7 == 0).then_some(Stage::Fit);
        let Some(trace) = chain.frame(lost_before) else {
            continue;
        };
        (truth.trace, centerlines.trace, descriptors.trace) = (trace, trace, trace);
        if number % 3 != 0 {
            sink.truth(&truth);
        }
        sink.centerlines(&centerlines);
        sink.descriptors(&descriptors, received_ns(&trace));
        if number % 3 == 0 {
            sink.truth(&truth);
        }
        assert!(!sink.live_line(received_ns(&trace) + 1000).is_empty());
    }
    sink.finish(FinalCounts::default());
    assert_eq!(allocations() - before, 0);
    assert!(sink.frames().received > 300);
}

#[test]
fn a_day_of_frames_costs_no_memory_and_each_is_counted() {
    const DAY: u64 = 24 * 3600 * 30;
    let mut sink = Sink::new(Options {
        period_ns: Some(PERIOD_NS),
        from_start: true,
        ..Options::default()
    });
    let mut chain = Chain::default();
    let mut descriptors = descriptors(lariat_message::Trace::EMPTY, &[]);
    let mut lost = 0;
    let mut before = 0;
    for number in 1..=DAY {
        if number == 10 {
            before = allocations();
        }
        let lost_before = number.is_multiple_of(1000).then_some(Stage::Extract);
        let Some(trace) = chain.frame(lost_before) else {
            lost += 1;
            continue;
        };
        descriptors.trace = trace;
        sink.descriptors(&descriptors, received_ns(&trace));
        if number.is_multiple_of(30) {
            sink.live_line(received_ns(&trace));
        }
    }
    assert_eq!(allocations() - before, 0);
    let frames = sink.frames();
    // The last frame of the day is lost, but no later message has shown it yet.
    assert_eq!(
        (frames.received, frames.lost.capture),
        (DAY - lost, lost - 1)
    );
    let total = sink.report().summary().latency_us.total;
    assert_eq!((total.p50, total.max), (Some(360.0), Some(360.0)));
}

//! Tests that every frame is received or lost on exactly one link.

#[allow(dead_code, reason = "each test binary uses a part of it")]
use crate::chain;

use chain::{Chain, Stage, descriptors, received_ns};
use lariat_message::Trace;
use lariat_sink::{AtRestart, DepthCounts, FinalCounts, Frames, Lost, Options, Sink};
use proptest::prelude::*;

fn sink(from_start: bool) -> Sink {
    Sink::new(Options {
        from_start,
        ..Options::default()
    })
}

fn receive(sink: &mut Sink, trace: Trace) {
    sink.descriptors(&descriptors(trace, &[]), received_ns(&trace));
}

fn is_whole(frames: &Frames) -> bool {
    let Lost {
        capture,
        mask,
        extract,
        bridge,
        fit,
        sink,
        source: _,
    } = frames.lost;
    frames.published == frames.received + capture + mask + extract + bridge + fit + sink
}

fn any_stage() -> impl Strategy<Value = Stage> {
    prop::sample::select(Stage::ALL.to_vec())
}

/// Generates the fate of some frames, and the stage that dies before one of them.
fn fates() -> impl Strategy<Value = (Vec<Option<Stage>>, Option<(Stage, usize)>)> {
    let fate = prop::option::weighted(0.4, any_stage());
    let death = prop::option::of((any_stage(), 0usize..120));
    (prop::collection::vec(fate, 0..120), death)
}

/// Returns the stage at which frame `i` is lost: that of its fate, or the dead stage if that comes
/// first.
fn earlier(fate: Option<Stage>, death: Option<(Stage, usize)>, i: usize) -> Option<Stage> {
    let dead = death.filter(|(_, at)| i >= *at).map(|(stage, _)| stage);
    [fate, dead]
        .into_iter()
        .flatten()
        .min_by_key(|stage| *stage as u8)
}

proptest! {
    #[test]
    fn what_each_link_lost_is_exact((fates, death) in fates(), joined in prop::option::of(0usize..40)) {
        let mut chain = Chain::default();
        let mut sink = sink(joined.is_none());
        // Counters of the stages before the first message that the sink received.
        let mut before = joined.is_none().then(Chain::default);
        let mut received = 0;
        for (i, fate) in fates.iter().enumerate() {
            let lost_before = earlier(*fate, death, i);
            let Some(trace) = chain.frame(lost_before) else { continue };
            if joined.is_none_or(|joined| i >= joined) {
                before.get_or_insert(Chain {
                    sequence: trace.sequence - 1,
                    sent: [trace.captured - 1, trace.extracted - 1, trace.fitted - 1, 0],
                });
                received += 1;
                receive(&mut sink, trace);
                prop_assert!(is_whole(&sink.frames()));
            }
        }
        sink.finish(FinalCounts {
            last_sequence: Some(chain.sequence),
            captured: Some(chain.sent[0]),
            extracted: Some(chain.sent[1]),
            fitted: Some(chain.sent[2]),
            ..FinalCounts::default()
        });
        let found = sink.frames();
        prop_assert!(is_whole(&found));
        prop_assert_eq!(found.received, received);
        let Some(before) = before else {
            // A late joiner without a message has nothing to count from.
            prop_assert_eq!(found.published, 0);
            return Ok(());
        };
        let sent = [0, 1, 2].map(|i| chain.sent[i] - before.sent[i]);
        prop_assert_eq!(found.published, sent[0]);
        prop_assert_eq!(found.lost, Lost {
            source: chain.sequence - before.sequence - sent[0],
            capture: sent[0] - sent[1],
            mask: 0,
            extract: sent[1] - sent[2],
            bridge: 0,
            fit: sent[2] - received,
            sink: 0,
        });
    }

    #[test]
    fn a_stage_that_did_not_live_to_say_leaves_the_sum_exact(
        (fates, death) in fates(),
        silent in prop::array::uniform4(any::<bool>()),
    ) {
        let mut chain = Chain::default();
        let mut sink = sink(true);
        let mut received = 0;
        for (i, fate) in fates.into_iter().enumerate() {
            if let Some(trace) = chain.frame(earlier(fate, death, i)) {
                received += 1;
                receive(&mut sink, trace);
            }
        }
        let says = |i: usize, count: u64| (!silent[i]).then_some(count);
        sink.finish(FinalCounts {
            last_sequence: says(0, chain.sequence),
            captured: says(1, chain.sent[0]),
            extracted: says(2, chain.sent[1]),
            fitted: says(3, chain.sent[2]),
            ..FinalCounts::default()
        });
        let found = sink.frames();
        prop_assert!(is_whole(&found));
        prop_assert_eq!(found.received, received);
        prop_assert!(found.published <= chain.sent[0]);
        // The link between two stages that reported is exact, whatever the others did not report.
        if !silent[1] {
            prop_assert_eq!(found.published, chain.sent[0]);
        }
        if !silent[0] && !silent[1] {
            prop_assert_eq!(found.lost.source, chain.sequence - chain.sent[0]);
        }
        if !silent[1] && !silent[2] {
            prop_assert_eq!(found.lost.capture, chain.sent[0] - chain.sent[1]);
        }
        if !silent[2] && !silent[3] {
            prop_assert_eq!(found.lost.extract, chain.sent[1] - chain.sent[2]);
        }
        if !silent[3] {
            prop_assert_eq!(found.lost.fit, chain.sent[2] - received);
        }
    }

    #[test]
    fn restarts_never_make_a_giant_loss(
        fates in prop::collection::vec((prop::option::weighted(0.3, any_stage()), prop::option::weighted(0.05, any_stage())), 1..200),
    ) {
        let mut chain = Chain::default();
        let mut sink = sink(true);
        let mut set_out = 0;
        for (fate, restarted) in fates {
            match restarted {
                Some(Stage::Capture) => chain.sent[0] = 0,
                Some(Stage::Extract) => chain.sent[1] = 0,
                Some(Stage::Fit) => chain.sent[2] = 0,
                Some(Stage::Sink) | None => {}
            }
            set_out += 1;
            if let Some(trace) = chain.frame(fate) {
                receive(&mut sink, trace);
            }
            let found = sink.frames();
            prop_assert!(is_whole(&found));
            prop_assert!(found.published + found.lost.source <= set_out, "{found:?} of {set_out}");
        }
    }

    #[test]
    fn no_counter_whatever_overflows(traces in prop::collection::vec(any::<[u64; 6]>(), 1..20)) {
        let mut sink = sink(true);
        for [sequence, captured, extracted, fitted, bridged, fitted_ns] in traces {
            receive(&mut sink, Trace { sequence, captured, extracted, fitted, bridged, fitted_ns: fitted_ns / 2, ..Trace::EMPTY });
        }
        sink.finish(FinalCounts::default());
        sink.report().to_string();
    }
}

#[test]
fn a_message_that_comes_twice_counts_once() {
    let mut chain = Chain::default();
    let mut sink = sink(true);
    let first = chain.frame(None).unwrap();
    let second = chain.frame(None).unwrap();
    for trace in [first, first, second, first, second] {
        receive(&mut sink, trace);
    }
    let found = sink.frames();
    assert_eq!((found.published, found.received), (2, 2));
    assert_eq!(found.lost, Lost::default());
    assert!(
        sink.report()
            .to_string()
            .contains("3 messages came a second time or late")
    );
}

proptest! {
    #[test]
    fn what_is_lost_over_a_bridge_is_told_from_what_is_lost_behind_it(
        fates in prop::collection::vec((0_u8..4, prop::bool::weighted(0.01)), 1..200),
    ) {
        let mut chain = Chain { sequence: 500, sent: [490, 480, 470, 0] };
        let mut sink = sink(false);
        let (mut bridged, mut pending, mut found) = (0, [0_u64; 2], Lost::default());
        let (mut has_come, mut has_restarted) = (false, false);
        for (fate, is_restart) in fates {
            if is_restart {
                bridged = 0;
                has_restarted = true;
            }
            let mut trace = chain.frame(None).unwrap();
            if fate == 0 {
                pending[0] += 1;
                continue;
            }
            bridged += 1;
            trace.bridged = bridged;
            if fate == 1 {
                pending[1] += 1;
                continue;
            }
            receive(&mut sink, trace);
            if std::mem::replace(&mut has_come, true) {
                found.bridge += pending[0];
                found.fit += pending[1];
            }
            pending = [0; 2];
            prop_assert!(is_whole(&sink.frames()));
            prop_assert_eq!(sink.frames().lost.total(), found.total());
            // The last message of a bridge before its restart is unknown.
            prop_assert!(has_restarted || sink.frames().lost == found);
        }
    }
}

#[test]
fn losses_over_a_bridge_are_exact_and_shown() {
    let mut chain = Chain::default();
    let mut sink = sink(false);
    let mut bridged = 0;
    for number in 0..100 {
        let mut trace = chain.frame(None).unwrap();
        // Every tenth message never arrives, and one that arrives is not read in time. Then the
        // bridge is killed, and five messages are missing.
        if number % 10 == 9 || (60..65).contains(&number) {
            continue;
        }
        bridged = if number == 65 { 1 } else { bridged + 1 };
        trace.bridged = bridged;
        if number != 33 {
            receive(&mut sink, trace);
        }
    }
    let lost = sink.frames().lost;
    // The loss of the last message is not known yet.
    assert_eq!(
        lost,
        Lost {
            bridge: 9 + 5,
            fit: 1,
            ..Lost::default()
        }
    );
    let report = sink.report().to_string();
    let row = report.lines().find(|line| line.contains("over the bridge"));
    assert!(row.is_some_and(|row| row.ends_with(" 14")), "{report}");
}

#[test]
fn an_extract_that_began_again_is_said_and_its_frames_are_counted() {
    let mut chain = Chain::default();
    let mut sink = sink(true);
    for _ in 0..100 {
        receive(&mut sink, chain.frame(None).unwrap());
    }
    // Extract is missing for 30 frames, and then counts from 1 again.
    for _ in 0..30 {
        chain.frame(Some(Stage::Extract));
    }
    chain.sent[1] = 0;
    for _ in 0..50 {
        receive(&mut sink, chain.frame(None).unwrap());
    }
    let report = sink.report();
    assert_eq!(
        report.summary().frames,
        Frames {
            published: 180,
            received: 150,
            with_curve: 0,
            lost: Lost {
                capture: 30,
                ..Lost::default()
            },
            at_restart: AtRestart::default(),
        }
    );
    assert_eq!(report.restarts().extract, 1);
    assert_eq!((report.restarts().capture, report.restarts().fit), (0, 0));
    assert!(report.to_string().contains("extract was restarted 1 time"));
}

#[test]
fn frames_without_an_image_count_and_are_not_timed() {
    let mut chain = Chain::default();
    let mut sink = sink(true);
    for number in 0..30 {
        let trace = chain.frame(None).unwrap();
        let mut message = descriptors(trace, &[]);
        let is_blank = number >= 10;
        if is_blank {
            (message.width, message.height) = (0, 0);
        }
        // Frames with an image arrive a second late, and blank ones are not delayed.
        let late_ns = if is_blank { 0 } else { 1_000_000_000 };
        sink.descriptors(&message, received_ns(&trace) + late_ns);
    }
    let report = sink.report();
    let summary = report.summary();
    assert_eq!(
        (summary.frames.received, summary.frames.lost.total()),
        (30, 0)
    );
    assert!(summary.latency_us.total.p50.is_some_and(|us| us > 1e6));
    assert!(report.to_string().contains("20 frames held no image"));
}

#[test]
fn a_whole_chain_that_began_again_is_counted_on() {
    let mut sink = sink(true);
    let mut chain = Chain::default();
    for _ in 0..10 {
        receive(&mut sink, chain.frame(None).unwrap());
    }
    let mut again = Chain::default();
    for _ in 0..4 {
        let trace = again.frame(None).unwrap();
        let later = 3_600_000_000_000;
        receive(
            &mut sink,
            Trace {
                exposed_ns: trace.exposed_ns + later,
                fitted_ns: trace.fitted_ns + later,
                ..trace
            },
        );
    }
    let found = sink.frames();
    assert_eq!((found.published, found.received), (14, 14));
    assert_eq!(found.lost, Lost::default());
}

#[test]
fn a_dead_fit_s_frames_are_lost_on_the_way_to_it() {
    let mut chain = Chain::default();
    let mut sink = sink(true);
    for _ in 0..20 {
        receive(&mut sink, chain.frame(None).unwrap());
    }
    for _ in 0..3 {
        chain.frame(Some(Stage::Fit));
    }
    sink.finish(FinalCounts {
        last_sequence: Some(23),
        captured: Some(23),
        extracted: Some(23),
        fitted: None,
        ..FinalCounts::default()
    });
    let text = sink.report().to_string();
    assert!(text.contains("fit did not say how many frames it sent"));
    assert!(!text.contains("extract did not say"));
    let found = sink.frames();
    assert_eq!((found.published, found.received), (23, 20));
    assert_eq!(
        found.lost,
        Lost {
            extract: 3,
            ..Lost::default()
        }
    );
}

#[test]
fn frames_whose_masks_came_too_late_are_told_from_those_lost_on_the_way() {
    let mut chain = Chain::default();
    let mut sink = sink(true);
    for number in 0..30 {
        let fate = (number % 3 == 0).then_some(Stage::Extract);
        if let Some(trace) = chain.frame(fate) {
            receive(&mut sink, trace);
        }
    }
    assert_eq!(sink.frames().lost.capture, 10, "as far as is known yet");
    sink.finish(FinalCounts {
        last_sequence: Some(30),
        captured: Some(30),
        extracted: Some(20),
        fitted: Some(20),
        masks_late: Some(7),
        ..FinalCounts::default()
    });
    let found = sink.frames();
    assert!(is_whole(&found));
    assert_eq!((found.lost.capture, found.lost.mask), (3, 7));
    let text = sink.report().to_string();
    assert!(
        text.contains("  lost after it             0       10        0        0\n"),
        "{text}"
    );
    assert!(
        text.contains("    mask too late                    7\n"),
        "{text}"
    );
}

#[test]
fn no_more_masks_are_late_than_frames_are_missing() {
    // A sink that joined late has not seen all frames that extract counted.
    let mut sink = sink(false);
    let mut chain = Chain::default();
    for number in 0..10 {
        let fate = (number == 5).then_some(Stage::Extract);
        if let Some(trace) = chain.frame(fate) {
            receive(&mut sink, trace);
        }
    }
    sink.finish(FinalCounts {
        masks_late: Some(400),
        ..FinalCounts::default()
    });
    let found = sink.frames();
    assert!(is_whole(&found));
    assert_eq!((found.lost.capture, found.lost.mask), (0, 1));
}

#[test]
fn of_frames_from_elsewhere_those_count_that_came_since_the_chain_began() {
    let mut sink = sink(false);
    let mut chain = Chain {
        sequence: 1000,
        sent: [900, 0, 0, 0],
    };
    // Extract skipped three frames before the first message for lack of masks, and two were lost at
    // the source.
    for _ in 0..3 {
        assert!(chain.frame(Some(Stage::Extract)).is_none());
    }
    chain.sequence += 2;
    for _ in 0..10 {
        receive(&mut sink, chain.frame(None).unwrap());
    }
    assert_eq!(sink.frames().published, 10, "as far as is known yet");
    sink.finish(FinalCounts {
        before_first: Some([1000, 900]),
        last_sequence: Some(chain.sequence),
        captured: Some(913),
        extracted: Some(10),
        fitted: Some(10),
        masks_late: Some(3),
        ..FinalCounts::default()
    });
    let found = sink.frames();
    assert!(is_whole(&found));
    assert_eq!((found.published, found.received), (13, 10));
    let (source, mask) = (2, 3);
    let lost = Lost {
        source,
        mask,
        ..Lost::default()
    };
    assert_eq!(found.lost, lost);
    let text = sink.report().to_string();
    assert!(text.contains("Another program wrote the frames"), "{text}");
}

#[test]
fn of_frames_from_elsewhere_that_no_stage_sent_on_all_are_lost() {
    let mut sink = sink(false);
    sink.finish(FinalCounts {
        before_first: Some([10, 10]),
        last_sequence: Some(14),
        captured: Some(14),
        extracted: Some(0),
        fitted: Some(0),
        masks_late: Some(4),
        ..FinalCounts::default()
    });
    let found = sink.frames();
    assert!(is_whole(&found));
    assert_eq!((found.published, found.lost.mask), (4, 4));
}

#[test]
fn a_message_whose_counters_cannot_be_does_not_end_the_counting() {
    let mut chain = Chain::default();
    let mut sink = sink(true);
    let mut frame = |sink: &mut Sink| receive(sink, chain.frame(None).expect("it arrives"));
    (0..3).for_each(|_| frame(&mut sink));
    let poisoned = Trace {
        captured: u64::MAX,
        extracted: u64::MAX,
        fitted: u64::MAX,
        fitted_ns: u64::MAX,
        ..Trace::EMPTY
    };
    sink.descriptors(&descriptors(poisoned, &[]), 1_000_000_000);
    (0..3).for_each(|_| frame(&mut sink));
    assert_eq!(sink.frames().received, 6);
    assert_eq!(sink.frames().lost, Lost::default());
}

/// Extract is restarted by its chain, continues its counter, and reports it. Messages in progress
/// are lost at the restart, on their links.
#[test]
fn what_was_lost_while_a_stage_was_restarted_is_told_apart() {
    let mut chain = Chain::default();
    let mut sink = sink(true);
    let mut restarts = 0;
    for frame in 1..=100 {
        let lost = match frame {
            20 => Some(Stage::Extract),
            50..58 => Some(Stage::Extract),
            58 => Some(Stage::Fit),
            _ => None,
        };
        let trace = chain.frame(lost);
        restarts += u64::from(frame == 58);
        if let Some(mut trace) = trace {
            trace.set_restarts(1, restarts);
            receive(&mut sink, trace);
        }
    }
    let frames = sink.frames();
    assert_eq!((frames.published, frames.received), (100, 90));
    assert_eq!((frames.lost.capture, frames.lost.extract), (9, 1));
    let at_restart = AtRestart {
        capture: 8,
        extract: 1,
        fit: 0,
    };
    assert_eq!(frames.at_restart, at_restart);
    let report = sink.report();
    assert_eq!(report.restarts().extract, 1);
    assert!(report.to_string().contains("at a restart"), "{report}");
    assert!(is_whole(&frames));
}

#[test]
fn frames_and_depth_images_that_did_not_find_each_other_are_in_the_report() {
    let run = || {
        let mut chain = Chain::default();
        let mut sink = sink(true);
        for _ in 0..30 {
            let trace = chain.frame(None).expect("none is lost");
            receive(&mut sink, trace);
        }
        sink
    };
    assert_eq!(run().report().summary().depth, None);
    let counts = FinalCounts {
        last_sequence: Some(30),
        captured: Some(30),
        extracted: Some(30),
        fitted: Some(30),
        depthless: Some(4),
        ..FinalCounts::default()
    };
    let said = |counts| {
        let mut sink = run();
        sink.finish(counts);
        let report = sink.report();
        let lines = report.to_string();
        let words = lines.split_whitespace().collect::<Vec<_>>().join(" ");
        (report.summary().depth.expect("there is depth"), words)
    };
    // The number of images from an external source is unknown.
    let (depth, text) = said(counts);
    assert_eq!((depth.frames_without, depth.images), (Some(4), None));
    assert!(text.contains("4 frames had no depth image"), "{text}");
    assert!(!text.contains("depth camera"), "{text}");
    let depths = DepthCounts {
        images: 31,
        lost: 2,
        unpaired: 5,
    };
    let (depth, text) = said(FinalCounts {
        depths: Some(depths),
        ..counts
    });
    assert_eq!(
        [depth.images, depth.lost, depth.unpaired],
        [31, 2, 5].map(Some)
    );
    assert!(
        text.contains("gave 31 images; 5 of them belonged to no frame; 2 more were lost"),
        "{text}"
    );
    let (_, text) = said(FinalCounts {
        depthless: Some(0),
        depths: Some(DepthCounts {
            images: 30,
            ..DepthCounts::default()
        }),
        ..counts
    });
    assert!(!text.contains("depth"), "{text}");
}

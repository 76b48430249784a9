//! Tests that a sink's state outlives the sink. A tally that was saved and restored gives the same
//! results and continues in the same way. Damaged or incomplete bytes are refused with a sentence.
//! Messages that were not counted between two sinks are lost with the sink.

use crate::chain::{Chain, PERIOD_NS, Stage, centerlines, descriptors, received_ns, straight};
use lariat_message::Trace;
use lariat_sink::{
    FinalCounts, Lost, Machine, Options, Receipt, Report, RestoreError, Sink, Tally,
};
use proptest::prelude::*;

const OPTIONS: Options = Options {
    period_ns: Some(PERIOD_NS),
    deadline_ns: None,
    from_start: true,
};

/// Returns the complete contents of a report as bytes.
fn said(report: &Report) -> Vec<(String, Vec<u8>)> {
    let mut files = report.files().expect("memory takes it");
    let mut timeline = Vec::new();
    report
        .write_timeline(&mut timeline)
        .expect("memory takes it");
    files.push(("timeline".to_owned(), timeline));
    files
}

fn report(tally: &Tally) -> Vec<(String, Vec<u8>)> {
    said(&tally.report_on(machine()))
}

fn machine() -> Machine {
    Machine {
        cpu: None,
        cores: None,
        kernel: "Linux".to_owned(),
        governor: None,
        memory_mb: None,
    }
}

fn saved(tally: &Tally) -> Vec<u8> {
    let mut bytes = vec![7; 3];
    tally.save(&mut bytes);
    bytes.split_off(3)
}

fn counts(tally: &Tally) -> Vec<u8> {
    let mut bytes = Vec::new();
    tally.save_counts(&mut bytes);
    bytes
}

/// The fate of a frame: where it is lost, how late it arrives, and whether its truth is known.
type Fate = (Option<Stage>, u64, bool);

fn fates() -> impl Strategy<Value = Vec<Fate>> {
    let lost = prop::option::weighted(0.2, prop::sample::select(Stage::ALL.to_vec()));
    let late_ns = prop_oneof![Just(0), 0u64..1_000_000, 0u64..200_000_000_000];
    prop::collection::vec((lost, late_ns, any::<bool>()), 0..60)
}

/// Sends frames through a chain to a sink. Returns the receipts for another tally.
fn run(chain: &mut Chain, sink: &mut Sink, fates: &[Fate]) -> Vec<Receipt> {
    let mut receipts = Vec::new();
    for (lost_before, late_ns, is_known) in fates {
        let Some(trace) = chain.frame(*lost_before) else {
            continue;
        };
        if *is_known {
            sink.truth(&centerlines(trace, &[&straight(200.0)]));
            sink.centerlines(&centerlines(trace, &[&straight(200.25)]));
        }
        let curve = [[100.0, 199.5], [159.5, 199.5], [219.0, 199.5]];
        let message = descriptors(trace, &[&curve]);
        receipts.push(sink.descriptors(&message, received_ns(&trace) + late_ns));
    }
    receipts
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_saved_and_read_back_says_the_same_and_goes_on_the_same(before in fates(), after in fates()) {
        let mut chain = Chain::default();
        let mut sink = Sink::new(OPTIONS);
        run(&mut chain, &mut sink, &before);
        let bytes = saved(sink.tally());
        let tally = Tally::restore(OPTIONS, &bytes).expect("whole");
        prop_assert_eq!(report(&tally), report(sink.tally()));
        prop_assert_eq!(saved(&tally), bytes);
        let mut other = Sink::of(tally);
        let mut same = chain;
        run(&mut chain, &mut sink, &after);
        run(&mut same, &mut other, &after);
        prop_assert_eq!(report(other.tally()), report(sink.tally()));
    }

    #[test]
    fn a_tally_that_is_told_the_same_says_the_same(before in fates(), after in fates()) {
        let mut chain = Chain::default();
        let mut sink = Sink::new(OPTIONS);
        run(&mut chain, &mut sink, &before);
        let mut told = sink.tally().clone();
        for receipt in run(&mut chain, &mut sink, &after) {
            told.count(&receipt);
        }
        told.take_comparisons(sink.tally());
        prop_assert_eq!(report(&told), report(sink.tally()));
    }

    #[test]
    fn damaged_bytes_are_refused(before in fates(), place: prop::sample::Index, bit in 0u8..8, cut: prop::sample::Index) {
        let mut sink = Sink::new(OPTIONS);
        run(&mut Chain::default(), &mut sink, &before);
        for bytes in [saved(sink.tally()), counts(sink.tally())] {
            let mut changed = bytes.clone();
            changed[place.index(bytes.len())] ^= 1 << bit;
            let short = &bytes[..cut.index(bytes.len())];
            let long = [&bytes[..], &[0]].concat();
            for damaged in [&changed[..], short, &long] {
                let cause = Tally::restore(OPTIONS, damaged).expect_err("it is refused");
                prop_assert!(cause.to_string().contains("tally"), "{}", cause);
                prop_assert!(Tally::new(OPTIONS).restore_counts(damaged).is_err());
            }
        }
    }

    // The checksum detects damage, so this test corrects it to let damaged bytes through.
    #[test]
    fn no_bytes_whatever_make_a_tally_that_panics(
        before in fates(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut sink = Sink::new(OPTIONS);
        let mut chain = Chain::default();
        run(&mut chain, &mut sink, &before);
        for bytes in [saved(sink.tally()), counts(sink.tally())] {
            let mut body = bytes[..bytes.len() - 4].to_vec();
            for (place, byte) in &changes {
                // Change only bytes after kind and version.
                let length = body.len();
                body[5 + place.index(length - 5)] = *byte;
            }
            let check = crc32fast::hash(&body);
            body.extend(check.to_le_bytes());
            let mut tally = Tally::new(OPTIONS);
            let read = match Tally::restore(OPTIONS, &body) {
                Ok(restored) => { tally = restored; true }
                Err(_) => tally.restore_counts(&body).is_ok(),
            };
            if read {
                let mut sink = Sink::of(tally.resumed());
                run(&mut chain, &mut sink, &before);
                sink.finish(FinalCounts::default());
                said(&sink.report_on(machine()));
            }
        }
    }

    #[test]
    fn every_frame_is_accounted_for_though_the_sink_dies(
        lives in prop::collection::vec((fates(), 0usize..20, 0usize..20), 1..5),
    ) {
        let mut chain = Chain::default();
        let mut tally = Tally::new(OPTIONS);
        let (mut received, mut away) = (0, 0);
        for (number, (fates, unwritten, missed)) in lives.iter().enumerate() {
            if number > 0 {
                tally = tally.resumed();
            }
            let mut sink = Sink::of(tally);
            received += run(&mut chain, &mut sink, fates).len() as u64;
            let written = counts(sink.tally());
            // Messages that the sink received but did not save, and messages that arrived while no
            // sink ran, count the same.
            for _ in 0..unwritten + missed {
                chain.frame(None);
                away += 1;
            }
            tally = Tally::new(OPTIONS);
            tally.restore_counts(&written).expect("whole");
        }
        let mut sink = Sink::of(tally.resumed());
        sink.finish(FinalCounts {
            last_sequence: Some(chain.sequence),
            captured: Some(chain.sent[0]),
            extracted: Some(chain.sent[1]),
            fitted: Some(chain.sent[2]),
            ..FinalCounts::default()
        });
        let found = sink.frames();
        prop_assert_eq!(found.received, received);
        prop_assert_eq!(found.published, chain.sent[0]);
        prop_assert_eq!(found.published, found.received + found.lost.total() - found.lost.source);
        prop_assert!(found.lost.sink >= away, "{:?} of {}", found, away);
        prop_assert_eq!(found.lost.sink + found.lost.fit, chain.sent[2] - received);
    }
}

#[test]
fn what_came_while_there_was_no_sink_is_lost_with_it_and_said() {
    let mut chain = Chain::default();
    let mut sink = Sink::new(OPTIONS);
    let none = (None, 0, false);
    run(&mut chain, &mut sink, &[none; 10]);
    // One frame is lost before the sink, as in normal operation.
    run(
        &mut chain,
        &mut sink,
        &[(Some(Stage::Sink), 0, false), none],
    );
    let mut newest = None;
    for _ in 0..7 {
        newest = chain.frame(None);
    }
    let mut sink = Sink::of(sink.tally().clone().resumed());
    // The service keeps the newest message for late readers. It counts as received, but its age
    // says nothing about the chain.
    let newest: Trace = newest.expect("it arrives");
    let late_ns = 5_000_000_000;
    sink.descriptors(&descriptors(newest, &[]), received_ns(&newest) + late_ns);
    run(&mut chain, &mut sink, &[none; 3]);
    sink.finish(FinalCounts::default());
    let report = sink.report_on(machine());
    let summary = report.summary();
    let lost = Lost {
        fit: 1,
        sink: 6,
        ..Lost::default()
    };
    assert_eq!((summary.frames.received, summary.frames.lost), (15, lost));
    assert_eq!(summary.frames.published, 22);
    assert_eq!(summary.latency_us.total.max, Some(360.0));
    assert_eq!(report.restarts().sink, 1);
    let text = report.to_string();
    assert!(
        text.contains("    with a sink                                        6\n"),
        "{text}"
    );
    assert!(text.contains("sink was restarted 1 time"), "{text}");
}

#[test]
fn the_newest_message_that_the_last_sink_has_counted_is_not_said_to_come_twice() {
    let mut chain = Chain::default();
    let mut sink = Sink::new(OPTIONS);
    run(&mut chain, &mut sink, &[(None, 0, false); 3]);
    let last = chain.sent;
    let mut other = Sink::of(sink.tally().clone().resumed());
    let mut again = Chain {
        sequence: chain.sequence - 1,
        sent: last.map(|count| count - 1),
    };
    run(&mut again, &mut other, &[(None, 0, false); 2]);
    other.finish(FinalCounts::default());
    let report = other.report_on(machine());
    assert_eq!(report.summary().frames.received, 4);
    assert_eq!(report.summary().frames.lost, Lost::default());
    assert!(!report.to_string().contains("a second time"));
}

#[test]
fn a_report_of_a_run_that_goes_on_says_so() {
    let mut sink = Sink::new(OPTIONS);
    let goes_on = sink.report_on(machine());
    assert!(!goes_on.summary().finished);
    assert!(goes_on.to_string().contains("had not ended"), "{goes_on}");
    sink.finish(FinalCounts::default());
    let ended = sink.report_on(machine());
    assert!(ended.summary().finished);
    assert!(!ended.to_string().contains("had not ended"), "{ended}");
}

#[test]
fn why_bytes_are_refused_is_told() {
    let refused = |bytes: &[u8]| Tally::restore(OPTIONS, bytes).expect_err("refused");
    assert_eq!(refused(b""), RestoreError::OfAnother);
    assert_eq!(refused(b"LCNT\x01"), RestoreError::OfAnother);
    let mut newer = saved(&Tally::new(OPTIONS));
    newer[4] += 1;
    assert_eq!(refused(&newer), RestoreError::Version { found: newer[4] });
    newer[4] -= 1;
    newer.pop();
    assert_eq!(refused(&newer), RestoreError::Damaged);
}

#[test]
fn counts_are_saved_into_the_same_buffer_without_an_allocation() {
    let mut sink = Sink::new(OPTIONS);
    let mut chain = Chain::default();
    let mut bytes = Vec::with_capacity(512);
    let message = descriptors(chain.frame(None).expect("it arrives"), &[]);
    let before = lariat_test_support::allocations();
    for _ in 0..100 {
        sink.descriptors(&message, received_ns(&message.trace));
        bytes.clear();
        sink.tally().save_counts(&mut bytes);
    }
    assert_eq!(lariat_test_support::allocations(), before);
    assert!(bytes.len() < 256, "{}", bytes.len());
}

//! Tests of the report: a table for people, a summary for programs, and histograms for plots.

#[allow(dead_code, reason = "each test binary uses a part of it")]
use crate::chain;

use chain::{Chain, PERIOD_NS, Stage, centerlines, descriptors, received_ns, straight};
use lariat_message::Status;
use lariat_sink::{FinalCounts, Machine, Options, Report, Sink};

fn machine() -> Machine {
    Machine {
        cpu: Some("Example 9000 at 3.0 GHz".to_owned()),
        cores: Some(2),
        kernel: "Linux 6.12.0".to_owned(),
        governor: Some("performance".to_owned()),
        memory_mb: Some(4096),
    }
}

fn options() -> Options {
    Options {
        period_ns: Some(PERIOD_NS),
        deadline_ns: None,
        from_start: true,
    }
}

/// Runs a chain for eight seconds: some frames are lost, some late, one is empty, and the truth is
/// known.
fn a_run(options: Options) -> Sink {
    let mut sink = Sink::new(options);
    let mut chain = Chain::default();
    for number in 1..=240u64 {
        let lost_before = match number {
            20 => Some(Stage::Capture),
            50 | 51 => Some(Stage::Extract),
            100 => Some(Stage::Fit),
            200 => Some(Stage::Sink),
            _ => None,
        };
        let Some(mut trace) = chain.frame(lost_before) else {
            continue;
        };
        // Every tenth extraction takes half a millisecond longer, and one takes one and a half
        // frame periods.
        let longer_ns = match number {
            150 => 50_000_000,
            _ if number % 10 == 0 => 500_000,
            _ => number * 100,
        };
        trace.extracted_ns += longer_ns;
        trace.fit_started_ns += longer_ns;
        trace.fitted_ns += longer_ns;
        sink.truth(&centerlines(trace, &[&straight(200.0)]));
        sink.centerlines(&centerlines(trace, &[&straight(200.25)]));
        let curve = [[100.0, 199.5], [159.5, 199.5], [219.0, 199.5]];
        let mut message = descriptors(trace, &[&curve]);
        if number == 77 {
            message.count = 0;
        }
        if number == 78 {
            message.curves[0].status = Status::Lost as u32;
        }
        sink.descriptors(&message, received_ns(&trace));
    }
    sink.finish(FinalCounts {
        last_sequence: Some(chain.sequence),
        captured: Some(chain.sent[0]),
        extracted: Some(chain.sent[1]),
        fitted: Some(chain.sent[2]),
        ..FinalCounts::default()
    });
    sink
}

fn report() -> Report {
    a_run(options()).report_on(machine())
}

#[test]
fn the_table_is_read_in_ten_seconds() {
    insta::assert_snapshot!(report());
}

/// A chain on a machine that is far too slow for it.
#[test]
fn times_of_tenths_of_a_second_and_more_keep_their_columns_apart() {
    let mut sink = Sink::new(options());
    let mut chain = Chain::default();
    for number in 1..=40u64 {
        let mut trace = chain.frame(None).unwrap();
        let longer_ns = number * 37_000_000;
        trace.extracted_ns += longer_ns;
        trace.fit_started_ns += longer_ns;
        trace.fitted_ns += longer_ns;
        sink.descriptors(&descriptors(trace, &[]), received_ns(&trace));
    }
    let table = sink.report_on(machine()).to_string();
    let rows = table
        .lines()
        .skip_while(|line| !line.starts_with("latency"));
    let rows: Vec<&str> = rows.take_while(|line| !line.is_empty()).collect();
    assert_eq!(
        rows[..2],
        [
            "latency, µs              p50     p90     p99   p99.9     max  p50/period",
            "exposed → received    741 ms  1.33 s  1.48 s  1.48 s  1.48 s   2222.46 % ███████",
        ]
    );
    assert!(rows.iter().all(|row| row.chars().count() <= 80), "{table}");
    assert!(
        table.contains("what limits it: extract takes 740 ms a frame"),
        "{table}"
    );
}

#[test]
fn the_summary_has_its_stable_keys() {
    let json = serde_json::to_string_pretty(report().summary()).unwrap();
    insta::assert_snapshot!(json);
}

#[test]
fn a_run_without_a_frame_has_no_figures() {
    let report = Sink::new(Options::default()).report_on(Machine {
        cpu: None,
        cores: None,
        governor: None,
        memory_mb: None,
        ..machine()
    });
    insta::assert_snapshot!(report);
    let json = serde_json::to_string(report.summary()).unwrap();
    insta::assert_snapshot!(json);
}

#[test]
fn the_known_times_of_each_piece_come_out() {
    let mut sink = Sink::new(options());
    let mut chain = Chain::default();
    for _ in 0..100 {
        let trace = chain.frame(None).unwrap();
        sink.descriptors(&descriptors(trace, &[]), received_ns(&trace));
    }
    let report = sink.report_on(machine());
    let latency = &report.summary().latency_us;
    for (spread, us) in [
        (latency.total, 360.0),
        (latency.capture, 40.0),
        (latency.wait_extract, 20.0),
        (latency.extract, 250.0),
        (latency.wait_fit, 15.0),
        (latency.fit, 10.0),
        (latency.wait_sink, 25.0),
    ] {
        let all = [spread.p50, spread.p90, spread.p99, spread.p999, spread.max];
        assert_eq!(all, [Some(us); 5]);
        assert!((spread.mean.unwrap() / us - 1.0).abs() < 1e-3);
    }
    assert_eq!(report.summary().deadline.missed, Some(0));
}

#[test]
fn frames_older_than_the_deadline_have_missed_it() {
    let options = Options {
        deadline_ns: Some(800_000),
        ..options()
    };
    let report = a_run(options).report_on(machine());
    // Every tenth of 240 frames, except 20, 50, 100 and 200, which were lost.
    assert_eq!(report.summary().deadline.missed, Some(20));
    assert_eq!(report.summary().deadline.us, Some(800.0));
    assert_eq!(self::report().summary().deadline.missed, Some(1));
}

#[test]
fn a_timestamp_of_the_future_is_no_latency() {
    let mut sink = Sink::new(options());
    let mut trace = Chain::default().frame(None).unwrap();
    trace.exposed_ns = trace.fitted_ns + 1_000_000_000;
    sink.descriptors(&descriptors(trace, &[]), received_ns(&trace));
    let report = sink.report_on(machine());
    assert_eq!(report.summary().latency_us.capture.max, Some(0.0));
    assert_eq!(report.summary().latency_us.total.max, Some(0.0));
    assert_eq!(report.summary().latency_us.extract.max, Some(250.0));
    assert!(
        report
            .to_string()
            .contains("1 frame had a timestamp before")
    );
}

#[test]
fn a_stamp_that_is_not_known_makes_no_figure() {
    let mut sink = Sink::new(options());
    let mut trace = Chain::default().frame(None).unwrap();
    trace.exposed_ns = 0;
    sink.descriptors(&descriptors(trace, &[]), received_ns(&trace));
    let report = sink.report_on(machine());
    assert_eq!(report.summary().latency_us.total.p50, None);
    assert_eq!(report.summary().latency_us.fit.p50, Some(10.0));
}

#[test]
fn a_frame_longer_under_way_than_the_histograms_reach_is_said() {
    let mut sink = Sink::new(options());
    let trace = Chain::default().frame(None).unwrap();
    sink.descriptors(&descriptors(trace, &[]), trace.fitted_ns + 200_000_000_000);
    let report = sink.report_on(machine());
    assert_eq!(
        report.summary().latency_us.wait_sink.max,
        Some(200_000_000.0)
    );
    assert!(report.to_string().contains("2 times longer than 100 s"));
}

#[test]
fn the_message_that_waited_for_a_late_joiner_is_received_but_not_timed() {
    let mut sink = Sink::new(Options::default());
    let mut chain = Chain {
        sequence: 500,
        sent: [490, 480, 470, 0],
    };
    let old = chain.frame(None).unwrap();
    sink.descriptors(&descriptors(old, &[]), received_ns(&old) + 5_000_000_000);
    let new = chain.frame(None).unwrap();
    sink.descriptors(&descriptors(new, &[]), received_ns(&new) + 5_000_000_000);
    let next = chain.frame(None).unwrap();
    sink.descriptors(&descriptors(next, &[]), received_ns(&next));
    let report = sink.report_on(machine());
    let frames = &report.summary().frames;
    assert_eq!((frames.published, frames.received), (3, 3));
    assert_eq!(frames.lost.total(), 0);
    assert_eq!(report.summary().deadline.us, None);
    let text = report.to_string();
    assert!(
        text.contains("The sink came later than the chain"),
        "{text}"
    );
}

#[test]
fn the_files_hold_the_table_the_summary_and_every_histogram() {
    let report = report();
    let files = report.files().unwrap();
    let mut names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names.last(), Some(&"summary.json"));
    names.sort_unstable();
    assert_eq!(
        names,
        [
            "capture.hgrm",
            "extract.hgrm",
            "fit.hgrm",
            "fitted.hgrm",
            "jitter.hgrm",
            "links.hgrm",
            "overhead.hgrm",
            "report.txt",
            "slowest.txt",
            "summary.json",
            "total.hgrm",
            "wait_extract.hgrm",
            "wait_fit.hgrm",
            "wait_sink.hgrm",
        ]
    );
    let text_of = |wanted: &str| {
        let (_, bytes) = files.iter().find(|(name, _)| name == wanted).unwrap();
        String::from_utf8(bytes.clone()).unwrap()
    };
    assert_eq!(text_of("report.txt"), report.to_string());
    let json: serde_json::Value = serde_json::from_str(&text_of("summary.json")).unwrap();
    assert_eq!(json, serde_json::to_value(report.summary()).unwrap());
    insta::assert_snapshot!(text_of("total.hgrm"));
    insta::assert_snapshot!("slowest", text_of("slowest.txt"));
}

#[test]
fn the_timeline_has_every_frame_that_was_timed() {
    let mut text = Vec::new();
    report().write_timeline(&mut text).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let events = json["traceEvents"].as_array().unwrap();
    let received = events
        .iter()
        .filter(|event| event["ph"] == "X" && event["tid"] == 3);
    assert_eq!(received.count(), 235);
}

#[test]
fn a_stage_slower_than_the_source_is_named_as_what_limits_it() {
    let mut sink = Sink::new(Options {
        period_ns: Some(100_000),
        ..options()
    });
    let trace = Chain::default().frame(None).unwrap();
    sink.descriptors(&descriptors(trace, &[]), received_ns(&trace));
    let table = sink.report_on(machine()).to_string();
    assert!(table.contains("what limits it: extract takes"), "{table}");
    assert!(table.contains("one comes every 100 µs"), "{table}");
}

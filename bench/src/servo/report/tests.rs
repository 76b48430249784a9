//! Tests of the report with invented ropes.

use super::*;
use crate::servo::judge::Moment;

/// Returns a rope that approaches the target with a time scale of `time_s` and remains `end_px`
/// from it.
fn outcome(seed: u64, time_s: f64, end_px: f64) -> Outcome {
    let errors = (0..240).map(|i| {
        let at_s = f64::from(i) / 30.0;
        let error_px = end_px + 80.0 * 0.05f64.powf(at_s / time_s);
        Moment { at_s, error_px }
    });
    Outcome {
        seed,
        errors: errors.collect(),
        doing: String::new(),
    }
}

/// Returns twenty ropes. `fail` of them do not reach the target.
fn row(group: Group, name: &str, value: Option<f64>, time_s: f64, fail: u64) -> Row {
    let one = |seed: u64| {
        let end_px = if seed < fail { 14.0 } else { 0.7 };
        outcome(seed, time_s * (0.8 + 0.02 * seed as f64), end_px)
    };
    Row {
        group,
        name: name.to_owned(),
        value,
        outcomes: (0..20).map(one).collect(),
    }
}

fn study() -> Study {
    let late = |ms: f64, time_s, fail| {
        let name = format!("{ms} ms");
        row(Group::Latency, &name, Some(ms), time_s, fail)
    };
    let rate = |fps: f64, time_s, fail| {
        let name = format!("{fps} frames/s");
        row(Group::FrameRate, &name, Some(fps), time_s, fail)
    };
    Study {
        title: "lariat servo".to_owned(),
        target: "u".to_owned(),
        unit: "px",
        rows: vec![
            row(Group::AsItIs, "as it is", None, 1.5, 0),
            late(100.0, 4.0, 12),
            late(10.0, 1.5, 0),
            late(30.0, 1.6, 1),
            rate(15.0, 1.5, 3),
            rate(30.0, 1.5, 0),
            rate(500.0, 1.4, 0),
            row(Group::Features, "9 control points", None, 1.5, 0),
            row(Group::Features, "9 points < raw", None, 1.6, 0),
            row(Group::Estimator, "Kalman", None, 1.5, 0),
            row(Group::Estimator, "none", None, 1.5, 20),
        ],
        command: "lariat servo --target u --seeds 20".to_owned(),
        parameters: vec![("machine", "two cores".to_owned())],
        own_latency_ms: Some(2.0),
    }
}

#[test]
fn the_table_is_aligned_and_says_what_it_means() {
    let text = table(&study());
    let lines: Vec<&str> = text.lines().collect();
    let width = |line: &str| line.chars().count();
    // The headings take two lines.
    assert!(lines[1].starts_with("to the target u"), "{text}");
    assert!(
        lines[2].starts_with("as it is") && lines[2].contains("  20/20  "),
        "{text}"
    );
    assert_eq!(lines[3], "latency");
    assert_eq!(width(lines[1]), width(lines[2]));
    let latest = lines[4].split_whitespace().collect::<Vec<_>>();
    assert_eq!(latest[..5], ["100", "ms", "8/20", "–", "–"], "{text}");
    assert!(text.contains("\nreached: ropes that"), "{text}");
}

#[test]
fn sentences_follow_the_numbers() {
    let study = study();
    let of = |group| findings::finding(&study, group);
    let late = of(Group::Latency);
    assert!(
        late.starts_with("Up to 30 ms of added latency nothing is lost; at 100 ms 8 of 20 ropes"),
        "{late}"
    );
    assert!(
        late.ends_with("2.00 ms, is 50 times below what hurts."),
        "{late}"
    );
    let rate = of(Group::FrameRate);
    assert!(
        rate.starts_with("Down to 30 frames/s nothing is lost; at 15 frames/s 17 of 20"),
        "{rate}"
    );
    assert!(of(Group::Features).starts_with("It makes little difference: 20 of 20"));
    let estimator = of(Group::Estimator);
    assert!(
        estimator.starts_with("Best is Kalman") && estimator.contains("worst is none: none of 20"),
        "{estimator}"
    );
    assert!(of(Group::AsItIs).starts_with("20 of 20 ropes reach the target"));
}

#[test]
fn what_is_never_lost_or_always_is_said_too() {
    let mut study = study();
    study.rows.retain(|row| row.value != Some(100.0));
    let held = findings::finding(&study, Group::Latency);
    assert!(
        held.starts_with("Up to 30 ms of added latency, the most that was tried, nothing is lost"),
        "{held}"
    );
    assert!(
        held.ends_with("15 times below the most that was tried."),
        "{held}"
    );
    study.rows.retain(|row| row.group == Group::AsItIs);
    for levels in [8.0, 16.0] {
        let row = row(Group::Noise, "noise", Some(levels), 1.5, 20);
        study.rows.push(row);
    }
    let lost = findings::finding(&study, Group::Noise);
    assert!(
        lost.starts_with("Already at noise of 8 levels none of 20")
            && lost.contains("; at 16 levels none"),
        "{lost}"
    );
}

#[test]
fn the_page_is_whole_and_stands_alone() {
    let html = page(&study(), Some(b"GIF89a")).unwrap();
    lariat_plot::check_tags(&html).unwrap();
    assert!(html.contains("data:image/gif;base64,R0lGODlh"));
    assert!(html.contains("9 points &lt; raw") && html.contains("two cores"));
    let addresses = html.matches("http").count();
    assert_eq!(
        addresses,
        html.matches("http://www.w3.org/2000/svg").count()
    );
    assert!(!html.contains("<script") && !html.contains("NaN") && !html.contains("inf"));
}

#[test]
fn what_is_said_of_lifted_ropes_is_in_millimetres() {
    let mut study = study();
    study.unit = "mm";
    for text in [table(&study), page(&study, Some(b"GIF89a")).unwrap()] {
        let words: Vec<&str> = text.split_whitespace().collect();
        assert!(
            words.join(" ").contains("5 mm from it on average"),
            "{text}"
        );
        // The remaining occurrences are sizes in the page's style.
        assert!(!words.contains(&"px") && !words.contains(&"px,"), "{text}");
    }
}

#[test]
fn a_study_of_nothing_is_a_page_too() {
    let mut study = study();
    for row in &mut study.rows {
        row.outcomes
            .truncate(usize::from(row.group == Group::AsItIs));
        row.outcomes
            .iter_mut()
            .for_each(|outcome| outcome.errors.clear());
    }
    lariat_plot::check_tags(&page(&study, None).unwrap()).unwrap();
    assert!(table(&study).contains("0/1"));
    study.rows.clear();
    lariat_plot::check_tags(&page(&study, None).unwrap()).unwrap();
    assert!(table(&study).contains("\nto the target u"));
}

//! Effects of other settings.

use super::Making;
use crate::replay::compare::{Comparison, Race};
use crate::replay::table;
use clap::{Args, Command, FromArgMatches};
use lariat_chain::recorded::RecordedSettings;
use lariat_chain::settings::Flags;

fn compare(made: &Making, flags: &[&str]) -> Comparison {
    let recording = made.make().open();
    let recorded = RecordedSettings::of(&recording).unwrap().unwrap();
    let command = Flags::augment_args(Command::new("run"));
    let words = command.get_matches_from([&["run"], flags].concat());
    let flags = Flags::from_arg_matches(&words).unwrap();
    let settings = recorded.changed(&flags).unwrap();
    let mut race = Race::new(&recorded.settings, &settings, &recording).unwrap();
    race.whole(&recording).unwrap();
    race.finish()
}

#[test]
fn the_same_settings_give_the_same_figures() {
    let made = Making {
        settings: "[fit]\ncontrol_points = 9\n",
        ..Making::default()
    };
    let comparison = compare(&made, &["--control-points=9"]);
    let Comparison {
        against,
        frames,
        recorded,
        now,
        ..
    } = &comparison;
    assert_eq!((*against, *frames), ("truth", 12));
    assert_eq!(recorded.centerline_px, now.centerline_px);
    assert_eq!(recorded.curve_px, now.curve_px);
    assert_eq!(recorded.rms, now.rms);
    assert_eq!((recorded.ropes_ok, now.ropes_ok), (12, 12));
    assert!(now.curve_px.mean.unwrap() < 1.0);
    assert!(now.extract_us.p50.unwrap() > 0.0);
}

#[test]
fn a_lower_order_fits_worse_and_what_was_lost_is_not() {
    let lossy = Making {
        seen: |number| number % 3 != 0,
        ..Making::default()
    };
    let comparison = compare(&lossy, &["--control-points=3"]);
    let Comparison { recorded, now, .. } = &comparison;
    assert!(now.rms > recorded.rms);
    assert!(now.curve_px.mean > recorded.curve_px.mean);
    // The last frame is not counted as lost, because nothing came after it.
    assert_eq!((recorded.lost.capture, now.lost.capture), (3, 0));
    assert_eq!((recorded.frames, now.frames), (8, 12));
    let text = table::text(&comparison);
    let row = text
        .lines()
        .find(|row| row.starts_with("frames lost on the way"));
    let cells: Vec<_> = row.unwrap().split_whitespace().skip(5).collect();
    assert_eq!(cells, ["3", "0", "-3"]);
}

#[test]
fn without_a_truth_curves_are_held_against_the_recorded_ones() {
    let untrue = Making {
        change: &|shot| shot.truth = None,
        ..Making::default()
    };
    let comparison = compare(&untrue, &["--points=60"]);
    assert_eq!(comparison.against, "recorded");
    assert_eq!(comparison.recorded.centerline_px.max, Some(0.0));
    assert!(comparison.now.centerline_px.mean.unwrap() < 0.2);
}

//! What other settings change.

use super::Making;
use crate::recording::RecordedSettings;
use crate::replay::compare::{Comparison, Race};
use crate::replay::table;
use crate::settings::ShapeArgs;

fn compare(made: &Making, shape: ShapeArgs) -> Comparison {
    let recording = made.make().open();
    let recorded = RecordedSettings::of(&recording).unwrap().unwrap();
    let settings = recorded.changed(&shape, false).unwrap();
    let mut race = Race::new(&recorded.settings, &settings, &recording).unwrap();
    race.whole(&recording).unwrap();
    race.finish()
}

#[test]
fn the_same_settings_give_the_same_figures() {
    let same = ShapeArgs {
        order: Some("8".to_owned()),
        ..ShapeArgs::default()
    };
    let comparison = compare(&Making::default(), same);
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
    let lower = ShapeArgs {
        order: Some("2".to_owned()),
        ..ShapeArgs::default()
    };
    let lossy = Making {
        seen: |number| number % 3 != 0,
        ..Making::default()
    };
    let comparison = compare(&lossy, lower);
    let Comparison { recorded, now, .. } = &comparison;
    assert!(now.rms > recorded.rms);
    assert!(now.curve_px.mean > recorded.curve_px.mean);
    // The last one is lost for nobody, as nothing came after it.
    assert_eq!((recorded.lost.capture, now.lost.capture), (3, 0));
    assert_eq!((recorded.frames, now.frames), (8, 12));
    let text = table::text(&comparison);
    assert!(
        text.contains("frames lost on the way                       3           0          -3\n"),
        "{text}"
    );
}

#[test]
fn without_a_truth_curves_are_held_against_the_recorded_ones() {
    let untrue = Making {
        change: &|shot| shot.truth = None,
        ..Making::default()
    };
    let other = ShapeArgs {
        points: Some(60),
        ..ShapeArgs::default()
    };
    let comparison = compare(&untrue, other);
    assert_eq!(comparison.against, "recorded");
    assert_eq!(comparison.recorded.centerline_px.max, Some(0.0));
    assert!(comparison.now.centerline_px.mean.unwrap() < 0.2);
}

//! Differences that a check finds, and recordings that cannot be checked.

use super::{Made, Making};
use crate::replay::check::{Check, Outcome};
use lariat_chain::recorded::RecordedSettings;
use lariat_record::Compression;
use std::time::Duration;

/// Checks a recording, as the command does.
fn check(made: &Made, within_px: Option<f64>) -> anyhow::Result<Outcome> {
    let recording = made.open();
    let recorded = RecordedSettings::of(&recording)?.expect("settings");
    let mut check = Check::new(&recorded, &recording, within_px)?;
    check.whole(&recording)?;
    Ok(check.outcome(Duration::from_secs(1)))
}

fn same(outcome: &Outcome) -> (String, u64, u64) {
    assert!(outcome.difference.is_none(), "{outcome:?}");
    let Outcome {
        rule,
        centerlines,
        descriptors,
        ..
    } = outcome;
    (rule.clone(), *centerlines, *descriptors)
}

/// Error message of a check that cannot be made.
fn impossible(made: &Made) -> String {
    let error = check(made, None).expect_err("it cannot be made");
    format!("{error:#}")
}

const FILTERED: &str = "[fit]\nfilter = true\n";

#[test]
fn a_recording_comes_out_again_to_the_bit() {
    for (settings, images, compression) in [
        ("", "raw", Compression::None),
        (FILTERED, "png", Compression::Lz4),
        (
            "[fit]\nbasis = \"rational\"\ncontrol_points = 4\n",
            "raw",
            Compression::Zstd,
        ),
        (
            "[extract]\nroi = [8, 6, 140, 100]\npoints = 60\n",
            "raw",
            Compression::Lz4,
        ),
    ] {
        let made = Making {
            settings,
            images,
            compression,
            ..Making::default()
        };
        let outcome = check(&made.make(), None).unwrap();
        assert_eq!(same(&outcome), ("bits".to_owned(), 12, 12), "{settings}");
        assert_eq!(outcome.largest_px, 0.0);
    }
}

#[test]
fn what_was_lost_on_the_way_is_not_handed_on_now_either() {
    let made = Making {
        settings: FILTERED,
        seen: |number| number % 3 != 0,
        sent: |number| number % 4 != 0,
        ..Making::default()
    };
    let outcome = check(&made.make(), None).unwrap();
    assert_eq!(same(&outcome), ("bits".to_owned(), 8, 6));
}

#[test]
fn stages_that_were_restarted_are_so_again() {
    let made = Making {
        settings: FILTERED,
        again: Some(5),
        ..Making::default()
    };
    assert_eq!(same(&check(&made.make(), None).unwrap()).1, 12);
}

#[test]
fn masks_that_were_made_elsewhere_are_used_again() {
    // The rope is blue, so its red is low.
    let mask = |bytes: &[u8]| {
        let red = bytes.iter().step_by(3);
        red.map(|&red| if red < 128 { 255 } else { 0 }).collect()
    };
    let settings = "[extract]\nmask = \"external\"\n";
    let with_masks = || Making {
        settings,
        mask: Some(mask),
        ..Making::default()
    };
    assert_eq!(same(&check(&with_masks().make(), None).unwrap()).1, 12);
    let without = Making {
        change: &|shot| {
            if shot.number == 7 {
                shot.mask = None;
            }
        },
        ..with_masks()
    };
    let sentence = impossible(&without.make());
    assert!(
        sentence.contains("extract saw frame 7: its mask was not recorded"),
        "{sentence}"
    );
}

#[test]
fn the_first_number_that_differs_is_shown() {
    let made = Making {
        change: &|shot| {
            let descriptors = shot.descriptors.as_mut().unwrap();
            if shot.number >= 5 {
                let x = &mut descriptors.curves[0].control_points[2][0];
                *x = f64::from_bits(x.to_bits() + 1);
            }
        },
        ..Making::default()
    };
    let outcome = check(&made.make(), None).unwrap();
    let difference = outcome.difference.unwrap();
    assert_eq!(difference.sequence, 5);
    assert_eq!(difference.what, "descriptors");
    assert_eq!(difference.field, "rope 1, control point 2, x");
    assert!(difference.distance > 0.0 && difference.distance < 1e-12);
    assert_eq!((outcome.centerlines, outcome.descriptors), (5, 5));
}

#[test]
fn centerlines_that_differ_are_shown_before_what_follows_from_them() {
    let made = Making {
        change: &|shot| {
            let centerlines = shot.centerlines.as_mut().unwrap();
            if shot.number == 4 {
                centerlines.curves[0].track = 9;
            }
        },
        ..Making::default()
    };
    let difference = check(&made.make(), None).unwrap().difference.unwrap();
    assert_eq!((difference.sequence, difference.what), (4, "centerlines"));
    assert_eq!(difference.field, "rope 1, track");
    assert_eq!(difference.recorded, "9");
}

#[test]
fn another_machine_may_round_otherwise_and_no_more() {
    let by = |offset: f64| {
        let change = move |shot: &mut super::Shot| {
            let descriptors = shot.descriptors.as_mut().unwrap();
            descriptors.curves[0].control_points[1][1] += offset;
        };
        let made = Making {
            cpu: Some("another"),
            change: &change,
            ..Making::default()
        };
        check(&made.make(), None).unwrap()
    };
    let outcome = by(1e-10);
    assert_eq!(same(&outcome).0, "1e-9 px");
    assert!(outcome.largest_px > 0.0);
    assert_eq!(by(1e-8).difference.unwrap().sequence, 1);
}

#[test]
fn what_begins_in_the_middle_of_a_run_is_compared_by_distance_only() {
    let made = Making {
        // A fixed number, because an automatic one depends on the first frame, which is a different
        // one here.
        settings: "[fit]\ncontrol_points = 8\n",
        change: &|shot| {
            if shot.number < 4 {
                (shot.centerlines, shot.descriptors) = (None, None);
                shot.has_frame = false;
            }
        },
        ..Making::default()
    };
    let made = made.make();
    let sentence = impossible(&made);
    assert!(
        sentence.contains("what extract saw before frame 4 is not all in it (--within PX"),
        "{sentence}"
    );
    assert!(sentence.contains("3 messages were before it"), "{sentence}");
    let outcome = check(&made, Some(1.0)).unwrap();
    assert_eq!(same(&outcome), ("1 px".to_owned(), 9, 9));
}

#[test]
fn a_frame_that_is_missing_makes_a_check_impossible() {
    let made = Making {
        change: &|shot| shot.has_frame = shot.number != 6,
        ..Making::default()
    };
    let made = made.make();
    let sentence = impossible(&made);
    assert!(
        sentence.contains("extract saw frame 6: its frame was not recorded"),
        "{sentence}"
    );
    assert_eq!(check(&made, Some(1.0)).unwrap().skipped, 1);

    let made = Making {
        change: &|shot| {
            if shot.number == 6 {
                shot.centerlines = None;
            }
        },
        ..Making::default()
    };
    let sentence = impossible(&made.make());
    assert!(
        sentence.contains("fit was sent centerlines of frame 6"),
        "{sentence}"
    );
}

#[test]
fn jpegs_are_compared_by_distance_only() {
    let made = Making {
        images: "jpeg",
        ..Making::default()
    };
    let made = made.make();
    let sentence = impossible(&made);
    assert!(
        sentence.contains("a JPEG is not the image that extract saw"),
        "{sentence}"
    );
    let outcome = check(&made, Some(0.5)).unwrap();
    assert_eq!(same(&outcome).1, 12);
    assert!(outcome.largest_px > 0.0);
    let outcome = check(&made, Some(1e-6)).unwrap();
    assert_eq!(outcome.difference.unwrap().field, "the ropes' places");
}

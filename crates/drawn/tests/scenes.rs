//! Drawn ropes have the properties of their class and are reproducible.

use lariat_drawn::scenes::{Class, SceneError, Still, draw};

const SIZE: [usize; 2] = [480, 360];

fn still(class: Class, seed: u64) -> Still {
    draw(class, seed, SIZE[0], SIZE[1]).expect("every class fits into this size")
}

#[test]
fn the_same_class_and_seed_are_the_same_picture() {
    for class in [Class::Noise, Class::Touch, Class::Border] {
        assert_eq!(still(class, 7), still(class, 7));
        assert_ne!(still(class, 7).rgb, still(class, 8).rgb);
    }
}

#[test]
fn true_points_are_evenly_spaced_within_the_image() {
    let classes = Class::ALL.into_iter().chain(Class::HARD);
    for class in classes.chain(Class::SHAPES) {
        assert_eq!(class.name().parse(), Ok(class));
        let still = still(class, 3);
        for rope in &still.truth.ropes {
            let wanted_px = rope.length_px / (rope.points.len() - 1) as f64;
            for pair in rope.points.windows(2) {
                let step_px = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
                assert!(
                    (step_px / wanted_px - 1.0).abs() < 0.02,
                    "{class}: {step_px}"
                );
            }
            let is_in = |p: &[f64; 2]| (0..2).all(|k| p[k] > -0.1 && p[k] < SIZE[k] as f64 - 0.9);
            let is_all_in = rope.points.iter().all(is_in);
            assert_eq!(is_all_in, class != Class::Returning, "{class}");
        }
    }
}

#[test]
fn crossings_are_as_many_and_as_steep_as_promised() {
    for seed in 0..4 {
        let counts = [
            Class::Crossings0,
            Class::Crossings1,
            Class::Crossings2,
            Class::Crossings3,
        ];
        for (count, class) in counts.into_iter().enumerate() {
            let crossings = still(class, seed).truth.crossings;
            assert_eq!(crossings.len(), count, "{class} {seed}");
            assert!(
                crossings.iter().all(|c| c.angle_deg > 29.9),
                "{crossings:?}"
            );
        }
        let flat = still(Class::FlatCrossings, seed).truth.crossings;
        let flattest_deg = flat.iter().map(|c| c.angle_deg).fold(90.0, f64::min);
        assert!(
            (19.9..30.1).contains(&flattest_deg),
            "{seed}: {flattest_deg}"
        );
        for class in [Class::Touch, Class::EndsNear, Class::EndsTouching] {
            assert!(still(class, seed).truth.crossings.is_empty());
        }
    }
}

#[test]
fn a_true_crossing_lies_on_both_of_its_strands() {
    for seed in 0..4 {
        let truth = still(Class::Crossings2, seed).truth;
        for crossing in &truth.crossings {
            for (rope, rho) in [crossing.over, crossing.under] {
                let points = &truth.ropes[rope].points;
                let at = points[(rho * (points.len() - 1) as f64).round() as usize];
                let off_px = (at[0] - crossing.at[0]).hypot(at[1] - crossing.at[1]);
                assert!(off_px < 1.0, "{off_px}");
            }
        }
    }
}

#[test]
fn ropes_leave_the_image_and_close_where_they_should() {
    for seed in 0..4 {
        let rope = &still(Class::Border, seed).truth.ropes[0];
        assert_ne!(rope.border, [false; 2]);
        for (end, point) in [(0, rope.points[0]), (1, rope.points[rope.points.len() - 1])] {
            let to = [0, 1].map(|k| point[k].min(SIZE[k] as f64 - 1.0 - point[k]));
            assert_eq!(to[0].min(to[1]) < 0.1, rope.border[end], "{point:?}");
        }
        assert!(still(Class::Closed, seed).truth.ropes[0].closed);
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_with_a_reason() {
    assert_eq!(
        draw(Class::Thin, 1, 100, 400),
        Err(SceneError::Size(100, 400))
    );
    // Five crossings of a rope 7 px wide need room.
    let error = draw(Class::Crossings5, 1, 160, 160).expect_err("there is no room");
    assert!(error.to_string().contains("larger picture"), "{error}");
}

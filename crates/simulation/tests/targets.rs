//! The named shapes can be reached from every start, and have the shape of their name.

use lariat_simulation::{Options, Simulation, TargetShape, at_equal_steps};

const SHAPES: [TargetShape; 3] = [TargetShape::U, TargetShape::S, TargetShape::Line];

fn mean_distance(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let pairs = a.iter().zip(b);
    let sum: f64 = pairs.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum();
    sum / a.len() as f64
}

#[test]
fn every_target_is_reached_from_every_start() {
    for seed in 0..20 {
        // Each shape is tested with a third of the seeds, from the start of another seed.
        let shape = SHAPES[seed as usize % 3];
        let options = Options {
            seed,
            ..Options::default()
        };
        let target = shape.reached(&options, 100).unwrap();
        let elsewhere = Options {
            seed: seed + 100,
            ..options
        };
        let mut simulation = Simulation::new(&elsewhere).unwrap();
        simulation.drive_to(&target.poses);
        let points = at_equal_steps(simulation.visible(), 100);
        let off_px = mean_distance(&points, &target.points);
        assert!(off_px <= 3.0, "{shape:?} {seed}: {off_px}");
    }
}

#[test]
fn targets_are_what_their_names_say() {
    let options = Options::default();
    let [u, s, line] = SHAPES.map(|shape| shape.reached(&options, 101).unwrap().points);
    let height = |points: &[[f64; 2]]| {
        let ys = || points.iter().map(|p| p[1]);
        ys().fold(f64::MIN, f64::max) - ys().fold(f64::MAX, f64::min)
    };
    // Both ends of the U are far above its middle.
    assert!(u[50][1] - u[0][1] > 100.0 && u[50][1] - u[100][1] > 100.0);
    // The S crosses its chord in the middle, and is on opposite sides of it before and after.
    let off_chord = |points: &[[f64; 2]], i: usize| {
        let (a, b, p) = (points[0], points[100], points[i]);
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        (x * (p[1] - a[1]) - y * (p[0] - a[0])) / x.hypot(y)
    };
    assert!(off_chord(&s, 22) > 25.0 && off_chord(&s, 78) < -25.0);
    assert!(off_chord(&s, 50).abs() < 5.0);
    assert!(height(&line) < 60.0 && off_chord(&line, 50).abs() < 25.0);
}

#[test]
fn one_gripper_has_no_targets_and_a_name_that_is_none_is_refused() {
    let options = Options {
        grippers: 1,
        ..Options::default()
    };
    let said = TargetShape::U
        .reached(&options, 10)
        .unwrap_err()
        .to_string();
    assert_eq!(said, "one gripper cannot give a rope a shape: take two");
    assert_eq!("line".parse(), Ok(TargetShape::Line));
    let said = "x".parse::<TargetShape>().unwrap_err().to_string();
    assert_eq!(said, "`x` is not a target: choose u, s or line");
}

//! Closed loops: a servo, a rope, and a camera with a delay.

use crate::support;

use lariat_control::{Doing, Estimator, Metric, Options, Robot, Servo};
use lariat_portable::SplitMix64;
use support::{Fit, Poses, World, bent, distance, linear};

/// A rope of 400 px on the table, with random gripper poses 200 to 320 px apart.
fn held(random: &mut SplitMix64) -> Poses {
    let apart = random.uniform(200.0, 320.0);
    let turn = random.uniform(-0.3, 0.3);
    let a = [random.uniform(150.0, 190.0), random.uniform(210.0, 270.0)];
    let b = [a[0] + apart * f64::cos(turn), a[1] + apart * f64::sin(turn)];
    let [at, bt] = [(); 2].map(|()| random.uniform(-0.9, 0.9));
    [[a[0], a[1], at], [b[0], b[1], bt]]
}

fn options(grippers: usize, estimator: Estimator) -> Options {
    Options::default()
        .robot(Robot::default().grippers(grippers))
        .metric(Metric::bezier(6).expect("a metric"))
        .estimator(estimator)
}

/// Runs at 60 images/s, 35 ms late. The shape is a curve fitted to 60 points with noise of 0.3 px
/// per coordinate, and the rope lags by 0.1 s.
fn reaches(seed: u64, grippers: usize, estimator: Estimator) {
    let mut random = SplitMix64::new(seed);
    let start = held(&mut random);
    let mut goal = held(&mut random);
    if grippers == 1 {
        goal[1] = start[1];
    }
    let target = bent(&goal);
    let mut world = World::new(bent, start, 17);
    (world.delay_ms, world.lag_s) = (35, 0.1);
    (world.noise_px, world.random, world.seen_by) = (0.3, random, Some(Fit::bezier(6, 60)));
    let mut servo = Servo::new(options(grippers, estimator), &target).expect("good options");
    let command = world.run(&mut servo, 20);
    assert_eq!(command.doing, Doing::Arrived, "seed {seed}: {command:?}");
    // The servo stops within 3 px of the curve.
    let left_px = distance(&points(&bent(&world.poses)), &points(&target));
    assert!(left_px < 4.0, "seed {seed}: {left_px}");
}

/// Points of the curve of seven control points.
fn points(shape: &[f64]) -> Vec<f64> {
    let (points, _) = shape.as_chunks::<2>();
    let at = |rho: f64| {
        let mut points = points.to_vec();
        while points.len() > 1 {
            let pairs = points.windows(2);
            points = pairs
                .map(|p| [0, 1].map(|c| p[0][c] + rho * (p[1][c] - p[0][c])))
                .collect();
        }
        points[0]
    };
    (0..50).flat_map(|i| at(i as f64 / 49.0)).collect()
}

#[test]
fn one_gripper_drives_a_bent_rope_to_its_target_from_twenty_starts() {
    for seed in 0..20 {
        reaches(seed, 1, Estimator::default());
        reaches(seed, 1, Estimator::BROYDEN);
    }
}

#[test]
fn two_grippers_drive_a_bent_rope_to_its_target_from_twenty_starts() {
    for seed in 100..120 {
        reaches(seed, 2, Estimator::default());
        reaches(seed, 2, Estimator::BROYDEN);
    }
}

/// The rope's Jacobian, by differences of the formula.
fn by_differences(poses: &Poses) -> Vec<[[f64; 3]; 2]> {
    let size = bent(poses).len();
    let mut rows = vec![[[0.0; 3]; 2]; size];
    for gripper in 0..2 {
        for axis in 0..3 {
            let moved = |by: f64| {
                let mut poses = *poses;
                poses[gripper][axis] += by;
                bent(&poses)
            };
            let (before, after) = (moved(-1e-4), moved(1e-4));
            for (row, (a, b)) in rows.iter_mut().zip(after.iter().zip(&before)) {
                row[gripper][axis] = (a - b) / 2e-4;
            }
        }
    }
    rows
}

/// Root sum of squares of all entries, with turns scaled by their lever of 100 px.
fn size(rows: &[[[f64; 3]; 2]]) -> f64 {
    let scaled = rows
        .iter()
        .flatten()
        .map(|[x, y, t]| x * x + y * y + t * t / 1e4);
    scaled.sum::<f64>().sqrt()
}

/// While steering, only the current motion is observed. The test therefore compares the response to
/// that motion with the formula.
#[test]
fn on_the_way_the_jacobian_is_that_of_the_rope() {
    for estimator in [Estimator::default(), Estimator::BROYDEN] {
        let mut random = SplitMix64::new(42);
        let (start, goal) = (held(&mut random), held(&mut random));
        let mut world = World::new(bent, start, 17);
        (world.delay_ms, world.noise_px) = (35, 0.1);
        let mut servo = Servo::new(options(2, estimator), &bent(&goal)).expect("good options");
        let (mut checked, mut worst, mut mean) = (0, 0.0f64, 0.0);
        for _ in 0..2000 {
            let command = world.turn(&mut servo);
            if command.doing == Doing::Arrived {
                break;
            }
            let moves = command
                .velocities
                .as_flattened()
                .iter()
                .any(|v| v.abs() > 5.0);
            if command.doing != Doing::Steering || !moves {
                continue;
            }
            let truth = by_differences(&world.poses);
            let (mut off, mut all) = (0.0, 0.0);
            for (feature, truth) in truth.iter().enumerate() {
                let known = servo.jacobian(feature).expect("steering");
                let answer = |row: &[[f64; 3]; 2]| -> f64 {
                    let pairs = row.as_flattened().iter();
                    pairs
                        .zip(command.velocities.as_flattened())
                        .map(|(j, v)| j * v)
                        .sum()
                };
                off += (answer(&known) - answer(truth)).powi(2);
                all += answer(truth).powi(2);
            }
            let error = (off / all).sqrt();
            worst = worst.max(error);
            mean += error;
            checked += 1;
        }
        mean /= f64::from(checked);
        println!("{estimator:?}: {checked} checked, mean {mean:.3}, worst {worst:.3}");
        assert!(checked > 50);
        assert!(
            mean < 0.15 && worst < 0.5,
            "{estimator:?}: mean {mean}, worst {worst}"
        );
    }
}

/// Explores at one place without noise. The remaining error is the nonlinearity of the response
/// over 15 px and 0.15 rad.
#[test]
fn exploring_finds_the_jacobian_of_a_bent_rope() {
    let mut random = SplitMix64::new(9);
    let (start, goal) = (held(&mut random), held(&mut random));
    let mut world = World::new(bent, start, 17);
    world.delay_ms = 35;
    let mut servo =
        Servo::new(options(2, Estimator::default()), &bent(&goal)).expect("good options");
    while !matches!(world.turn(&mut servo).doing, Doing::Steering) {
        assert!(world.now_ns() < 20_000_000_000);
    }
    let truth = by_differences(&start);
    let known: Vec<_> = (0..truth.len())
        .map(|k| servo.jacobian(k).expect("explored"))
        .collect();
    let off: Vec<_> = known
        .iter()
        .zip(&truth)
        .map(|(a, b)| [0, 1].map(|g| [0, 1, 2].map(|c| a[g][c] - b[g][c])))
        .collect();
    let error = size(&off) / size(&truth);
    println!("explored to {error:.3} of the whole");
    assert!(error < 0.1, "{error}");
}

/// Returns the overshoot of a loop as a share of its way, and the final distance after 5 s.
fn overshoot(look_ahead: bool) -> (f64, f64) {
    let mut world = World::new(linear, [[100.0, 50.0, 0.0]; 2], 10);
    world.delay_ms = 100;
    let goal = [[220.0, 110.0, 0.3], [0.0; 3]];
    let target = linear(&goal);
    let options = Options::default()
        .robot(
            Robot::default()
                // No limit saturates, so only the law acts.
                .speeds([1e5; 3]),
        )
        .gain(8.0)
        .damping(0.0)
        .tolerance_px(1e-3)
        .ramp_s(0.0)
        .look_ahead(look_ahead)
        // Keeps the known Jacobian.
        .estimator(Estimator::Kalman { drift: 0.0 });
    let mut servo = Servo::new(options, &target).expect("good options");
    let origin = linear(&[[0.0; 3]; 2]);
    let mut rows = vec![[[0.0; 3]; 2]; target.len()];
    for axis in 0..3 {
        let mut poses = [[0.0; 3]; 2];
        poses[0][axis] = 1.0;
        for (row, (a, b)) in rows.iter_mut().zip(linear(&poses).iter().zip(&origin)) {
            row[0][axis] = a - b;
        }
    }
    servo.know(&rows).expect("a row each");
    let way: f64 = goal[0][0] - world.poses[0][0];
    let mut beyond = 0.0f64;
    while world.now_ns() < 5_000_000_000 {
        world.turn(&mut servo);
        beyond = beyond.max((world.poses[0][0] - goal[0][0]) / way);
    }
    (beyond, distance(&linear(&world.poses), &target))
}

/// Overshoot beyond 0 of ė = −λe(t − T), starting from 1, in steps of T/10⁴.
fn overshoot_of_a_delay(lambda_t: f64) -> f64 {
    let steps = 10_000;
    let mut e = vec![1.0; steps + 1];
    for k in 0..5 * steps {
        e.push(e[k + steps] - lambda_t / steps as f64 * e[k]);
    }
    e.iter().fold(0.0, |beyond, e| beyond.max(-e))
}

/// T is 100 ms plus half of a command's period of 10 ms, so λT = 0.84, for which theory predicts an
/// overshoot of 34 %.
#[test]
fn looking_ahead_takes_away_the_overshoot_of_a_delay() {
    let theory = overshoot_of_a_delay(8.0 * 0.105);
    let (without, left_without) = overshoot(false);
    let (with, left_with) = overshoot(true);
    println!(
        "overshoot: {theory:.3} in theory, {without:.3} without looking ahead, {with:.5} with it"
    );
    assert!((without - theory).abs() < 0.01, "{without} {theory}");
    assert!(with < 1e-3, "{with}");
    assert!(left_with < 0.01 && left_without < 0.01);
}

//! When a servo holds, and how it resumes.

use crate::support;

use lariat_control::{Doing, Exploring, Observation, Options, Robot, Servo, Weights, Why};
use support::{World, linear};

const START: [[f64; 3]; 2] = [[100.0, 50.0, 0.0], [0.0; 3]];
const GOAL: [[f64; 3]; 2] = [[220.0, 110.0, 0.3], [0.0; 3]];

fn servo(options: Options) -> Servo {
    Servo::new(options, &linear(&GOAL)).expect("good options")
}

/// Runs until exploration is over and the servo moves at speed.
fn steering(world: &mut World, servo: &mut Servo) {
    for _ in 0..2000 {
        let command = world.turn(servo);
        if command.doing == Doing::Steering && speed(&command.velocities) > 20.0 {
            return;
        }
    }
    panic!("it never steers");
}

fn speed(velocities: &[[f64; 3]; 2]) -> f64 {
    velocities[0][0].abs().max(velocities[0][1].abs())
}

#[test]
fn a_lost_rope_is_held_in_the_very_call_and_steered_to_its_end_when_it_comes_again() {
    let mut world = World::new(linear, START, 16);
    let mut servo = servo(Options::default());
    steering(&mut world, &mut servo);
    for _ in 0..60 {
        let (_, _) = world.image();
        let command = servo.hold(Why::Lost, world.now_ns());
        assert_eq!(command.velocities, [[0.0; 3]; 2]);
        assert_eq!(command.doing, Doing::Holding { why: Why::Lost });
        assert!(command.error_px.is_some());
        world.obey(&command);
    }
    // The speed returns over 0.3 s, so no frame adds more than 16/300 of the full speed.
    let mut before = 0.0;
    for _ in 0..15 {
        let now = speed(&world.turn(&mut servo).velocities);
        assert!(now - before < 100.0 * 16.5 / 300.0, "{before} {now}");
        before = now;
    }
    assert!(before > 20.0, "{before}");
    assert_eq!(world.run(&mut servo, 30).doing, Doing::Arrived);
}

#[test]
fn an_image_too_old_is_held_by_in_the_very_call() {
    let mut world = World::new(linear, START, 16);
    let mut servo = servo(Options::default());
    steering(&mut world, &mut servo);
    let (exposed_ns, shape) = world.image();
    let command = servo.see(
        Observation::new(&shape, exposed_ns),
        exposed_ns + 500_000_001,
    );
    assert_eq!(command.doing, Doing::Holding { why: Why::Stale });
    assert_eq!(command.velocities, [[0.0; 3]; 2]);
}

#[test]
fn exploring_goes_on_where_a_hold_broke_it_off() {
    let mut world = World::new(linear, START, 16);
    let mut servo = servo(Options::default());
    // The rope is visible a third of the time, mostly within the ramp after a hold.
    for turn in 0..6000 {
        if turn % 30 < 20 {
            world.image();
            let command = servo.hold(Why::Lost, world.now_ns());
            world.obey(&command);
        } else if world.turn(&mut servo).doing == Doing::Arrived {
            return;
        }
    }
    panic!("it never arrives");
}

#[test]
fn a_covered_rope_is_steered_at_half_the_speed_or_held_and_never_explored() {
    for hold_on_partial in [false, true] {
        let mut world = World::new(linear, START, 16);
        let mut servo = servo(
            Options::default()
                .hold_on_partial(hold_on_partial)
                // Commands full speed all the way.
                .gain(100.0),
        );
        let (exposed_ns, shape) = world.image();
        let partial = |shape, exposed_ns| Observation {
            partial: true,
            ..Observation::new(shape, exposed_ns)
        };
        let command = servo.see(partial(&shape, exposed_ns), world.now_ns());
        assert_eq!(command.doing, Doing::Holding { why: Why::Partial });
        steering(&mut world, &mut servo);
        for _ in 0..30 {
            world.turn(&mut servo);
        }
        let (exposed_ns, shape) = world.image();
        let whole = servo
            .clone()
            .see(Observation::new(&shape, exposed_ns), world.now_ns());
        let command = servo.see(partial(&shape, exposed_ns), world.now_ns());
        if hold_on_partial {
            assert_eq!(command.doing, Doing::Holding { why: Why::Partial });
        } else {
            assert!((speed(&command.velocities) / speed(&whole.velocities) - 0.5).abs() < 1e-9);
        }
    }
}

#[test]
fn what_is_no_shape_is_held_by_with_its_reason() {
    let mut world = World::new(linear, START, 16);
    let mut servo = servo(Options::default());
    steering(&mut world, &mut servo);
    let (exposed_ns, shape) = world.image();
    let now_ns = world.now_ns();
    let with = |value: f64| {
        let mut shape = shape.clone();
        shape[3] = value;
        shape
    };
    for value in [f64::NAN, f64::INFINITY, -1e7] {
        let shape = with(value);
        let command = servo.see(Observation::new(&shape, exposed_ns), now_ns);
        assert_eq!(
            command.doing,
            Doing::Holding {
                why: Why::NotAShape
            }
        );
    }
    let command = servo.see(Observation::new(&shape[..4], exposed_ns), now_ns);
    let why = Why::Size {
        given: 4,
        expected: 6,
    };
    assert_eq!(command.doing, Doing::Holding { why });
    let weights = Weights::Points(&[1.0, f64::NAN, 1.0]);
    let observation = Observation {
        weights,
        ..Observation::new(&shape, exposed_ns)
    };
    assert_eq!(
        servo.see(observation, now_ns).doing,
        Doing::Holding { why: Why::Weights }
    );
    for (exposed_ns, now_ns) in [(now_ns + 1, now_ns), (exposed_ns, now_ns - 1), (0, now_ns)] {
        let command = servo.see(Observation::new(&shape, exposed_ns), now_ns);
        assert_eq!(command.doing, Doing::Holding { why: Why::Clock });
        assert_eq!(command.velocities, [[0.0; 3]; 2]);
    }
    // The invalid shapes have done no harm.
    assert_eq!(world.run(&mut servo, 30).doing, Doing::Arrived);
}

#[test]
fn a_target_that_runs_the_other_way_is_turned_around() {
    let mut target: Vec<f64> = Vec::new();
    for point in linear(&GOAL).chunks(2).rev() {
        target.extend(point);
    }
    let mut world = World::new(linear, START, 16);
    let mut turned = Servo::new(Options::default(), &target).expect("good options");
    assert_eq!(world.run(&mut turned, 30).doing, Doing::Arrived);
    assert!(
        (world.poses[0][0] - GOAL[0][0]).abs() < 5.0,
        "{:?}",
        world.poses
    );

    let mut world = World::new(linear, START, 16);
    let options = Options::default().either_way(false);
    let mut kept = Servo::new(options, &target).expect("good options");
    assert_ne!(world.run(&mut kept, 30).doing, Doing::Arrived);
}

#[test]
fn an_arrived_servo_stands_until_the_shape_has_left_the_tolerance_by_half() {
    let mut world = World::new(linear, START, 16);
    let mut servo = servo(Options::default());
    assert_eq!(world.run(&mut servo, 30).doing, Doing::Arrived);
    let target = linear(&GOAL);
    let mut offs = vec![
        (2.9, Doing::Arrived),
        (3.1, Doing::Steering),
        (2.1, Doing::Steering),
    ];
    // 0.2 s are a dozen images at 16 ms. Until then, the servo stands and waits.
    offs.extend([(1.9, Doing::Steering); 13]);
    offs.push((2.9, Doing::Arrived));
    for (off, doing) in offs {
        let (exposed_ns, _) = world.image();
        // Shifts every point by the same amount along x.
        let shape: Vec<f64> = target
            .iter()
            .enumerate()
            .map(|(k, c)| c + if k % 2 == 0 { off } else { 0.0 })
            .collect();
        let command = servo.see(Observation::new(&shape, exposed_ns), world.now_ns());
        assert_eq!(command.doing, doing, "{off}");
        assert!((command.error_px.expect("seen") - off).abs() < 1e-9);
    }
}

#[test]
fn a_rope_that_does_not_answer_is_explored_a_few_times_more_and_then_waited_for() {
    let mut world = World::new(|_| linear(&START), START, 16);
    let exploring = Exploring::default().again(2);
    let mut servo = servo(Options::default().exploring(exploring));
    let mut begun = 0;
    let mut before = Doing::Steering;
    while world.now_ns() < 20_000_000_000 {
        let doing = world.turn(&mut servo).doing;
        begun += u32::from(
            doing
                == (Doing::Exploring {
                    gripper: 1,
                    axis: "x",
                })
                && before == Doing::Steering,
        );
        before = doing;
    }
    assert_eq!((begun, before), (3, Doing::Steering));
}

#[test]
fn a_robot_that_says_where_it_is_is_believed() {
    let robot = Robot::default().start(START);
    let mut world = World::new(linear, START, 16);
    let mut servo = servo(Options::default().robot(robot));
    // The robot moves only half as far as commanded.
    for _ in 0..2000 {
        servo.robot_is_at(&world.poses, world.now_ns());
        let mut command = world.turn(&mut servo);
        if command.doing == Doing::Arrived {
            let poses = servo.poses(world.now_ns());
            assert!(
                (poses[0][0] - world.poses[0][0]).abs() < 1.0,
                "{poses:?} {:?}",
                world.poses
            );
            return;
        }
        command
            .velocities
            .as_flattened_mut()
            .iter_mut()
            .for_each(|v| *v *= 0.5);
        world.obey(&command);
    }
    panic!("it never arrives");
}

/// With 15 images/s and 1000 commands/s, the servo uses the predicted shape between two images, and
/// learns from each image once.
#[test]
fn a_robot_with_a_faster_beat_than_the_camera_is_given_commands_between_images() {
    let mut world = World::new(linear, START, 1);
    let mut servo = servo(Options::default());
    let mut last = world.image();
    for turn in 0..15_000 {
        let image = world.image();
        if turn % 67 == 0 {
            last = image;
        }
        let command = servo.see(Observation::new(&last.1, last.0), world.now_ns());
        world.obey(&command);
        if command.doing == Doing::Arrived {
            return;
        }
    }
    panic!("it never arrives");
}

#[test]
fn another_target_is_steered_to_at_once() {
    let mut world = World::new(linear, START, 16);
    let mut servo = servo(Options::default());
    assert_eq!(world.run(&mut servo, 30).doing, Doing::Arrived);
    servo.aim(&linear(&START)).expect("as many points");
    for _ in 0..600 {
        let doing = world.turn(&mut servo).doing;
        assert!(matches!(doing, Doing::Steering | Doing::Arrived), "{doing}");
        if doing == Doing::Arrived {
            return;
        }
    }
    panic!("it never arrives");
}

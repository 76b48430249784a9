//! No command exceeds the robot's limits, whatever the servo receives.

use crate::support;

use lariat_control::{
    Doing, Estimator, Observation, Options, Robot, Servo, Weights, Why, Workspace,
};
use proptest::prelude::*;
use support::{World, bent, linear};

/// Numbers as they may come from other software, including invalid ones.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -500.0..500.0f64,
        1 => -1e6..1e6f64,
        1 => any::<f64>(),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(0.0),
    ]
}

#[derive(Debug, Clone)]
enum Event {
    See {
        shape: Vec<f64>,
        weights: Vec<f64>,
        late_ms: u64,
        partial: bool,
    },
    /// A possible shape, so that the servo makes progress.
    Believe {
        by: [f64; 6],
    },
    Hold,
    Robot([f64; 3], u64),
    Aim(Vec<f64>),
    Clock(u64),
}

fn event() -> impl Strategy<Value = Event> {
    let shape = || prop::collection::vec(number(), 6);
    let some = prop::collection::vec(number(), 0..9);
    let weights = prop_oneof![Just(vec![]), prop::collection::vec(number(), 3)];
    prop_oneof![
        2 => (prop_oneof![4 => shape(), 1 => some], weights, 0..700u64, any::<bool>())
            .prop_map(|(shape, weights, late_ms, partial)| Event::See { shape, weights, late_ms, partial }),
        12 => prop::array::uniform6(-400.0..400.0f64).prop_map(|by| Event::Believe { by }),
        1 => Just(Event::Hold),
        1 => (prop::array::uniform3(number()), any::<u64>()).prop_map(|(r, t)| Event::Robot(r, t)),
        1 => shape().prop_map(Event::Aim),
        1 => any::<u64>().prop_map(Event::Clock),
    ]
}

fn robot() -> impl Strategy<Value = Robot> {
    let speed = prop_oneof![Just(0.0), 1e-3..1e3f64, Just(1e5)];
    (
        1..=2usize,
        prop::array::uniform3(speed),
        prop::option::of(prop::array::uniform3(1e-3..1e4f64)),
        prop_oneof![Just(f64::INFINITY), 0.0..300.0f64],
        1.0..1e4f64,
        0.0..0.3f64,
        any::<bool>(),
    )
        .prop_filter("something moves", |(_, speeds, ..)| *speeds != [0.0; 3])
        .prop_map(
            |(grippers, speeds, accelerations, longest_apart_px, lever_px, delay_s, boxed)| {
                let boxed = if boxed {
                    Workspace {
                        least: [-30.0, -30.0, -0.5],
                        most: [60.0, 40.0, 0.4],
                    }
                } else {
                    Workspace::ANYWHERE
                };
                Robot::default()
                    .grippers(grippers)
                    .speeds(speeds)
                    .accelerations(accelerations)
                    .workspaces([boxed; 2])
                    .longest_apart_px(longest_apart_px)
                    .lever_px(lever_px)
                    .delay_s(delay_s)
            },
        )
}

fn feed(servo: &mut Servo, event: &Event, now_ns: &mut u64) -> Option<lariat_control::Command> {
    *now_ns += 16_000_000;
    match event {
        Event::See {
            shape,
            weights,
            late_ms,
            partial,
        } => {
            let covariances: Vec<[f64; 3]> =
                weights.iter().map(|w| [*w, 0.5 * w, 2.0 * w]).collect();
            let weights = match weights.len() {
                0 => Weights::Even,
                _ if *partial => Weights::Covariances(&covariances),
                _ => Weights::Points(weights),
            };
            let exposed_ns = now_ns.saturating_sub(late_ms * 1_000_000);
            let seen = Observation {
                features: shape,
                weights,
                exposed_ns,
                partial: *partial,
            };
            Some(servo.see(seen, *now_ns))
        }
        Event::Believe { by } => Some(servo.see(Observation::new(by, *now_ns), *now_ns)),
        Event::Hold => Some(servo.hold(Why::Lost, *now_ns)),
        Event::Robot(r, at_ns) => {
            servo.robot_is_at(&[*r; 2], *at_ns);
            None
        }
        Event::Aim(target) => {
            let _ = servo.aim(target);
            None
        }
        // Time goes back once, and the next event is on time again.
        Event::Clock(t) => Some(servo.hold(Why::Stale, *now_ns - t % 100_000_000)),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn whatever_it_is_fed_no_velocity_is_above_its_limit(
        robot in robot(),
        gain in 1e-3..100.0f64,
        damping in 0.0..1.0f64,
        broyden in any::<bool>(),
        known in prop::option::of(prop::collection::vec(prop::array::uniform2(prop::array::uniform3(-3.0..3.0f64)), 6)),
        events in prop::collection::vec(event(), 1..80),
    ) {
        let estimator = if broyden { Estimator::BROYDEN } else { Estimator::default() };
        let options = Options::default().robot(robot).gain(gain).damping(damping).estimator(estimator).ramp_s(0.0);
        let mut servo = Servo::new(options, &[0.0, 0.0, 50.0, 20.0, 100.0, 0.0]).expect("good options");
        if let Some(rows) = known {
            servo.know(&rows).expect("a row each");
        }
        let mut now_ns = 1_000_000_000;
        let mut before: Option<([[f64; 3]; 2], u64)> = None;
        for event in &events {
            let Some(command) = feed(&mut servo, event, &mut now_ns) else { continue };
            for (gripper, velocity) in command.velocities.iter().enumerate() {
                for (axis, v) in velocity.iter().enumerate() {
                    let limit = if gripper < robot.grippers { robot.speeds[axis] } else { 0.0 };
                    prop_assert!(v.abs() <= limit, "{command:?}");
                }
            }
            let holds = matches!(command.doing, Doing::Holding { .. });
            if holds {
                prop_assert_eq!(command.velocities, [[0.0; 3]; 2]);
            }
            // Speed increases at most by the acceleration limit. It decreases by as much as a
            // border demands.
            if let (Some(limits), Some((velocities, then_ns))) = (robot.accelerations, before) {
                let step_s = ((now_ns - then_ns) as f64 * 1e-9).min(0.1);
                let pairs = command.velocities.as_flattened().iter().zip(velocities.as_flattened());
                for (i, (v, was)) in pairs.enumerate() {
                    let most = was.abs() + limits[i % 3] * step_s;
                    prop_assert!(v.abs() <= most * (1.0 + 1e-9) + 1e-12, "{was} {v}");
                }
            }
            let at_ns = if let Event::Clock(t) = event { now_ns - t % 100_000_000 } else { now_ns };
            before = Some((command.velocities, before.map_or(at_ns, |(_, then_ns)| at_ns.max(then_ns))));
            prop_assert!(command.error_px.is_none_or(|e| e.is_finite()));
        }
    }
}

/// A servo whose limits are a hundredth of another servo's moves in the same direction.
#[test]
fn a_saturated_velocity_keeps_its_direction() {
    let commands = [1.0, 100.0].map(|times: f64| {
        let robot = Robot::default().speeds([50.0 * times, 30.0 * times, 0.2 * times]);
        let options = Options::default().robot(robot).gain(10.0).ramp_s(0.0);
        let mut servo =
            Servo::new(options, &linear(&[[90.0, -70.0, 0.8], [0.0; 3]])).expect("good options");
        let rows: Vec<_> = (0..6)
            .map(|k| {
                let column = |axis: usize| {
                    let mut poses = [[0.0; 3]; 2];
                    poses[0][axis] = 1.0;
                    linear(&poses)[k]
                };
                [[column(0), column(1), column(2)], [0.0; 3]]
            })
            .collect();
        servo.know(&rows).expect("a row each");
        servo.see(Observation::new(&linear(&[[0.0; 3]; 2]), 0), 0)
    });
    let [small, large] = commands.map(|command| command.velocities[0]);
    let ratio = small[0] / large[0];
    assert!(ratio < 0.5, "{small:?} {large:?}");
    for (small, large) in small.iter().zip(large) {
        assert!((small / large / ratio - 1.0).abs() < 1e-9);
    }
    let saturated = small
        .iter()
        .zip([50.0, 30.0, 0.2])
        .any(|(v, limit)| (v.abs() - limit).abs() < 1e-9);
    assert!(saturated, "{small:?}");
}

#[test]
fn grippers_stay_in_their_workspaces_and_slide_along_the_border() {
    let start = [[170.0, 240.0, 0.3], [420.0, 240.0, -0.3]];
    let border = Workspace {
        least: [0.0, 200.0, -1.5],
        most: [450.0, 280.0, 1.5],
    };
    let robot = Robot::default()
        .grippers(2)
        .start(start)
        .workspaces([border; 2]);
    // The second gripper would have to leave the workspace by 40 px upwards, and also move 20 px to
    // the right.
    let goal = [[170.0, 230.0, 0.5], [440.0, 320.0, 0.0]];
    let mut world = World::new(bent, start, 16);
    let mut servo =
        Servo::new(Options::default().robot(robot), &bent(&goal)).expect("good options");
    while world.now_ns() < 25_000_000_000 {
        world.turn(&mut servo);
        for [x, y, t] in world.poses {
            let inside =
                (0.0..=450.0).contains(&x) && (200.0..=280.0).contains(&y) && t.abs() <= 1.5;
            assert!(inside, "{:?}", world.poses);
        }
    }
    assert!(world.poses[1][1] > 279.0, "{:?}", world.poses);
}

#[test]
fn two_grippers_never_pull_the_rope_taut() {
    let start = [[170.0, 240.0, 0.3], [420.0, 240.0, -0.3]];
    let robot = Robot::default()
        .grippers(2)
        .start(start)
        .longest_apart_px(350.0);
    let goal = [[100.0, 240.0, 0.0], [490.0, 260.0, 0.0]];
    let mut world = World::new(bent, start, 16);
    let mut servo =
        Servo::new(Options::default().robot(robot), &bent(&goal)).expect("good options");
    let mut longest = 0.0f64;
    while world.now_ns() < 25_000_000_000 {
        world.turn(&mut servo);
        let [a, b] = world.poses;
        longest = longest.max(((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)).sqrt());
    }
    assert!(longest > 345.0 && longest < 350.1, "{longest}");
}

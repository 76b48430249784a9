//! Guaranteed properties of the simulated rope in 3-D.

use lariat_simulation::{
    Limits, Options, RADIUS_MM, STEP_S, SpacePose, SpaceSimulation, TargetShape, at_equal_steps,
};

fn of_seed(seed: u64) -> Options {
    Options {
        seed,
        ..Options::default()
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let square = |k: usize| (a[k] - b[k]) * (a[k] - b[k]);
    (square(0) + square(1) + square(2)).sqrt()
}

fn length_mm(line: &[[f64; 3]]) -> f64 {
    line.windows(2).map(|p| distance(p[0], p[1])).sum()
}

fn lowest_mm(simulation: &SpaceSimulation) -> f64 {
    let nodes = simulation.nodes().iter();
    nodes.map(|p| p[2]).fold(f64::MAX, f64::min)
}

/// Moves each gripper in its own direction, changed every 0.3 s, at the robot's limits, and turns
/// it by `turn_rad_s`.
fn dance(
    simulation: &mut SpaceSimulation,
    seconds: f64,
    turn_rad_s: f64,
    mut look: impl FnMut(&mut SpaceSimulation),
) {
    for step in 0..(seconds / STEP_S) as u64 {
        if step % 100 == 0 {
            let beat = (step / 300) as f64;
            let way = |phase: f64| {
                let wave = |k: f64| (k * (2.4 * beat + phase)).sin();
                let [x, y, z] = [1.0, 1.3, 1.7].map(|k| 1e4 * wave(k));
                let [a, b, c] = [2.1, 2.9, 3.7].map(|k| turn_rad_s * wave(k));
                [x, y, z, a, b, c]
            };
            simulation.command(&[way(0.3), way(2.0)]);
        }
        simulation.step();
        look(simulation);
    }
}

/// A stiff rope, held level at one end. At each node, the moment M of all weight beyond it bends
/// the rope by M ℓ/B.
#[test]
fn a_rope_held_by_one_end_bends_by_its_weight_as_a_beam_does() {
    let options = Options {
        grippers: 1,
        length_px: 200.0,
        stiffness: 1.0,
        ..of_seed(1)
    };
    let simulation = SpaceSimulation::new(&options).unwrap();
    let free = simulation.visible();
    let segment_mm = options.length_px / (options.nodes - 1) as f64;
    let turn = |node: usize| {
        let arms = (node + 1..free.len()).map(|beyond| (beyond - node) as f64 * segment_mm);
        9810.0 * arms.sum::<f64>() * segment_mm.powi(2) / 1e12
    };
    let wanted_mm: f64 = (0..free.len())
        .map(|node| turn(node) * (free.len() - 1 - node) as f64 * segment_mm)
        .sum();
    // The sag is between that of an engineering beam, w L⁴/8B, and that of a beam one segment
    // longer.
    let beam_mm = |length: f64| 9810.0 * length.powi(4) / 8e12;
    let free_mm = options.length_px - simulation.jaw_mm();
    assert!((beam_mm(free_mm)..beam_mm(free_mm + segment_mm)).contains(&wanted_mm));
    let sag_mm = free[0][2] - free[free.len() - 1][2];
    assert!(
        (sag_mm / wanted_mm - 1.0).abs() < 0.005,
        "{sag_mm} {wanted_mm}"
    );
}

#[test]
fn energy_does_not_grow_while_the_grippers_rest() {
    for seed in 1..=4 {
        let mut simulation = SpaceSimulation::new(&of_seed(seed)).unwrap();
        // The rope is not wound up so far that its bends fold, because one linear step does not
        // solve those.
        dance(&mut simulation, 0.9, 0.7, |_| ());
        simulation.command(&[]);
        simulation.step();
        // This step includes the energy from the last motion of the jaws.
        simulation.step();
        let mut last = simulation.energy().total();
        let first = last;
        for step in 0..3000 {
            simulation.step();
            let now = simulation.energy().total();
            assert!(now <= last + 1e-9 * first, "{seed} {step}: {last} to {now}");
            last = now;
        }
        assert!(last < first);
        assert!(simulation.energy().kinetic < 1e-3 * last);
    }
}

#[test]
fn it_keeps_its_length_and_stays_on_the_table_in_the_fastest_motion_allowed() {
    for (seed, grippers) in [(1, 2), (2, 2), (3, 1)] {
        let options = Options {
            grippers,
            limits: Limits {
                speed_px_s: 300.0,
                turn_rad_s: 3.0,
                ..Limits::default()
            },
            ..of_seed(seed)
        };
        let mut simulation = SpaceSimulation::new(&options).unwrap();
        dance(&mut simulation, 3.0, 1e4, |simulation| {
            let length_mm = length_mm(simulation.nodes());
            let error = (length_mm - options.length_px).abs() / options.length_px;
            assert!(error < 0.02, "{seed}: {length_mm}");
            // A turning gripper presses the rope down by part of its radius.
            let lowest_mm = lowest_mm(simulation);
            assert!(lowest_mm > 0.0, "{seed}: {lowest_mm}");
        });
    }
}

#[test]
fn a_rope_let_down_lies_on_the_table() {
    let mut simulation = SpaceSimulation::new(&of_seed(2)).unwrap();
    let down: Vec<SpacePose> = (simulation.grippers().iter())
        .map(|pose| SpacePose {
            at: [pose.at[0], pose.at[1], RADIUS_MM],
            ..*pose
        })
        .collect();
    simulation.drive_to(&down);
    for p in simulation.nodes() {
        assert!((p[2] - RADIUS_MM).abs() < 0.2, "{p:?}");
    }
}

#[test]
fn clamped_ends_have_the_place_and_the_direction_of_their_gripper() {
    let mut simulation = SpaceSimulation::new(&of_seed(2)).unwrap();
    dance(&mut simulation, 1.0, 1e4, |simulation| {
        let [first, last] = [simulation.grippers()[0], simulation.grippers()[1]];
        let (nodes, jaw_mm) = (simulation.nodes(), simulation.jaw_mm());
        let n = nodes.len();
        for (pose, end, inner) in [
            (first, nodes[0], nodes[2]),
            (last, nodes[n - 1], nodes[n - 3]),
        ] {
            assert!(distance(pose.at, end) < 1e-9);
            assert!(distance(pose.ahead(jaw_mm), inner) < 1e-9);
        }
        assert_eq!(simulation.visible()[0], nodes[2]);
        assert_eq!(simulation.visible().last(), Some(&nodes[n - 3]));
    });
}

#[test]
fn grippers_stay_in_their_workspace_and_a_taut_rope_is_pulled_no_farther() {
    let mut simulation = SpaceSimulation::new(&of_seed(5)).unwrap();
    let workspace_mm = SpaceSimulation::workspace_mm(simulation.options());
    for way in [[1.0, 0.0, 1.0], [-1.0, 0.0, -1.0], [0.0, 1.0, 1.0]] {
        for _ in 0..3000 {
            let [x, y, z] = way.map(|c| 150.0 * c);
            simulation.command(&[[-x, y, z, 0.0, 0.0, 0.0], [x, -y, -z, 0.0, 0.0, 0.0]]);
            simulation.step();
            for pose in simulation.grippers() {
                for (at, [low, high]) in pose.at.iter().zip(workspace_mm) {
                    // A gripper that gives way to the rope is not confined to its workspace.
                    assert!((low - 1.0..=high + 1.0).contains(at), "{pose:?}");
                }
            }
            let length = length_mm(simulation.nodes()) / 390.0;
            assert!((length - 1.0).abs() < 0.01, "{length}");
        }
    }
}

#[test]
fn the_same_seed_is_the_same_rope_on_every_machine() {
    let mut digest = 0xcbf2_9ce4_8422_2325_u64;
    for (seed, grippers) in [(1, 2), (2, 1)] {
        let options = Options {
            grippers,
            ..of_seed(seed)
        };
        let mut simulation = SpaceSimulation::new(&options).unwrap();
        for step in 0..1500_u32 {
            if step % 50 == 0 {
                let way = f64::from(step / 50 % 7) - 3.0;
                simulation.command(&[
                    [20.0, -9.0, 12.0, 0.1, -0.2, 0.2].map(|v| v * way),
                    [-25.0, 6.0 * way, -8.0 * way, 0.0, 0.1, 0.1],
                ]);
            }
            simulation.step();
        }
        let nodes = simulation.nodes().iter().flatten();
        for byte in nodes.flat_map(|c| c.to_bits().to_le_bytes()) {
            // FNV-1a.
            digest = (digest ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
    assert_eq!(digest, 0x93f7_aba6_5716_c5ad, "{digest:#x}");
}

#[test]
fn every_target_is_lifted_and_reached_from_another_start() {
    for (seed, shape) in (0..3).zip([TargetShape::U, TargetShape::S, TargetShape::Line]) {
        let options = of_seed(seed);
        let target = shape.reached_in_space(&options, 100).unwrap();
        assert!(target.poses.iter().all(|pose| pose.at[2] >= 60.0));
        let mut simulation = SpaceSimulation::new(&of_seed(seed + 100)).unwrap();
        simulation.drive_to(&target.poses);
        let points = at_equal_steps(simulation.visible(), 100);
        let pairs = points.iter().zip(&target.points);
        let off_mm = pairs.map(|(a, b)| distance(*a, *b)).sum::<f64>() / 100.0;
        assert!(off_mm <= 3.0, "{shape:?} {seed}: {off_mm}");
    }
}

#[test]
fn a_rope_that_is_wound_up_without_end_stays_within_the_numbers() {
    for turns in [[1.0, -1.0], [-1.0, 0.0]] {
        let mut simulation = SpaceSimulation::new(&of_seed(1)).unwrap();
        for step in 0..(10.0 / STEP_S) as u64 {
            if step % 100 == 0 {
                let turn = |turn: f64| [0.0, 0.0, -1e9, 1e9 * turn, f64::NAN, 1e9 * turn];
                simulation.command(&turns.map(turn));
            }
            simulation.step();
            let nodes = simulation.nodes().as_flattened();
            assert!(nodes.iter().all(|c| c.is_finite()), "{turns:?}: {step}");
        }
    }
}

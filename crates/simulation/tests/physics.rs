//! Guaranteed properties of the simulated rope.

use lariat_simulation::{Limits, Options, Pose, STEP_S, Simulation};

fn of_seed(seed: u64) -> Options {
    Options {
        seed,
        ..Options::default()
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn length_px(line: &[[f64; 2]]) -> f64 {
    line.windows(2).map(|p| distance(p[0], p[1])).sum()
}

/// Moves each gripper in its own direction, changed every 0.3 s, at the robot's limits.
fn dance(simulation: &mut Simulation, seconds: f64, mut look: impl FnMut(&mut Simulation)) {
    for step in 0..(seconds / STEP_S) as u64 {
        if step % 100 == 0 {
            let beat = (step / 300) as f64;
            let [a, b] = [2.4 * beat, 4.1 * beat + 1.0];
            let far = 1e4;
            simulation.command(&[
                [far * a.cos(), far * a.sin(), far * (3.0 * a).sin()],
                [far * b.cos(), far * b.sin(), far * (5.0 * b).cos()],
            ]);
        }
        simulation.step();
        look(simulation);
    }
}

#[test]
fn energy_does_not_grow_while_the_grippers_rest() {
    for seed in 1..=4 {
        let mut simulation = Simulation::new(&of_seed(seed)).unwrap();
        dance(&mut simulation, 0.9, |_| ());
        simulation.command(&[]);
        simulation.step();
        // This step includes the energy from the last motion of the jaws.
        simulation.step();
        let mut last = simulation.energy().total();
        let first = last;
        for _ in 0..2000 {
            simulation.step();
            let now = simulation.energy().total();
            assert!(now <= last * (1.0 + 1e-9), "{seed}: {last} to {now}");
            last = now;
        }
        assert!(last < first);
        assert!(simulation.energy().kinetic < 1e-3 * last);
    }
}

#[test]
fn the_rope_keeps_its_length_in_the_fastest_motion_allowed() {
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
        let mut simulation = Simulation::new(&options).unwrap();
        let step_px = options.length_px / (options.nodes - 1) as f64;
        let mut worst = 0.0_f64;
        dance(&mut simulation, 3.0, |simulation| {
            let length_px = length_px(simulation.nodes());
            let error = (length_px - options.length_px).abs() / options.length_px;
            assert!(error < 0.02, "{seed}: {length_px}");
            for pair in simulation.nodes().windows(2) {
                worst = worst.max((distance(pair[0], pair[1]) / step_px - 1.0).abs());
            }
        });
        // The worst case is a single segment at a jaw that reverses at full speed.
        assert!(worst < 0.05, "{seed}: {worst}");
    }
}

#[test]
fn a_taut_rope_is_pulled_no_farther() {
    let mut simulation = Simulation::new(&of_seed(5)).unwrap();
    for _ in 0..2000 {
        simulation.command(&[[-150.0, 0.0, 0.0], [150.0, 0.0, 0.0]]);
        simulation.step();
    }
    let length = length_px(simulation.nodes()) / 390.0;
    assert!((length - 1.0).abs() < 0.005, "{length}");
}

#[test]
fn clamped_ends_have_the_place_and_the_direction_of_their_gripper() {
    let mut simulation = Simulation::new(&of_seed(2)).unwrap();
    dance(&mut simulation, 1.0, |simulation| {
        let [first, last] = [simulation.grippers()[0], simulation.grippers()[1]];
        let (nodes, jaw_px) = (simulation.nodes(), simulation.jaw_px());
        let n = nodes.len();
        for (pose, end, inner) in [
            (first, nodes[0], nodes[2]),
            (last, nodes[n - 1], nodes[n - 3]),
        ] {
            assert!(distance(pose.at, end) < 1e-9);
            assert!(distance(pose.ahead(jaw_px), inner) < 1e-9);
        }
        assert_eq!(simulation.visible()[0], nodes[2]);
        assert_eq!(simulation.visible().last(), Some(&nodes[n - 3]));
    });
}

#[test]
fn friction_holds_a_rope_at_rest_and_nothing_else_does() {
    let drift = |friction| {
        let options = Options {
            friction,
            grippers: 1,
            ..of_seed(3)
        };
        let mut simulation = Simulation::new(&options).unwrap();
        // The free end is bent to the side, because it was laid out that way.
        let before = simulation.nodes().to_vec();
        for _ in 0..3000 {
            simulation.step();
        }
        let bend = simulation.energy().bending;
        let pairs = before.iter().zip(simulation.nodes());
        let farthest = pairs.map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max);
        (farthest, bend)
    };
    let (with, bend_with) = drift(0.3);
    let (_, bend_without) = drift(0.0);
    assert!(with < 0.05, "{with}");
    assert!(
        bend_with > 10.0 * bend_without,
        "{bend_with} {bend_without}"
    );
}

#[test]
fn a_straight_rope_pulled_straight_stays_straight() {
    let mut simulation = Simulation::new(&of_seed(1)).unwrap();
    let middle = [320.0, 240.0];
    // Farther than the rope is long: the robot stops when the rope is taut.
    let half = 0.5 * simulation.options().length_px + 1.0;
    let pose = |x: f64, angle_rad| Pose {
        at: [x, middle[1]],
        angle_rad,
    };
    let apart = [
        pose(middle[0] - half, 0.0),
        pose(middle[0] + half, std::f64::consts::PI),
    ];
    simulation.drive_to(&apart);
    let off = |simulation: &Simulation| {
        let nodes = simulation.nodes().iter();
        nodes.map(|p| (p[1] - middle[1]).abs()).fold(0.0, f64::max)
    };
    assert!(off(&simulation) < 0.5, "{}", off(&simulation));
    let before = off(&simulation);
    for _ in 0..500 {
        simulation.command(&[[60.0, 0.0, 0.0], [60.0, 0.0, 0.0]]);
        simulation.step();
    }
    assert!(off(&simulation) <= before + 1e-6, "{}", off(&simulation));
    assert!(simulation.grippers()[0].at[0] > middle[0] - half + 25.0);
}

#[test]
fn a_robot_that_hears_nothing_stops() {
    let mut simulation = Simulation::new(&of_seed(1)).unwrap();
    let start = simulation.grippers()[0];
    simulation.command(&[[100.0, 0.0, 0.0]]);
    for _ in 0..1000 {
        simulation.step();
    }
    let way = simulation.grippers()[0].at[0] - start.at[0];
    assert!((way - 25.0).abs() < 0.2, "{way}");
    assert_eq!(simulation.velocities(), [[0.0; 3]; 2]);
}

#[test]
fn grippers_stay_in_their_workspace() {
    let mut simulation = Simulation::new(&of_seed(4)).unwrap();
    for _ in 0..4000 {
        simulation.command(&[[-150.0, -150.0, 0.0], [-150.0, -150.0, 0.0]]);
        simulation.step();
        for pose in simulation.grippers() {
            assert!((30.0..=610.0).contains(&pose.at[0]));
            assert!((30.0..=450.0).contains(&pose.at[1]));
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
        let mut simulation = Simulation::new(&options).unwrap();
        for step in 0..1500_u32 {
            if step % 50 == 0 {
                let way = f64::from(step / 50 % 7) - 3.0;
                simulation.command(&[[20.0 * way, -9.0 * way, 0.2 * way], [-25.0, 6.0 * way, 0.1]]);
            }
            simulation.step();
        }
        for byte in simulation
            .nodes()
            .iter()
            .flatten()
            .flat_map(|c| c.to_bits().to_le_bytes())
        {
            // FNV-1a.
            digest = (digest ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
    assert_eq!(digest, 0x6bfb_3915_d680_487b, "{digest:#x}");
}

#[test]
fn starts_differ_by_seed_and_lie_well_within_the_picture() {
    let starts: Vec<_> = (0..20)
        .map(|seed| Simulation::new(&of_seed(seed)).unwrap())
        .collect();
    for (seed, start) in starts.iter().enumerate() {
        assert_eq!(start.steps(), 0);
        for p in start.nodes() {
            assert!(
                (60.0..580.0).contains(&p[0]) && (60.0..420.0).contains(&p[1]),
                "{p:?}"
            );
        }
        // It has no loop: it runs from left to right everywhere.
        assert!(
            start.nodes().windows(2).all(|p| p[1][0] > p[0][0]),
            "{seed}"
        );
        let bow = length_px(start.nodes())
            / distance(start.nodes()[0], start.nodes()[start.nodes().len() - 1]);
        assert!((1.05..1.5).contains(&bow), "{bow}");
        for other in &starts[..seed] {
            let apart = other.nodes().iter().zip(start.nodes());
            let apart: f64 = apart.map(|(a, b)| distance(*a, *b)).sum();
            assert!(apart > 60.0, "no two starts are alike");
        }
    }
}

#[test]
fn what_cannot_be_simulated_is_refused_with_a_sentence() {
    let said = |options: Options| Simulation::new(&options).unwrap_err().to_string();
    let options = Options::default();
    assert_eq!(
        said(Options {
            grippers: 3,
            ..options
        }),
        "the simulated rope needs 1 or 2 grippers, not 3"
    );
    assert!(
        said(Options {
            friction: f64::NAN,
            ..options
        })
        .ends_with("not NaN")
    );
    assert!(
        said(Options {
            length_px: 600.0,
            ..options
        })
        .contains("100 to 427 px")
    );
}

#[test]
fn a_rope_that_is_wound_up_without_end_stays_within_the_numbers() {
    for turns in [[1.0, -1.0], [-1.0, 0.0]] {
        let mut simulation = Simulation::new(&of_seed(1)).unwrap();
        for step in 0..(25.0 / STEP_S) as u64 {
            if step % 100 == 0 {
                simulation.command(&turns.map(|turn| [0.0, 0.0, 1e9 * turn]));
            }
            simulation.step();
            let nodes = simulation.nodes().as_flattened();
            assert!(nodes.iter().all(|c| c.is_finite()), "{turns:?}: {step}");
        }
    }
}

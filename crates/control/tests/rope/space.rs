//! The same loop with a lifted rope: noisy points in 3-D, a curve fitted to them, a 3-D servo, and
//! grippers with six coordinates.

use lariat_control::{
    Doing, Metric, Observation, Options, Robot, SpaceServo, Tool, Weights, Workspace,
};
use lariat_fit::Fitter;
use lariat_portable::SplitMix64;
use lariat_simulation::{STEP_NS, SpaceSimulation, TargetShape, at_equal_steps};

const POINTS: usize = 120;
const ORDER: usize = 8;
/// Noise of a depth camera in each coordinate of each point, mm.
const NOISE_MM: f64 = 0.5;

/// Returns control points, and the covariance of each.
fn describe(fitter: &mut Fitter<3>, points: &[[f64; 3]]) -> (Vec<f64>, Vec<[f64; 6]>) {
    let fit = fitter.fit(points).expect("a curve");
    let count = fit.control_points.len();
    let covariances = (0..count).map(|j| {
        let variance = fit.residual_variance * fit.covariance_factor[(j, j)];
        [variance, 0.0, 0.0, variance, 0.0, variance]
    });
    let features = fit.control_points.as_flattened().to_vec();
    (features, covariances.collect())
}

/// Returns the final distance of the rope from its target, mm, and whether it has arrived.
fn drive(shape: TargetShape, seed: u64) -> (f64, bool) {
    let simulated = lariat_simulation::Options {
        seed,
        ..Default::default()
    };
    let target = shape
        .reached_in_space(&simulated, POINTS)
        .expect("two grippers")
        .points;
    let mut simulation = SpaceSimulation::new(&simulated).expect("good options");
    let mut fitter =
        Fitter::<3>::in_dimensions(lariat_fit::Options::bezier(ORDER)).expect("a fitter");
    let mut tools = [0, 1].map(|i| Tool::new(simulation.grippers()[i].along));
    let [x, y, z] = SpaceSimulation::workspace_mm(&simulated);
    let turns = [f64::INFINITY; 3];
    let side = |which: usize, turn: f64| {
        let [a, b, c] = turns.map(|t| t * turn);
        [x[which], y[which], z[which], a, b, c]
    };
    let start = [0, 1].map(|i| {
        let [x, y, z] = simulation.grippers()[i].at;
        [x, y, z, 0.0, 0.0, 0.0]
    });
    let options = Options::default()
        .robot(
            Robot::default()
                .grippers(2)
                .start(start)
                .speeds([85.0, 85.0, 85.0, 1.0, 1.0, 0.0])
                .workspaces(
                    [Workspace {
                        least: side(0, -1.0),
                        most: side(1, 1.0),
                    }; 2],
                )
                .longest_apart_px(0.998 * simulated.length_px),
        )
        .metric(Metric::bezier(ORDER).expect("a metric"))
        .gain(3.0);
    let mut servo =
        SpaceServo::new(options, &describe(&mut fitter, &target).0).expect("good options");
    let mut random = SplitMix64::new(seed);
    let mut arrived = 0;
    let off = |simulation: &SpaceSimulation| {
        let points = at_equal_steps(simulation.visible(), POINTS);
        let far = |(p, q): (&[f64; 3], &[f64; 3])| {
            (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
        };
        points.iter().zip(&target).map(far).sum::<f64>() / POINTS as f64
    };
    while simulation.steps() < 25_000 && arrived < 60 {
        let now_ns = simulation.steps() * STEP_NS;
        let mut points = at_equal_steps(simulation.visible(), POINTS);
        for c in points.as_flattened_mut() {
            *c += NOISE_MM * random.normal();
        }
        let (features, covariances) = describe(&mut fitter, &points);
        let seen = Observation {
            weights: Weights::Covariances3(&covariances),
            ..Observation::new(&features, now_ns)
        };
        let command = servo.see(seen, now_ns);
        arrived = if command.doing == Doing::Arrived {
            arrived + 1
        } else {
            0
        };
        for _ in 0..16 {
            simulation.command(&[0, 1].map(|i| tools[i].twist(&command.velocities[i])));
            simulation.step();
        }
        for (tool, velocity) in tools.iter_mut().zip(&command.velocities) {
            tool.turn(velocity, 0.016);
        }
    }
    println!(
        "{shape:?}, seed {seed}: {:.2} mm after {} s",
        off(&simulation),
        simulation.steps() / 1000
    );
    (off(&simulation), arrived > 0)
}

#[test]
fn a_lifted_rope_is_driven_to_each_shape() {
    for shape in [TargetShape::U, TargetShape::S, TargetShape::Line] {
        for seed in 1..=2 {
            let (off_mm, arrived) = drive(shape, seed);
            assert!(arrived && off_mm < 3.0, "{shape:?} {seed}: {off_mm}");
        }
    }
}

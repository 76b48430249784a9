//! The control loop without processes and images: the simulated rope, noise in its points, a curve
//! fitted to them, the servo, and the grippers.

use std::collections::VecDeque;

use lariat_control::{Command, Doing, Metric, Observation, Options, Servo, Weights, Workspace};
use lariat_fit::{Fitter, bernstein};
use lariat_portable::SplitMix64;
use lariat_simulation::{STEP_NS, Simulation, TargetShape, at_equal_steps};

/// Number of points from the camera; shapes are compared by the same number of points.
pub(crate) const POINTS: usize = 120;

/// Properties of the camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sight {
    pub(crate) order: usize,
    pub(crate) frames_per_s: f64,
    /// Time from an exposure to the command based on it.
    pub(crate) delay_ms: u64,
    /// Standard deviation of each coordinate of each point.
    pub(crate) noise_px: f64,
}

impl Default for Sight {
    fn default() -> Self {
        Self {
            order: 8,
            frames_per_s: 60.0,
            delay_ms: 1,
            noise_px: 0.1,
        }
    }
}

/// A rope in its start position, and its target.
#[derive(Clone)]
pub(crate) struct Case {
    pub(crate) seed: u64,
    pub(crate) simulation: Simulation,
    pub(crate) target: Vec<[f64; 2]>,
}

impl Case {
    pub(crate) fn new(shape: TargetShape, seed: u64) -> Self {
        let options = lariat_simulation::Options {
            seed,
            ..Default::default()
        };
        Self {
            seed,
            simulation: Simulation::new(&options).expect("good options"),
            target: shape
                .reached(&options, POINTS)
                .expect("two grippers")
                .points,
        }
    }

    /// Adds the case's robot and the metric of a curve to these options.
    pub(crate) fn options(&self, sight: &Sight, options: Options) -> Options {
        let simulated = self.simulation.options();
        let margin_px = simulated.limits.margin_px;
        let [width, height] = simulated.picture_px;
        let workspace = Workspace {
            least: [margin_px, margin_px, f64::NEG_INFINITY],
            most: [width - margin_px, height - margin_px, f64::INFINITY],
        };
        let mut start = [[0.0; 3]; 2];
        for (to, from) in start.iter_mut().zip(self.simulation.grippers()) {
            *to = [from.at[0], from.at[1], from.angle_rad];
        }
        let rows = (0..64).map(|i| {
            let mut row = vec![0.0; sight.order + 1];
            bernstein(sight.order, i as f64 / 63.0, &mut row);
            row
        });
        let robot = options
            .robot
            .grippers(2)
            .start(start)
            .workspaces([workspace; 2])
            .longest_apart_px(0.998 * simulated.length_px);
        options
            .robot(robot)
            .metric(Metric::of_rows(rows).expect("a metric"))
            .oldest_image_s(0.6)
    }
}

/// A shape as in a message, and its exposure time.
struct Image {
    exposed_ns: u64,
    features: Vec<f64>,
    covariances: Vec<[f64; 3]>,
}

/// A closed loop.
pub(crate) struct Chain {
    pub(crate) simulation: Simulation,
    pub(crate) servo: Servo,
    target: Vec<[f64; 2]>,
    sight: Sight,
    fitter: Fitter,
    random: SplitMix64,
    exposures: u64,
    images: VecDeque<Image>,
}

impl Chain {
    pub(crate) fn new(case: &Case, sight: Sight, options: Options) -> Self {
        let mut fitter = fitter(sight.order);
        let target = describe(&mut fitter, &case.target).0;
        let options = case.options(&sight, options);
        Self {
            simulation: case.simulation.clone(),
            servo: Servo::new(options, &target).expect("good options"),
            target: case.target.clone(),
            sight,
            fitter,
            random: SplitMix64::new(case.seed),
            exposures: 0,
            images: VecDeque::new(),
        }
    }

    pub(crate) fn now_ns(&self) -> u64 {
        self.simulation.steps() * STEP_NS
    }

    pub(crate) fn now_s(&self) -> f64 {
        self.now_ns() as f64 * 1e-9
    }

    /// Advances the rope by one step. Returns the command of an image if one was due.
    pub(crate) fn step(&mut self) -> Option<Command> {
        let now_ns = self.now_ns();
        let exposed_ns = (self.exposures as f64 * 1e9 / self.sight.frames_per_s) as u64;
        if exposed_ns <= now_ns {
            self.expose(now_ns);
        }
        let due = |image: &Image| image.exposed_ns + self.sight.delay_ms * 1_000_000 <= now_ns;
        let mut command = None;
        if self.images.front().is_some_and(due) {
            let image = self.images.pop_front().expect("just seen");
            let observation = Observation {
                weights: Weights::Covariances(&image.covariances),
                ..Observation::new(&image.features, image.exposed_ns)
            };
            let given = self.servo.see(observation, now_ns);
            self.simulation.command(&given.velocities);
            command = Some(given);
        }
        self.simulation.step();
        command
    }

    fn expose(&mut self, exposed_ns: u64) {
        self.exposures += 1;
        let mut points = at_equal_steps(self.simulation.visible(), POINTS);
        for c in points.as_flattened_mut() {
            *c += self.sight.noise_px * self.random.normal();
        }
        let (features, covariances) = describe(&mut self.fitter, &points);
        self.images.push_back(Image {
            exposed_ns,
            features,
            covariances,
        });
    }

    /// Mean distance of the rope from its target, px.
    pub(crate) fn error_px(&self) -> f64 {
        let points = at_equal_steps(self.simulation.visible(), POINTS);
        let pairs = points.iter().zip(&self.target);
        let distances = pairs.map(|(p, q)| ((p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)).sqrt());
        distances.sum::<f64>() / POINTS as f64
    }

    /// Runs until the rope has been at rest at its target for a second, or this many seconds have
    /// passed.
    pub(crate) fn run(&mut self, seconds: f64) -> Outcome {
        let mut outcome = Outcome::default();
        let mut arrived_s = None;
        while self.now_s() < seconds {
            let Some(command) = self.step() else {
                continue;
            };
            let (now_s, error_px) = (self.now_s(), self.error_px());
            match command.doing {
                Doing::Exploring { .. } => outcome.explored_s = now_s,
                Doing::Arrived => {
                    arrived_s.get_or_insert(now_s);
                }
                _ => arrived_s = None,
            }
            outcome.final_px = error_px;
            match error_px <= NEAR_PX {
                true => {
                    outcome.reached_s.get_or_insert(now_s);
                }
                false => outcome.reached_s = None,
            }
            if arrived_s.is_some_and(|since_s| now_s > since_s + 1.0) {
                break;
            }
        }
        outcome.arrived_s = arrived_s;
        outcome
    }
}

/// Maximum mean distance at which a rope has reached its target.
pub(crate) const NEAR_PX: f64 = 5.0;

/// Result of a run.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Outcome {
    /// Time when the rope came near the target for good.
    pub(crate) reached_s: Option<f64>,
    /// Time when the rope came to rest at its target.
    pub(crate) arrived_s: Option<f64>,
    /// Time of the last exploration.
    pub(crate) explored_s: f64,
    pub(crate) final_px: f64,
}

pub(crate) fn fitter(order: usize) -> Fitter {
    Fitter::new(lariat_fit::Options::bezier(order)).expect("a fitter")
}

/// Returns a curve's control points, and the covariance of each.
pub(crate) fn describe(fitter: &mut Fitter, points: &[[f64; 2]]) -> (Vec<f64>, Vec<[f64; 3]>) {
    let fit = fitter.fit(points).expect("a curve");
    let count = fit.control_points.len();
    let covariances = (0..count).map(|j| {
        let variance = fit.residual_variance * fit.covariance_factor[(j, j)];
        [variance, 0.0, variance]
    });
    let features = fit.control_points.as_flattened().to_vec();
    (features, covariances.collect())
}

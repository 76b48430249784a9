//! The servo and its state from image to image.

mod known;
mod sight;

use crate::command::{Command, Doing, Observation, Why};
use crate::error::ServoError;
use crate::estimator::{Learner, NONE};
use crate::explore::Explorer;
use crate::history::History;
use crate::jacobian::{Jacobian, square};
use crate::law::{Law, Wish};
use crate::limits::Limits;
use crate::options::Options;
use crate::pairs::{Frame, Pairs};
use crate::progress::Progress;
use crate::robot::axes;
use crate::weighing::Weighing;
use crate::{Coordinates, Features, MAX_POINTS, dimensions};
use sight::{Sight, checked};

/// Maximum time between commands for which the acceleration limit counts, s.
const LONGEST_STEP_S: f64 = 0.1;

/// Share of the full speed while the rope is partly covered.
const PARTIAL_SHARE: f64 = 0.5;

/// Drives a rope's shape to a target: call [`see`](Self::see) for each image, or
/// [`hold`](Self::hold) if there is no usable one.
///
/// Times are in ns on any monotonic clock. The images' exposure times must be on the same clock.
#[derive(Debug, Clone)]
pub struct Servo<const A: usize = 3> {
    options: Options<A>,
    limits: Limits,
    /// Number of coordinates of a shape.
    size: usize,
    target: Features,
    way_chosen: bool,
    weighing: Weighing,
    history: History,
    jacobian: Jacobian,
    learner: Learner,
    pairs: Pairs,
    explorer: Explorer,
    phase: Phase,
    progress: Progress,
    exposed_ns: Option<u64>,
    error_px: Option<f64>,
    commanded: Option<Commanded>,
    /// Time at which the servo last resumed; `None` during a hold.
    resumed_ns: Option<u64>,
}

/// A servo for ropes in 3-D. Coordinates of a gripper are x, y and z in mm, then three turns in
/// rad. Lengths documented in px are in mm.
pub type SpaceServo = Servo<6>;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Exploring,
    Steering,
    /// The shape is within the tolerance, and the grippers stand still.
    Within {
        since_ns: u64,
    },
}

#[derive(Debug, Clone, Copy)]
struct Commanded {
    at_ns: u64,
    velocity: Coordinates,
    /// Share of the law's wish that the limits left.
    share: f64,
}

/// The wanted motion, before the limits.
struct Plan {
    velocity: Coordinates,
    doing: Doing,
    condition: Option<f64>,
}

impl<const A: usize> Servo<A> {
    /// Coordinates per point.
    const DIMENSIONS: usize = dimensions(A);

    /// Creates a servo for shapes with as many points as the target: `[x₀, y₀, x₁, y₁, …]`, px; in
    /// 3-D `[x₀, y₀, z₀, …]`, mm. `A` is 3, or 6 in 3-D.
    ///
    /// # Errors
    /// Fails if an option is out of range, the target is invalid, or the metric is for another
    /// number of points.
    pub fn new(options: Options<A>, target: &[f64]) -> Result<Self, ServoError> {
        const {
            assert!(
                A == 3 || A == 6,
                "a gripper has 3 coordinates in the plane and 6 in space"
            )
        };
        options.check()?;
        let size = target.len();
        let dimensions = Self::DIMENSIONS;
        let points = size / dimensions;
        if points == 0 || !size.is_multiple_of(dimensions) || points > MAX_POINTS {
            return Err(ServoError::TargetSize {
                given: size,
                dimensions,
            });
        }
        match options.metric.points() {
            Some(metric) if metric != points => {
                let target = points;
                return Err(ServoError::OtherMetric { metric, target });
            }
            _ => {}
        }
        let limits = Limits::new(&options.robot);
        let remembered_s = options.oldest_image_s + options.robot.delay_s;
        Ok(Self {
            limits,
            size,
            target: checked(target)?,
            way_chosen: !options.either_way,
            weighing: Weighing::new(&options.metric, points, dimensions),
            history: History::new(limits.gather(&options.robot.start), remembered_s),
            jacobian: Jacobian::ZERO,
            learner: Learner::new(options.estimator),
            pairs: Pairs::new(options.learning),
            explorer: Explorer::new(options.exploring),
            phase: Phase::Exploring,
            progress: Progress::new(&options.exploring),
            exposed_ns: None,
            error_px: None,
            commanded: None,
            resumed_ns: None,
            options,
        })
    }

    /// Returns the command for the newest image. Call it for each new image, and in between, with
    /// the same image, as often as the robot needs commands.
    ///
    /// If the shape is unusable (too old, of another size, not finite), the servo holds and the
    /// command gives the reason.
    pub fn see(&mut self, seen: Observation<'_>, now_ns: u64) -> Command<A> {
        match self.sight(&seen, now_ns) {
            Ok(sight) => self.go_by(&sight, now_ns),
            Err(why) => self.hold(why, now_ns),
        }
    }

    /// Commands velocity 0 at once. Call it in each cycle without a shape to steer by. The next
    /// [`see`](Self::see) resumes.
    pub fn hold(&mut self, why: Why, now_ns: u64) -> Command<A> {
        self.resumed_ns = None;
        self.command(now_ns, NONE, 0.0);
        Command {
            velocities: [[0.0; A]; 2],
            doing: Doing::Holding { why },
            error_px: self.error_px,
            condition: None,
        }
    }

    /// Sets another target with the same number of points. Knowledge of the rope is kept.
    ///
    /// # Errors
    /// Fails if the target is invalid or of another size.
    pub fn aim(&mut self, target: &[f64]) -> Result<(), ServoError> {
        if target.len() != self.size {
            return Err(ServoError::OtherTarget {
                given: target.len(),
                expected: self.size,
            });
        }
        self.target = checked(target)?;
        self.way_chosen = !self.options.either_way;
        if let Phase::Within { .. } = self.phase {
            self.phase = Phase::Steering;
        }
        self.progress = Progress::new(&self.options.exploring);
        self.resumed_ns = None;
        Ok(())
    }

    /// Restarts with another rope, or with one that was released and gripped again. The servo
    /// explores again, and keeps the grippers' positions.
    pub fn reset(&mut self) {
        self.jacobian = Jacobian::ZERO;
        self.learner = Learner::new(self.options.estimator);
        self.pairs.forget();
        self.explorer = Explorer::new(self.options.exploring);
        self.phase = Phase::Exploring;
        self.progress = Progress::new(&self.options.exploring);
        self.way_chosen = !self.options.either_way;
        self.resumed_ns = None;
    }

    fn go_by(&mut self, sight: &Sight, now_ns: u64) -> Command<A> {
        self.error_px = Some(sight.error_px);
        let progress = &mut self.progress;
        let resumed_ns = *self.resumed_ns.get_or_insert_with(|| {
            progress.resume(now_ns);
            now_ns
        });
        if sight.is_new && !sight.partial {
            self.learn(&sight.frame);
        }
        // The history always covers the present.
        let r = self.history.at(now_ns).unwrap_or(sight.frame.r);
        let dt_s = self.step_s(now_ns);
        let plan = self.plan(sight, now_ns, dt_s, &r);
        let mut share = 1.0;
        if self.options.ramp_s > 0.0 {
            share = ((now_ns - resumed_ns) as f64 * 1e-9 / self.options.ramp_s).min(1.0);
        }
        if sight.partial {
            share *= PARTIAL_SHARE;
        }
        let before = self.commanded.map_or(NONE, |last| last.velocity);
        let velocity = self.limits.keep(&plan.velocity, share, &before, dt_s, &r);
        self.command(now_ns, velocity, share_of(&velocity, &plan.velocity));
        Command {
            velocities: self.limits.spread_velocity(&velocity),
            doing: plan.doing,
            error_px: self.error_px,
            condition: plan.condition,
        }
    }

    fn learn(&mut self, frame: &Frame) {
        if self.phase == Phase::Exploring {
            self.explorer
                .take(frame, &mut self.jacobian, &mut self.learner);
            self.pairs.forget();
        } else if let Some(pair) = self.pairs.pair(frame) {
            self.learner.learn(&mut self.jacobian, &pair);
        }
    }

    fn plan(&mut self, sight: &Sight, now_ns: u64, dt_s: f64, r: &Coordinates) -> Plan {
        if self.phase != Phase::Exploring {
            let plan = self.pursue(sight, now_ns, r);
            if self.phase != Phase::Exploring {
                return plan;
            }
        }
        if let Some((input, velocity)) = self.explorer.drive(now_ns, dt_s, r, &self.limits) {
            return Plan {
                velocity,
                doing: Doing::Exploring {
                    gripper: input / A + 1,
                    axis: axes(A)[input % A],
                },
                condition: None,
            };
        }
        self.phase = Phase::Steering;
        self.progress.begin(now_ns);
        self.pursue(sight, now_ns, r)
    }

    /// Steers, detects arrival, or starts to explore if the error has stalled.
    fn pursue(&mut self, sight: &Sight, now_ns: u64, r: &Coordinates) -> Plan {
        let mut error = sight.error;
        if self.options.look_ahead {
            let since = std::array::from_fn(|i| r[i] - sight.frame.r[i]);
            let moved = self.jacobian.times(&since);
            error
                .iter_mut()
                .zip(moved)
                .for_each(|(e, moved)| *e -= moved);
        }
        let law = Law::new(
            &self.jacobian,
            &self.weighing,
            &error,
            self.options.gain,
            self.options.damping,
        );
        let wish = self.within_borders(&law, r);
        // Uses the larger of the observed and the predicted error, as both must be near the target.
        let error_px = sight.error_px.max(self.weighing.distance_px(&error));
        let within = self.is_within(error_px, now_ns);
        let share = self.commanded.map_or(0.0, |last| last.share);
        if !within && self.progress.has_stalled(error_px, share, now_ns) {
            self.explorer = Explorer::new(self.options.exploring);
            self.phase = Phase::Exploring;
        }
        Plan {
            velocity: if within { NONE } else { wish.velocity },
            doing: self.arrived_or_steering(sight.frame.at_ns),
            condition: Some(wish.condition),
        }
    }

    /// Returns whether the shape is near enough to the target to stand still. Once it is, a larger
    /// distance is allowed.
    fn is_within(&mut self, error_px: f64, now_ns: u64) -> bool {
        let tolerance_px = self.options.tolerance_px;
        match self.phase {
            Phase::Within { .. } if error_px <= self.options.release * tolerance_px => true,
            Phase::Within { .. } => {
                self.phase = Phase::Steering;
                self.progress.begin(now_ns);
                false
            }
            _ if error_px <= tolerance_px => {
                self.phase = Phase::Within { since_ns: now_ns };
                true
            }
            _ => false,
        }
    }

    fn arrived_or_steering(&self, seen_at_ns: u64) -> Doing {
        let settle_ns = (self.options.settle_s * 1e9) as u64;
        match self.phase {
            Phase::Within { since_ns } if seen_at_ns >= since_ns.saturating_add(settle_ns) => {
                Doing::Arrived
            }
            _ => Doing::Steering,
        }
    }

    /// Returns the law's wish. Inputs blocked by a border are left out, and the others compensate
    /// as far as they can.
    fn within_borders(&self, law: &Law, r: &Coordinates) -> Wish {
        let mut free = self.limits.movable();
        loop {
            let wish = law.solve(&free);
            let mut blocked = false;
            for (input, free) in free.iter_mut().enumerate() {
                let velocity = wish.velocity[input];
                if *free && velocity != 0.0 && self.limits.blocks(input, r, velocity) {
                    (*free, blocked) = (false, true);
                }
            }
            // Each repetition removes at least one input.
            if !blocked {
                return wish;
            }
        }
    }

    fn command(&mut self, now_ns: u64, velocity: Coordinates, share: f64) {
        self.history.drive(now_ns, velocity);
        let at_ns = self.commanded.map_or(now_ns, |last| last.at_ns.max(now_ns));
        self.commanded = Some(Commanded {
            at_ns,
            velocity,
            share,
        });
    }

    fn step_s(&self, now_ns: u64) -> f64 {
        let step_ns = self
            .commanded
            .map_or(0, |last| now_ns.saturating_sub(last.at_ns));
        (step_ns as f64 * 1e-9).min(LONGEST_STEP_S)
    }

    fn delay_ns(&self) -> u64 {
        (self.options.robot.delay_s * 1e9) as u64
    }
}

/// Share of a wish that is kept; 1 if the wish is zero.
fn share_of(kept: &Coordinates, wish: &Coordinates) -> f64 {
    let (kept, wish) = (square(kept), square(wish));
    if wish == 0.0 {
        return 1.0;
    }
    (kept / wish).sqrt()
}

//! Shape servoing: a rope's descriptor in, gripper velocities out.
//!
//! One or two grippers at `r` (each x px, y px, θ rad; in space x, y, z in mm and three turns) hold a rope whose shape a camera sees as `s`: the
//! control points of a curve, or any points, stacked `[x₀, y₀, x₁, y₁, …]`, in space with z. How the shape answers to the grippers, `J = ∂s/∂r`, is the rope's own and not
//! known beforehand. A [`Servo`] finds it by small motions of each input in turn, keeps it up to date while it steers, and drives the
//! shape towards a target `s*` by damped least squares:
//!
//! ```text
//! v = λ (JᵀWJ + μ²I)⁻¹ JᵀW (s* − s)
//! ```
//!
//! It holds still when told that the rope is lost, and goes on by itself. It has no clock, no thread and does no I/O: it is told
//! the time, and allocates nothing once made. Whatever it is fed, no velocity is above the robot's limits.
//!
//! ```
//! use lariat_control::{Doing, Observation, Options, Servo};
//!
//! // A rope of three control points, held at its last: it answers as it likes.
//! let rope = |[x, y, turn]: [f64; 3]| [0.0, 0.0, 0.5 * x - 40.0 * turn, 0.7 * y + 60.0 * turn, x, y];
//! let mut servo: Servo = Servo::new(Options::default(), &rope([180.0, 60.0, 0.4]))?;
//! let (mut gripper, mut now_ns) = ([150.0, 0.0, 0.0], 0);
//! loop {
//!     let command = servo.see(Observation::new(&rope(gripper), now_ns), now_ns);
//!     if command.doing == Doing::Arrived { break }
//!     now_ns += 10_000_000;
//!     for (pose, velocity) in gripper.iter_mut().zip(command.velocities[0]) { *pose += 0.01 * velocity }
//! #   assert!(now_ns < 20_000_000_000);
//! }
//! # assert!((gripper[0] - 180.0).abs() < 5.0 && (gripper[1] - 60.0).abs() < 5.0, "{gripper:?}");
//! # Ok::<(), lariat_control::ServoError>(())
//! ```
//!
//! | for | see |
//! |---|---|
//! | the robot: limits of speed, acceleration and place, its delay | [`Robot`], [`Workspace`] |
//! | what counts as distance between two shapes | [`Metric`]: of curves, not of their control points, where the feature is a curve |
//! | how well each point is seen | [`Weights`], by which the law weighs and the estimator learns |
//! | how `J` is learnt | [`Estimator`]: Broyden's rule, or a Kalman filter on its entries; [`Learning`], [`Exploring`] |
//! | what it does, and why it holds | [`Doing`], [`Why`] |
//! | a robot that measures where it is | [`Servo::robot_is_at`] |
//!
//! With a reader (`lariat_wire`) a loop is this, and a command for the robot in every case:
//!
//! ```text
//! let command = match reader.wait(deadline)?.only_rope(max_age) {
//!     Seen::Fresh(rope) => servo.see(Observation::new(rope.control_points().as_flattened(), rope.exposed_ns()), now_ns()),
//!     Seen::Partial(rope) => servo.see(Observation { partial: true, ..as above }, now_ns()),
//!     Seen::Lost(_) => servo.hold(Why::Lost, now_ns()),
//!     Seen::Stale(_) => servo.hold(Why::Stale, now_ns()),
//!     Seen::Absent(_) => servo.hold(Why::Absent, now_ns()),
//! };
//! ```
//!
//! with `weights: Weights::Covariances(&descriptor.covariances[..count])`, and the metric of the curve: [`Metric::bezier`], or
//! [`Metric::of_rows`] of the shape's `jacobian_at`.
//!
//! # In space
//!
//! A [`Servo`] is one of the plane, with three coordinates a gripper; a [`SpaceServo`] has six (`A`), and shapes of three coordinates a
//! point; what is px here is mm there. Turns are rates about three axes that turn with the gripper ([`Tool`]): two across the rope, and the
//! rope itself, which does nothing to one that may be twisted, and has the limit 0 then. Covariances are
//! [3×3](Weights::Covariances3).
//!
//! # Delay
//!
//! A shape is of the moment at which its image was *exposed*, and the grippers have moved since. The servo remembers where they were at
//! every moment of the last second or so. It pairs `δs` of two images with `δr` between the same two exposures, so that no delay
//! corrupts `J`, and it steers by the shape that the rope should have *now*, `s + J (r(now) − r(exposed))`: a Smith predictor (O. Smith
//! 1957), whose plant is the integrator that a velocity-driven rope is.
//!
//! # Sources
//!
//! The loop is that of D. Navarro-Alarcon and others (*Automatic 3-D manipulation of soft objects by robotic arms with an adaptive
//! deformation model*, IEEE T-RO 32, 2016; with Y. Liu, *Fourier-based shape servoing*, IEEE T-RO 34, 2018), after K. Hosoda and
//! M. Asada (*Versatile visual servoing without knowledge of true Jacobian*, IROS 1994). Each module cites what it rests on.
//!
//! # How it works
//!
//! `crates/control`: what docs/control.md (`docs/control.md`) says of a loop, as a library that is lifted out whole. It is told images and the
//! time, and answers with velocities; it has neither clock nor thread, and allocates nothing once made (its memory is of fixed size:
//! 32 points, two grippers of six coordinates; some 150 KB, most of it the way of the grippers). In the order in which an image goes through:
//!
//! - **Is it to be gone by** (`servo/sight`): as many numbers as the target, all of them places in a picture, a time that does not go back, an
//!   image not too old. If not, velocity 0 in the same call, with the reason, and nothing else has changed.
//! - **Where the grippers were** when it was exposed (`history`): the commanded velocities, integrated, at some thousand moments. A robot that
//!   measures its place corrects it (`robot_is_at`). Angles are px-like from there on, by a lever.
//! - **What it teaches** (`explore`, `pairs`, `estimator`). At the start each input goes out and back; its column of `J` is the slope of all
//!   images of that time over where the input was at their exposures. After that pairs of images teach, far enough apart in `r` for their
//!   difference to be three times its noise: not each image and the next, between which at 500 frames/s the grippers move by a fifth of a
//!   pixel. Broyden's rule and the Kalman filter differ in the gain alone; one covariance serves all rows of `J`, since in the metric's
//!   coordinates all have the same noise.
//! - **What counts** (`metric`, `weighing`): distance is that of curves, `M = BᵀB/N`, not of control points. The law's `W` is `M`,
//!   scaled by how each point's variance differs from what even noise would make of it: `Σ⁻¹` by the same model that readers have
//!   (`lariat-wire`'s `covariance`).
//! - **Where the rope is now**: `s + J (r(now) − r(exposed))`. On a linear rope with 100 ms of delay and λ = 8/s the overshoot is 34 % without
//!   it, which is that of the delayed equation, and none with it (`crates/control/tests/all/loops.rs` holds both).
//! - **The law** (`law`, `eigen`): damped least squares by the eigenvectors of `JᵀWJ`, more damped near a singularity. An input that a
//!   border of its workspace blocks is taken out and the rest solved again, so that a gripper slides along the border.
//! - **What the robot may do** (`limits`): the whole vector is scaled, its direction kept; then acceleration, borders, and two grippers that
//!   must not pull their rope taut. A property test feeds it numbers of every kind: no command is above a limit.
//! - **What it is at** (`servo`, `progress`): exploring, steering, arrived (the shape still there some time after it stood still), holding. A hold
//!   is at once and ends by a ramp. A loop that gets no nearer for a second explores again, a few times at most; time in which the limits
//!   leave little of what the law asks for counts less.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod broyden;
mod command;
mod eigen;
mod error;
mod estimator;
mod explore;
mod history;
mod jacobian;
mod kalman;
mod law;
mod limits;
mod metric;
mod options;
mod pairs;
mod progress;
mod robot;
mod servo;
mod setters;
mod tool;
mod weighing;

pub use command::{Command, Doing, Observation, Weights, Why};
pub use error::{MetricError, ServoError};
pub use metric::Metric;
pub use options::{Estimator, Exploring, Learning, Options};
pub use robot::{Robot, Workspace};
pub use servo::{Servo, SpaceServo};
pub use tool::Tool;

/// The most points that a shape can have: as many as a descriptor has control points.
pub const MAX_POINTS: usize = 32;

/// Coordinates of a shape, three for each point in space; in the plane two, and the rest is 0.
const MAX_FEATURES: usize = 3 * MAX_POINTS;

/// Coordinates of two grippers in space: three of place and three turns each. In the plane the first six are x, y, θ of each, and the others do
/// not move.
const INPUTS: usize = 12;

/// Of both grippers, all px-like: angles are multiplied by the robot's lever. Of velocities, px/s.
type Coordinates = [f64; INPUTS];

/// A shape, or a difference of two. Behind its size all is 0.
type Features = [f64; MAX_FEATURES];

/// Dimensions in which a gripper with so many coordinates moves.
const fn dimensions(axes: usize) -> usize {
    match axes {
        6 => 3,
        _ => 2,
    }
}

#[cfg(test)]
mod random;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

//! Shape servoing: a rope's descriptor in, gripper velocities out.
//!
//! One or two grippers at `r` hold a rope whose shape a camera sees as `s`. Each gripper has x and
//! y in px and an angle in rad. `s` is the control points of a curve, or any points, stacked as
//! `[x₀, y₀, x₁, y₁, …]`. The Jacobian `J = ∂s/∂r` depends on the rope and is unknown at first. A
//! [`Servo`] finds it by small motions of each input, updates it while steering, and drives the
//! shape to a target `s*` by damped least squares:
//!
//! ```text
//! v = λ (JᵀWJ + μ²I)⁻¹ JᵀW (s* − s)
//! ```
//!
//! It holds while the rope is lost and then continues by itself. The caller passes the time. This
//! crate has no clock, thread or I/O. Once made, a servo does not allocate. Every velocity respects
//! the robot's limits, whatever the input.
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
//! - [`Robot`], [`Workspace`]: limits of speed, acceleration and place, and the robot's delay
//! - [`Metric`]: distance of two shapes, or of their curves
//! - [`Weights`]: how well each point is seen
//! - [`Estimator`], [`Learning`], [`Exploring`]: how `J` is learned, by Broyden's rule or a Kalman
//!   filter
//! - [`Doing`], [`Why`]: the servo's state, and why it holds
//! - [`Servo::robot_is_at`]: for a robot that measures its position
//!
//! With a reader of `lariat_wire`, every case gives a command:
//!
//! ```text
//! let command = match reader.wait(deadline)?.only_rope(max_age) {
//!     Seen::Fresh(rope) => servo.see(Observation::new(rope.control_points().as_flattened(), rope.exposed_ns()), now_ns()),
//!     Seen::Partial(rope) => servo.see(Observation { partial: true, ..as above }, now_ns()),
//!     Seen::Unsure(..) => servo.hold(Why::Told, now_ns()),
//!     Seen::Lost(_) => servo.hold(Why::Lost, now_ns()),
//!     Seen::Stale(_) => servo.hold(Why::Stale, now_ns()),
//!     Seen::Absent(_) => servo.hold(Why::Absent, now_ns()),
//! };
//! ```
//!
//! Use `weights: Weights::Covariances(&descriptor.covariances[..count])`, and the curve's metric:
//! [`Metric::bezier`], or [`Metric::of_rows`] of the shape's `jacobian_at`.
//!
//! # 3-D
//!
//! A [`SpaceServo`] has six coordinates per gripper, and shapes with three per point, in mm instead
//! of px. Turns are rates about three axes of the gripper ([`Tool`]): two across the rope, and the
//! rope itself. Set the speed limit of the last turn to 0 if the rope may twist. Covariances are
//! [3×3](Weights::Covariances3).
//!
//! # Delay
//!
//! A shape belongs to the moment of its exposure. The servo remembers where the grippers were. It
//! learns from differences `δs` and `δr` between the same two exposures, so delay does not corrupt
//! `J`. It steers by the shape predicted for now, `s + J (r(now) − r(exposed))`: a Smith predictor
//! (O. Smith 1957) for a velocity-driven rope, which acts as an integrator.
//!
//! # Steps
//!
//! 1. `servo/sight` rejects unusable images: velocity 0 with a reason, and no other change.
//! 2. `history` gives the grippers' place at the exposure.
//! 3. `explore` finds the first `J`; `pairs` and `estimator` update it.
//! 4. `metric` and `weighing` define `W`.
//! 5. `law` and `eigen` solve for the velocity, leaving out inputs that a border blocks.
//! 6. `limits` scales the velocity without changing its direction, then applies the limits of
//!    acceleration, borders, and the grippers' distance.
//! 7. `servo` and `progress` set the state. Without progress the servo explores again.
//!
//! # Known limitations
//!
//! - At most [`MAX_POINTS`] points and two grippers.
//! - Tested on the simulated rope only.
//! - An unreachable target is not recognized.
//!
//! # Sources
//!
//! D. Navarro-Alarcon and others (*Automatic 3-D manipulation of soft objects by robotic arms with
//! an adaptive deformation model*, IEEE T-RO 32, 2016; with Y. Liu, *Fourier-based shape servoing*,
//! IEEE T-RO 34, 2018), after K. Hosoda and M. Asada (*Versatile visual servoing without knowledge
//! of true Jacobian*, IROS 1994).

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

/// Maximum number of points in a shape: the maximum number of control points in a descriptor.
pub const MAX_POINTS: usize = 32;

/// Coordinates of a shape: three for each point in 3-D. In the plane there are two, and the rest is
/// 0.
const MAX_FEATURES: usize = 3 * MAX_POINTS;

/// Coordinates of two grippers in 3-D: position and three turns each. In the plane, the first six
/// are x, y and θ of each, and the others do not move.
const INPUTS: usize = 12;

/// Coordinates of both grippers in px, or px/s for velocities. Angles are multiplied by the robot's
/// lever.
type Coordinates = [f64; INPUTS];

/// A shape, or the difference of two. Entries after its size are 0.
type Features = [f64; MAX_FEATURES];

/// Dimensions in which a gripper with this many coordinates moves.
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

//! A rope on a table seen from above, held by one or two grippers: position-based dynamics, one unit a pixel.
//!
//! ```
//! use lariat_simulation::{Options, Simulation, TargetShape, at_equal_steps};
//!
//! let options = Options::default();
//! let target = TargetShape::U.reached(&options, 120)?;
//! let mut simulation = Simulation::new(&options)?;
//! for _ in 0..500 {
//!     simulation.command(&[[20.0, 0.0, 0.3], [-20.0, 0.0, -0.3]]); // px/s, px/s, rad/s
//!     simulation.step(); // a millisecond
//! }
//! let seen = at_equal_steps(simulation.visible(), 120);
//! assert_eq!(seen.len(), target.points.len());
//! # Ok::<(), lariat_simulation::OptionsError>(())
//! ```
//!
//! The rope hardly stretches, resists bending and rubs on the table ([`Options`]); how it is computed stands at the head
//! of `rod`. It does not feel itself: strands pass through each other. Each gripper clamps an end, place and direction
//! ([`Pose`]), and goes where it is [told](Simulation::command) as fast as the robot's [`Limits`] allow. A robot that feels
//! the rope taut between its grippers pulls no farther.
//!
//! Pure: no I/O, no clock, no threads; nothing is allocated in a step. Sums are in a fixed order, roots are IEEE's, sines
//! libm's: the same commands give the same rope, to the last bit, on every machine.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod band;
mod gripper;
mod options;
mod random;
mod rod;
mod shape;
mod simulation;
mod target;

pub use gripper::Pose;
pub use options::{Limits, MAX_GRIPPERS, Options, OptionsError};
pub use rod::Energy;
pub use shape::at_equal_steps;
pub use simulation::{STEP_NS, STEP_S, Simulation};
pub use target::{NoTarget, Target, TargetShape};

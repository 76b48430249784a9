//! A rope held by one or two grippers, simulated by position-based dynamics. It is either on a
//! table seen from above, with one unit per pixel, or lifted off the table, with one unit per
//! millimeter.
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
//! The rope hardly stretches, resists bending and has friction with the table ([`Options`]); the
//! documentation of `rod` explains the method. There is no self-contact: strands pass through each
//! other. Each gripper clamps an end in position and direction ([`Pose`]). It moves as
//! [commanded](Simulation::command), as fast as the robot's [`Limits`] allow. A robot that feels a
//! taut rope between its grippers pulls no farther. A [`Simulation`] is in the plane of the table.
//! A [`SpaceSimulation`] has gravity, a table below, and grippers with a [pose in 3-D](SpacePose).
//!
//! Pure: no I/O, no clock, no threads, and no allocation within a step. Sums have a fixed order,
//! roots are IEEE's and sines are libm's. Therefore the same commands give the same rope on every
//! machine, bit for bit.
//!
//! # How the chain shows it
//!
//! `crates/simulation` simulates the rope and the robot in steps of a millisecond.
//! `crates/capture/src/simulated.rs` runs it in real time, and `crates/drawn` draws its pictures.
//! The shell (`crates/chain/src/stages/capture.rs`) passes the rig's commands to it.
//!
//! **The rope** (`rod`, `band`) is a chain of 61 masses under extended position-based dynamics
//! (XPBD: Macklin et al. 2016, and *Small Steps* 2019), with one iteration per step. The
//! constraints of a chain, alternately stretch and bend, couple at most four rows. The system is
//! therefore solved exactly, by a banded LDLᵀ, instead of constraint by constraint. The stiffness
//! is then the requested one whatever the step size, and the rope between two clamps is an elastica
//! that hardly stretches. Bending is that of discrete elastic rods, 2 tan(φ/2). Coulomb friction is
//! a drag with the coefficient μg divided by the speed, implicit in each node's inverse mass. It
//! can only remove energy, and it holds the rope below 10⁻³ px/s. One pixel is a millimeter;
//! stiffness and friction are those of a cable on a smooth table. There is no self-contact. Tests
//! check that the energy does not grow in any step while the grippers rest, and that the length
//! stays within 2 % in the fastest motion. They also check a digest of the results: sums have one
//! order, roots are IEEE's, and sines are libm's.
//!
//! **In 3-D** (`space`), the same chain has three coordinates, and each node bends about three
//! axes. The band is 11 wide instead of 5, and a step takes about five times as long. Gravity pulls
//! the rope down. The table is a stiff damped spring, implicit like friction. In 3-D, friction
//! depends on the contact pressure. The rope has no torsional stiffness. The code for commands and
//! clamps is the same as in the plane (`held`, `gripper`, `rod`).
//!
//! **The robot** (`gripper`) clamps three nodes of an end, which fixes position and direction. It
//! limits velocities, stays in its workspace, stops 0.25 s after the last command, and does not
//! pull beyond the rope's length. Grippers that move apart on a taut rope are moved back along it,
//! each in proportion to its motion.
//!
//! **Targets** (`target`): `u`, `s` and `line` are poses. The shape is the one that the rope takes
//! when it is slowly moved there from its own start, so it can be reached. The S is that of an
//! elastica without tension or compression, because a compressed rod between antisymmetric clamps
//! has several shapes. The line sags by a twentieth of its length, because the middle of a taut
//! rope moves many times as far as a gripper does.
//!
//! **The picture.** Frames are like a camera's: the pacer gives the time, the simulation advances
//! to it, the picture is drawn, and `exposed_ns` is that time. Between two frames, the source
//! checks for commands every 4 ms and simulates up to 3 ms behind the clock. A command therefore
//! takes effect at its `sent_ns`, and little work remains at the time of the frame. Grippers are
//! orange, with a wrist much wider than the rope, so that extraction removes them from the mask.
//! The truth is the centerline from jaw to jaw.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod band;
mod gripper;
mod held;
mod options;
mod rod;
mod shape;
mod simulation;
mod space;
mod target;
mod vector;

pub use gripper::{Pose, SpacePose};
pub use held::{STEP_NS, STEP_S};
pub use options::{Limits, MAX_GRIPPERS, Options, OptionsError};
pub use rod::Energy;
pub use shape::at_equal_steps;
pub use simulation::Simulation;
pub use space::{RADIUS_MM, SpaceSimulation};
pub use target::{NoTarget, SpaceTarget, Target, TargetShape};

//! A rope held by one or two grippers, on a table seen from above, one unit a pixel, or lifted off it, one unit a millimetre:
//! position-based dynamics.
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
//! the rope taut between its grippers pulls no farther. A [`Simulation`] is in the plane of the table; a [`SpaceSimulation`] has gravity, the
//! table below, and grippers with a [place and direction in space](SpacePose).
//!
//! Pure: no I/O, no clock, no threads; nothing is allocated in a step. Sums are in a fixed order, roots are IEEE's, sines
//! libm's: the same commands give the same rope, to the last bit, on every machine.
//!
//! # How the chain shows it
//!
//! `crates/simulation` is the rope and the robot, step by step of a millisecond; `crates/capture/src/simulated.rs` runs it in real
//! time, and `crates/drawn` takes its picture; the shell (`crates/chain/src/stages/capture.rs`) hands it the rig's commands.
//!
//! **The rope** (`rod`, `band`) is a chain of 61 masses under extended position-based dynamics (XPBD: Macklin et al. 2016, and *Small
//! Steps* 2019), one iteration a step. The constraints of a chain, stretch and bend in turns, couple no farther than four rows:
//! the system is solved exactly, by a banded LDLᵀ, instead of constraint by constraint. Stiffness is then what was asked for, whatever the step, and the
//! rope between two clamps is an elastica, and hardly stretches. Bending is that of discrete elastic rods, 2 tan(φ/2).
//! Coulomb friction is a drag of μg over the speed, implicit in each mass's inverse mass: it can only take energy, and below
//! 10⁻³ px/s it holds. One pixel is a millimetre; stiffness and friction are a cable's on a smooth table. There is no self-contact. A
//! test holds the energy from growing in any step while grippers rest, the length to 2 % in the fastest motion, and all of it to a digest:
//! sums have one order, roots are IEEE's, sines libm's.
//!
//! **In space** (`space`) the same chain has three coordinates, and at each node bends about three axes: the band is 11 wide instead of 5, and a step
//! takes some five times as long. Gravity takes it down, the table is a stiff damped spring, implicit like friction, which there is by
//! what presses. It may be twisted as one likes. What it is told and what holds it is in the plane and in space one code
//! (`held`, `gripper`, `rod`), and in the plane the same to the bit.
//!
//! **The robot** (`gripper`) clamps an end by three nodes: place and direction. It slows down what is faster than its limits, stays
//! in its workspace, stops 0.25 s after the last command, and pulls no farther than the rope is long: grippers that go apart at a taut
//! rope are put back along it, each by its share.
//!
//! **Targets** (`target`): `u`, `s`, `line` are poses, and the shape is what the rope takes when it is slowly brought there from its own
//! start: so it can be reached. The S is the one of an elastica neither pulled nor pushed, as under a push a rod between
//! antisymmetric clamps has several shapes; the line hangs by a twentieth of its length, as a taut rope's middle moves by
//! many times what a gripper does.
//!
//! **The picture.** Frames are a camera's: the moment comes by the pacer, the simulation goes on to it, the picture is drawn then
//! and `exposed_ns` is the moment. Between two frames the source looks for commands every 4 ms and simulates up to
//! 3 ms behind the clock, so that a command takes effect at its `sent_ns` and little is left to do at the moment. Grippers are
//! orange, with a wrist far wider than the rope: extraction takes what is so out of the mask. The truth is the
//! centerline from jaw to jaw.

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

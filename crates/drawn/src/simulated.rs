//! The simulated rope, drawn as a camera would see it: table, rope, grippers, a hand.

mod gripper;
mod hand;
mod plate;
mod scene;

pub use hand::HandOptions;
pub use scene::Scene;

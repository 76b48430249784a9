//! The simulated rope, drawn as a camera would see it: table, rope, grippers, a hand; or, lifted, by a colour and a depth camera.

mod gripper;
mod hand;
mod lifted;
mod plate;
mod rays;
mod scene;

pub use hand::HandOptions;
pub use lifted::{SpaceCameras, SpaceScene};
pub use scene::Scene;

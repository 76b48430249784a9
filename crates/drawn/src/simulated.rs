//! The simulated rope as a camera sees it: table, rope, grippers, a hand. A lifted rope is drawn
//! for a color camera and a depth camera.

mod gripper;
mod hand;
mod lifted;
mod plate;
mod rays;
mod scene;

pub use hand::HandOptions;
pub use lifted::{SpaceCameras, SpaceScene};
pub use scene::Scene;

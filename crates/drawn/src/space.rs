//! Ropes in space whose centerlines are known, as cameras see them that stand somewhere: in colour, and in depth.
//!
//! Millimetres in a frame whose plane z = 0 is the table, z up. An [`Eye`] is a pinhole of its own arithmetic, and none of the
//! product's, which is held against what is drawn here. A [`LiftedRope`] lies on the table, or is lifted off it here and there, and
//! may cross itself, touching or with air between; it is drawn as a round tube by rays, each pixel's nearest hit by a depth
//! buffer, in colour with 16 rays a pixel and in depth with 9, through the faults of a [`DepthSensor`].

mod eye;
mod paint;
mod rope;
mod sensor;

pub use eye::Eye;
pub(crate) use eye::dot;
pub use paint::{Painter, picture};
pub(crate) use rope::End;
pub use rope::{LiftOptions, LiftedRope, NoSuchRope};
pub use sensor::{DepthPainter, DepthSensor, depth};

//! Ropes in 3-D with known centerlines, as color and depth cameras at any position see them.
//!
//! Units are millimeters, in a frame whose plane z = 0 is the table, with z up. An [`Eye`] is a
//! pinhole camera. Its arithmetic is independent of the product's, because the product is tested
//! against these drawings. A [`LiftedRope`] is on the table or lifted off it here and there. At
//! its crossings, the strands touch or have air between them. It is drawn as a round tube by
//! rays, and a depth buffer keeps each ray's nearest hit. Color has 16 rays per pixel. Depth has 9,
//! and the errors of a [`DepthSensor`].

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

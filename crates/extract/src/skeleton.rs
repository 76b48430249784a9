//! The second step: from the mask to lines one pixel wide. The result is a list of pixels with
//! their neighbors and their distances to the rope's edge.

mod pixels;
pub(crate) mod thin;
pub(crate) mod wide;

pub(crate) use pixels::{NONE, Pixel, Skeleton};

//! How far ropes are: a depth image beside the colour one, read along their centerlines.
//!
//! A rope's centerline comes from the colour image, where it is a few hundredths of a pixel sure; how far each of its points is comes
//! from the depth image. No image is aligned to the other: only the rope's points are taken across.
//!
//! ```text
//! pixel ──lens──▶ ray ──at a depth──▶ mm, colour camera ──pose──▶ mm, depth camera ──lens──▶ its pixel
//! ```
//!
//! 1. **Found.** A ray of the colour camera is a line in the depth image: at every few points of the rope that is walked from near to
//!    far to the first place where what is measured is where the ray is. The first, as the table behind a lifted rope, which the depth
//!    camera may see from beside, would agree with the ray as well.
//!    One such place alone that is far behind those beside it was seen through a hole.
//! 2. **Measured.** Around every second point, in the rope's inner width only, an edge's mixed pixels left out, depth is read at 32
//!    places. A rope is round: what lies `u` beside its axis is nearer than the axis by √(r² − u²) / |ρ × d|, with ρ the ray, one ahead,
//!    d the rope's direction, and its radius r half of its width in the colour image. The mean of what they say of the axis, twice
//!    without what is far from it, with the variance of the sensor's model and of their spread.
//!    What the rope cannot go on to from the others, as the table beyond an end that the colour image has too far out, is no measurement.
//! 3. **Bridged.** Where something covers the rope (another strand, a hand), and where the sensor has nothing, depth goes on
//!    straight between the measured points, with a variance that grows with the way.
//! 4. **Cut.** At an end that rises or falls, the outline in the colour image goes on beyond the axis.

mod file;
mod image;
mod pair;
mod rope;

pub use file::DepthCalibration;
pub(crate) use file::read_range;
pub use image::{DepthImage, DepthImageError, DepthKind};
pub use pair::{DepthCamera, DepthCameraError};
pub use rope::{NoDepth, RopeDepth};

//! Depths of ropes: reads a depth image along the centerlines that a color image shows.
//!
//! A rope's centerline comes from the color image, where it is accurate to a few hundredths of a
//! pixel. The depth of each of its points comes from the depth image. Neither image is aligned to
//! the other; only the rope's points are transferred.
//!
//! ```text
//! pixel ──lens──▶ ray ──at a depth──▶ mm, color camera ──pose──▶ mm, depth camera ──lens──▶ its pixel
//! ```
//!
//! 1. **Find.** A ray of the color camera is a line in the depth image. At every few points of the
//!    rope, this line is walked from near to far. The walk ends at the first place where the
//!    measured depth agrees with the ray. Later places do not count: the depth camera may see the
//!    table behind a lifted rope from the side, and that place would agree with the ray too. A
//!    single place that is far behind its neighbors was seen through a hole and is dropped.
//! 2. **Measure.** Around every second point, depth is read at 32 places within the rope's inner
//!    width, without the mixed pixels of an edge. A rope is round: a place `u` to the side of its
//!    axis is closer than the axis by √(r² − u²) / |ρ × d|. Here ρ is the ray at a depth of one, d
//!    the rope's direction, and r its radius, half of its width in the color image. The mean of the
//!    resulting depths of the axis is computed twice, the second time without outliers. Its
//!    variance comes from the sensor's model and from the spread of the values. A place does not
//!    count if the rope cannot reach it from the other places. An example is the table beyond an
//!    end that the color image puts too far out.
//! 3. **Bridge.** Depth is interpolated linearly between the measured points where something covers
//!    the rope (another strand, a hand), or where the sensor's data are missing. Its variance grows
//!    with the distance.
//! 4. **Cut.** At an end that rises or falls, the outline in the color image continues beyond the
//!    axis and is shortened.

mod file;
mod image;
mod pair;
mod rope;

pub use file::DepthCalibration;
pub(crate) use file::read_range;
pub use image::{DepthImage, DepthImageError, DepthKind};
pub use pair::{DepthCamera, DepthCameraError};
pub use rope::{NoDepth, RopeDepth};

//! Where ropes are: two colour cameras that know where they stand to each other, each with the ropes' centerlines in its picture.
//!
//! ```text
//! pixel of the first ──lens──▶ ray ──pose──▶ epipolar line of the second ──∩ the rope there──▶ depth
//! ```
//!
//! 1. **Matched.** The epipolar line of a point crosses the other view's curve here and there: each crossing is a candidate, with a depth.
//!    Through the candidates of a rope goes the chain, forward or backward along the other curve, that has the most of them in it and is
//!    the least rugged: both views see as much rope between two points, but for what it rises. Which rope is which, and which way round,
//!    is the pairing whose chains are the best. Where a view takes strands for each other that touch there, the chain is better with the
//!    parts between two contacts turned, and they are.
//! 2. **Measured.** Inverse depth along the rope is a spline: the sum of squares of its distances from the other curve, across that curve,
//!    and of its bends is least (Gauss and Newton; the curve between its points is a cubic). Where the rope runs along the epipolar line
//!    its distance from the curve says next to nothing of its depth, and the spline goes by the neighbors there: such stretches are
//!    bridged, as are those under something. How much a rope may bend against how far its points may err is what makes the distances
//!    the likeliest (MacKay, *Bayesian interpolation*, 1992).
//! 3. **Sure.** A depth's variance is the diagonal of the spline's inverse information, times the variance of the distances.
//! 4. **Cut.** At an end that rises or falls the outline goes on beyond the axis.

mod curve;
mod exchanging;
mod file;
mod matching;
mod pair;
mod pairing;
mod refining;
mod ropes;
mod smooth;

pub use file::SecondCalibration;
pub use pair::{ViewPair, ViewPairError};
pub use pairing::Partner;
pub use ropes::{NoSecondView, RopeViews};

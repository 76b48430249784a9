//! Locates ropes in 3-D from two color cameras with a known relative pose and the centerlines in
//! both images.
//!
//! ```text
//! pixel of the first ──lens──▶ ray ──pose──▶ epipolar line of the second ──∩ the rope there──▶ depth
//! ```
//!
//! 1. **Match.** The epipolar line of a point crosses the other view's curve at several places.
//!    Each crossing is a candidate with a depth. A chain runs through the candidates of a rope,
//!    forward or backward along the other curve. The best chain contains the most candidates and is
//!    the least rugged: both views see equal lengths of rope between two points, except for its
//!    rise. The pairing with the best chains determines which rope is which, and its direction. If
//!    strands touch and a view confuses them, reversing the parts between two contacts improves the
//!    chain. They are then reversed.
//! 2. **Measure.** Inverse depth along the rope is a spline. It minimizes the sum of squared
//!    distances from the other curve, measured across that curve, plus weighted squares of the
//!    spline's bends (Gauss–Newton; the curve between its points is a cubic). If the rope runs
//!    along the epipolar line, its distance from the curve says almost nothing about its depth, and
//!    the spline follows its neighbors. Such stretches are bridged, as are covered ones. The weight
//!    of bends relative to distances is chosen to make the distances most likely (MacKay, *Bayesian
//!    interpolation*, 1992).
//! 3. **Estimate errors.** A depth's variance is the diagonal of the spline's inverse information
//!    matrix, times the variance of the distances.
//! 4. **Cut.** At an end that rises or falls, the outline continues beyond the axis and is
//!    shortened.

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

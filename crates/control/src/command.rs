//! Input and output of a servo.

use std::fmt;

/// A shape observed in an image.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
    /// The shape: points stacked `[x₀, y₀, x₁, y₁, …]`, px, in 3-D `[x₀, y₀, z₀, …]`, mm
    /// (`control_points().as_flattened()` of a reader's rope). It has as many points as the target.
    pub features: &'a [f64],
    /// Accuracy of each point.
    pub weights: Weights<'a>,
    /// Time at which the image was exposed, ns, on the same clock as `now_ns`.
    pub exposed_ns: u64,
    /// True if part of the rope is covered. The servo does not learn from such a shape. It steers
    /// at half the speed, or holds ([`Options::hold_on_partial`](crate::Options::hold_on_partial)).
    pub partial: bool,
}

impl<'a> Observation<'a> {
    /// Creates an observation of a whole shape with even weights.
    pub fn new(features: &'a [f64], exposed_ns: u64) -> Self {
        Self {
            features,
            weights: Weights::Even,
            exposed_ns,
            partial: false,
        }
    }
}

/// Accuracy of each point, as estimated by a least-squares fit for its control points.
///
/// The law uses each point's variance relative to its variance under even noise
/// ([`Metric`](crate::Metric)). The estimator uses the variances themselves.
#[derive(Debug, Clone, Copy)]
pub enum Weights<'a> {
    /// The variances that noise of [`Options::noise_px`](crate::Options::noise_px), even along the
    /// curve, would cause.
    Even,
    /// Reciprocal variance of each point's coordinates, 1/px²; from 10⁻¹² to 10¹².
    Points(&'a [f64]),
    /// Covariance of each point, `[xx, xy, yy]`, px², as in a descriptor; up to 10¹².
    Covariances(&'a [[f64; 3]]),
    /// Covariance of each point in 3-D, `[xx, xy, xz, yy, yz, zz]`, mm².
    Covariances3(&'a [[f64; 6]]),
}

/// Motion of the robot until the next command, and the reason for it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Command<const A: usize = 3> {
    /// Velocity of each gripper: px/s, px/s, rad/s; in 3-D mm/s along three axes and rad/s about
    /// three. Never above the robot's limits. Velocities of a missing gripper are 0.
    pub velocities: [[f64; A]; 2],
    /// The servo's state.
    pub doing: Doing,
    /// Distance of the last observed shape from the target, px: root mean square, as the
    /// [`Metric`](crate::Metric) defines it. `None` before the first one.
    pub error_px: Option<f64>,
    /// Condition number of `W^½J`, with θ measured by the robot's lever: the ratio of the rope's
    /// responses to the best and to the worst motion of the grippers. Infinite if a motion has no
    /// effect. `None` unless steering.
    pub condition: Option<f64>,
}

/// State of a servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Doing {
    /// The servo moves one input out and back, to measure the rope's response.
    Exploring {
        /// The moving gripper: 1 or 2.
        gripper: usize,
        /// The moving coordinate: `x`, `y` or `θ`; in 3-D `x`, `y`, `z`, or a turn, `θ₁`, `θ₂`,
        /// `θ₃`.
        axis: &'static str,
    },
    /// The servo drives the rope to the target, or has stopped there and waits to see whether the
    /// rope stays.
    Steering,
    /// The rope is within the tolerance and stays there. The velocity is 0.
    Arrived,
    /// The velocity is 0 until the reason is gone.
    Holding {
        /// Reason for the hold.
        why: Why,
    },
}

/// Why a servo holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Why {
    /// The rope is not in the image.
    Lost,
    /// The image is too old.
    Stale,
    /// There is no shape: nothing has arrived yet, there are several ropes, or the chain has
    /// restarted.
    Absent,
    /// Part of the rope is covered.
    Partial,
    /// The shape and the target differ in the number of coordinates.
    Size {
        /// Number of coordinates received.
        given: usize,
        /// Number of coordinates of the target.
        expected: usize,
    },
    /// A coordinate is not a number, or exceeds 10⁶ px.
    NotAShape,
    /// Invalid weights: too few, negative, or not finite.
    Weights,
    /// A time is earlier than a previous one, or the image is from the future.
    Clock,
    /// The caller requested it.
    Told,
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lost => f.write_str("the rope is out of sight"),
            Self::Stale => f.write_str("the last image is too old"),
            Self::Absent => f.write_str("there is no shape to steer by"),
            Self::Partial => f.write_str("a part of the rope is covered"),
            Self::Size { given, expected } => {
                write!(
                    f,
                    "the shape has {given} coordinates and the target {expected}"
                )
            }
            Self::NotAShape => f.write_str("a coordinate is not a position in a picture"),
            Self::Weights => f.write_str("invalid weights: each must be finite and not negative"),
            Self::Clock => f.write_str("time went back, or the image is of the future"),
            Self::Told => f.write_str("told to"),
        }
    }
}

impl fmt::Display for Doing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exploring { gripper, axis } => {
                write!(f, "exploring {axis} of gripper {gripper}")
            }
            Self::Steering => f.write_str("steering"),
            Self::Arrived => f.write_str("arrived"),
            Self::Holding { why } => write!(f, "holding: {why}"),
        }
    }
}

//! What goes into a servo, and what comes out.

use std::fmt;

/// A shape as an image shows it.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
    /// The shape: points stacked `[x₀, y₀, x₁, y₁, …]`, px, in space `[x₀, y₀, z₀, …]`, mm (`control_points().as_flattened()` of a reader's
    /// rope); as many as the target has.
    pub features: &'a [f64],
    /// How well each point is seen.
    pub weights: Weights<'a>,
    /// When the image was taken, ns, by the clock that `now_ns` is of.
    pub exposed_ns: u64,
    /// Whether a part of the rope is covered. Such a shape teaches nothing, and is steered by at half the speed, or not at all
    /// ([`Options::hold_on_partial`](crate::Options::hold_on_partial)).
    pub partial: bool,
}

impl<'a> Observation<'a> {
    /// A shape seen whole, every point as well as it can be.
    pub fn new(features: &'a [f64], exposed_ns: u64) -> Self {
        Self {
            features,
            weights: Weights::Even,
            exposed_ns,
            partial: false,
        }
    }
}

/// How well each point is seen: what a least-squares fit says of its control points.
///
/// The law goes by what each point's variance is beside what it would be of even noise
/// ([`Metric`](crate::Metric)); the estimator by the variances themselves.
#[derive(Debug, Clone, Copy)]
pub enum Weights<'a> {
    /// As even noise of the curve makes them, with noise of [`Options::noise_px`](crate::Options::noise_px) in all.
    Even,
    /// One by the variance of each point's coordinates, 1/px²; from 10⁻¹² to 10¹².
    Points(&'a [f64]),
    /// The covariance of each point, `[xx, xy, yy]`, px², as a descriptor has it; up to 10¹².
    Covariances(&'a [[f64; 3]]),
    /// The same in space, `[xx, xy, xz, yy, yz, zz]`, mm².
    Covariances3(&'a [[f64; 6]]),
}

/// What the robot is to do until the next command, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Command<const A: usize = 3> {
    /// Of each gripper: px/s, px/s, rad/s; in space mm/s along three axes and rad/s about three. Never above the robot's limits. Of a gripper that is not there 0.
    pub velocities: [[f64; A]; 2],
    /// What the servo is at.
    pub doing: Doing,
    /// Distance of the last seen shape from the target, px: root mean square by the [`Metric`](crate::Metric). `None` before there was one.
    pub error_px: Option<f64>,
    /// How much better the rope answers to the best motion of the grippers than to the worst: the condition number of `W^½J`, θ
    /// measured by the robot's lever. Infinite where a motion does nothing. `None` unless steering.
    pub condition: Option<f64>,
}

/// What a servo is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Doing {
    /// It moves one input there and back, to see how the rope answers.
    Exploring {
        /// Of which gripper: 1 or 2.
        gripper: usize,
        /// Which: `x`, `y` or `θ`; in space `x`, `y`, `z`, or a turn, `θ₁`, `θ₂`, `θ₃`.
        axis: &'static str,
    },
    /// It drives the rope to the target, or stands there and waits whether the rope stays.
    Steering,
    /// The rope is within the tolerance, and stays there: velocity 0.
    Arrived,
    /// Velocity 0 until it knows better.
    Holding {
        /// What it waits for.
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
    /// There is no shape: nothing came yet, several ropes, another run of the chain.
    Absent,
    /// A part of the rope is covered.
    Partial,
    /// The shape has another number of coordinates than the target.
    Size {
        /// How many came.
        given: usize,
        /// How many the target has.
        expected: usize,
    },
    /// A coordinate is no number, or farther off than 10⁶ px.
    NotAShape,
    /// Invalid weights: too few, negative, or not finite.
    Weights,
    /// A time before one that was given, or an image of the future.
    Clock,
    /// Whoever runs the loop says so.
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

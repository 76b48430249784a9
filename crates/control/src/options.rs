//! Settings for steering, learning and exploring.

use crate::error::ServoError;
use crate::setters::setters;
use crate::{Metric, Robot};

/// The settings of a servo. Each field has a method of its name that sets it:
/// `Options::default().gain(1.0)`.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Options<const A: usize = 3> {
    /// The grippers and their limits.
    pub robot: Robot<A>,
    /// Distance of two shapes. Default: that of points.
    pub metric: Metric,
    /// λ, 1/s: an error that can be corrected decays as `e^−λt`, as far as the speed limits allow.
    /// From 10⁻³ to 100. With `look_ahead`, the accuracy of `J` and the lag of the rope limit λ.
    /// Without `look_ahead`, the whole delay T limits it: 0.37/T is the maximum without overshoot.
    /// Default: 2.
    pub gain: f64,
    /// μ as a share of the shape's response to the best motion. It grows automatically when the
    /// response to the worst motion is nearly zero. From 0 to 1. Default: 0.05.
    pub damping: f64,
    /// The servo stops when the shape is within this distance of the target, px. From 10⁻⁶ to 10⁴.
    /// A tolerance below the noise of the shape is never reached. Default: 2.
    pub tolerance_px: f64,
    /// The servo resumes when the distance has grown to this many times the tolerance. From 1
    /// to 10. Default: 1.5.
    pub release: f64,
    /// The servo has arrived when an image exposed this long after it stopped still shows the shape
    /// within the tolerance, s. A rope may lag behind its grippers. From 0 to 10. Default: 0.2.
    pub settle_s: f64,
    /// Steer by the shape predicted for now, rather than the shape at the image's exposure.
    /// Default: yes.
    pub look_ahead: bool,
    /// Allow the target in reverse order: of the two directions, the servo chooses the one nearer
    /// to the first observed shape. Disable this for Fourier series, and for knots or a metric that
    /// are not symmetric. Default: yes.
    pub either_way: bool,
    /// Hold while part of the rope is covered. Otherwise, steer by the visible part at half the
    /// speed. Default: no.
    pub hold_on_partial: bool,
    /// Maximum age of an image to steer by, s. From 10⁻³ to 10. Default: 0.5.
    pub oldest_image_s: f64,
    /// Time to return to full speed after a hold, s. From 0 to 10. Default: 0.3.
    pub ramp_s: f64,
    /// Noise of shapes whose weights do not state it, px: root mean square by the metric. From 0 to
    /// 10³. Default: 0.5.
    pub noise_px: f64,
    /// Rule that keeps `J` up to date. Default: a Kalman filter.
    pub estimator: Estimator,
    /// Pairs of images that the rule learns from.
    pub learning: Learning,
    /// Motions that find `J` at the start.
    pub exploring: Exploring,
}

impl<const A: usize> Default for Options<A> {
    fn default() -> Self {
        Self {
            robot: Robot::default(),
            metric: Metric::default(),
            gain: 2.0,
            damping: 0.05,
            tolerance_px: 2.0,
            release: 1.5,
            settle_s: 0.2,
            look_ahead: true,
            either_way: true,
            hold_on_partial: false,
            oldest_image_s: 0.5,
            ramp_s: 0.3,
            noise_px: 0.5,
            estimator: Estimator::default(),
            learning: Learning::default(),
            exploring: Exploring::default(),
        }
    }
}

setters! {
    {const A: usize} Options<A>;
    robot: Robot<A>,
    metric: Metric,
    gain: f64,
    damping: f64,
    tolerance_px: f64,
    release: f64,
    settle_s: f64,
    look_ahead: bool,
    either_way: bool,
    hold_on_partial: bool,
    oldest_image_s: f64,
    ramp_s: f64,
    noise_px: f64,
    estimator: Estimator,
    learning: Learning,
    exploring: Exploring,
}

/// Rule by which the Jacobian follows the rope.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Estimator {
    /// C. Broyden's rank-one rule (*A class of methods for solving nonlinear simultaneous
    /// equations*, Math. Comp. 19, 1965), damped. It changes `J` only along the last motion.
    Broyden {
        /// Share of each innovation that is applied. Above 0, up to 1.
        share: f64,
    },
    /// A Kalman filter on the entries of `J`, modeled as a random walk. It tracks how accurately
    /// each motion's response is known, and weights each pair of images by its noise.
    Kalman {
        /// Standard deviation of an entry's change after the grippers have moved by 100 px, px per
        /// px. From 0 to 10.
        drift: f64,
    },
}

impl Default for Estimator {
    /// The Kalman filter. An entry is of the order of 1, and a rope bends over some hundreds of px.
    /// With 0.1, a rope on a table occasionally stalls before its target with an outdated `J`.
    /// Above 0.3, a rope that lags is more readily mistaken for one that responds less.
    fn default() -> Self {
        Self::Kalman { drift: 0.2 }
    }
}

impl Estimator {
    /// Broyden's rule at half its step. The noise of `J` is a third of the variance that one pair
    /// causes, `γ/(2 − γ)`.
    pub const BROYDEN: Self = Self::Broyden { share: 0.5 };
}

/// Criteria for the pairs of images that the estimator learns from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Learning {
    /// Minimum motion of the grippers between the two images, px. It must also be at least three
    /// times the noise of the difference of the two shapes, so that noise does not distort `J`.
    /// From 10⁻³ to 10³. Default: 2.
    pub least_step_px: f64,
    /// Maximum time between the two images, s. From 10⁻³ to 60. Default: 1.
    pub longest_pair_s: f64,
}

impl Default for Learning {
    fn default() -> Self {
        Self {
            least_step_px: 2.0,
            longest_pair_s: 1.0,
        }
    }
}

setters! {
    {} Learning;
    least_step_px: f64,
    longest_pair_s: f64,
}

/// The motions at the start, out and back with each input in turn.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Exploring {
    /// Reach of the motions, px; a turn moves the end of the robot's lever this far. Choose it far
    /// above the noise and well below the rope's length. From 10⁻² to 10³. Default: 13.
    pub reach_px: f64,
    /// Speed of the motions, px/s; never above the robot's limits. From 10⁻² to 10⁵. Default: 100.
    pub speed_px_s: f64,
    /// Explore again when the error has not fallen by a twentieth for this long, s. The time is up
    /// to four times as long if the robot's limits reduce the velocity that the law requests. From
    /// 0.1 to 10³. Default: 1.
    pub stalled_s: f64,
    /// Maximum number of repeated explorations. Default: 4.
    pub again: u32,
}

impl Default for Exploring {
    fn default() -> Self {
        Self {
            reach_px: 13.0,
            speed_px_s: 100.0,
            stalled_s: 1.0,
            again: 4,
        }
    }
}

setters! {
    {} Exploring;
    reach_px: f64,
    speed_px_s: f64,
    stalled_s: f64,
    again: u32,
}

impl<const A: usize> Options<A> {
    pub(crate) fn check(&self) -> Result<(), ServoError> {
        self.robot.check()?;
        let estimator = match self.estimator {
            Estimator::Broyden { share } => ("share", share, f64::MIN_POSITIVE, 1.0),
            Estimator::Kalman { drift } => ("drift", drift, 0.0, 10.0),
        };
        for (name, given, least, most) in [
            ("gain", self.gain, 1e-3, 100.0),
            ("damping", self.damping, 0.0, 1.0),
            ("tolerance_px", self.tolerance_px, 1e-6, 1e4),
            ("release", self.release, 1.0, 10.0),
            ("settle_s", self.settle_s, 0.0, 10.0),
            ("oldest_image_s", self.oldest_image_s, 1e-3, 10.0),
            ("ramp_s", self.ramp_s, 0.0, 10.0),
            ("noise_px", self.noise_px, 0.0, 1e3),
            estimator,
            ("least_step_px", self.learning.least_step_px, 1e-3, 1e3),
            ("longest_pair_s", self.learning.longest_pair_s, 1e-3, 60.0),
            ("reach_px", self.exploring.reach_px, 1e-2, 1e3),
            ("speed_px_s", self.exploring.speed_px_s, 1e-2, 1e5),
            ("stalled_s", self.exploring.stalled_s, 0.1, 1e3),
        ] {
            within(name, given, least, most)?;
        }
        Ok(())
    }
}

/// Also rejects NaN.
pub(crate) fn within(
    name: &'static str,
    given: f64,
    least: f64,
    most: f64,
) -> Result<(), ServoError> {
    if (least..=most).contains(&given) {
        return Ok(());
    }
    Err(ServoError::Option {
        name,
        given,
        least,
        most,
    })
}

//! How a servo is to drive, to learn and to explore.

use crate::error::ServoError;
use crate::setters::setters;
use crate::{Metric, Robot};

/// The settings of a servo. Each field has a method of its name that sets it:
/// `Options::default().gain(1.0)`.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Options<const A: usize = 3> {
    /// What may move, and how fast.
    pub robot: Robot<A>,
    /// What counts as the distance of two shapes. Default: of points.
    pub metric: Metric,
    /// λ, 1/s: an error that can be taken away falls by `e^−λt`, as far as the limits of speed allow. From 10⁻³ to 100. With
    /// `look_ahead` it is bounded by how well `J` is known and how fast the rope follows, without it by the whole delay T:
    /// 0.37/T if nothing is to overshoot. Default: 2.
    pub gain: f64,
    /// μ as a share of how strongly the shape answers to the best motion; where the worst is nearly none it grows by itself. From 0 to
    /// 1. Default: 0.05.
    pub damping: f64,
    /// The servo stands still when the shape is within this distance of the target, px. From 10⁻⁶ to 10⁴. Below what noise makes of
    /// the shape it never does. Default: 2.
    pub tolerance_px: f64,
    /// It goes on when the distance has grown to this many times the tolerance. From 1 to 10. Default: 1.5.
    pub release: f64,
    /// It has arrived when an image that was exposed this long after it began to stand there still shows the shape there, s: a rope may
    /// follow its grippers late. From 0 to 10. Default: 0.2.
    pub settle_s: f64,
    /// Steer by the shape as it should be now, not as it was when its image was exposed. Default: yes.
    pub look_ahead: bool,
    /// The target may be run through the other way: of the two, the one nearer to the first shape that is seen is taken. Not for Fourier
    /// series, nor for knots or a metric that differ from end to end. Default: yes.
    pub either_way: bool,
    /// Hold while a part of the rope is covered; else steer by what is seen, at half the speed. Default: no.
    pub hold_on_partial: bool,
    /// An image older than this is not steered by, s. From 10⁻³ to 10. Default: 0.5.
    pub oldest_image_s: f64,
    /// After a hold, the time in which the full speed comes back, s. From 0 to 10. Default: 0.3.
    pub ramp_s: f64,
    /// What noise makes of a shape whose weights do not say, px: root mean square by the metric. From 0 to 10³. Default: 0.5.
    pub noise_px: f64,
    /// How `J` is kept up to date. Default: a Kalman filter.
    pub estimator: Estimator,
    /// What it is kept up to date by.
    pub learning: Learning,
    /// How `J` is found at the start.
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

/// How the Jacobian follows the rope.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Estimator {
    /// C. Broyden's rank-one rule (*A class of methods for solving nonlinear simultaneous equations*, Math. Comp. 19, 1965), damped:
    /// it changes `J` only along the last motion.
    Broyden {
        /// The share of each surprise that is taken over. Above 0, to 1.
        share: f64,
    },
    /// A Kalman filter on the entries of `J`, which it takes for a random walk: it remembers how well each motion's answer is known,
    /// and weighs by the noise.
    Kalman {
        /// By how much an entry has changed after 100 px of the grippers' way: a standard deviation, px by px. From 0 to 10.
        drift: f64,
    },
}

impl Default for Estimator {
    /// The filter. An entry is of the order of 1, and a rope bends over some hundreds of px. With 0.1 a rope on a table now and then
    /// stands before its target with a `J` of long ago; with more than 0.3 one that lags behind is sooner taken for one that answers
    /// less.
    fn default() -> Self {
        Self::Kalman { drift: 0.2 }
    }
}

impl Estimator {
    /// Broyden's rule at half its step: noise in `J` is a third of the variance that one pair makes, `γ/(2 − γ)`.
    pub const BROYDEN: Self = Self::Broyden { share: 0.5 };
}

/// Which pairs of images the estimator learns from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Learning {
    /// Between the two the grippers must have moved by at least this, px; and by at least three times what noise makes of the
    /// difference of the two shapes, so that noise does not turn `J`. From 10⁻³ to 10³. Default: 2.
    pub least_step_px: f64,
    /// Images farther apart than this are no pair, s. From 10⁻³ to 60. Default: 1.
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

/// The motions at the start, there and back with each input in turn.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Exploring {
    /// How far, px; a turn by as much at the robot's lever. Far above the noise, well below the rope's length. From 10⁻² to 10³. Default: 13.
    pub reach_px: f64,
    /// How fast, px/s; never above the robot's limits. From 10⁻² to 10⁵. Default: 100.
    pub speed_px_s: f64,
    /// Explore again when the error has not fallen by a twentieth for this long, s; up to four times as long where the limits leave
    /// less of what the law asks for. From 0.1 to 10³. Default: 1.
    pub stalled_s: f64,
    /// How often at most. Default: 4.
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

/// NaN is within no range.
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

//! One rope of a frame, and where it will be.

use std::fmt;
use std::time::Duration;

use thiserror::Error;

use crate::shape::Growth;
use crate::{
    Centerline, CenterlinePoints, Descriptor, Descriptor3, Descriptors3, FitQuality,
    MAX_CONTROL_POINTS, NoShape, Shape, Unit,
};

/// Which rope: its number, which it keeps from frame to frame, and the run of the chain that gave it.
///
/// A chain that is restarted numbers its ropes again: a track of another run is never found again, so that no other
/// rope is taken for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Track {
    pub(crate) number: u32,
    pub(crate) run: u64,
}

impl Track {
    /// The rope of this number, in the run that this reader counts so ([`Frame::run`](crate::Frame::run)).
    pub fn new(run: u64, number: u32) -> Self {
        Self { number, run }
    }

    /// The rope's number, as messages, files and pictures have it.
    pub fn number(&self) -> u32 {
        self.number
    }

    /// Which run of the chain it is of, counted by this reader from 1.
    pub fn run(&self) -> u64 {
        self.run
    }
}

impl fmt::Display for Track {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.number)
    }
}

/// How a rope is taken to move between its images, for [`Rope::predict`]: the same that the chain's filter is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// The standard deviation of the acceleration of a point on the rope, along each axis, in units/s²
    /// (`acceleration_px_s2` in the chain's settings). Default: 1000, the chain's in pixels.
    pub acceleration: f64,
    /// How long an acceleration lasts before it is another, s. Default: 0.1, the chain's.
    pub lasts_s: f64,
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            acceleration: 1000.0,
            lasts_s: 0.1,
        }
    }
}

/// When a rope was seen, and by whom.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    /// When the frame was asked for.
    pub(crate) now_ns: u64,
    /// When the image was taken.
    pub(crate) exposed_ns: u64,
    pub(crate) run: u64,
    pub(crate) unit: Option<Unit>,
    /// From image to image, s; `None` before the second.
    pub(crate) period_s: Option<f64>,
    pub(crate) motion: Motion,
    /// Whether a coarse curve is as good as another.
    pub(crate) coarse: bool,
    /// The least confidence that is enough.
    pub(crate) min_confidence: f32,
}

/// A rope, as it was when its image was taken. It borrows the message in shared memory from the reader: copy what is to
/// be kept.
#[derive(Debug, Clone, Copy)]
pub struct Rope<'a> {
    descriptor: &'a Descriptor,
    points: &'a CenterlinePoints,
    space: InSpace<'a>,
    moment: Moment,
}

/// What the reader has of a frame in space.
#[derive(Debug, Clone, Copy)]
pub(crate) enum InSpace<'a> {
    /// It does not ask.
    NotFollowed,
    /// Nothing came for this frame.
    None,
    /// What came.
    Message(&'a Descriptors3),
}

/// Why it is not known where in space a rope is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoSpace {
    /// The reader does not ask for it.
    #[error("this reader reads ropes in the image only: have it follow_in_space()")]
    NotFollowed,
    /// The chain says nothing of space.
    #[error(
        "the chain says nothing of space for this frame: it needs a depth camera (lariat run --calibration FILE --depth FILE)"
    )]
    NoDepth,
    /// It says why not, or its numbers make no curve.
    #[error(transparent)]
    NoShape(#[from] NoShape),
}

impl<'a> Rope<'a> {
    pub(crate) fn new(
        descriptor: &'a Descriptor,
        points: &'a CenterlinePoints,
        space: InSpace<'a>,
        moment: Moment,
    ) -> Self {
        Self {
            descriptor,
            points,
            space,
            moment,
        }
    }

    /// Which rope it is: give it to [`Frame::rope`](crate::Frame::rope) to have the same one again.
    pub fn track(&self) -> Track {
        Track {
            number: self.descriptor.track,
            run: self.moment.run,
        }
    }

    /// How long ago the rope had this shape, when the frame was asked for: since its image was taken, and, of a lost one,
    /// since the last image that it was seen in.
    pub fn age(&self) -> Duration {
        let before_ns = self.descriptor.age_ns;
        let since_ns = self.moment.now_ns.saturating_sub(self.moment.exposed_ns);
        Duration::from_nanos(since_ns.saturating_add(before_ns))
    }

    /// When its image was taken, in nanoseconds of `CLOCK_MONOTONIC`.
    pub fn exposed_ns(&self) -> u64 {
        self.moment.exposed_ns
    }

    /// What it is measured in; `None` for a unit that this version does not know.
    pub fn unit(&self) -> Option<Unit> {
        self.moment.unit
    }

    /// The points that its curve was fitted to: where it was seen, whether the curve lies on them or not, and of points and
    /// center too. `None` if who describes it sends none; lariat's own chain always does.
    pub fn centerline(&self) -> Option<Centerline<'a>> {
        Centerline::of(self.points)
    }

    /// Whether the curve lies on those points; `None` for a number that this version does not know.
    pub fn fit(&self) -> Option<FitQuality> {
        self.descriptor.fit()
    }

    /// How sure it is that this is a rope, and its centerline whole and in order, 0 to 1: of those at 0.9, nine of ten are.
    /// Of a lost one, when it was last seen. [`Reader::min_confidence`](crate::Reader::min_confidence) asks for one.
    pub fn confidence(&self) -> f32 {
        self.descriptor.confidence
    }

    /// Its curve.
    ///
    /// # Errors
    /// The chain describes ropes by points or by their center: there is no curve.
    pub fn shape(&self) -> Result<Shape<'a>, NoShape> {
        Shape::of(self.descriptor)
    }

    /// Its curve in space, in mm, by what the depth camera shows. What has no place there has no curve, and says why: nothing is
    /// guessed. A rope that is lost is where it was.
    ///
    /// # Errors
    /// The reader does not [follow in space](crate::Reader::follow_in_space), the chain has no depth camera, or it is not known
    /// where the rope is.
    pub fn in_space(&self) -> Result<Shape<'a, 3>, NoSpace> {
        Ok(Shape::in_space(self.descriptor3()?)?)
    }

    /// All that the message in space says of it.
    ///
    /// # Errors
    /// As [`in_space`](Self::in_space), but where the message says why not.
    pub fn descriptor3(&self) -> Result<&'a Descriptor3, NoSpace> {
        match self.space {
            InSpace::NotFollowed => Err(NoSpace::NotFollowed),
            InSpace::None => Err(NoSpace::NoDepth),
            InSpace::Message(message) => {
                let mut curves = message.curves().iter();
                let own = curves.find(|curve| curve.track == self.descriptor.track);
                own.ok_or(NoSpace::NoDepth)
            }
        }
    }

    /// Its control points, `[x, y]`: feature points and center too, where the chain describes ropes by those.
    pub fn control_points(&self) -> &'a [[f64; 2]] {
        self.descriptor.control_points()
    }

    /// The velocities of its control points, units a second; `None` unless the chain filters them (`--filter`).
    pub fn velocities(&self) -> Option<&'a [[f64; 2]]> {
        let count = self.descriptor.control_points().len();
        (self.descriptor.filtered == 1).then(|| &self.descriptor.velocities[..count])
    }

    /// Arc length of the centerline.
    pub fn length(&self) -> f64 {
        self.descriptor.length
    }

    /// Which share of it was covered by something, and so bridged: 0 to 1.
    pub fn hidden(&self) -> f64 {
        let samples = self.descriptor.samples.max(1);
        f64::from(self.descriptor.hidden.min(samples)) / f64::from(samples)
    }

    /// Which of its ends leave the image, first and last: what lies outside is not part of the shape.
    pub fn leaves_image(&self) -> [bool; 2] {
        [1, 2].map(|bit| self.descriptor.border & bit != 0)
    }

    /// All that the message says of it.
    pub fn descriptor(&self) -> &'a Descriptor {
        self.descriptor
    }

    /// Where it will be at the moment `t_ns` (of `CLOCK_MONOTONIC`, as [`now_ns`](crate::now_ns) has it), by its velocities,
    /// and how uncertain: the covariance grows by what the rope may accelerate until then
    /// ([`Reader::expect_motion`](crate::Reader::expect_motion)).
    ///
    /// # Errors
    /// No curve, no velocities (yet), or a moment before the image or more than [`FARTHEST`] after it.
    pub fn predict(&self, t_ns: u64) -> Result<Prediction<'a>, NoPrediction> {
        let shape = self.shape()?;
        let velocities = self.velocities().ok_or(NoPrediction::NotFiltered)?;
        let (Some(period_s), true) = (
            self.moment.period_s,
            velocities.iter().flatten().any(|v| *v != 0.0),
        ) else {
            return Err(NoPrediction::JustBegun);
        };
        let ahead_ns = t_ns.checked_sub(self.moment.exposed_ns);
        let within = |ahead: &Duration| *ahead <= FARTHEST;
        let ahead = ahead_ns.map(Duration::from_nanos).filter(within);
        let seconds = ahead.ok_or(NoPrediction::TooFar)?.as_secs_f64();
        let Motion {
            acceleration,
            lasts_s,
        } = self.moment.motion;
        let growth = Growth {
            density: acceleration.powi(2) * lasts_s,
            period_s,
        };
        let count = shape.control_points().len();
        let mut control_points = self.descriptor.control_points;
        for (point, velocity) in control_points[..count].iter_mut().zip(velocities) {
            *point = [0, 1].map(|axis| point[axis] + seconds * velocity[axis]);
        }
        let mut covariances = self.descriptor.covariances;
        growth.after(seconds, &shape, &mut covariances[..count]);
        Ok(Prediction {
            of: self.descriptor,
            shape,
            control_points,
            covariances,
        })
    }
}

/// No prediction goes farther: the chain's own filter begins again after as long without an image.
pub const FARTHEST: Duration = Duration::from_millis(500);

/// A rope where it is thought to be at another moment.
#[derive(Debug, Clone, Copy)]
pub struct Prediction<'a> {
    of: &'a Descriptor,
    shape: Shape<'a>,
    control_points: [[f64; 2]; MAX_CONTROL_POINTS],
    covariances: [[f64; 3]; MAX_CONTROL_POINTS],
}

impl Prediction<'_> {
    /// Its curve there, with the covariance that it has then.
    pub fn shape(&self) -> Shape<'_> {
        let count = self.shape.control_points().len();
        self.shape
            .moved(&self.control_points[..count], &self.covariances[..count])
    }

    /// The rope's descriptor with the control points and covariances that it has then. All else is as it was seen.
    pub fn to_descriptor(&self) -> Descriptor {
        Descriptor {
            control_points: self.control_points,
            covariances: self.covariances,
            ..*self.of
        }
    }
}

/// Why it is not known where a rope will be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoPrediction {
    /// It has no curve.
    #[error(transparent)]
    NoShape(#[from] NoShape),
    /// Its control points have no velocities.
    #[error("the chain does not filter, so ropes have no velocities: start it with --filter")]
    NotFiltered,
    /// Of its velocity nothing is known yet.
    #[error(
        "the rope has been seen once only since it was found or jumped: wait for the next image"
    )]
    JustBegun,
    /// A moment before the image, or too far from it.
    #[error(
        "a prediction goes from the rope's image to {} ms after it, and this moment is outside: ask for a nearer one, and \
         hold still when the image is older",
        FARTHEST.as_millis()
    )]
    TooFar,
}

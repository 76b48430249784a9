//! One rope of a frame, and the prediction of its shape.

use std::fmt;
use std::time::Duration;

use thiserror::Error;

use crate::shape::Growth;
use crate::{
    Centerline, CenterlinePoints, Descriptor, Descriptor3, Descriptors3, FitQuality,
    MAX_CONTROL_POINTS, NoShape, Shape, Unit,
};

/// Identity of a rope: its number, which is constant from frame to frame, and the run of the chain
/// that assigned it.
///
/// A restarted chain numbers its ropes again. A track of an earlier run is never found, so that no
/// other rope is mistaken for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Track {
    pub(crate) number: u32,
    pub(crate) run: u64,
}

impl Track {
    /// The rope of this number in a run, as counted by this reader
    /// ([`Frame::run`](crate::Frame::run)).
    pub fn new(run: u64, number: u32) -> Self {
        Self { number, run }
    }

    /// Number of the rope in messages, files and images.
    pub fn number(&self) -> u32 {
        self.number
    }

    /// Run of the chain, counted by this reader from 1.
    pub fn run(&self) -> u64 {
        self.run
    }
}

impl fmt::Display for Track {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.number)
    }
}

/// Motion model of a rope between images, for [`Rope::predict`]. It should equal that of the
/// chain's filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Standard deviation of the acceleration of a point on the rope, along each axis, in units/s²
    /// (`acceleration_px_s2` in the chain's settings). The default is 1000, the chain's own in
    /// pixels.
    pub acceleration: f64,
    /// Correlation time of the acceleration, s. The default is 0.1, the chain's own.
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

/// Time and source of a rope's observation, with the reader's settings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    /// Time of the request for the frame.
    pub(crate) now_ns: u64,
    /// Exposure time of the image.
    pub(crate) exposed_ns: u64,
    pub(crate) run: u64,
    pub(crate) unit: Option<Unit>,
    /// Time from image to image, s; `None` before the second image.
    pub(crate) period_s: Option<f64>,
    pub(crate) motion: Motion,
    /// True if a coarse curve is acceptable.
    pub(crate) coarse: bool,
    /// Minimum sufficient confidence.
    pub(crate) min_confidence: f32,
}

/// A rope at the time of its image. It borrows the message in shared memory from the reader, so
/// copy what you keep.
#[derive(Debug, Clone, Copy)]
pub struct Rope<'a> {
    descriptor: &'a Descriptor,
    points: &'a CenterlinePoints,
    space: InSpace<'a>,
    moment: Moment,
}

/// The part of a frame that describes ropes in space.
#[derive(Debug, Clone, Copy)]
pub(crate) enum InSpace<'a> {
    /// The reader does not follow in space.
    NotFollowed,
    /// No message exists for this frame.
    None,
    /// The message of this frame.
    Message(&'a Descriptors3),
}

/// Reason why a rope's position in space is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoSpace {
    /// The reader does not follow in space.
    #[error("this reader reads ropes in the image only: have it follow_in_space()")]
    NotFollowed,
    /// The chain sends no shapes in space.
    #[error(
        "the chain says nothing of space for this frame: it needs a depth camera (lariat run --calibration FILE --depth FILE)"
    )]
    NoDepth,
    /// The message gives the reason, or its numbers do not describe a curve.
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

    /// Identity of the rope. [`Frame::rope`](crate::Frame::rope) finds the same rope by it.
    pub fn track(&self) -> Track {
        Track {
            number: self.descriptor.track,
            run: self.moment.run,
        }
    }

    /// Age of the shape when the frame was requested: the time since its image was taken or, for a
    /// lost rope, since the last image that showed it.
    pub fn age(&self) -> Duration {
        let before_ns = self.descriptor.age_ns;
        let since_ns = self.moment.now_ns.saturating_sub(self.moment.exposed_ns);
        Duration::from_nanos(since_ns.saturating_add(before_ns))
    }

    /// Exposure time of its image in nanoseconds of `CLOCK_MONOTONIC`.
    pub fn exposed_ns(&self) -> u64 {
        self.moment.exposed_ns
    }

    /// Unit of its coordinates; `None` for a unit that this version does not know.
    pub fn unit(&self) -> Option<Unit> {
        self.moment.unit
    }

    /// The points that its curve was fitted to: the observed points, whether or not the curve
    /// follows them. They exist even if the chain describes ropes by feature points or centers.
    /// `None` if the writer sends none; lariat's own chain always does.
    pub fn centerline(&self) -> Option<Centerline<'a>> {
        Centerline::of(self.points)
    }

    /// Fit quality of its curve; `None` for a number that this version does not know.
    pub fn fit(&self) -> Option<FitQuality> {
        self.descriptor.fit()
    }

    /// Calibrated probability, 0 to 1, that this is a rope and its centerline is whole and in
    /// order. For a lost rope it is that of the last observation.
    /// [`Reader::min_confidence`](crate::Reader::min_confidence) sets the required minimum.
    pub fn confidence(&self) -> f32 {
        self.descriptor.confidence
    }

    /// Its curve.
    ///
    /// # Errors
    /// The chain describes ropes by points or by their center instead of a curve.
    pub fn shape(&self) -> Result<Shape<'a>, NoShape> {
        Shape::of(self.descriptor)
    }

    /// Its curve in space, in mm, from the depth camera. Without a measured position it returns an
    /// error that says why; nothing is guessed. A lost rope keeps its last position.
    ///
    /// # Errors
    /// The reader does not [follow in space](crate::Reader::follow_in_space), the chain lacks a
    /// depth camera, or the rope's position is unknown.
    pub fn in_space(&self) -> Result<Shape<'a, 3>, NoSpace> {
        Ok(Shape::in_space(self.descriptor3()?)?)
    }

    /// Its whole descriptor in space.
    ///
    /// # Errors
    /// As for [`in_space`](Self::in_space), except for the reasons that the descriptor itself
    /// contains.
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

    /// Its control points, `[x, y]`, or its feature points or center, if the chain describes ropes
    /// by those.
    pub fn control_points(&self) -> &'a [[f64; 2]] {
        self.descriptor.control_points()
    }

    /// Velocities of its control points, units per second; `None` unless the chain filters them
    /// (`--filter`).
    pub fn velocities(&self) -> Option<&'a [[f64; 2]]> {
        let count = self.descriptor.control_points().len();
        (self.descriptor.filtered == 1).then(|| &self.descriptor.velocities[..count])
    }

    /// Arc length of the centerline.
    pub fn length(&self) -> f64 {
        self.descriptor.length
    }

    /// Share of its points that are covered or outside the image, and so interpolated: 0 to 1.
    pub fn hidden(&self) -> f64 {
        let samples = self.descriptor.samples.max(1);
        f64::from(self.descriptor.hidden.min(samples)) / f64::from(samples)
    }

    /// True for each end, first and last, that leaves the image. The shape ends there.
    pub fn leaves_image(&self) -> [bool; 2] {
        [1, 2].map(|bit| self.descriptor.border & bit != 0)
    }

    /// Its whole descriptor.
    pub fn descriptor(&self) -> &'a Descriptor {
        self.descriptor
    }

    /// Predicts the rope at the time `t_ns` (of `CLOCK_MONOTONIC`, as [`now_ns`](crate::now_ns))
    /// from its velocities. The covariance grows by the acceleration that is possible until then
    /// ([`Reader::expect_motion`](crate::Reader::expect_motion)).
    ///
    /// # Errors
    /// The rope has no curve, its velocities are not known (yet), or the time is before the image
    /// or more than [`FARTHEST`] after it.
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

/// Maximum prediction horizon. The chain's own filter restarts after the same time without an
/// image.
pub const FARTHEST: Duration = Duration::from_millis(500);

/// A rope predicted for another time.
#[derive(Debug, Clone, Copy)]
pub struct Prediction<'a> {
    of: &'a Descriptor,
    shape: Shape<'a>,
    control_points: [[f64; 2]; MAX_CONTROL_POINTS],
    covariances: [[f64; 3]; MAX_CONTROL_POINTS],
}

impl Prediction<'_> {
    /// Its predicted curve, with the predicted covariance.
    pub fn shape(&self) -> Shape<'_> {
        let count = self.shape.control_points().len();
        self.shape
            .moved(&self.control_points[..count], &self.covariances[..count])
    }

    /// The rope's descriptor with predicted control points and covariances. All other fields are as
    /// observed.
    pub fn to_descriptor(&self) -> Descriptor {
        Descriptor {
            control_points: self.control_points,
            covariances: self.covariances,
            ..*self.of
        }
    }
}

/// Reason why a rope cannot be predicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoPrediction {
    /// The rope has no curve.
    #[error(transparent)]
    NoShape(#[from] NoShape),
    /// Its control points lack velocities.
    #[error("the chain does not filter, so ropes have no velocities: start it with --filter")]
    NotFiltered,
    /// Its velocity is not known yet.
    #[error(
        "the rope has been seen once only since it was found or jumped: wait for the next image"
    )]
    JustBegun,
    /// The time is before the image, or too long after it.
    #[error(
        "a prediction goes from the rope's image to {} ms after it, and this moment is outside: ask for a nearer one, and \
         hold still when the image is older",
        FARTHEST.as_millis()
    )]
    TooFar,
}

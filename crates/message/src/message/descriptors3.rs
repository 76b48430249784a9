//! What a control loop reads of ropes in space: their shapes there, where a depth camera stands beside the colour one.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

use crate::{
    Axes, Basis, FitQuality, MAX_CONTROL_POINTS, MAX_CURVES, MAX_POINTS, Place, Status, Trace,
};

message! {
    /// One rope's shape in space as a few control points, in millimetres; its shape in the image is the [`Descriptor`](crate::Descriptor)
    /// of the same track. It has a shape unless `place` says why not.
    pub struct Descriptor3 = "lariat.Descriptor3.v2" {
        /// The rope's number; it keeps it from frame to frame, and has it in the image, too.
        track: u32 = 0 => number,
        /// A [`Status`]'s number: what the colour image shows of it.
        status: u32 = Status::Ok as u32 => code(Status),
        /// A [`Place`]'s number: whether it is known where the rope is, or why not.
        place: u32 = Place::Unmeasured as u32 => code(Place),
        /// A [`Basis`]'s number.
        basis: u32 = Basis::Bezier as u32 => code(Basis),
        /// Degree of the curve's polynomials, whatever their number: 3 of a cubic B-spline; of a Fourier series its harmonics.
        degree: u32 = 0 => number,
        /// How many control points are meant; 0 where there is no shape.
        count: u32 = 0 => count(control_points),
        /// How many points of the centerline were fitted: N.
        samples: u32 = 0 => count(points),
        /// 1 if the rope is closed.
        closed: u32 = 0 => flag,
        /// Which ends leave the colour image: bit 0 the first, bit 1 the last.
        border: u32 = 0 => ends,
        /// How many of the centerline's points are measured. The others are bridged.
        measured: u32 = 0 => number,
        /// 1 if the control points are filtered in time, and have velocities.
        filtered: u32 = 0 => flag,
        /// A [`FitQuality`]'s number: whether the curve lies on its points.
        fit: u32 = FitQuality::NotJudged as u32 => code(FitQuality),
        /// How sure it is that the centerline is a rope's, whole and in order: of those at 0.9, nine of ten are. 0 to 1.
        confidence: f32 = 0.0 => number,
        /// Always 0.
        reserved: u32 = 0 => reserved,
        /// How long before the image the rope was last seen, in nanoseconds: 0 unless it is lost.
        age_ns: u64 = 0 => number,
        /// Root mean square distance of the points from the curve at their ρ, mm.
        rms: f64 = 0.0 => number,
        /// Largest such distance, mm.
        max: f64 = 0.0 => number,
        /// Arc length of the centerline, mm.
        length: f64 = 0.0 => number,
        /// Median width of the rope, mm.
        width: f64 = 0.0 => number,
        /// The control points, `[x, y, z]`, mm.
        control_points: [[f64; 3]; MAX_CONTROL_POINTS] = [[0.0; 3]; MAX_CONTROL_POINTS] => points(control_points),
        /// Their weights: rational bases only, 1 elsewhere.
        weights: [f64; MAX_CONTROL_POINTS] = [1.0; MAX_CONTROL_POINTS] => list(weights),
        /// Covariance of the coordinates of each control point, `[xx, xy, xz, yy, yz, zz]`, mm².
        covariances: [[f64; 6]; MAX_CONTROL_POINTS] = [[0.0; 6]; MAX_CONTROL_POINTS] => list(covariances),
        /// Velocity of each control point, mm/s; 0 where they are not filtered.
        velocities: [[f64; 3]; MAX_CONTROL_POINTS] = [[0.0; 3]; MAX_CONTROL_POINTS] => list(velocities),
        /// The inner knots of a B-spline, `count − degree − 1` of them, ascending within 0 and 1; outside stand
        /// `degree + 1` times 0 and as many times 1.
        knots: [f64; MAX_CONTROL_POINTS] = [0.0; MAX_CONTROL_POINTS] => list(inner_knots),
        /// The points of the centerline that were fitted, `[x, y, z]`, mm, at equal steps of arc length in space.
        points: [[f32; 3]; MAX_POINTS] = [[0.0; 3]; MAX_POINTS] => points(points),
        /// The standard deviation of each along the line to the camera, mm.
        sigmas: [f32; MAX_POINTS] = [0.0; MAX_POINTS] => list(sigmas),
    }
}

impl Descriptor3 {
    /// The control points that are meant.
    pub fn control_points(&self) -> &[[f64; 3]] {
        &self.control_points[..self.meant()]
    }

    /// Their weights.
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.meant()]
    }

    /// The covariances of their coordinates, `[xx, xy, xz, yy, yz, zz]`.
    pub fn covariances(&self) -> &[[f64; 6]] {
        &self.covariances[..self.meant()]
    }

    /// Their velocities.
    pub fn velocities(&self) -> &[[f64; 3]] {
        &self.velocities[..self.meant()]
    }

    /// The points of the centerline.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points[..self.sampled()]
    }

    /// The standard deviation of each along the line to the camera, mm.
    pub fn sigmas(&self) -> &[f32] {
        &self.sigmas[..self.sampled()]
    }

    fn meant(&self) -> usize {
        (self.count as usize).min(MAX_CONTROL_POINTS)
    }

    fn sampled(&self) -> usize {
        (self.samples as usize).min(MAX_POINTS)
    }

    /// The inner knots of a B-spline, `count − degree − 1` of them; none of other curves.
    pub fn inner_knots(&self) -> &[f64] {
        let inner = match Basis::from_code(self.basis) {
            Some(Basis::BSpline) => self
                .meant()
                .saturating_sub((self.degree as usize).saturating_add(1)),
            _ => 0,
        };
        &self.knots[..inner]
    }

    /// Whether it is known where the rope is, or why not; `None` for a number this version does not know.
    pub const fn place(&self) -> Option<Place> {
        Place::from_code(self.place)
    }

    /// What the colour image shows of it; `None` for a number this version does not know.
    pub const fn status(&self) -> Option<Status> {
        Status::from_code(self.status)
    }

    /// Whether the curve lies on its points; `None` for a number this version does not know.
    pub const fn fit(&self) -> Option<FitQuality> {
        FitQuality::from_code(self.fit)
    }

    /// The functions that the control points weigh; `None` for a number this version does not know.
    pub const fn basis(&self) -> Option<Basis> {
        Basis::from_code(self.basis)
    }

    /// Takes over what another means; what it does not mean stays as it was.
    pub fn copy_meant(&mut self, from: &Self) {
        let Self {
            control_points,
            weights,
            covariances,
            velocities,
            knots,
            points,
            sigmas,
            ..
        } = self;
        // What lies in shared memory may be another a moment later: both numbers are read once.
        let (count, samples) = (from.meant(), from.sampled());
        control_points[..count].copy_from_slice(&from.control_points[..count]);
        weights[..count].copy_from_slice(&from.weights[..count]);
        covariances[..count].copy_from_slice(&from.covariances[..count]);
        velocities[..count].copy_from_slice(&from.velocities[..count]);
        knots[..count].copy_from_slice(&from.knots[..count]);
        points[..samples].copy_from_slice(&from.points[..samples]);
        sigmas[..samples].copy_from_slice(&from.sigmas[..samples]);
        (self.track, self.status, self.place) = (from.track, from.status, from.place);
        (self.basis, self.degree, self.count) = (from.basis, from.degree, count as u32);
        (self.samples, self.closed, self.border) = (samples as u32, from.closed, from.border);
        (self.measured, self.filtered, self.fit) = (from.measured, from.filtered, from.fit);
        (self.confidence, self.age_ns) = (from.confidence, from.age_ns);
        (self.rms, self.max, self.length, self.width) =
            (from.rms, from.max, from.length, from.width);
    }
}

message! {
    /// What a control loop reads of ropes in space: the shape of each rope of one frame, in the order of
    /// [`Descriptors`](crate::Descriptors), which come right after it.
    pub struct Descriptors3 = "lariat.Descriptors3.v3" {
        /// The frame's whole way.
        trace: Trace = Trace::EMPTY => message,
        /// How many curves are meant. 0 is an answer: there is no rope.
        count: u32 = 0 => count(curves),
        /// An [`Axes`]'s number: from where, and along which axes, everything in it is measured.
        axes: u32 = Axes::Camera as u32 => code(Axes),
        /// The curves.
        curves: [Descriptor3; MAX_CURVES] = [Descriptor3::EMPTY; MAX_CURVES] => messages(curves),
    }
}

impl Descriptors3 {
    /// The curves that are meant.
    pub fn curves(&self) -> &[Descriptor3] {
        &self.curves[..(self.count as usize).min(MAX_CURVES)]
    }

    /// From where, and along which axes, everything in it is measured; `None` for a number this version does not know.
    pub const fn axes(&self) -> Option<Axes> {
        Axes::from_code(self.axes)
    }

    /// Takes over what another message means; what it does not mean stays as it was.
    pub fn copy_meant(&mut self, from: &Self) {
        (self.trace, self.axes) = (from.trace, from.axes);
        let count = from.curves().len();
        self.count = count as u32;
        for (to, from) in self.curves[..count].iter_mut().zip(&from.curves) {
            to.copy_meant(from);
        }
    }
}

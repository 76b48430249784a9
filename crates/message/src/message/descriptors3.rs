//! Shapes of ropes in space, for control loops. They exist where a depth camera accompanies the
//! color camera.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

use crate::{
    Axes, Basis, FitQuality, MAX_CONTROL_POINTS, MAX_CURVES, MAX_POINTS, Place, Status, Trace,
};

message! {
    /// One rope's shape in space as a few control points, in millimeters. Its shape in the image is
    /// the [`Descriptor`](crate::Descriptor) of the same track. Without a shape, `place` says why.
    pub struct Descriptor3 = "lariat.Descriptor3.v2" {
        /// Rope number, as in the image.
        track: u32 = 0 => number,
        /// A [`Status`]'s number, from the color image.
        status: u32 = Status::Ok as u32 => code(Status),
        /// A [`Place`]'s number.
        place: u32 = Place::Unmeasured as u32 => code(Place),
        /// A [`Basis`]'s number.
        basis: u32 = Basis::Bezier as u32 => code(Basis),
        /// Polynomial degree (cubic: 3); harmonics of a Fourier series.
        degree: u32 = 0 => number,
        /// Number of valid control points; 0 without a shape.
        count: u32 = 0 => count(control_points),
        /// Number of fitted centerline points, N.
        samples: u32 = 0 => count(points),
        /// 1 if closed.
        closed: u32 = 0 => flag,
        /// Ends that leave the color image: bit 0 first, bit 1 last.
        border: u32 = 0 => ends,
        /// Number of measured centerline points; the others are interpolated.
        measured: u32 = 0 => number,
        /// 1 if filtered over time, with velocities.
        filtered: u32 = 0 => flag,
        /// A [`FitQuality`]'s number.
        fit: u32 = FitQuality::NotJudged as u32 => code(FitQuality),
        /// Calibrated probability of a whole, correctly ordered rope.
        confidence: f32 = 0.0 => number,
        /// Always 0.
        reserved: u32 = 0 => reserved,
        /// Time from the last sighting to this image; 0 unless lost.
        age_ns: u64 = 0 => number,
        /// RMS distance of points from the curve at their ρ, mm.
        rms: f64 = 0.0 => number,
        /// Maximum distance, mm.
        max: f64 = 0.0 => number,
        /// Arc length of the centerline, mm.
        length: f64 = 0.0 => number,
        /// Median width of the rope, mm.
        width: f64 = 0.0 => number,
        /// Control points, `[x, y, z]`, mm.
        control_points: [[f64; 3]; MAX_CONTROL_POINTS] = [[0.0; 3]; MAX_CONTROL_POINTS] => points(control_points),
        /// Weights of a rational basis; 1 elsewhere.
        weights: [f64; MAX_CONTROL_POINTS] = [1.0; MAX_CONTROL_POINTS] => list(weights),
        /// Covariance of each control point, `[xx, xy, xz, yy, yz, zz]`, mm².
        covariances: [[f64; 6]; MAX_CONTROL_POINTS] = [[0.0; 6]; MAX_CONTROL_POINTS] => list(covariances),
        /// Velocity of each control point, mm/s; 0 if unfiltered.
        velocities: [[f64; 3]; MAX_CONTROL_POINTS] = [[0.0; 3]; MAX_CONTROL_POINTS] => list(velocities),
        /// The `count − degree − 1` inner knots of a B-spline, ascending, between `degree + 1`
        /// zeros and as many ones.
        knots: [f64; MAX_CONTROL_POINTS] = [0.0; MAX_CONTROL_POINTS] => list(inner_knots),
        /// Fitted centerline points, `[x, y, z]`, mm, at equal steps of arc length in space.
        points: [[f32; 3]; MAX_POINTS] = [[0.0; 3]; MAX_POINTS] => points(points),
        /// Standard deviation of each point along the line of sight, mm.
        sigmas: [f32; MAX_POINTS] = [0.0; MAX_POINTS] => list(sigmas),
    }
}

impl Descriptor3 {
    /// The valid control points.
    pub fn control_points(&self) -> &[[f64; 3]] {
        &self.control_points[..self.meant()]
    }

    /// Weights of the control points.
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.meant()]
    }

    /// Covariances of the control points' coordinates, `[xx, xy, xz, yy, yz, zz]`.
    pub fn covariances(&self) -> &[[f64; 6]] {
        &self.covariances[..self.meant()]
    }

    /// Velocities of the control points.
    pub fn velocities(&self) -> &[[f64; 3]] {
        &self.velocities[..self.meant()]
    }

    /// The points of the centerline.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points[..self.sampled()]
    }

    /// The standard deviation of each point along the camera's line of sight, mm.
    pub fn sigmas(&self) -> &[f32] {
        &self.sigmas[..self.sampled()]
    }

    fn meant(&self) -> usize {
        (self.count as usize).min(MAX_CONTROL_POINTS)
    }

    fn sampled(&self) -> usize {
        (self.samples as usize).min(MAX_POINTS)
    }

    /// The `count − degree − 1` inner knots of a B-spline; empty for other curves.
    pub fn inner_knots(&self) -> &[f64] {
        let inner = match Basis::from_code(self.basis) {
            Some(Basis::BSpline) => self
                .meant()
                .saturating_sub((self.degree as usize).saturating_add(1)),
            _ => 0,
        };
        &self.knots[..inner]
    }

    /// State of the rope's position in space; `None` for a number this version does not know.
    pub const fn place(&self) -> Option<Place> {
        Place::from_code(self.place)
    }

    /// Visibility in the color image; `None` for a number this version does not know.
    pub const fn status(&self) -> Option<Status> {
        Status::from_code(self.status)
    }

    /// Fit quality; `None` for a number this version does not know.
    pub const fn fit(&self) -> Option<FitQuality> {
        FitQuality::from_code(self.fit)
    }

    /// The basis functions that are weighted by the control points; `None` for a number this
    /// version does not know.
    pub const fn basis(&self) -> Option<Basis> {
        Basis::from_code(self.basis)
    }

    /// Copies the valid part of another descriptor; the rest stays as it was.
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
        // Shared memory may change at any moment, so both counts are read only once.
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
    /// Shapes in space for a control loop: one for each rope of one frame, in the order of
    /// [`Descriptors`](crate::Descriptors), which is sent right after it.
    pub struct Descriptors3 = "lariat.Descriptors3.v3" {
        /// Complete trace of the frame.
        trace: Trace = Trace::EMPTY => message,
        /// Number of valid curves; 0 means no rope.
        count: u32 = 0 => count(curves),
        /// An [`Axes`]'s number: coordinate frame of everything in the message.
        axes: u32 = Axes::Camera as u32 => code(Axes),
        /// Curves.
        curves: [Descriptor3; MAX_CURVES] = [Descriptor3::EMPTY; MAX_CURVES] => messages(curves),
    }
}

impl Descriptors3 {
    /// The valid curves.
    pub fn curves(&self) -> &[Descriptor3] {
        &self.curves[..(self.count as usize).min(MAX_CURVES)]
    }

    /// Coordinate frame of everything in the message; `None` for a number this version does not
    /// know.
    pub const fn axes(&self) -> Option<Axes> {
        Axes::from_code(self.axes)
    }

    /// Copies the valid part of another message; the rest stays as it was.
    pub fn copy_meant(&mut self, from: &Self) {
        (self.trace, self.axes) = (from.trace, from.axes);
        let count = from.curves().len();
        self.count = count as u32;
        for (to, from) in self.curves[..count].iter_mut().zip(&from.curves) {
            to.copy_meant(from);
        }
    }
}

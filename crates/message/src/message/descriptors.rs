//! Shapes of ropes in the image, and the points that they were fitted to, for control loops.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

use std::iter::repeat_n;

use super::hidden::{self, is_hidden};
use crate::{Basis, FitQuality, MAX_CONTROL_POINTS, MAX_CURVES, MAX_POINTS, Status, Trace, Unit};

message! {
    /// One rope's shape as a few control points, in the message's unit ([`Descriptors::unit`]).
    pub struct Descriptor = "lariat.Descriptor.v7" {
        /// Rope number, constant across frames.
        track: u32 = 0 => number,
        /// A [`Status`]'s number.
        status: u32 = Status::Ok as u32 => code(Status),
        /// A [`Basis`]'s number.
        basis: u32 = Basis::Bezier as u32 => code(Basis),
        /// Polynomial degree (cubic: 3); harmonics of a Fourier series.
        degree: u32 = 0 => number,
        /// Number of valid control points.
        count: u32 = 0 => count(control_points),
        /// Number of fitted centerline points, N.
        samples: u32 = 0 => number,
        /// 1 if closed.
        closed: u32 = 0 => flag,
        /// Ends that leave the image: bit 0 first, bit 1 last.
        border: u32 = 0 => ends,
        /// RMS distance of points from the curve at their ρ.
        rms: f64 = 0.0 => number,
        /// Maximum distance.
        max: f64 = 0.0 => number,
        /// Residual variance per coordinate, unit squared: sum of squares over degrees of freedom,
        /// 2 (N − count) for plain least squares.
        residual_variance: f64 = 0.0 => number,
        /// Condition number (2-norm) of the regression.
        condition: f64 = 0.0 => number,
        /// Arc length of the centerline.
        length: f64 = 0.0 => number,
        /// Median width of the rope.
        width: f64 = 0.0 => number,
        /// Time from the last sighting to this image; 0 unless lost.
        age_ns: u64 = 0 => number,
        /// Number of points covered or outside the image.
        hidden: u32 = 0 => number,
        /// 1 if filtered over time, with velocities.
        filtered: u32 = 0 => flag,
        /// A [`FitQuality`]'s number.
        fit: u32 = FitQuality::NotJudged as u32 => code(FitQuality),
        /// Calibrated probability of a whole, correctly ordered rope.
        confidence: f32 = 0.0 => number,
        /// Control points, `[x, y]`.
        control_points: [[f64; 2]; MAX_CONTROL_POINTS] = [[0.0; 2]; MAX_CONTROL_POINTS] => points(control_points),
        /// Weights of a rational basis; 1 elsewhere.
        weights: [f64; MAX_CONTROL_POINTS] = [1.0; MAX_CONTROL_POINTS] => list(weights),
        /// Covariance of each control point, `[xx, xy, yy]`, unit squared.
        covariances: [[f64; 3]; MAX_CONTROL_POINTS] = [[0.0; 3]; MAX_CONTROL_POINTS] => list(covariances),
        /// Velocity of each control point, units/s; 0 if unfiltered.
        velocities: [[f64; 2]; MAX_CONTROL_POINTS] = [[0.0; 2]; MAX_CONTROL_POINTS] => list(velocities),
        /// The `count − degree − 1` inner knots of a B-spline, ascending, between `degree + 1`
        /// zeros and as many ones.
        knots: [f64; MAX_CONTROL_POINTS] = [0.0; MAX_CONTROL_POINTS] => list(inner_knots),
    }
}

impl Descriptor {
    /// The valid control points.
    pub fn control_points(&self) -> &[[f64; 2]] {
        &self.control_points[..self.meant()]
    }

    /// Weights of the control points.
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.meant()]
    }

    /// Covariances of the control points' coordinates, `[xx, xy, yy]`.
    pub fn covariances(&self) -> &[[f64; 3]] {
        &self.covariances[..self.meant()]
    }

    /// Velocities of the control points.
    pub fn velocities(&self) -> &[[f64; 2]] {
        &self.velocities[..self.meant()]
    }

    fn meant(&self) -> usize {
        (self.count as usize).min(MAX_CONTROL_POINTS)
    }

    /// The `count − degree − 1` inner knots of a B-spline; empty for other curves.
    pub fn inner_knots(&self) -> &[f64] {
        let inner = match self.basis() {
            Some(Basis::BSpline) => self
                .meant()
                .saturating_sub((self.degree as usize).saturating_add(1)),
            _ => 0,
        };
        &self.knots[..inner]
    }

    /// All knots of a B-spline, from 0 to 1; empty for other curves.
    pub fn all_knots(&self) -> impl Iterator<Item = f64> {
        let degree = self.degree as usize;
        let is_spline = self.basis() == Some(Basis::BSpline) && degree < self.meant();
        let end = if is_spline { degree + 1 } else { 0 };
        let inner = self.inner_knots().iter().copied();
        repeat_n(0.0, end).chain(inner).chain(repeat_n(1.0, end))
    }

    /// Visibility of the rope; `None` for a number this version does not know.
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
}

message! {
    /// The points that a descriptor was fitted to: the rope's centerline, at equal steps of arc
    /// length, in the message's unit. They are the unfiltered points of the image, whether or not
    /// the curve follows them.
    pub struct CenterlinePoints = "lariat.CenterlinePoints.v1" {
        /// Number of valid points; 0 if the writer gives none.
        count: u32 = 0 => count(points),
        /// 1 if closed: the first point follows the last.
        closed: u32 = 0 => flag,
        /// Points covered or outside the image: bit `i % 32` of word `i / 32`.
        hidden: [u32; MAX_POINTS / 32] = [0; MAX_POINTS / 32] => hidden(points),
        /// Points, `[x, y]`.
        points: [[f32; 2]; MAX_POINTS] = [[0.0; 2]; MAX_POINTS] => points(points),
        /// Width of the rope at each point.
        widths: [f32; MAX_POINTS] = [0.0; MAX_POINTS] => list(widths),
    }
}

impl CenterlinePoints {
    /// The valid points.
    pub fn points(&self) -> &[[f32; 2]] {
        &self.points[..(self.count as usize).min(MAX_POINTS)]
    }

    /// The widths at those points.
    pub fn widths(&self) -> &[f32] {
        &self.widths[..(self.count as usize).min(MAX_POINTS)]
    }

    /// Copies the valid part of another centerline; the rest stays as it was.
    fn copy_meant(&mut self, from: &Self) {
        (self.count, self.closed, self.hidden) = (from.count, from.closed, from.hidden);
        // The count is taken from the copy, because shared memory may change at any moment.
        let count = self.points().len();
        self.points[..count].copy_from_slice(&from.points[..count]);
        self.widths[..count].copy_from_slice(&from.widths[..count]);
    }

    /// Returns whether point `i` is covered or outside the image, and so not visible.
    pub const fn is_hidden(&self, i: usize) -> bool {
        is_hidden(&self.hidden, i)
    }

    /// Sets for each point, in order, whether it is covered or outside the image.
    pub fn set_hidden(&mut self, hidden: impl IntoIterator<Item = bool>) {
        self.hidden = hidden::hidden(hidden);
    }
}

message! {
    /// Input of a control loop: the shape of every rope in one frame.
    pub struct Descriptors = "lariat.Descriptors.v9" {
        /// Complete trace of the frame.
        trace: Trace = Trace::EMPTY => message,
        /// Image width in pixels; 0 while the camera gives no image.
        width: u32 = 0 => number,
        /// Image height in pixels.
        height: u32 = 0 => number,
        /// Number of valid curves; 0 means no rope.
        count: u32 = 0 => count(curves),
        /// A [`Unit`]'s number: unit of the curves.
        unit: u32 = Unit::Pixel as u32 => code(Unit),
        /// Curves.
        curves: [Descriptor; MAX_CURVES] = [Descriptor::EMPTY; MAX_CURVES] => messages(curves),
        /// Points of each curve, in the same order.
        centerlines: [CenterlinePoints; MAX_CURVES] = [CenterlinePoints::EMPTY; MAX_CURVES] => messages(centerlines),
    }
}

impl Descriptors {
    /// Unit of the curves; `None` for a number this version does not know.
    pub const fn unit(&self) -> Option<Unit> {
        Unit::from_code(self.unit)
    }

    /// Copies the valid part of another message; the rest stays as it was.
    pub fn copy_meant(&mut self, from: &Self) {
        self.trace = from.trace;
        (self.width, self.height) = (from.width, from.height);
        (self.count, self.unit) = (from.count, from.unit);
        // The count is taken from the copy, because shared memory may change at any moment.
        let count = self.curves().len();
        self.curves[..count].copy_from_slice(&from.curves[..count]);
        for (to, from) in self.centerlines[..count].iter_mut().zip(&from.centerlines) {
            to.copy_meant(from);
        }
    }

    /// The valid curves.
    pub fn curves(&self) -> &[Descriptor] {
        &self.curves[..(self.count as usize).min(MAX_CURVES)]
    }

    /// The points of those curves.
    pub fn centerlines(&self) -> &[CenterlinePoints] {
        &self.centerlines[..(self.count as usize).min(MAX_CURVES)]
    }
}

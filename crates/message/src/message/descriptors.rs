//! What a control loop reads: the ropes' shapes, and the points that they were fitted to.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

use std::iter::repeat_n;

use super::hidden::{self, is_hidden};
use crate::{Basis, FitQuality, MAX_CONTROL_POINTS, MAX_CURVES, MAX_POINTS, Status, Trace, Unit};

message! {
    /// One rope's shape as a few control points, in the message's unit ([`Descriptors::unit`]).
    pub struct Descriptor = "lariat.Descriptor.v7" {
        /// The rope's number; it keeps it from frame to frame.
        track: u32 = 0 => number,
        /// A [`Status`]'s number.
        status: u32 = Status::Ok as u32 => code(Status),
        /// A [`Basis`]'s number.
        basis: u32 = Basis::Bezier as u32 => code(Basis),
        /// Degree of the curve's polynomials, whatever their number: 3 of a cubic B-spline; of a Fourier series its harmonics.
        degree: u32 = 0 => number,
        /// How many control points are meant; what lies behind them in the arrays is stale.
        count: u32 = 0 => count(control_points),
        /// How many points of the centerline were fitted: N.
        samples: u32 = 0 => number,
        /// 1 if the rope is closed.
        closed: u32 = 0 => flag,
        /// Which ends leave the image: bit 0 the first, bit 1 the last.
        border: u32 = 0 => ends,
        /// Root mean square distance of the points from the curve at their ρ, in the message's unit.
        rms: f64 = 0.0 => number,
        /// Largest such distance.
        max: f64 = 0.0 => number,
        /// Variance of one coordinate's residual: the sum of squares over its degrees of freedom, 2 (N − count) for
        /// plain least squares, in the unit's square.
        residual_variance: f64 = 0.0 => number,
        /// Condition number (2-norm) of the regression.
        condition: f64 = 0.0 => number,
        /// Arc length of the centerline, in the message's unit.
        length: f64 = 0.0 => number,
        /// Median width of the rope, likewise.
        width: f64 = 0.0 => number,
        /// How long before the image the rope was last seen, in nanoseconds: 0 unless it is lost.
        age_ns: u64 = 0 => number,
        /// How many of the points were covered by something or outside of the image, and so not seen.
        hidden: u32 = 0 => number,
        /// 1 if the control points are filtered in time, and have velocities.
        filtered: u32 = 0 => flag,
        /// A [`FitQuality`]'s number: whether the curve lies on its points.
        fit: u32 = FitQuality::NotJudged as u32 => code(FitQuality),
        /// How sure it is that the centerline is a rope's, whole and in order: of those at 0.9, nine of ten are. 0 to 1.
        confidence: f32 = 0.0 => number,
        /// The control points, `[x, y]` in the message's unit.
        control_points: [[f64; 2]; MAX_CONTROL_POINTS] = [[0.0; 2]; MAX_CONTROL_POINTS] => points(control_points),
        /// Their weights: rational bases only, 1 elsewhere.
        weights: [f64; MAX_CONTROL_POINTS] = [1.0; MAX_CONTROL_POINTS] => list(weights),
        /// Covariance of the coordinates of each control point, `[xx, xy, yy]`, in the unit's square.
        covariances: [[f64; 3]; MAX_CONTROL_POINTS] = [[0.0; 3]; MAX_CONTROL_POINTS] => list(covariances),
        /// Velocity of each control point, in units a second; 0 where they are not filtered.
        velocities: [[f64; 2]; MAX_CONTROL_POINTS] = [[0.0; 2]; MAX_CONTROL_POINTS] => list(velocities),
        /// The inner knots of a B-spline, `count − degree − 1` of them, ascending within 0 and 1; outside stand
        /// `degree + 1` times 0 and as many times 1.
        knots: [f64; MAX_CONTROL_POINTS] = [0.0; MAX_CONTROL_POINTS] => list(inner_knots),
    }
}

impl Descriptor {
    /// The control points that are meant.
    pub fn control_points(&self) -> &[[f64; 2]] {
        &self.control_points[..self.meant()]
    }

    /// Their weights.
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.meant()]
    }

    /// The covariances of their coordinates, `[xx, xy, yy]`.
    pub fn covariances(&self) -> &[[f64; 3]] {
        &self.covariances[..self.meant()]
    }

    /// Their velocities.
    pub fn velocities(&self) -> &[[f64; 2]] {
        &self.velocities[..self.meant()]
    }

    fn meant(&self) -> usize {
        (self.count as usize).min(MAX_CONTROL_POINTS)
    }

    /// The inner knots of a B-spline, `count − degree − 1` of them; none of other curves.
    pub fn inner_knots(&self) -> &[f64] {
        let inner = match self.basis() {
            Some(Basis::BSpline) => self
                .meant()
                .saturating_sub((self.degree as usize).saturating_add(1)),
            _ => 0,
        };
        &self.knots[..inner]
    }

    /// All knots of a B-spline, from 0 to 1; none of other curves.
    pub fn all_knots(&self) -> impl Iterator<Item = f64> {
        let degree = self.degree as usize;
        let is_spline = self.basis() == Some(Basis::BSpline) && degree < self.meant();
        let end = if is_spline { degree + 1 } else { 0 };
        let inner = self.inner_knots().iter().copied();
        repeat_n(0.0, end).chain(inner).chain(repeat_n(1.0, end))
    }

    /// What is known of the rope; `None` for a number this version does not know.
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
}

message! {
    /// The points that a descriptor was fitted to: the rope's centerline, at equal steps of arc length, in the message's unit.
    /// They are as the image has them, unfiltered, however well the curve lies on them.
    pub struct CenterlinePoints = "lariat.CenterlinePoints.v1" {
        /// How many points are meant; 0 if the writer has none to give.
        count: u32 = 0 => count(points),
        /// 1 if the rope is closed: the last point is followed by the first.
        closed: u32 = 0 => flag,
        /// Which points are covered by something or outside of the image, and so not seen: bit i % 32 of word i / 32 is point i.
        hidden: [u32; MAX_POINTS / 32] = [0; MAX_POINTS / 32] => hidden(points),
        /// The points, `[x, y]`.
        points: [[f32; 2]; MAX_POINTS] = [[0.0; 2]; MAX_POINTS] => points(points),
        /// The rope's width at each point.
        widths: [f32; MAX_POINTS] = [0.0; MAX_POINTS] => list(widths),
    }
}

impl CenterlinePoints {
    /// The points that are meant.
    pub fn points(&self) -> &[[f32; 2]] {
        &self.points[..(self.count as usize).min(MAX_POINTS)]
    }

    /// The widths at those points.
    pub fn widths(&self) -> &[f32] {
        &self.widths[..(self.count as usize).min(MAX_POINTS)]
    }

    /// Takes over what others mean; what they do not mean stays as it was.
    fn copy_meant(&mut self, from: &Self) {
        (self.count, self.closed, self.hidden) = (from.count, from.closed, from.hidden);
        // By the copy: what lies in shared memory may be another a moment later.
        let count = self.points().len();
        self.points[..count].copy_from_slice(&from.points[..count]);
        self.widths[..count].copy_from_slice(&from.widths[..count]);
    }

    /// Whether point `i` is covered by something or outside of the image, and so not seen.
    pub const fn is_hidden(&self, i: usize) -> bool {
        is_hidden(&self.hidden, i)
    }

    /// Says of each point, in order, whether it is covered.
    pub fn set_hidden(&mut self, hidden: impl IntoIterator<Item = bool>) {
        self.hidden = hidden::hidden(hidden);
    }
}

message! {
    /// What a control loop reads: the shape of every rope in one frame.
    pub struct Descriptors = "lariat.Descriptors.v9" {
        /// The frame's whole way.
        trace: Trace = Trace::EMPTY => message,
        /// Width of the image in pixels; 0 while the camera gives none.
        width: u32 = 0 => number,
        /// Height of the image in pixels.
        height: u32 = 0 => number,
        /// How many curves are meant. 0 is an answer: there is no rope.
        count: u32 = 0 => count(curves),
        /// A [`Unit`]'s number: what the curves are measured in.
        unit: u32 = Unit::Pixel as u32 => code(Unit),
        /// The curves.
        curves: [Descriptor; MAX_CURVES] = [Descriptor::EMPTY; MAX_CURVES] => messages(curves),
        /// The points of each curve, in the same order.
        centerlines: [CenterlinePoints; MAX_CURVES] = [CenterlinePoints::EMPTY; MAX_CURVES] => messages(centerlines),
    }
}

impl Descriptors {
    /// What the curves are measured in; `None` for a number this version does not know.
    pub const fn unit(&self) -> Option<Unit> {
        Unit::from_code(self.unit)
    }

    /// Takes over what another message means; what it does not mean stays as it was.
    pub fn copy_meant(&mut self, from: &Self) {
        self.trace = from.trace;
        (self.width, self.height) = (from.width, from.height);
        (self.count, self.unit) = (from.count, from.unit);
        // By the copy: what lies in shared memory may be another a moment later.
        let count = self.curves().len();
        self.curves[..count].copy_from_slice(&from.curves[..count]);
        for (to, from) in self.centerlines[..count].iter_mut().zip(&from.centerlines) {
            to.copy_meant(from);
        }
    }

    /// The curves that are meant.
    pub fn curves(&self) -> &[Descriptor] {
        &self.curves[..(self.count as usize).min(MAX_CURVES)]
    }

    /// The points of those curves.
    pub fn centerlines(&self) -> &[CenterlinePoints] {
        &self.centerlines[..(self.count as usize).min(MAX_CURVES)]
    }
}

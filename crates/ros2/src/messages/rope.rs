//! A rope's curve for ROS, in three coordinates: in space, on the plane or, in pixels, in the
//! image.

use lariat_wire::{
    Axes, Descriptor, Descriptor3, Descriptors, Descriptors3, FitQuality, MIN_CONFIDENCE, Place,
    Shape, Status as Seen,
};

use super::Scale;
use super::ellipsoid::Ellipsoid;

/// The message with the shapes of a frame.
#[derive(Clone, Copy)]
pub(crate) enum Shapes<'a> {
    /// On the plane, or in the image.
    Flat(&'a Descriptors),
    InSpace(&'a Descriptors3),
}

impl<'a> Shapes<'a> {
    /// The axes of shapes in space; `None` for flat shapes and for unknown axes.
    pub(crate) fn axes(self) -> Option<Axes> {
        match self {
            Self::Flat(_) => None,
            Self::InSpace(message) => message.axes(),
        }
    }

    /// Number of visible ropes whose position in space is unknown.
    pub(crate) fn unplaced(self) -> usize {
        let Self::InSpace(message) = self else {
            return 0;
        };
        let ropes = message.curves().iter();
        let is_seen = |rope: &&Descriptor3| rope.status() != Some(Seen::Lost);
        ropes
            .filter(is_seen)
            .filter(|rope| rope.place() != Some(Place::Known))
            .count()
    }

    /// The ropes that can be used for steering, in the order of the message.
    pub(crate) fn sure(self) -> Vec<Rope<'a>> {
        match self {
            Self::Flat(message) => {
                let scale = Scale::of(message);
                let sure = message.curves().iter();
                sure.filter_map(|rope| Rope::flat(rope, scale)).collect()
            }
            Self::InSpace(message) => message.curves().iter().filter_map(Rope::in_space).collect(),
        }
    }
}

/// A rope that can be used for steering. Lost or doubtful ropes are excluded, as are those with a
/// coarse curve or an unknown position.
pub(crate) struct Rope<'a> {
    pub(crate) track: u32,
    pub(crate) width: f64,
    curve: Curve<'a>,
}

enum Curve<'a> {
    Flat(&'a Descriptor, Shape<'a>, Scale),
    InSpace(&'a Descriptor3, Shape<'a, 3>),
}

impl<'a> Rope<'a> {
    pub(crate) fn flat(rope: &'a Descriptor, scale: Scale) -> Option<Self> {
        let shape = Shape::of(rope).ok();
        let shape = shape.filter(|_| is_sure(rope.status(), rope.fit(), rope.confidence))?;
        Some(Self {
            track: rope.track,
            width: scale.length(rope.width),
            curve: Curve::Flat(rope, shape, scale),
        })
    }

    pub(crate) fn in_space(rope: &'a Descriptor3) -> Option<Self> {
        let is_measured = rope.place() == Some(Place::Known);
        let shape = Shape::in_space(rope).ok();
        let shape =
            shape.filter(|_| is_measured && is_sure(rope.status(), rope.fit(), rope.confidence))?;
        Some(Self {
            track: rope.track,
            width: Scale::MILLIMETERS.length(rope.width),
            curve: Curve::InSpace(rope, shape),
        })
    }

    pub(crate) fn is_closed(&self) -> bool {
        match &self.curve {
            Curve::Flat(_, shape, _) => shape.is_closed(),
            Curve::InSpace(_, shape) => shape.is_closed(),
        }
    }

    /// Returns true if the curve is flat: on the plane or in the image.
    pub(crate) fn is_flat(&self) -> bool {
        matches!(self.curve, Curve::Flat(..))
    }

    /// Points at equal steps of ρ, from end to end or once around, and the direction of the curve
    /// at each.
    pub(crate) fn along(&self, count: usize) -> impl Iterator<Item = ([f64; 3], [f64; 3])> {
        (0..count).map(move |i| match &self.curve {
            Curve::Flat(_, shape, scale) => {
                let rho = shape.even_rho(i, count);
                let [x, y] = shape.tangent_at(rho).unwrap_or([1.0, 0.0]);
                (scale.point(shape.point_at(rho)), [x, y, 0.0])
            }
            Curve::InSpace(_, shape) => {
                let rho = shape.even_rho(i, count);
                let direction = shape.tangent_at(rho).unwrap_or([1.0, 0.0, 0.0]);
                (Scale::MILLIMETERS.point3(shape.point_at(rho)), direction)
            }
        })
    }

    /// The control points; for a closed rope, the coefficients of its Fourier series.
    pub(crate) fn control_points(&self) -> Vec<[f64; 3]> {
        match &self.curve {
            Curve::Flat(_, shape, scale) => {
                let points = shape.control_points().iter();
                points.map(|&p| scale.point(p)).collect()
            }
            Curve::InSpace(_, shape) => {
                let points = shape.control_points().iter();
                points.map(|&p| Scale::MILLIMETERS.point3(p)).collect()
            }
        }
    }

    /// The covariance of each control point.
    pub(crate) fn uncertainties(&self) -> Vec<Ellipsoid> {
        match &self.curve {
            Curve::Flat(rope, _, scale) => {
                let covariances = rope.covariances().iter();
                covariances
                    .map(|&c| Ellipsoid::flat(c).scaled(*scale))
                    .collect()
            }
            Curve::InSpace(rope, _) => {
                let covariances = rope.covariances().iter();
                covariances
                    .map(|&c| Ellipsoid::in_space(c).scaled(Scale::MILLIMETERS))
                    .collect()
            }
        }
    }
}

fn is_sure(status: Option<Seen>, fit: Option<FitQuality>, confidence: f32) -> bool {
    let is_seen = matches!(status, Some(Seen::Ok | Seen::Partial));
    is_seen && fit != Some(FitQuality::Coarse) && confidence >= MIN_CONFIDENCE
}

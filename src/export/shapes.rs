//! Recorded descriptors, with the keys that `lariat fit` and `lariat trace` print and all other
//! fields.

use crate::message_json::Object;
use lariat_wire::{Basis, CenterlinePoints, Descriptor, Descriptors, FitQuality, Status, Unit};
use serde::Serialize;

/// One frame.
#[derive(Serialize)]
pub(super) struct FrameObject<'a> {
    trace: Object<'a>,
    width: u32,
    height: u32,
    curves: Vec<CurveObject<'a>>,
}

/// One rope.
#[derive(Debug, Serialize)]
struct CurveObject<'a> {
    track: u32,
    status: &'static str,
    closed: bool,
    border: [bool; 2],
    confidence: f32,
    age_ns: u64,
    hidden: u32,
    samples: u32,
    basis: &'static str,
    degree: u32,
    control_points: &'a [[f64; 2]],
    #[serde(skip_serializing_if = "<[f64]>::is_empty")]
    weights: &'a [f64],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    knots: Vec<f64>,
    fit: &'static str,
    rms: f64,
    max: f64,
    residual_variance: f64,
    condition: f64,
    unit: &'static str,
    length: f64,
    width: f64,
    covariances: &'a [[f64; 3]],
    /// Velocities of the control points; only for filtered curves.
    #[serde(skip_serializing_if = "<[[f64; 2]]>::is_empty")]
    velocities: &'a [[f64; 2]],
    /// Points that the curve was fitted to.
    centerline: &'a [[f32; 2]],
    /// Width at each point.
    widths: &'a [f32],
}

impl<'a> FrameObject<'a> {
    pub(super) fn of(message: &'a Descriptors) -> Self {
        let unit = unit(message);
        Self {
            trace: Object(&message.trace, &[]),
            width: message.width,
            height: message.height,
            curves: message
                .curves()
                .iter()
                .zip(message.centerlines())
                .map(|(curve, points)| CurveObject::of(curve, points, unit))
                .collect(),
        }
    }
}

impl<'a> CurveObject<'a> {
    fn of(curve: &'a Descriptor, points: &'a CenterlinePoints, unit: &'static str) -> Self {
        let is_rational = curve.basis() == Some(Basis::RationalBezier);
        let is_filtered = curve.filtered != 0;
        Self {
            track: curve.track,
            status: status(curve),
            closed: curve.closed != 0,
            border: [curve.border & 1 != 0, curve.border & 2 != 0],
            confidence: curve.confidence,
            age_ns: curve.age_ns,
            hidden: curve.hidden,
            samples: curve.samples,
            basis: basis(curve),
            degree: curve.degree,
            control_points: curve.control_points(),
            weights: if is_rational { curve.weights() } else { &[] },
            knots: curve.all_knots().collect(),
            fit: fit(curve),
            rms: curve.rms,
            max: curve.max,
            residual_variance: curve.residual_variance,
            condition: curve.condition,
            unit,
            length: curve.length,
            width: curve.width,
            covariances: curve.covariances(),
            velocities: if is_filtered { curve.velocities() } else { &[] },
            centerline: points.points(),
            widths: points.widths(),
        }
    }
}

/// Unit of a message's curves.
pub(super) fn unit(message: &Descriptors) -> &'static str {
    message.unit().unwrap_or(Unit::Pixel).name()
}

/// Name of a rope's status.
pub(super) fn status(curve: &Descriptor) -> &'static str {
    curve.status().map_or("unknown", Status::name)
}

/// Name of a curve's fit quality.
pub(super) fn fit(curve: &Descriptor) -> &'static str {
    curve.fit().map_or("unknown", FitQuality::name)
}

/// Name of a curve's basis, as in the settings.
pub(super) fn basis(curve: &Descriptor) -> &'static str {
    curve.basis().map_or("unknown", Basis::name)
}

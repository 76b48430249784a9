//! A message as a JSON object on one line: the fields of the message by their names, enumerations as words, arrays as far
//! as they are meant. Numbers are written so that they read back to the last bit.

use std::borrow::Cow;

use anyhow::Result;
use lariat_wire::{
    Basis, CenterlinePoints, Centerlines, Crossing, Curve, Descriptor, Descriptors, FitQuality,
    FrameHeader, PixelFormat, SourceKind, Status, Trace, Unit,
};
use serde::Serialize;

use crate::topic::probe::Any;

#[derive(Serialize)]
struct Line<'a> {
    channel: &'a str,
    trace: TraceFields,
    width: u32,
    height: u32,
    #[serde(flatten)]
    rest: Rest<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Rest<'a> {
    Image {
        stride: u32,
        pixel_format: Cow<'static, str>,
        source: Cow<'static, str>,
        /// Of the pixels, which are left out.
        bytes: usize,
    },
    Centerlines {
        curves: Vec<CurveFields<'a>>,
        crossings: Vec<CrossingFields>,
    },
    Descriptors {
        unit: Cow<'static, str>,
        curves: Vec<DescriptorFields<'a>>,
    },
}

#[derive(Serialize)]
struct TraceFields {
    sequence: u64,
    captured: u64,
    extracted: u64,
    fitted: u64,
    exposed_ns: u64,
    captured_ns: u64,
    extract_started_ns: u64,
    extracted_ns: u64,
    fit_started_ns: u64,
    fitted_ns: u64,
}

#[derive(Serialize)]
struct CurveFields<'a> {
    track: u32,
    status: Cow<'static, str>,
    closed: bool,
    /// Whether its first and its last end leave the image.
    border: [bool; 2],
    width_px: f32,
    length_px: f32,
    age_ns: u64,
    /// The points that are covered, by their numbers from 0.
    hidden: Vec<usize>,
    points: &'a [[f32; 2]],
    widths_px: &'a [f32],
}

#[derive(Serialize)]
struct CrossingFields {
    at: [f32; 2],
    over: u32,
    under: u32,
    over_rho: f32,
    under_rho: f32,
    confidence: f32,
}

#[derive(Serialize)]
struct DescriptorFields<'a> {
    track: u32,
    status: Cow<'static, str>,
    basis: Cow<'static, str>,
    order: u32,
    samples: u32,
    closed: bool,
    border: [bool; 2],
    rms: f64,
    max: f64,
    residual_variance: f64,
    condition: f64,
    length: f64,
    width: f64,
    age_ns: u64,
    hidden: u32,
    filtered: bool,
    fit: Cow<'static, str>,
    control_points: &'a [[f64; 2]],
    weights: &'a [f64],
    covariances: &'a [[f64; 3]],
    velocities: &'a [[f64; 2]],
    /// The inner ones of a B-spline.
    knots: &'a [f64],
    centerline: PointsFields<'a>,
}

/// The points that a curve was fitted to.
#[derive(Serialize)]
struct PointsFields<'a> {
    /// Those that are covered, by their numbers from 0.
    hidden: Vec<usize>,
    points: &'a [[f32; 2]],
    widths: &'a [f32],
}

/// The message on a line.
pub(super) fn line(channel: &str, message: Any) -> Result<String> {
    let (width, height) = match message {
        Any::Image(header, _) => (header.width, header.height),
        Any::Centerlines(message) => (message.width, message.height),
        Any::Descriptors(message) => (message.width, message.height),
    };
    let line = Line {
        channel,
        trace: TraceFields::of(message.trace()),
        width,
        height,
        rest: match message {
            Any::Image(header, pixels) => image(header, pixels),
            Any::Centerlines(message) => centerlines(message),
            Any::Descriptors(message) => descriptors(message),
        },
    };
    Ok(serde_json::to_string(&line)? + "\n")
}

fn image<'a>(header: &FrameHeader, pixels: &[u8]) -> Rest<'a> {
    Rest::Image {
        stride: header.stride,
        pixel_format: PixelFormat::word(header.pixel_format),
        source: SourceKind::word(header.source),
        bytes: pixels.len(),
    }
}

fn centerlines(message: &Centerlines) -> Rest<'_> {
    Rest::Centerlines {
        curves: message.curves().iter().map(CurveFields::of).collect(),
        crossings: message.crossings().iter().map(CrossingFields::of).collect(),
    }
}

fn descriptors(message: &Descriptors) -> Rest<'_> {
    let curves = message.curves().iter().zip(message.centerlines());
    Rest::Descriptors {
        unit: Unit::word(message.unit),
        curves: curves
            .map(|(curve, points)| DescriptorFields::of(curve, points))
            .collect(),
    }
}

fn ends(border: u32) -> [bool; 2] {
    [border & 1 != 0, border & 2 != 0]
}

impl TraceFields {
    fn of(trace: &Trace) -> Self {
        Self {
            sequence: trace.sequence,
            captured: trace.captured,
            extracted: trace.extracted,
            fitted: trace.fitted,
            exposed_ns: trace.exposed_ns,
            captured_ns: trace.captured_ns,
            extract_started_ns: trace.extract_started_ns,
            extracted_ns: trace.extracted_ns,
            fit_started_ns: trace.fit_started_ns,
            fitted_ns: trace.fitted_ns,
        }
    }
}

impl<'a> CurveFields<'a> {
    fn of(curve: &'a Curve) -> Self {
        let points = curve.points();
        Self {
            track: curve.track,
            status: Status::word(curve.status),
            closed: curve.closed != 0,
            border: ends(curve.border),
            width_px: curve.width_px,
            length_px: curve.length_px,
            age_ns: curve.age_ns,
            hidden: (0..points.len()).filter(|&i| curve.is_hidden(i)).collect(),
            points,
            widths_px: curve.widths_px(),
        }
    }
}

impl CrossingFields {
    fn of(crossing: &Crossing) -> Self {
        Self {
            at: crossing.at,
            over: crossing.over,
            under: crossing.under,
            over_rho: crossing.over_rho,
            under_rho: crossing.under_rho,
            confidence: crossing.confidence,
        }
    }
}

impl<'a> DescriptorFields<'a> {
    fn of(curve: &'a Descriptor, centerline: &'a CenterlinePoints) -> Self {
        Self {
            track: curve.track,
            status: Status::word(curve.status),
            basis: Basis::word(curve.basis),
            order: curve.order,
            samples: curve.samples,
            closed: curve.closed != 0,
            border: ends(curve.border),
            rms: curve.rms,
            max: curve.max,
            residual_variance: curve.residual_variance,
            condition: curve.condition,
            length: curve.length,
            width: curve.width,
            age_ns: curve.age_ns,
            hidden: curve.hidden,
            filtered: curve.filtered != 0,
            fit: FitQuality::word(curve.fit),
            control_points: curve.control_points(),
            weights: curve.weights(),
            covariances: curve.covariances(),
            velocities: curve.velocities(),
            knots: curve.inner_knots(),
            centerline: PointsFields {
                hidden: (0..centerline.points().len())
                    .filter(|&i| centerline.is_hidden(i))
                    .collect(),
                points: centerline.points(),
                widths: centerline.widths(),
            },
        }
    }
}

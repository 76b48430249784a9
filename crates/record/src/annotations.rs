//! Annotations that Foxglove draws over the image: the observed ropes, and the curves fitted to
//! them.

use lariat_message::{Basis, Centerlines, Curve, Descriptor, Descriptors, Status};

use crate::cdr::{Cdr, Encoder};
use crate::images::put_time;
use crate::palette::rope_color;
use crate::schema::{Schema, schema};

/// Schema of the annotations.
pub const ANNOTATIONS: Schema = schema!(
    "foxglove_msgs/msg/ImageAnnotations",
    "ImageAnnotations.msg",
    "foxglove_msgs/CircleAnnotation" = "CircleAnnotation.msg",
    "foxglove_msgs/PointsAnnotation" = "PointsAnnotation.msg",
    "foxglove_msgs/TextAnnotation" = "TextAnnotation.msg",
    "foxglove_msgs/Point2" = "Point2.msg",
    "foxglove_msgs/Color" = "Color.msg",
    "builtin_interfaces/Time" = "Time.msg"
);

/// Types in `PointsAnnotation`.
const POINTS: u8 = 1;
const LINE_LOOP: u8 = 2;
const LINE_STRIP: u8 = 3;

type Color = [f64; 4];
const NONE: Color = [0.0; 4];
/// Color of covered points.
const HIDDEN: Color = [0.5, 0.5, 0.5, 1.0];
const WHITE: Color = [1.0; 4];
const BACKGROUND: Color = [0.0, 0.0, 0.0, 0.5];

fn color(track: u32) -> Color {
    let [red, green, blue] = rope_color(track).map(|byte| f64::from(byte) / 255.0);
    [red, green, blue, 1.0]
}

/// Writes `foxglove_msgs/ImageAnnotations` into a buffer, replacing its contents: centerlines as
/// lines, with hidden parts in gray, a ring around each crossing, and a label at each rope's start.
/// `stamp_ns` is the image's exposure, in nanoseconds of Unix time.
pub fn encode_ropes(seen: &Centerlines, stamp_ns: u64, into: &mut Vec<u8>) {
    let to = &mut Encoder::new(into);
    to.byte_count(seen.crossings().len());
    for crossing in seen.crossings() {
        let over = seen.curves().get(crossing.over as usize);
        let width_px = over.map_or(10.0, |rope| f64::from(rope.width_px));
        put_circle(to, stamp_ns, crossing.at.map(f64::from), 2.0 * width_px);
    }
    to.byte_count(seen.curves().len());
    for rope in seen.curves() {
        put_rope(to, stamp_ns, rope);
    }
    to.byte_count(seen.curves().len());
    for rope in seen.curves() {
        put_label(to, stamp_ns, rope);
    }
}

/// Writes the control polygons like [`encode_ropes`]. `pixel` maps a point of the descriptors to
/// the image. A polygon that is not completely in the image is left out.
pub fn encode_control_points(
    shapes: &Descriptors,
    pixel: impl Fn([f64; 2]) -> Option<[f64; 2]>,
    stamp_ns: u64,
    into: &mut Vec<u8>,
) {
    let to = &mut Encoder::new(into);
    to.byte_count(0);
    let is_seen = |shape: &&Descriptor| {
        has_polygon(shape) && shape.control_points().iter().all(|p| pixel(*p).is_some())
    };
    to.byte_count(2 * shapes.curves().iter().filter(is_seen).count());
    for shape in shapes.curves().iter().filter(is_seen) {
        let points = shape.control_points().iter();
        let color = color(shape.track);
        for (kind, thickness_px) in [(LINE_STRIP, 1.0), (POINTS, 5.0)] {
            put_time(to, stamp_ns);
            kind.put(to);
            put_points(to, points.clone().map(|p| pixel(*p).unwrap_or_default()));
            color.put(to);
            to.byte_count(0);
            NONE.put(to);
            put_thickness(to, thickness_px);
        }
    }
    to.byte_count(0);
}

/// Returns whether the control points surround the curve.
fn has_polygon(shape: &Descriptor) -> bool {
    !matches!(shape.basis(), None | Some(Basis::Fourier))
}

fn put_thickness(to: &mut Encoder, thickness_px: f64) {
    thickness_px.put(to);
}

/// Shifts points by half a pixel: Foxglove's origin is the corner of the top-left pixel, lariat's
/// is the center of that pixel.
fn put_points(to: &mut Encoder, points: impl ExactSizeIterator<Item = [f64; 2]>) {
    to.byte_count(points.len());
    points.for_each(|p| p.map(|c| c + 0.5).put(to));
}

fn put_rope(to: &mut Encoder, stamp_ns: u64, rope: &Curve) {
    put_time(to, stamp_ns);
    let is_closed = rope.closed != 0;
    (if is_closed { LINE_LOOP } else { LINE_STRIP }).put(to);
    let points = rope.points();
    put_points(to, points.iter().map(|p| p.map(f64::from)));
    let own = color(rope.track);
    own.put(to);
    let is_hidden = |i| rope.status() == Some(Status::Lost) || rope.is_hidden(i);
    let colors = if (0..points.len()).any(is_hidden) {
        // One color per segment.
        points.len() - usize::from(!is_closed && !points.is_empty())
    } else {
        0
    };
    to.byte_count(colors);
    for i in 0..colors {
        let covered = is_hidden(i) || is_hidden((i + 1) % points.len());
        (if covered { HIDDEN } else { own }).put(to);
    }
    NONE.put(to);
    put_thickness(to, 2.0);
}

fn put_circle(to: &mut Encoder, stamp_ns: u64, at: [f64; 2], diameter_px: f64) {
    put_time(to, stamp_ns);
    at.map(|c| c + 0.5).put(to);
    diameter_px.put(to);
    put_thickness(to, 1.0);
    NONE.put(to);
    WHITE.put(to);
}

fn put_label(to: &mut Encoder, stamp_ns: u64, rope: &Curve) {
    put_time(to, stamp_ns);
    let at = rope.points().first().copied().unwrap_or_default();
    at.map(|c| f64::from(c) + 0.5).put(to);
    to.string(match rope.status() {
        None | Some(Status::Ok) => "start",
        Some(status) => status.name(),
    });
    12.0_f64.put(to);
    color(rope.track).put(to);
    BACKGROUND.put(to);
}

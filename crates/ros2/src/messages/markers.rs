//! `visualization_msgs/MarkerArray`: the ropes as RViz and Foxglove draw them.

use lariat_record::{Cdr, Encoder, rope_color};
use lariat_wire::{Centerlines, Crossing, Descriptor, Descriptors, Shape, Unit};

use super::{Header, Scale, put_turn, sure};

/// As in `visualization_msgs/Marker`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Cylinder = 3,
    LineStrip = 4,
    SphereList = 7,
}
const ADD: i32 = 0;
const DELETE_ALL: i32 = 3;

type Color = [f32; 4];
const CONTROL_POINT: Color = [1.0, 1.0, 1.0, 1.0];
const ELLIPSE: Color = [1.0, 1.0, 1.0, 0.35];
const CROSSING: Color = [1.0, 1.0, 1.0, 0.6];
const UNDER: Color = [0.15, 0.15, 0.15, 1.0];

/// Points that a curve is drawn with.
const DRAWN: usize = 96;
/// Points on each side of a crossing by which the strands there are drawn.
const BESIDE: usize = 4;
/// Half axes of an ellipse, in standard deviations: nine of ten control points lie within √(−2 ln 0.1).
const DEVIATIONS: f64 = 2.146;

/// A rope's own.
fn color(track: u32) -> Color {
    let [red, green, blue] = rope_color(track).map(|byte| f32::from(byte) / 255.0);
    [red, green, blue, 1.0]
}

/// What is drawn once.
struct Marker<'a> {
    /// What it belongs to.
    ns: &'a str,
    id: i32,
    kind: Kind,
    at: [f64; 3],
    yaw: f64,
    scale: [f64; 3],
    color: Color,
    points: &'a [[f64; 3]],
}

/// Writes what is to be drawn: all that was before is deleted, then for each rope whose curve may be steered by its `curve`, its
/// `control_points` and for each an ellipse of `covariance`; then, where the centerlines of the same frame are there, each crossing
/// with the strand that is `over` and the one `under`, by its side.
pub(crate) fn markers(
    message: &Descriptors,
    seen: Option<&Centerlines>,
    header: &Header,
    into: &mut Vec<u8>,
) {
    let scale = Scale::of(message);
    let mut drawn = Drawing {
        count: 0,
        body: Vec::new(),
        header,
    };
    drawn.delete_all();
    for rope in message.curves() {
        if let Some(shape) = sure(rope) {
            drawn.rope(rope, &shape, scale);
        }
    }
    if let Some(seen) = seen {
        for (id, crossing) in seen.crossings().iter().enumerate() {
            drawn.crossing(id as i32, crossing, seen, message, scale);
        }
    }
    drawn.finish(into);
}

/// Markers, counted while they are written.
struct Drawing<'a> {
    count: usize,
    /// As a message by itself: it begins with its number of markers, not yet known.
    body: Vec<u8>,
    header: &'a Header<'a>,
}

impl Drawing<'_> {
    fn delete_all(&mut self) {
        self.put(
            &Marker {
                ns: "",
                id: 0,
                kind: Kind::LineStrip,
                at: [0.0; 3],
                yaw: 0.0,
                scale: [0.0; 3],
                color: [0.0; 4],
                points: &[],
            },
            DELETE_ALL,
        );
    }

    fn rope(&mut self, rope: &Descriptor, shape: &Shape, scale: Scale) {
        let color = color(rope.track);
        let width = scale.length(rope.width);
        let curve: Vec<_> = (0..DRAWN + usize::from(shape.is_closed()))
            .map(|i| scale.point(shape.point_at(shape.even_rho(i, DRAWN))))
            .collect();
        self.lines("curve", rope.track as i32, 0.3 * width, color, &curve);
        // The coefficients of a Fourier series lie nowhere.
        if shape.is_closed() {
            return;
        }
        let control: Vec<_> = shape
            .control_points()
            .iter()
            .map(|&p| scale.point(p))
            .collect();
        self.put(
            &Marker {
                ns: "control_points",
                id: rope.track as i32,
                kind: Kind::SphereList,
                at: [0.0; 3],
                yaw: 0.0,
                scale: [0.5 * width; 3],
                color: CONTROL_POINT,
                points: &control,
            },
            ADD,
        );
        for (i, (at, covariance)) in control.iter().zip(rope.covariances()).enumerate() {
            let (axes, yaw) = ellipse(*covariance);
            let [long, short] = axes.map(|axis| scale.length(2.0 * DEVIATIONS * axis));
            self.put(
                &Marker {
                    ns: "covariance",
                    id: rope.track as i32 * lariat_wire::MAX_CONTROL_POINTS as i32 + i as i32,
                    kind: Kind::Cylinder,
                    at: *at,
                    yaw,
                    scale: [long, short, 0.05 * width],
                    color: ELLIPSE,
                    points: &[],
                },
                ADD,
            );
        }
    }

    fn crossing(
        &mut self,
        id: i32,
        crossing: &Crossing,
        seen: &Centerlines,
        message: &Descriptors,
        scale: Scale,
    ) {
        // Extract's curves and fit's are of the same tracks.
        let line = |rope: u32| {
            let track = seen.curves().get(rope as usize)?.track;
            let place = message
                .curves()
                .iter()
                .position(|rope| rope.track == track)?;
            Some((place, message.centerlines().get(place)?.points()))
        };
        let (Some((place, over)), Some((_, under))) = (line(crossing.over), line(crossing.under))
        else {
            return;
        };
        let [upper, lower] = [(over, crossing.over_rho), (under, crossing.under_rho)]
            .map(|(points, rho)| beside(points, rho, message, crossing));
        let (Some(upper), Some(lower)) = (upper, lower) else {
            return;
        };
        let width = scale.length(message.curves()[place].width);
        let raised = |points: &[[f32; 2]], z: f64| -> Vec<[f64; 3]> {
            let points = points.iter().map(|p| scale.point(p.map(f64::from)));
            points.map(|[x, y, _]| [x, y, z]).collect()
        };
        let own = color(message.curves()[place].track);
        self.lines("under", id, 0.8 * width, UNDER, &raised(lower, 0.5 * width));
        self.lines("over", id, 0.8 * width, own, &raised(upper, width));
        let at = upper[upper.len() / 2].map(f64::from);
        self.put(
            &Marker {
                ns: "crossings",
                id,
                kind: Kind::Cylinder,
                at: scale.point(at),
                yaw: 0.0,
                scale: [3.0 * width, 3.0 * width, 0.05 * width],
                color: CROSSING,
                points: &[],
            },
            ADD,
        );
    }

    fn lines(&mut self, ns: &str, id: i32, width: f64, color: Color, points: &[[f64; 3]]) {
        self.put(
            &Marker {
                ns,
                id,
                kind: Kind::LineStrip,
                at: [0.0; 3],
                yaw: 0.0,
                // Of a line, x is the width, and the rest has no meaning.
                scale: [width, 0.0, 0.0],
                color,
                points,
            },
            ADD,
        );
    }

    fn put(&mut self, marker: &Marker, action: i32) {
        // Continued where it stands, so that what follows is aligned.
        let to = &mut if self.count == 0 {
            let mut to = Encoder::new(&mut self.body);
            to.byte_count(0);
            to
        } else {
            Encoder::after(&mut self.body)
        };
        self.count += 1;
        self.header.put(to);
        to.string(marker.ns);
        marker.id.put(to);
        (marker.kind as i32).put(to);
        action.put(to);
        marker.at.put(to);
        put_turn(to, marker.yaw);
        marker.scale.put(to);
        marker.color.put(to);
        // It stays until the next message, and is not locked to a frame that moves.
        [0_u32; 2].put(to);
        0_u8.put(to);
        to.byte_count(marker.points.len());
        marker.points.iter().for_each(|point| point.put(to));
        // No colors by the point, no texture (a name, then a whole compressed image), no places on it, no text, no mesh.
        to.byte_count(0);
        to.string("");
        Header {
            stamp_ns: 0,
            frame_id: "",
        }
        .put(to);
        to.string("");
        to.byte_count(0);
        to.byte_count(0);
        to.string("");
        to.string("");
        to.string("");
        to.byte_count(0);
        0_u8.put(to);
    }

    fn finish(mut self, into: &mut Vec<u8>) {
        // Behind the head of four bytes.
        self.body[4..8].copy_from_slice(&(self.count as u32).to_le_bytes());
        *into = self.body;
    }
}

/// A strand's points around a crossing. On a plane ρ is not the image's, but of pictures of a table seldom far from it: enough to
/// say which piece is meant.
fn beside<'a>(
    points: &'a [[f32; 2]],
    rho: f32,
    message: &Descriptors,
    crossing: &Crossing,
) -> Option<&'a [[f32; 2]]> {
    let last = points.len().checked_sub(1)?;
    let near = if message.unit() == Some(Unit::Pixel) {
        let far = |point: &[f32; 2]| {
            let [x, y] = [0, 1].map(|axis| point[axis] - crossing.at[axis]);
            x * x + y * y
        };
        // Near the ρ that it says, as the rope may come by more than once.
        let said = (f64::from(rho) * last as f64) as usize;
        let about = said.saturating_sub(BESIDE)..=(said + BESIDE).min(last);
        about.min_by(|&a, &b| far(&points[a]).total_cmp(&far(&points[b])))?
    } else {
        (f64::from(rho) * last as f64).round() as usize
    };
    points.get(near.saturating_sub(BESIDE)..=(near + BESIDE).min(last))
}

/// The standard deviations along an ellipse's axes, the longer first, and where that points, of a covariance `[xx, xy, yy]`.
fn ellipse([xx, xy, yy]: [f64; 3]) -> ([f64; 2], f64) {
    let middle = 0.5 * (xx + yy);
    let half = (0.5 * (xx - yy)).hypot(xy);
    let axes = [middle + half, middle - half].map(|variance| variance.max(0.0).sqrt());
    (axes, 0.5 * (2.0 * xy).atan2(xx - yy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ellipse_has_the_axes_of_its_covariance() {
        // Deviations 3 along (1, 1)/√2 and 1 across.
        let (axes, yaw) = ellipse([5.0, 4.0, 5.0]);
        assert!((axes[0] - 3.0).abs() < 1e-12 && (axes[1] - 1.0).abs() < 1e-12);
        assert!((yaw - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
        assert_eq!(ellipse([4.0, 0.0, 9.0]).0, [3.0, 2.0]);
    }
}

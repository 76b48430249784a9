//! `visualization_msgs/MarkerArray`: the ropes as RViz and Foxglove draw them.

use lariat_record::{Cdr, Encoder, rope_color};
use lariat_wire::{Centerlines, Crossing, Descriptors, MAX_CONTROL_POINTS, Unit};

use super::{Header, Rope, Scale};

/// Types, as in `visualization_msgs/Marker`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Sphere = 2,
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

/// Points with which a curve is drawn.
const DRAWN: usize = 96;
/// Points of a strand that are drawn on each side of a crossing.
const BESIDE: usize = 4;
/// The identity rotation.
const AS_IT_IS: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Color of a rope.
fn color(track: u32) -> Color {
    let [red, green, blue] = rope_color(track).map(|byte| f32::from(byte) / 255.0);
    [red, green, blue, 1.0]
}

/// A single marker.
struct Marker<'a> {
    /// Namespace of the marker.
    ns: &'a str,
    id: i32,
    kind: Kind,
    at: [f64; 3],
    /// A quaternion x, y, z, w.
    turn: [f64; 4],
    scale: [f64; 3],
    color: Color,
    points: &'a [[f64; 3]],
}

/// Writes all markers. Earlier ones are deleted first. Each rope then has its `curve`, its
/// `control_points`, and for each of those a `covariance`: an ellipse, or in space an ellipsoid. If
/// the centerlines of a flat message are known, each crossing follows, with the strand `over` and
/// the one `under` at different heights. In space the strands themselves have heights.
pub(crate) fn markers(
    ropes: &[Rope],
    crossed: Option<(&Descriptors, &Centerlines)>,
    header: &Header,
    into: &mut Vec<u8>,
) {
    let mut drawn = Drawing {
        count: 0,
        body: Vec::new(),
        header,
    };
    drawn.delete_all();
    for rope in ropes {
        drawn.rope(rope);
    }
    if let Some((message, seen)) = crossed {
        for (id, crossing) in seen.crossings().iter().enumerate() {
            drawn.crossing(id as i32, crossing, seen, message);
        }
    }
    drawn.finish(into);
}

/// Markers, counted while they are written.
struct Drawing<'a> {
    count: usize,
    /// A separate message that begins with the number of markers, which is not known yet.
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
                turn: AS_IT_IS,
                scale: [0.0; 3],
                color: [0.0; 4],
                points: &[],
            },
            DELETE_ALL,
        );
    }

    fn rope(&mut self, rope: &Rope) {
        let color = color(rope.track);
        let mut curve: Vec<_> = rope.along(DRAWN).map(|(at, _)| at).collect();
        curve.extend(curve.first().copied().filter(|_| rope.is_closed()));
        self.lines("curve", rope.track as i32, 0.3 * rope.width, color, &curve);
        // The coefficients of a Fourier series are not positions.
        if rope.is_closed() {
            return;
        }
        let control = rope.control_points();
        self.put(
            &Marker {
                ns: "control_points",
                id: rope.track as i32,
                kind: Kind::SphereList,
                at: [0.0; 3],
                turn: AS_IT_IS,
                scale: [0.5 * rope.width; 3],
                color: CONTROL_POINT,
                points: &control,
            },
            ADD,
        );
        for (i, (at, ellipsoid)) in control.iter().zip(rope.uncertainties()).enumerate() {
            let [long, short, third] = ellipsoid.axes;
            let (kind, third) = if rope.is_flat() {
                (Kind::Cylinder, 0.05 * rope.width)
            } else {
                (Kind::Sphere, third)
            };
            self.put(
                &Marker {
                    ns: "covariance",
                    id: (rope.track as i32).wrapping_mul(MAX_CONTROL_POINTS as i32) + i as i32,
                    kind,
                    at: *at,
                    turn: ellipsoid.turn,
                    scale: [long, short, third],
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
    ) {
        let scale = Scale::of(message);
        // Extract's curves and fit's curves have the same tracks.
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
                turn: AS_IT_IS,
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
                turn: AS_IT_IS,
                // For a line, x is the width; the rest is unused.
                scale: [width, 0.0, 0.0],
                color,
                points,
            },
            ADD,
        );
    }

    fn put(&mut self, marker: &Marker, action: i32) {
        // Continue the same encoding, so that the following data is aligned.
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
        marker.turn.put(to);
        marker.scale.put(to);
        marker.color.put(to);
        // The marker stays until the next message, and does not follow a moving frame.
        [0_u32; 2].put(to);
        0_u8.put(to);
        to.byte_count(marker.points.len());
        marker.points.iter().for_each(|point| point.put(to));
        // No colors per point, texture (a name and a compressed image), texture coordinates, text
        // or mesh.
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
        // After the four-byte header.
        self.body[4..8].copy_from_slice(&(self.count as u32).to_le_bytes());
        *into = self.body;
    }
}

/// A strand's points around a crossing. On a plane, ρ differs from ρ in the image. For images of a
/// table the difference is usually small, so the image's ρ suffices to select the points.
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
        // Search near the given ρ, because the rope may pass more than once.
        let said = (f64::from(rho) * last as f64) as usize;
        let about = said.saturating_sub(BESIDE)..=(said + BESIDE).min(last);
        about.min_by(|&a, &b| far(&points[a]).total_cmp(&far(&points[b])))?
    } else {
        (f64::from(rho) * last as f64).round() as usize
    };
    points.get(near.saturating_sub(BESIDE)..=(near + BESIDE).min(last))
}

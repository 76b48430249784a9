//! `nav_msgs/Path`: a rope's curve as poses along it; `geometry_msgs/PoseArray`: where ropes end.

use lariat_record::Encoder;
use lariat_wire::{Descriptor, Descriptors, Shape};

use super::{Header, Scale, put_pose, sure};

/// Poses along a curve: of a rope of 1 m one each 16 mm.
const POSES: usize = 64;

/// Writes poses at even steps of ρ, each with its x axis along the rope. `false`, and nothing is written: the rope has no curve
/// that may be steered by.
pub(crate) fn path(rope: &Descriptor, scale: Scale, header: &Header, into: &mut Vec<u8>) -> bool {
    let Some(shape) = sure(rope) else {
        return false;
    };
    let to = &mut Encoder::new(into);
    header.put(to);
    to.byte_count(POSES);
    for i in 0..POSES {
        header.put(to);
        put_on(to, &shape, shape.even_rho(i, POSES), scale);
    }
    true
}

/// Writes two poses for each open rope whose curve may be steered by, in the order of the message: its first end and its last,
/// both with their x axis along the rope, from the first to the last.
pub(crate) fn endpoints(message: &Descriptors, header: &Header, into: &mut Vec<u8>) {
    let scale = Scale::of(message);
    let to = &mut Encoder::new(into);
    header.put(to);
    let open = || {
        let ropes = message.curves().iter().filter(|rope| rope.closed == 0);
        ropes.filter_map(sure)
    };
    to.byte_count(2 * open().count());
    for shape in open() {
        put_on(to, &shape, 0.0, scale);
        put_on(to, &shape, 1.0, scale);
    }
}

fn put_on(to: &mut Encoder, shape: &Shape, rho: f64, scale: Scale) {
    let direction = shape.tangent_at(rho).unwrap_or([1.0, 0.0]);
    put_pose(to, scale.point(shape.point_at(rho)), direction);
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_wire::{Basis, FitQuality, Status, Unit};

    /// A straight rope from (100, 200) to (300, 200) mm.
    fn rope() -> Descriptor {
        let mut rope = Descriptor::EMPTY;
        (rope.order, rope.count, rope.samples) = (2, 3, 120);
        rope.basis = Basis::Bezier as u32;
        rope.status = Status::Ok as u32;
        rope.control_points[..3].copy_from_slice(&[[100.0, 200.0], [200.0, 200.0], [300.0, 200.0]]);
        rope
    }

    #[test]
    fn lengths_are_metres_where_there_is_a_plane_and_pixels_elsewhere() {
        let mut message = Box::new(Descriptors::EMPTY);
        message.count = 1;
        message.curves[0] = rope();
        let header = Header {
            stamp_ns: 1_000_000_001,
            frame_id: "a",
        };
        for (unit, x) in [(Unit::Millimeter, 0.3), (Unit::Pixel, 300.0)] {
            message.unit = unit as u32;
            let mut cdr = Vec::new();
            endpoints(&message, &header, &mut cdr);
            let mut from = lariat_record::Decoder::new(&cdr).expect("CDR");
            assert_eq!((from.value::<i32>(), from.value::<u32>()), (Ok(1), Ok(1)));
            assert_eq!(from.string(), Ok("a"));
            assert_eq!(from.value::<u32>(), Ok(2));
            let poses: [[f64; 7]; 2] = from.value().expect("two poses");
            assert!((poses[1][0] - x).abs() < 1e-9, "{poses:?}");
            assert_eq!(poses[1][2..], [0.0, 0.0, 0.0, 0.0, 1.0]);
        }
    }

    #[test]
    fn a_rope_that_is_not_sure_has_no_path() {
        let header = Header {
            stamp_ns: 0,
            frame_id: "a",
        };
        let has_path = |rope: &Descriptor| path(rope, Scale(1.0), &header, &mut Vec::new());
        assert!(has_path(&rope()));
        for status in [Status::Lost, Status::Doubtful] {
            let mut rope = rope();
            rope.status = status as u32;
            assert!(!has_path(&rope), "{status:?}");
        }
        let mut coarse = rope();
        coarse.fit = FitQuality::Coarse as u32;
        assert!(!has_path(&coarse));
    }
}

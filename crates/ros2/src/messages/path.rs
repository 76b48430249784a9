//! `nav_msgs/Path`: a rope's curve as poses along it. `geometry_msgs/PoseArray`: the ends of ropes.

use lariat_record::Encoder;

use super::{Header, Rope, put_pose};

/// Number of poses along a curve: one every 16 mm for a rope of 1 m.
const POSES: usize = 64;

/// Writes poses at equal steps of ρ, each with its x axis along the rope.
pub(crate) fn path(rope: &Rope, header: &Header, into: &mut Vec<u8>) {
    let to = &mut Encoder::new(into);
    header.put(to);
    to.byte_count(POSES);
    for (at, direction) in rope.along(POSES) {
        header.put(to);
        put_pose(to, at, direction);
    }
}

/// Writes two poses for each open rope, its first end and its last. Both have their x axis along
/// the rope, in the direction from first to last.
pub(crate) fn endpoints(ropes: &[Rope], header: &Header, into: &mut Vec<u8>) {
    let to = &mut Encoder::new(into);
    header.put(to);
    let open = || ropes.iter().filter(|rope| !rope.is_closed());
    to.byte_count(2 * open().count());
    for (at, direction) in open().flat_map(|rope| rope.along(2)) {
        put_pose(to, at, direction);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::{Scale, Shapes};
    use lariat_wire::{
        Basis, Descriptor, Descriptor3, Descriptors, FitQuality, Place, Status, Unit,
    };

    /// A straight rope from (100, 200) to (300, 200) mm.
    fn rope() -> Descriptor {
        let mut rope = Descriptor::EMPTY;
        rope.confidence = 1.0;
        (rope.degree, rope.count, rope.samples) = (2, 3, 120);
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
            endpoints(&Shapes::Flat(&message).sure(), &header, &mut cdr);
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
    fn a_rope_that_is_not_sure_is_none_to_be_steered_by() {
        let is_sure = |rope: &Descriptor| Rope::flat(rope, Scale::MILLIMETERS).is_some();
        assert!(is_sure(&rope()));
        for status in [Status::Lost, Status::Doubtful] {
            let mut rope = rope();
            rope.status = status as u32;
            assert!(!is_sure(&rope), "{status:?}");
        }
        let mut unsure = rope();
        unsure.confidence = 0.05;
        assert!(!is_sure(&unsure));
        let mut coarse = rope();
        coarse.fit = FitQuality::Coarse as u32;
        assert!(!is_sure(&coarse));
    }

    #[test]
    fn in_space_a_pose_points_along_the_rope_and_one_whose_place_is_not_known_has_none() {
        let mut rope = Descriptor3::EMPTY;
        rope.confidence = 1.0;
        (rope.degree, rope.count, rope.samples) = (1, 2, 120);
        rope.place = Place::Known as u32;
        rope.control_points[..2].copy_from_slice(&[[0.0, 0.0, 500.0], [200.0, -100.0, 700.0]]);
        let header = Header {
            stamp_ns: 0,
            frame_id: "a",
        };
        let mut cdr = Vec::new();
        let sure = Rope::in_space(&rope).expect("a rope to steer by");
        endpoints(&[sure], &header, &mut cdr);
        let mut from = lariat_record::Decoder::new(&cdr).expect("CDR");
        let head = (from.value::<i32>(), from.value::<u32>(), from.string());
        assert_eq!((head, from.value()), ((Ok(0), Ok(0), Ok("a")), Ok(2_u32)));
        let poses: [[f64; 7]; 2] = from.value().expect("two poses");
        for ([x, y, z, a, b, c, w], at) in
            poses.into_iter().zip([[0.0, 0.0, 0.5], [0.2, -0.1, 0.7]])
        {
            assert!(
                [x, y, z]
                    .iter()
                    .zip(at)
                    .all(|(c, at)| (c - at).abs() < 1e-12)
            );
            let along = [
                w * w + a * a - b * b - c * c,
                2.0 * (a * b + w * c),
                2.0 * (a * c - w * b),
            ];
            let third = 1.0 / 3.0;
            for (c, meant) in along.iter().zip([2.0 * third, -third, 2.0 * third]) {
                assert!((c - meant).abs() < 1e-12, "{along:?}");
            }
            // The y axis is level.
            assert!((2.0 * (b * c + w * a)).abs() < 1e-12);
        }
        rope.place = Place::Before as u32;
        assert!(Rope::in_space(&rope).is_none());
    }
}

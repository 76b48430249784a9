//! Number types of points.

/// Type of a point's coordinates, `f64` or `f32`. Fits are computed in `f64`.
pub trait Coordinate: Sealed + Sized {
    /// Returns these points in `f64`, copied to `room` if necessary.
    #[doc(hidden)]
    fn widen<'a, const D: usize>(
        points: &'a [[Self; D]],
        room: &'a mut Vec<[f64; D]>,
    ) -> &'a [[f64; D]];
}

/// Prevents implementations outside of this crate.
pub trait Sealed {}

impl Sealed for f64 {}
impl Sealed for f32 {}

impl Coordinate for f64 {
    fn widen<'a, const D: usize>(
        points: &'a [[Self; D]],
        _: &'a mut Vec<[f64; D]>,
    ) -> &'a [[f64; D]] {
        points
    }
}

impl Coordinate for f32 {
    fn widen<'a, const D: usize>(
        points: &'a [[Self; D]],
        room: &'a mut Vec<[f64; D]>,
    ) -> &'a [[f64; D]] {
        room.clear();
        room.extend(points.iter().map(|point| point.map(f64::from)));
        room
    }
}

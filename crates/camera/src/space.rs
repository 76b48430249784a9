//! A rope as a camera sees it, and its points in 3-D. Depth images and second views share these
//! types.

mod ends;
pub(crate) mod sight;

pub(crate) use ends::cut_ends;
pub(crate) use sight::Sight;

/// A rope in a color image.
#[derive(Debug, Clone, Copy)]
pub struct SeenRope<'a> {
    /// Points of its centerline in order, px.
    pub points: &'a [[f32; 2]],
    /// Width at each point, px.
    pub widths_px: &'a [f32],
    /// True at each point where another object is visible instead: another strand, or a hand.
    pub hidden: &'a [bool],
    /// True if the first point follows the last.
    pub closed: bool,
    /// True for the first and the last end if it is visible. False if the rope leaves the image
    /// there or continues under something.
    pub ends: [bool; 2],
}

impl SeenRope<'_> {
    /// Returns whether it has 8 or more points, each with a width and a hidden flag.
    pub(crate) fn is_whole(&self) -> bool {
        let count = self.points.len();
        count >= 8 && self.widths_px.len() == count && self.hidden.len() == count
    }
}

/// A point of a rope's axis in 3-D, in the color camera's frame: x right, y down, z ahead, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SpacePoint {
    /// Position of the point.
    pub point: [f64; 3],
    /// Derivative by the pixel, mm/px, for the pixel errors that are not in `variance`.
    pub by_pixel: [[f64; 2]; 3],
    /// Derivative by the depth, which is along the ray.
    pub ray: [f64; 3],
    /// Variance of the depth, mm².
    pub variance: f64,
    /// Share of `variance` that is common to neighboring points: 0 if the point was measured
    /// independently, 1 if it was bridged.
    pub in_common: f64,
    /// True if the point was measured; otherwise it is bridged from measured points.
    pub is_measured: bool,
    /// Possible offset of the pixel from the rope, px, common to neighboring points. The cause is
    /// light from one side, or a depth image that shows the rope to one side of the pixel or not at
    /// all.
    pub doubt_px: f64,
    /// Depth error that results from this offset, mm. It is also common to neighboring points.
    pub doubt_mm: f64,
    /// Width of the rope at the point, mm.
    pub width_mm: f64,
}

pub(crate) fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

pub(crate) fn between(to: [f64; 3], from: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| to[k] - from[k])
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

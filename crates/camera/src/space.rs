//! A rope as a camera sees it, and its points in space: what a depth image and a second view share.

mod ends;
pub(crate) mod sight;

pub(crate) use ends::cut_ends;
pub(crate) use sight::Sight;

/// A rope in a colour image.
#[derive(Debug, Clone, Copy)]
pub struct SeenRope<'a> {
    /// Points of its centerline in their order, px.
    pub points: &'a [[f32; 2]],
    /// Its width at each, px.
    pub widths_px: &'a [f32],
    /// Whether something else is seen at each of them: another strand, or a hand.
    pub hidden: &'a [bool],
    /// Whether the first comes after the last.
    pub closed: bool,
    /// Whether its first and its last end are seen: not where it leaves the image, or goes on under something.
    pub ends: [bool; 2],
}

impl SeenRope<'_> {
    /// Whether it has 8 points or more, each with its width and whether it is hidden.
    pub(crate) fn is_whole(&self) -> bool {
        let count = self.points.len();
        count >= 8 && self.widths_px.len() == count && self.hidden.len() == count
    }
}

/// A point of a rope's axis in space, in the colour camera's frame: x right, y down, z ahead, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SpacePoint {
    /// Where it is.
    pub point: [f64; 3],
    /// Its derivative by the pixel, mm/px, as far as an error of the pixel is not in `variance`.
    pub by_pixel: [[f64; 2]; 3],
    /// Its derivative by the depth: along the ray.
    pub ray: [f64; 3],
    /// The variance of the depth, mm².
    pub variance: f64,
    /// The share of that variance which its neighbors have in common with it: 0 where it was measured by itself, 1 where it was bridged.
    pub in_common: f64,
    /// Whether it was measured here; otherwise it is bridged from where it was.
    pub is_measured: bool,
    /// How far beside the rope the pixel may be, px, as its neighbors are, too: as a depth image shows the rope there to one side of
    /// it, or not at all, or as light falls on one side of it.
    pub doubt_px: f64,
    /// And how far its depth is off then, mm, as its neighbors' are, too.
    pub doubt_mm: f64,
    /// The rope's width there, mm.
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

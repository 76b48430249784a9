//! Arms of a crossing, which the assignment joins to strands.

use crate::past::FormerPlaces;
use crate::vec2::Vec2;

/// One end of an edge where it meets a zone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arm {
    pub(crate) edge: u32,
    /// 0 if the edge's first pixel is in the zone, 1 if its last is.
    pub(crate) end: u8,
    pub(crate) zone: u32,
    /// Number of pixels, from this end of the edge, that belong to the crossing instead of to one
    /// strand.
    pub(crate) trim: u32,
    /// Position at which the strand leaves the crossing.
    pub(crate) at: Vec2,
    /// Direction of the strand at `at`, into the zone.
    pub(crate) into: Vec2,
    pub(crate) half_px: f32,
    /// Mean color along the strand just outside of the crossing, in the image's native format.
    pub(crate) color: [f32; 3],
    /// Places in the prior that correspond to `at` and `into`.
    pub(crate) past: FormerPlaces,
}

impl Arm {
    /// Index of the edge's end, 2·edge + end.
    pub(crate) fn slot(&self) -> usize {
        2 * self.edge as usize + usize::from(self.end)
    }

    /// Number of pixels over which the strand's direction is measured.
    pub(crate) fn reach_px(&self) -> usize {
        reach_px(self.half_px)
    }
}

/// Number of pixels over which the direction of a strand of this half-width is measured.
pub(crate) fn reach_px(half_px: f32) -> usize {
    ((3.5 * half_px) as usize).max(7)
}

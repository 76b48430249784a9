//! An arm of a crossing: what the pairing of strands weighs.

use crate::past::FormerPlaces;
use crate::vec2::Vec2;

/// One end of an edge where it meets a zone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arm {
    pub(crate) edge: u32,
    /// 0: the edge's first pixel lies in the zone; 1: its last.
    pub(crate) end: u8,
    pub(crate) zone: u32,
    /// Pixels of the edge, from this end, that belong to the crossing and not to one strand.
    pub(crate) trim: u32,
    /// Where the strand comes out of the crossing.
    pub(crate) at: Vec2,
    /// Its direction there, into the zone.
    pub(crate) into: Vec2,
    pub(crate) half_px: f32,
    /// The mean native color along the strand, just outside of the crossing.
    pub(crate) color: [f32; 3],
    /// On which side of an overlap its strand lies at the overlap's near end, −1 to 1, by how sure it is; 0: of none.
    pub(crate) side: f32,
    /// Where it was in the last image.
    pub(crate) past: FormerPlaces,
}

impl Arm {
    /// The end of the edge that this is, as 2·edge + end.
    pub(crate) fn slot(&self) -> usize {
        2 * self.edge as usize + usize::from(self.end)
    }

    /// Pixels of the strand over which its direction is taken.
    pub(crate) fn reach_px(&self) -> usize {
        reach_px(self.half_px)
    }
}

/// Pixels over which the direction of a strand of this half-width is taken.
pub(crate) fn reach_px(half_px: f32) -> usize {
    ((3.5 * half_px) as usize).max(7)
}

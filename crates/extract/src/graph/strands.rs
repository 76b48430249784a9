//! Edges joined through crossings: each rope as a list of edges in order.

/// One edge along a rope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leg {
    pub(crate) edge: u32,
    /// True if the rope runs from the edge's second node to its first.
    pub(crate) reversed: bool,
    /// Number of pixels left out at the leg's start and end because they are in a crossing.
    pub(crate) trim: [u32; 2],
    /// Range of `Assigner::shared`: pixels of the edges passed after the leg.
    pub(crate) shared: [u32; 2],
    /// Half-width of the wider strand along those edges.
    pub(crate) shared_half_px: f32,
}

/// One rope: a range of `Assigner::legs`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strand {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) closed: bool,
    /// Length of its edges, in pixels of the skeleton.
    pub(crate) length_px: f32,
}

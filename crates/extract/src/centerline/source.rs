//! Input for the line along a strand.

use crate::graph::Graph;
use crate::graph::strands::Leg;
use crate::graph::zones::Zones;
use crate::image::gray::GrayPlane;
use crate::skeleton::Skeleton;

/// Input for the line along a strand.
pub(crate) struct Source<'a> {
    pub(crate) difference: &'a GrayPlane,
    pub(crate) skeleton: &'a Skeleton,
    pub(crate) graph: &'a Graph,
    pub(crate) zones: &'a Zones,
    pub(crate) legs: &'a [Leg],
    /// Pixels of the stretches shared with other strands, to which the legs refer.
    pub(crate) shared: &'a [u32],
    /// Minimum distance between samples along a line.
    pub(crate) least_step_px: f32,
}

/// Half the rope's width according to the skeleton, weighted by the lengths of the legs.
pub(crate) fn mean_half(source: &Source, legs: &[Leg]) -> f32 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for leg in legs {
        let length = source.graph.edges[leg.edge as usize].length_px + 0.1;
        sum += length * source.zones.edge_half_px[leg.edge as usize];
        weight += length;
    }
    (sum / weight).max(0.5)
}

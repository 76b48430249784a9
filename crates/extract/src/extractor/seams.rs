//! Joins strands that were separated at their seams into ropes again.

use super::Extractor;
use crate::occlusion::ends::Scenery;

impl Extractor {
    /// Joins the first `count` lines of a cut mask where they pass under each other, and rebuilds
    /// them in the whole mask.
    pub(super) fn join_strands(&mut self, count: usize, width_px: f32, yuv: bool) -> usize {
        let scenery = Scenery {
            past: &self.zones.past,
            difference: &self.masker.whole.0,
            level: super::SOMETHING,
            occluder: &self.occluder.plane,
            yuv,
            elsewhere: None,
            picked: None,
        };
        let (lines, colors) = (&mut self.lines[..count], &mut self.colors[..]);
        let mask = (&self.masker.whole.1, width_px);
        let joined = self.bridger.join_under(lines, colors, &scenery, mask);
        self.masker.uncut();
        for line in &mut self.lines[..joined] {
            let difference = &self.masker.mask.difference;
            self.centerliner.retrace(line, difference, 0.5 * width_px);
        }
        joined
    }
}

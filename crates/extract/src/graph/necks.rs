//! Necks of an overlap: the places where two strands that run along each other change sides.
//!
//! Side by side, two strands are up to two ropes wide together. In a crossing, one is on top of the
//! other, and the mask narrows to one rope. Strands that only touch have no neck, strands that
//! cross once have one, and strands wound around each other have one for each change of sides.

use super::Graph;
use crate::skeleton::Skeleton;

/// Maximum half-width at which an overlap is one rope wide, in half-widths plus `DOUBT_PX`. Strands
/// that meet at up to 60° without crossing reach 1.33 (see `zones`).
const NECK_HALVES: f32 = 1.22;
/// Minimum half-width of an overlap that is definitely wider than one rope, in half-widths plus
/// `DOUBT_PX`.
const WIDE_HALVES: f32 = 1.35;
/// Part of the overlap at each end that is ignored, in half-widths.
const RIM_HALVES: f32 = 0.4;
/// Tolerance for whole pixels.
const DOUBT_PX: f32 = 0.5;
/// Minimum half-width at which whole pixels can distinguish one strand from two.
const THINNEST_HALF_PX: f32 = 2.0;
/// Maximum number of necks. Strands that change sides more often are not resolved.
pub(crate) const MOST: usize = 6;

/// Necks of one overlap, in order from its edge's first node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Necks {
    at: [u32; MOST],
    count: usize,
    /// True if the rope is wide enough, and the overlap's narrowest place either clearly is or
    /// clearly is not a neck.
    pub(crate) are_known: bool,
}

impl Necks {
    /// Finds the necks of edge `e`, an overlap whose wider rope has this half-width.
    pub(crate) fn of(e: usize, graph: &Graph, skeleton: &Skeleton, half_px: f32) -> Self {
        let pixels = graph.pixels(e);
        let radius = |k: usize| skeleton.pixels[pixels[k] as usize].half_px;
        let mut necks = Self {
            at: [0; MOST],
            count: 0,
            are_known: half_px >= THINNEST_HALF_PX,
        };
        // The skeleton bends at the junctions, and its radius changes with it.
        let rim = ((RIM_HALVES * half_px) as usize)
            .max(1)
            .min(pixels.len() / 3);
        let inner = rim..pixels.len() - rim;
        let narrowest = inner.clone().map(radius).fold(f32::INFINITY, f32::min);
        let wide_px = WIDE_HALVES * half_px + DOUBT_PX;
        let neck_px = NECK_HALVES * half_px + DOUBT_PX;
        necks.are_known &= narrowest <= neck_px || narrowest >= wide_px;
        // First and last pixel of the current neck, and the number of wide pixels since.
        let (mut passed, mut wide): (Option<[usize; 2]>, usize) = (None, 0);
        for k in inner {
            if radius(k) <= neck_px {
                if wide >= rim.max(2) {
                    passed.take().into_iter().for_each(|n| necks.push(n));
                }
                wide = 0;
                passed = Some([passed.map_or(k, |[first, _]| first), k]);
            } else if radius(k) >= wide_px {
                wide += 1;
            }
        }
        passed.into_iter().for_each(|n| necks.push(n));
        necks
    }

    /// Adds the middle of a neck. Whole pixels do not show where exactly it is narrowest. More than
    /// `MOST` necks make all of them unknown.
    fn push(&mut self, [first, last]: [usize; 2]) {
        if self.count == MOST {
            self.are_known = false;
        } else {
            self.at[self.count] = ((first + last) / 2) as u32;
            self.count += 1;
        }
    }

    /// Pixel indices on the edge at which the strands change sides.
    pub(crate) fn at(&self) -> &[u32] {
        &self.at[..self.count]
    }
}

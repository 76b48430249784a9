//! Where two strands that lie along each other change sides: at the necks of their overlap.
//!
//! Side by side, two strands are up to two ropes wide together; where they cross they lie on top of each other and the
//! mask narrows to one rope. Strands that only touch have no neck, strands that cross once have one, and strands that
//! are wound around each other have one for each time.

use super::Graph;
use crate::skeleton::Skeleton;

/// At most this many half-widths (and half a pixel) wide on either side, the overlap is one rope wide. Where strands
/// meet at up to 60° without crossing, it is 1.33 (see `zones`).
const NECK_HALVES: f32 = 1.22;
/// From here on it is surely wider.
const WIDE_HALVES: f32 = 1.35;
/// Nearer to its ends than this many half-widths the overlap is not looked at.
const RIM_HALVES: f32 = 0.4;
/// What whole pixels leave in doubt.
const DOUBT_PX: f32 = 0.5;
/// Of thinner ropes whole pixels do not tell one strand from two.
const THINNEST_HALF_PX: f32 = 2.0;
/// More often, strands are not followed around each other.
pub(crate) const MOST: usize = 6;

/// The necks of one overlap, in order from its edge's first node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Necks {
    at: [u32; MOST],
    count: usize,
    /// Whether the rope is wide enough to tell, and the overlap clearly narrow somewhere or nowhere.
    pub(crate) are_known: bool,
}

impl Necks {
    /// The necks of edge `e`, an overlap of ropes of which the wider has this half-width.
    pub(crate) fn of(e: usize, graph: &Graph, skeleton: &Skeleton, half_px: f32) -> Self {
        let pixels = graph.pixels(e);
        let radius = |k: usize| skeleton.pixels[pixels[k] as usize].half_px;
        let mut necks = Self {
            at: [0; MOST],
            count: 0,
            are_known: half_px >= THINNEST_HALF_PX,
        };
        // At the junctions themselves the skeleton bends, and its radius with it.
        let rim = ((RIM_HALVES * half_px) as usize)
            .max(1)
            .min(pixels.len() / 3);
        let inner = rim..pixels.len() - rim;
        let narrowest = inner.clone().map(radius).fold(f32::INFINITY, f32::min);
        let wide_px = WIDE_HALVES * half_px + DOUBT_PX;
        let neck_px = NECK_HALVES * half_px + DOUBT_PX;
        necks.are_known &= narrowest <= neck_px || narrowest >= wide_px;
        // The first and last pixel of the neck that is being passed, and how many since then are wide.
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

    /// A neck lies in the middle of the pixels that are as narrow as one rope: where it is narrowest, whole pixels do
    /// not tell.
    fn push(&mut self, [first, last]: [usize; 2]) {
        if self.count == MOST {
            self.are_known = false;
        } else {
            self.at[self.count] = ((first + last) / 2) as u32;
            self.count += 1;
        }
    }

    /// The pixels of the edge at which the strands change sides.
    pub(crate) fn at(&self) -> &[u32] {
        &self.at[..self.count]
    }
}

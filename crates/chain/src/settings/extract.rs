//! `[extract]`: what is a rope, and how it is described.

use lariat_extract::{Mask, Method, Region};
use lariat_wire::MAX_CURVES;
use std::num::NonZeroU8;
use std::path::PathBuf;
use std::time::Duration;

/// What is a rope, and how it is described.
#[derive(Debug, Clone, PartialEq)]
pub struct Extract {
    /// Which pixels are rope.
    pub mask: Mask,
    /// From which level on a mask made elsewhere is rope; without one, by its histogram.
    pub mask_level: Option<NonZeroU8>,
    /// Weights of the network, if not lariat's own.
    pub network: Option<PathBuf>,
    /// How long after its capture a frame's mask is waited for, if masks are made elsewhere.
    pub mask_deadline: Duration,
    /// How the mask becomes a centerline.
    pub method: Method,
    /// Points of a centerline.
    pub points: usize,
    /// The most ropes reported.
    pub ropes: usize,
    /// The confidence below which a rope is warned of.
    pub min_confidence: f64,
    /// Near which position (px) the first point is, in the first frame.
    pub start: Option<[f32; 2]>,
    /// Positions on the ropes that are meant, in pixels; empty: all are.
    pub at: Vec<[f32; 2]>,
    /// For how long a rope that is out of sight is reported.
    pub keep_lost: Duration,
    /// The part of the image that is read; without it, all.
    pub roi: Option<Region>,
}

impl Default for Extract {
    fn default() -> Self {
        Self {
            mask: Mask::Auto,
            mask_level: None,
            network: None,
            mask_deadline: Duration::from_millis(50),
            method: Method::Skeleton,
            points: 120,
            ropes: MAX_CURVES,
            min_confidence: 0.5,
            start: None,
            at: Vec::new(),
            keep_lost: Duration::from_secs(1),
            roi: None,
        }
    }
}

impl Extract {
    /// A position in the image as the extractor sees it, which is the region alone.
    fn in_region(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [left, top] = self.roi.map_or([0; 2], |region| [region.x, region.y]);
        [x - left as f32, y - top as f32]
    }

    /// The extractor's own options.
    pub fn options(&self) -> lariat_extract::Options {
        lariat_extract::Options::default()
            .mask(self.mask.clone())
            .mask_level(self.mask_level)
            .method(self.method)
            .points(self.points)
            .ropes(self.ropes)
            .min_confidence(self.min_confidence as f32)
            .start(self.start.map(|at| self.in_region(at)))
            .at(self.at.iter().map(|&at| self.in_region(at)).collect())
            .keep_lost(self.keep_lost)
    }
}

//! `[extract]`: how ropes are found and described.

use lariat_extract::{Mask, Method, Region};
use lariat_wire::MAX_CURVES;
use std::num::NonZeroU8;
use std::path::PathBuf;
use std::time::Duration;

/// How ropes are found and described.
#[derive(Debug, Clone, PartialEq)]
pub struct Extract {
    /// How rope pixels are found.
    pub mask: Mask,
    /// Minimum level of rope in an external mask. Without it, the mask's histogram decides.
    pub mask_level: Option<NonZeroU8>,
    /// File with the weights of the network, if not lariat's own.
    pub network: Option<PathBuf>,
    /// Maximum time from a frame's capture to the arrival of its external mask.
    pub mask_deadline: Duration,
    /// How a mask is converted to centerlines.
    pub method: Method,
    /// Number of points of a centerline.
    pub points: usize,
    /// Maximum number of ropes reported.
    pub ropes: usize,
    /// Confidence below which lariat warns of a rope.
    pub min_confidence: f64,
    /// Position (px) near the first point of the rope, in the first frame.
    pub start: Option<[f32; 2]>,
    /// Positions on the ropes to report, in pixels. If empty, all ropes are reported.
    pub at: Vec<[f32; 2]>,
    /// Time for which a rope that is out of sight is reported.
    pub keep_lost: Duration,
    /// Region of the image that is processed. Without it, the whole image.
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
    /// Converts an image position to the extractor's coordinates, which are relative to the region.
    fn in_region(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [left, top] = self.roi.map_or([0; 2], |region| [region.x, region.y]);
        [x - left as f32, y - top as f32]
    }

    /// Returns the extractor's options.
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

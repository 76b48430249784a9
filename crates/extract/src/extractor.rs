//! The steps in their order, and the memory they share from frame to frame.

use crate::background::median;
use crate::bits::BitPlane;
use crate::centerline::{Centerliner, Source};
use crate::color;
use crate::crossings::Crosser;
use crate::graph::Graph;
use crate::line::{Line, Sample};
use crate::mask::{MaskError, Masker};
use crate::overlaps::Overlaps;
use crate::rehearse;
use crate::skeleton::Skeleton;
use crate::strands::Strands;
use crate::thin::Thinner;
use crate::track::Tracker;
use crate::zones::Zones;
use crate::{Crossing, Curve, Image, Mask, Options, OptionsError, Scene};

/// A rope is at least this many times as long as wide.
const SHORTEST: f32 = 4.0;

/// The steps of an extraction, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Pixels to one bit each: rope or not.
    Mask,
    /// The mask thinned to lines of one pixel.
    Skeleton,
    /// Ends, crossings and the strands between them; crossings resolved into ropes.
    Graph,
    /// Sub-pixel centers and widths, equal arc lengths, tracks.
    Points,
}

/// Turns images into centerlines, remembering the ropes from one image to the next.
#[derive(Debug)]
pub struct Extractor {
    options: Options,
    size: (usize, usize),
    masker: Masker,
    thin: BitPlane,
    thinner: Thinner,
    skeleton: Skeleton,
    graph: Graph,
    zones: Zones,
    overlaps: Overlaps,
    strands: Strands,
    centerliner: Centerliner,
    lines: Vec<Line>,
    spaced: Vec<Sample>,
    tracker: Tracker,
    /// The first `count` are this image's; the rest is memory.
    curves: Vec<Curve>,
    count: usize,
    crosser: Crosser,
    crossings: Vec<Crossing>,
}

impl Extractor {
    /// An extractor that has seen nothing yet.
    ///
    /// # Errors
    /// When an option is out of its range.
    pub fn new(options: Options) -> Result<Self, OptionsError> {
        options.check()?;
        Ok(Self {
            options,
            size: (0, 0),
            masker: Masker::default(),
            thin: BitPlane::default(),
            thinner: Thinner::default(),
            skeleton: Skeleton::default(),
            graph: Graph::default(),
            zones: Zones::default(),
            overlaps: Overlaps::default(),
            strands: Strands::default(),
            centerliner: Centerliner::default(),
            lines: Vec::new(),
            spaced: Vec::new(),
            tracker: Tracker::default(),
            curves: Vec::new(),
            count: 0,
            crosser: Crosser::default(),
            crossings: Vec::new(),
        })
    }

    /// The ropes in `image`, taken as the next frame of the same scene. An image of another size is
    /// a new scene.
    pub fn extract(&mut self, image: &Image) -> Scene<'_> {
        self.extract_observed(image, &mut |_| {})
    }

    /// As [`extract`](Self::extract), calling `after` when each step is finished, so that a caller
    /// who has a clock can time them.
    pub fn extract_observed(&mut self, image: &Image, after: &mut dyn FnMut(Step)) -> Scene<'_> {
        self.turn_to(image);
        self.masker.run(image, &self.options.mask);
        self.after_mask(image, after)
    }

    /// As [`extract`](Self::extract), with a mask that was made elsewhere, by a network for instance, in the place of
    /// the extractor's own: `Gray8` of the image's size, from 128 on rope. Where its edges are soft, as
    /// probabilities are, the rope's place between pixels is read from them.
    ///
    /// # Errors
    /// When the mask is no `Gray8` of the image's size. The image is then not looked at, and the next one goes on from
    /// the one before.
    pub fn extract_masked(&mut self, image: &Image, mask: &Image) -> Result<Scene<'_>, MaskError> {
        self.extract_masked_observed(image, mask, &mut |_| {})
    }

    /// As [`extract_masked`](Self::extract_masked), calling `after` when each step is finished.
    ///
    /// # Errors
    /// As there.
    pub fn extract_masked_observed(
        &mut self,
        image: &Image,
        mask: &Image,
        after: &mut dyn FnMut(Step),
    ) -> Result<Scene<'_>, MaskError> {
        self.masker.take(image, mask)?;
        self.turn_to(image);
        Ok(self.after_mask(image, after))
    }

    /// An image of another size is a new scene.
    fn turn_to(&mut self, image: &Image) {
        let size = (image.width(), image.height());
        if size != self.size {
            self.new_scene();
            self.size = size;
        }
    }

    /// The steps from the mask on.
    fn after_mask(&mut self, image: &Image, after: &mut dyn FnMut(Step)) -> Scene<'_> {
        let size = self.size;
        after(Step::Mask);
        self.thin.copy_from(&self.masker.mask);
        let most_passes = (size.0.min(size.1) / 8).clamp(16, 128) as u32;
        self.thinner.thin(&mut self.thin, most_passes);
        after(Step::Skeleton);
        self.skeleton.list(&self.thin, &self.masker.mask);
        self.graph.trace(&self.skeleton);
        self.graph.prune(&mut self.skeleton);
        self.zones.find(image, &self.graph, &self.skeleton);
        self.overlaps
            .join(image, &self.graph, &self.skeleton, &mut self.zones);
        let yuv = color::is_yuv(image.format());
        self.strands.join(yuv, &self.graph, &self.zones);
        after(Step::Graph);
        self.points();
        let seen = self.count;
        let options = &self.options;
        self.count = self.tracker.update(&mut self.curves, seen, options);
        self.crosser.find(
            image,
            (&self.graph, &self.skeleton, &self.zones),
            &self.lines[..seen],
            &self.curves[..seen],
            &mut self.crossings,
        );
        after(Step::Points);
        Scene {
            curves: &self.curves[..self.count],
            crossings: &self.crossings,
            notice: self.masker.notice,
        }
    }

    /// Makes the buffers for images of this size, by extracting from a picture full of ropes, and
    /// forgets the past. Not needed, but without it buffers grow when a scene first gets richer.
    pub fn prepare(&mut self, width: usize, height: usize) {
        let pixels = rehearse::picture(width, height);
        if let Some(image) = rehearse::image(&pixels, width, height) {
            let wanted = std::mem::replace(&mut self.options.mask, Mask::Auto);
            // Twice: what is kept of the first frame is compared with the second.
            self.extract(&image);
            self.extract(&image);
            // And a bare table, which is looked at more closely.
            let bare = rehearse::bare(width, height);
            if let Some(image) = rehearse::image(&bare, width, height) {
                self.extract(&image);
            }
            self.options.mask = wanted;
        }
        self.reset();
    }

    /// Forgets the past: the next image is a new scene, whose tracks are numbered from the first
    /// again.
    pub fn reset(&mut self) {
        self.new_scene();
        self.tracker.restart();
    }

    fn new_scene(&mut self) {
        self.count = 0;
        self.crossings.clear();
        self.tracker.reset();
    }

    /// The mask of the last image.
    pub(crate) fn mask(&self) -> &BitPlane {
        &self.masker.mask
    }

    /// A curve for each strand that is long enough to be a rope, the longest first.
    fn points(&mut self) {
        self.count = 0;
        for strand in &self.strands.strands {
            let least_px = (SHORTEST - 1.5) * 2.0 * self.zones.half_px;
            if self.count == self.options.ropes || strand.length_px < least_px {
                break;
            }
            if self.lines.len() <= self.count {
                self.lines.push(Line::default());
            }
            let line = &mut self.lines[self.count];
            let source = Source {
                difference: &self.masker.difference,
                skeleton: &self.skeleton,
                graph: &self.graph,
                zones: &self.zones,
                legs: &self.strands.legs,
            };
            if !self.centerliner.build(&source, strand, line) {
                continue;
            }
            line.resample(self.options.points, &mut self.spaced);
            // Smoothing may carry a tip at the image's border a little over it.
            let (right, bottom) = (self.size.0 as f32 - 1.0, self.size.1 as f32 - 1.0);
            for Sample { at: [x, y], .. } in &mut self.spaced {
                (*x, *y) = (x.clamp(0.0, right), y.clamp(0.0, bottom));
            }
            if self.curves.len() <= self.count {
                self.curves.push(Curve::empty());
            }
            let curve = &mut self.curves[self.count];
            curve.closed = line.closed;
            curve.border = line.border;
            curve.length_px = line.length_px();
            curve.widths_px.clear();
            curve
                .widths_px
                .extend(self.spaced.iter().map(|s| s.width_px));
            curve.width_px = median(&mut curve.widths_px);
            curve.widths_px.clear();
            curve
                .widths_px
                .extend(self.spaced.iter().map(|s| s.width_px));
            curve.points.clear();
            curve.points.extend(self.spaced.iter().map(|s| s.at));
            if curve.length_px >= SHORTEST * curve.width_px {
                self.count += 1;
            }
        }
    }
}

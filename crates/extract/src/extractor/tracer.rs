//! From a mask to a hypothesis: the steps of a trace in their order, and their scratch memory.

use super::hypothesis::Hypothesis;
use super::judgement::context;
use super::{SOMETHING, Step};
use crate::bitmap::bits::BitPlane;
use crate::bitmap::strips::Strips;
use crate::centerline::Centerliner;
use crate::centerline::connector::ConnectorCutter;
use crate::centerline::line::{Line, MOST_PIECES, Sample};
use crate::clustering::Clusterer;
use crate::clustering::ordering::Orderer;
use crate::graph::Graph;
use crate::graph::assignment::{Assigner, Ground};
use crate::graph::zones::Zones;
use crate::image::{Image, color};
use crate::mask::{Masker, RopeMask};
use crate::occlusion::bridge::Bridger;
use crate::occlusion::ends::Scenery;
use crate::occlusion::occluder::Occluder;
use crate::options::{Method, Options};
use crate::skeleton::thin::Thinner;
use crate::skeleton::wide::Wide;
use crate::skeleton::{Pixel, Skeleton};
use crate::tracking::noise::NoiseFilter;
use crate::tracking::refit::{self, Refitter};
use crate::tracking::track::Tracker;

/// An image, and what is known before it is traced.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observation<'a> {
    pub(super) image: &'a Image<'a>,
    pub(super) options: &'a Options,
    /// The ropes of the last image.
    pub(super) tracker: &'a Tracker,
}

/// Scratch memory of a trace. It carries nothing from one trace to the next, except that clusterings
/// begin with the last image's centers.
#[derive(Debug, Default)]
pub(super) struct Tracer {
    pub(super) wide: Wide,
    pub(super) occluder: Occluder,
    thinner: Thinner,
    pub(super) skeleton: Skeleton,
    pub(super) clustering: Clustering,
    pub(super) graph: Graph,
    pub(super) zones: Zones,
    pub(super) assigner: Assigner,
    pub(super) centerliner: Centerliner,
    pub(super) lines: Vec<Line>,
    pub(super) colors: Vec<[f32; 3]>,
    pub(super) bridger: Bridger,
    pub(super) noise_filter: NoiseFilter,
    pub(super) refitter: Refitter,
    pub(super) connector_cutter: ConnectorCutter,
    pub(super) spaced: Vec<Sample>,
}

/// Scratch memory of the paper's clusterings.
#[derive(Debug, Default)]
pub(super) struct Clustering {
    pub(super) clusterer: Clusterer,
    pub(super) orderer: Orderer,
    /// The mask with the links between centers outside it, in rows and in strips, and the links.
    rows: BitPlane,
    strips: Strips,
    links: Strips,
}

impl Clustering {
    /// Lists the links between the centers of a mask as its skeleton.
    fn skeletonize(
        &mut self,
        mask: &RopeMask,
        options: &Options,
        thinner: &mut Thinner,
        skeleton: &mut Skeleton,
    ) {
        let &Options {
            method,
            points,
            ropes,
            ..
        } = options;
        self.clusterer.run(method, &mask.bits, points, ropes);
        let nerve = &self.clusterer.nerve.plane;
        self.links.take(nerve);
        thinner.thin(&self.links, most_passes(mask));
        self.rows.copy_from(&mask.bits);
        let words = self.rows.words_mut().iter_mut().zip(nerve.words());
        words.for_each(|(word, lines)| *word |= lines);
        self.strips.take(&self.rows);
        skeleton.list(&thinner.thin, &self.strips, &self.rows);
    }
}

impl Tracer {
    /// Runs the steps from the mask to the curves of `found`. With `cut`, the mask is cut at the
    /// seams between strands of about this width, and becomes whole again on the way. An object
    /// over the ropes is removed from the mask.
    pub(super) fn trace(
        &mut self,
        of: &Observation,
        masker: &mut Masker,
        cut: Option<f32>,
        found: &mut Hypothesis,
        after: &mut dyn FnMut(Step),
    ) {
        after(Step::Mask);
        let &Observation { image, options, .. } = of;
        let yuv = color::is_yuv(image.format());
        self.list_skeleton(of, masker, cut, found);
        after(Step::Skeleton);
        self.graph.trace(&self.skeleton);
        let is_of_mask = options.method == Method::Skeleton;
        (self.graph).prune(&mut self.skeleton, &self.zones.past, is_of_mask);
        self.zones.begin(&self.graph, &self.skeleton);
        let ground = Ground {
            image,
            graph: &self.graph,
            skeleton: &self.skeleton,
            mask: &masker.mask.bits,
        };
        self.assigner.assign(ground, &mut self.zones);
        (self.zones).collect_arms(image, &self.graph, &self.skeleton);
        let source = masker.mask.source;
        after(Step::Graph);
        let laid = self.lay_lines(of, &masker.mask, found);
        let laid = cut.map_or(laid, |width_px| {
            self.join_strands(laid, masker, width_px, yuv)
        });
        let mask = &masker.mask;
        let scenery = Scenery {
            past: &self.zones.past,
            difference: &mask.difference,
            level: SOMETHING,
            occluder: &self.occluder.plane,
            yuv,
            elsewhere: source.is_of_ropes_alone().then_some(image),
            picked: source.is_of_user().then_some(image),
        };
        let (lines, colors) = (&mut self.lines[..laid], &mut self.colors[..]);
        let mut joined = self.bridger.join(lines, colors, &scenery);
        if !source.is_table() {
            joined = self.drop_noise(mask, joined);
        }
        self.lengthen(mask, joined);
        // A refitted line is measured again, which would lose the centers of a clustering.
        if options.method == Method::Skeleton {
            joined = self.refit(image, mask, joined);
        }
        if source.is_network() {
            self.cut_connectors(image, joined);
        }
        self.points(of, joined, &masker.mask, found);
        found.has_occluder = self.occluder.any();
        // Without meeting strands, the lines leave no remainder. Something far wider is not a rope.
        if (cut.is_some() || self.zones.has_meeting()) && !found.has_wide {
            let (lines, width_px) = (&self.lines[..found.count], found.widest_px());
            found.remainder.find(&masker.mask.bits, lines, width_px);
        } else {
            found.remainder.clear();
        }
        found.judge(&context(image, masker));
        self.leave_out(options.ropes, found);
    }

    /// Lists the skeleton of the mask, without objects over the ropes or parts that are too wide.
    fn list_skeleton(
        &mut self,
        of: &Observation,
        masker: &mut Masker,
        cut: Option<f32>,
        found: &mut Hypothesis,
    ) {
        of.tracker.remember(&mut self.zones.past);
        self.skeletonize(&masker.mask, of.options);
        let pixels = self.skeleton.pixels.iter();
        self.zones.past.check(pixels.map(Pixel::at));
        let mask = (&masker.mask.bits, &masker.mask.strips);
        let known = (&self.zones.past, most_passes(&masker.mask) as f32);
        let knows_some = self.zones.past.widest_half_px().is_some();
        found.has_wide = !knows_some && !self.wide.places.is_empty();
        if cut.is_none() && (self.occluder).find(of.image, &self.skeleton, mask, known) {
            masker.take_out(&self.occluder.plane);
            self.skeletonize(&masker.mask, of.options);
        }
        found.has_wide |= self.leave_wide_out(&masker.mask, of.options);
    }

    /// Lists the skeleton of the mask: the thinned mask, or the links between the centers of a
    /// clustering.
    fn skeletonize(&mut self, mask: &RopeMask, options: &Options) {
        if options.method != Method::Skeleton {
            (self.clustering).skeletonize(mask, options, &mut self.thinner, &mut self.skeleton);
            return;
        }
        let most_passes = most_passes(mask);
        let has_wide = self.wide.find(&mask.strips, &mask.bits, most_passes);
        let lines = if has_wide {
            &self.wide.rest
        } else {
            &mask.strips
        };
        self.thinner.thin(lines, most_passes);
        (self.skeleton).list(&self.thinner.thin, &mask.strips, &mask.bits);
        self.skeleton.add(&self.wide.places);
    }

    /// Excludes from the skeleton the parts connected to an object that is far too wide, but has a
    /// color like the ropes'. Returns whether there is such an object.
    fn leave_wide_out(&mut self, mask: &RopeMask, options: &Options) -> bool {
        if options.method != Method::Skeleton || self.wide.places.is_empty() {
            return false;
        }
        self.wide.leave_pieces_out(&mask.bits);
        self.thinner.thin(&self.wide.rest, most_passes(mask));
        (self.skeleton).list(&self.thinner.thin, &mask.strips, &mask.bits);
        true
    }

    /// Joins the first `count` lines of a cut mask where they pass under each other, and lays them
    /// again in the whole mask.
    fn join_strands(
        &mut self,
        count: usize,
        masker: &mut Masker,
        width_px: f32,
        yuv: bool,
    ) -> usize {
        let (difference, bits) = &masker.whole;
        let scenery = Scenery {
            past: &self.zones.past,
            difference,
            level: SOMETHING,
            occluder: &self.occluder.plane,
            yuv,
            elsewhere: None,
            picked: None,
        };
        let (lines, colors) = (&mut self.lines[..count], &mut self.colors[..]);
        let joined = (self.bridger).join_under(lines, colors, &scenery, (bits, width_px));
        masker.uncut();
        for line in &mut self.lines[..joined] {
            let difference = &masker.mask.difference;
            self.centerliner.retrace(line, difference, 0.5 * width_px);
        }
        joined
    }

    /// Reserves what a picture full of ropes does not need: room for ropes that wind through an
    /// image of this size four times, sampled at each pixel. `mask` is a mask of this size.
    pub(super) fn reserve(&mut self, mask: &RopeMask, options: &Options, tracker: &Tracker) {
        let (width, height) = (mask.bits.width(), mask.bits.height());
        let samples = 2 * (width + height);
        let lines = 2 * options.ropes;
        self.lines
            .resize_with(lines.max(self.lines.len()), Line::default);
        for line in &mut self.lines {
            line.samples.reserve(samples);
        }
        self.spaced.reserve(samples);
        match options.method {
            Method::Skeleton => self.centerliner.reserve(samples),
            _ => {
                let &Options { points, ropes, .. } = options;
                let Clustering {
                    clusterer, orderer, ..
                } = &mut self.clustering;
                clusterer.reserve(width, height, points, ropes);
                orderer.reserve(samples);
            }
        }
        self.wide.reserve(&mask.strips, most_passes(mask));
        self.graph.reserve();
        self.assigner.reserve();
        self.colors.reserve(MOST_PIECES);
        self.bridger.reserve(samples);
        self.connector_cutter.reserve(samples);
        self.noise_filter.reserve(MOST_PIECES);
        self.occluder.reserve(width, height);
        tracker.remember(&mut self.zones.past);
        let scene = refit::Scene {
            past: &self.zones.past,
            moves: &self.bridger.moves,
            difference: &mask.difference,
            mask: &mask.bits,
            occluder: &self.occluder.plane,
            skeleton: &self.skeleton,
        };
        self.refitter.warm_up(lines, samples, &scene);
    }

    /// Forgets the last image.
    pub(super) fn forget(&mut self) {
        self.clustering.clusterer.forget();
    }
}

/// Number of passes for thinning a mask: the widest rope's width to either side of its middle, in
/// pixels.
fn most_passes(mask: &RopeMask) -> u32 {
    (mask.bits.width().min(mask.bits.height()) / 8).clamp(16, 128) as u32
}

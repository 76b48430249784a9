//! The steps of an extraction in their order, and their memory from frame to frame.

mod doubts;
mod lines;
mod meant;
mod readings;
mod seams;
mod seek;
mod still;
mod warm_up;

use crate::bitmap::bits::BitPlane;
use crate::bitmap::strips::Strips;
use crate::centerline::Centerliner;
use crate::centerline::connector::ConnectorCutter;
use crate::centerline::line::{Line, MOST_PIECES, Sample};
use crate::clustering::Clusterer;
use crate::clustering::ordering::Orderer;
use crate::confidence::Evidence;
use crate::confidence::remainder::Remainder;
use crate::crossings::Crosser;
use crate::following::Follower;
use crate::graph::Graph;
use crate::graph::overlaps::Overlaps;
use crate::graph::strands::Strands;
use crate::graph::zones::Zones;
use crate::image::unpack::Unpacker;
use crate::image::{Image, color};
use crate::mask::{MaskError, MaskSource, Masker};
use crate::notice::Notice;
use crate::occlusion::bridge::Bridger;
use crate::occlusion::ends::Scenery;
use crate::occlusion::occluder::Occluder;
use crate::options::{Mask, Method, Options, OptionsError};
use crate::scene::{Crossing, Curve, Scene, Status};
use crate::skeleton::thin::Thinner;
use crate::skeleton::wide::Wide;
use crate::skeleton::{Pixel, Skeleton};
use crate::tracking::noise::NoiseFilter;
use crate::tracking::refit::{self, Refitter};
use crate::tracking::track::{Appearance, Tracker};
use lariat_network::Network;
use meant::Meant;
use readings::Hypothesis;
use seek::Answer;
pub(crate) use seek::SURER;
use std::sync::Arc;
use still::{Comparison, Still};

/// Difference from the table, in levels, that indicates an object. Noise of camera and coding stays
/// below.
const SOMETHING: f32 = 24.0;
/// Time between two images if nothing else is known: 1/30 s.
const FRAME_NS: u64 = 1_000_000_000 / 30;

/// The steps of an extraction, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Follows the ropes of the last image into this one, if they were seen whole. If it succeeds,
    /// it is the only step ([`Scene::followed`]).
    Follow,
    /// Turns pixels into one bit each: rope or not.
    Mask,
    /// Thins the mask to lines of one pixel. With a clustering, finds its centers.
    Skeleton,
    /// Finds ends, crossings and the strands between them, and resolves crossings into ropes.
    Graph,
    /// Finds subpixel centers and widths, or puts a clustering's centers in order. Yields equal arc
    /// lengths and tracks.
    Points,
}

/// A mask in rows and in strips, and lines to be thinned in it.
#[derive(Debug, Default)]
struct Body {
    rows: BitPlane,
    strips: Strips,
    lines: Strips,
}

/// Turns images into centerlines, and remembers the ropes from one image to the next.
#[derive(Debug)]
pub struct Extractor {
    options: Options,
    size: (usize, usize),
    unpacker: Unpacker,
    masker: Masker,
    occluder: Occluder,
    wide: Wide,
    /// True if something was too wide and is not a gripper over a known rope.
    has_wide: bool,
    thinner: Thinner,
    skeleton: Skeleton,
    graph: Graph,
    zones: Zones,
    overlaps: Overlaps,
    strands: Strands,
    centerliner: Centerliner,
    clusterer: Clusterer,
    /// The area that contains a clustering's skeleton: the mask, and the links between centers
    /// outside of it.
    body: Body,
    orderer: Orderer,
    lines: Vec<Line>,
    colors: Vec<[f32; 3]>,
    bridger: Bridger,
    refitter: Refitter,
    connector_cutter: ConnectorCutter,
    noise_filter: NoiseFilter,
    remainder: Remainder,
    appearances: Vec<Appearance>,
    spaced: Vec<Sample>,
    now_ns: u64,
    next_ns: Option<u64>,
    tracker: Tracker,
    /// The first `count` are this image's; the rest is memory.
    curves: Vec<Curve>,
    count: usize,
    crosser: Crosser,
    crossings: Vec<Crossing>,
    follower: Follower,
    /// The objects that each curve may be instead of a rope, as a notice.
    doubts: Vec<Option<Notice>>,
    /// The evidence for and against each curve.
    evidence: Vec<Evidence>,
    doubt: Option<Notice>,
    /// True if there were more ropes than are reported.
    is_crowded: bool,
    /// True if the last image's ropes were followed into it.
    followed: bool,
    answer: Answer,
    /// The best hypothesis for this image while another is tried; otherwise memory.
    kept: Hypothesis,
    meant: Meant,
    /// The last image, to recognize it.
    still: Still,
}

impl Extractor {
    /// An extractor without past images.
    ///
    /// # Errors
    /// If an option is out of range.
    pub fn new(options: Options) -> Result<Self, OptionsError> {
        options.check()?;
        Ok(Self {
            options,
            size: (0, 0),
            unpacker: Unpacker::default(),
            masker: Masker::default(),
            occluder: Occluder::default(),
            wide: Wide::default(),
            has_wide: false,
            thinner: Thinner::default(),
            skeleton: Skeleton::default(),
            graph: Graph::default(),
            zones: Zones::default(),
            overlaps: Overlaps::default(),
            strands: Strands::default(),
            centerliner: Centerliner::default(),
            clusterer: Clusterer::default(),
            body: Body::default(),
            orderer: Orderer::default(),
            lines: Vec::new(),
            colors: Vec::new(),
            bridger: Bridger::default(),
            refitter: Refitter::default(),
            connector_cutter: ConnectorCutter::default(),
            noise_filter: NoiseFilter::default(),
            remainder: Remainder::default(),
            appearances: Vec::new(),
            spaced: Vec::new(),
            now_ns: 0,
            next_ns: None,
            tracker: Tracker::default(),
            curves: Vec::new(),
            count: 0,
            crosser: Crosser::default(),
            crossings: Vec::new(),
            follower: Follower::default(),
            doubts: Vec::new(),
            evidence: Vec::new(),
            doubt: None,
            is_crowded: false,
            followed: false,
            answer: Answer::default(),
            kept: Hypothesis::default(),
            meant: Meant::default(),
            still: Still::default(),
        })
    }

    /// Uses another network instead of [`Network::ropes`].
    ///
    /// # Errors
    /// If the masks are made without a network.
    pub fn with_network(mut self, network: Arc<Network>) -> Result<Self, OptionsError> {
        if !matches!(self.options.mask, Mask::Auto | Mask::Network) {
            return Err(OptionsError::IdleNetwork);
        }
        self.masker.use_network(network);
        Ok(self)
    }

    /// Extracts the ropes in `image`, the next frame of the same scene. An image of another size
    /// starts a new scene. An image with the same pixels as the last one has the same result; only
    /// lost ropes age.
    pub fn extract(&mut self, image: &Image) -> Scene<'_> {
        self.extract_observed(image, &mut |_| {})
    }

    /// Sets the time when the next image was taken, in nanoseconds of any clock. Ropes out of sight
    /// age by it. Without this call, the image counts as taken 1/30 s after the last.
    pub fn at(&mut self, exposed_ns: u64) -> &mut Self {
        self.next_ns = Some(exposed_ns);
        self
    }

    /// Like [`extract`](Self::extract), but calls `after` at the end of each step taken, so that a
    /// caller with a clock can time them.
    pub fn extract_observed(&mut self, image: &Image, after: &mut dyn FnMut(Step)) -> Scene<'_> {
        self.turn_to(image);
        let compared = self.still.compare(image);
        let mut unpacker = std::mem::take(&mut self.unpacker);
        if compared.is_same {
            let seen = self.stay();
            // Ropes are followed after they were seen a few times.
            if !self.follower.is_anchored() {
                self.anchor(&unpacker.unpack(image), seen);
            }
            after(Step::Follow);
        } else {
            self.followed = self.take_in(&unpacker.unpack(image), after);
            self.still.remember(image, compared, !self.followed);
        }
        self.unpacker = unpacker;
        self.choose_meant();
        self.scene()
    }

    /// Follows the ropes of the last image into `image`, the next one. Returns `None` if that
    /// fails: pass the image to [`extract`](Self::extract) or
    /// [`extract_masked`](Self::extract_masked) instead. This way, an expensive mask, such as a
    /// network's, is only made if needed:
    ///
    /// ```
    /// # use lariat_extract::{Extractor, Image, MaskError};
    /// # fn see(extractor: &mut Extractor, image: &Image, network: impl Fn(&Image) -> Vec<u8>) -> Result<(), MaskError> {
    /// if extractor.follow(image).is_none() {
    ///     let mask = network(image);
    ///     let format = lariat_extract::PixelFormat::Gray8;
    ///     let mask = Image::new(&mask, image.width(), image.height(), image.width(), format);
    ///     extractor.extract_masked(image, &mask.expect("a byte a pixel"))?;
    /// }
    /// let scene = extractor.scene();
    /// # Ok(())
    /// # }
    /// ```
    pub fn follow(&mut self, image: &Image) -> Option<Scene<'_>> {
        let compared = self.still.compare(image);
        if compared.is_same && self.size == (image.width(), image.height()) {
            self.turn_the_clock();
            self.stay();
            self.choose_meant();
            return Some(self.scene());
        }
        let next_ns = self.due_ns();
        if !self.follower.is_ready(next_ns) || self.size != (image.width(), image.height()) {
            return None;
        }
        let mut unpacker = std::mem::take(&mut self.unpacker);
        let found = self.find_again(&unpacker.unpack(image), next_ns);
        self.unpacker = unpacker;
        if !found {
            return None;
        }
        self.turn_the_clock();
        self.go_on(image);
        self.followed = true;
        self.still.remember(image, compared, false);
        self.choose_meant();
        Some(self.scene())
    }

    /// Repeats the result for the last image, which had the same pixels. Lost ropes age. Returns
    /// the number of visible ropes.
    fn stay(&mut self) -> usize {
        self.tracker.pass(self.now_ns);
        let is_seen = |curve: &&Curve| curve.status != Status::Lost;
        let seen = self.curves[..self.count].iter().filter(is_seen).count();
        self.count = self.tracker.stay(&mut self.curves, seen, &self.options);
        self.followed = true;
        // The network is skipped for as many images as without this shortcut.
        self.is_passed_over();
        seen
    }

    /// Processes an image in a format that all steps can read. Returns whether the ropes of the
    /// last image could be followed into it. If not, it gets a full extraction.
    fn take_in(&mut self, image: &Image, after: &mut dyn FnMut(Step)) -> bool {
        if self.follower.is_ready(self.now_ns) {
            let found = self.find_again(image, self.now_ns);
            if found {
                self.go_on(image);
            }
            after(Step::Follow);
            if found {
                return true;
            }
        }
        self.look(image, after);
        self.report(image, after);
        false
    }

    /// Moves the curves of the last image to their places in this one. Returns false if that fails.
    fn find_again(&mut self, image: &Image, now_ns: u64) -> bool {
        let curves = &mut self.curves[..self.count];
        let background = &self.masker.background;
        (self.follower).follow(image, background, curves, &mut self.crossings, now_ns)
    }

    /// Updates the tracks with the followed curves.
    fn go_on(&mut self, image: &Image) {
        self.tracker
            .begin(self.now_ns, color::is_yuv(image.format()));
        self.tracker.go_on(&self.curves[..self.count]);
    }

    /// Like [`extract`](Self::extract), but with a mask made elsewhere, such as by a network. The
    /// mask is `Gray8` of the image's size; higher values are more likely rope
    /// ([`Options::mask_level`]). If its edges are soft, as probabilities are, the rope's subpixel
    /// position is read from them.
    ///
    /// The mask is used whether or not the ropes could be followed. Not every image needs a mask:
    /// in between, the ropes are [followed](Self::follow).
    ///
    /// # Errors
    /// If the mask is not `Gray8` of the image's size. The image is then ignored, and the next one
    /// continues from the one before.
    pub fn extract_masked(&mut self, image: &Image, mask: &Image) -> Result<Scene<'_>, MaskError> {
        self.extract_masked_observed(image, mask, &mut |_| {})
    }

    /// Like [`extract_masked`](Self::extract_masked), but calls `after` at the end of each step.
    ///
    /// # Errors
    /// As for [`extract_masked`](Self::extract_masked).
    pub fn extract_masked_observed(
        &mut self,
        image: &Image,
        mask: &Image,
        after: &mut dyn FnMut(Step),
    ) -> Result<Scene<'_>, MaskError> {
        self.masker.take(image, mask, self.options.mask_level)?;
        self.turn_to(image);
        let mut unpacker = std::mem::take(&mut self.unpacker);
        let unpacked = &unpacker.unpack(image);
        self.read(unpacked, after);
        self.report(unpacked, after);
        self.unpacker = unpacker;
        self.followed = false;
        self.still.remember(image, Comparison::default(), true);
        self.choose_meant();
        Ok(self.scene())
    }

    /// The scene at a moment without an image, for instance when a camera delivers none for a
    /// while. Every rope is lost, and keeps its last place. The moment counts as a frame, so a rope
    /// out of sight for too long is forgotten.
    pub fn blank(&mut self) -> Scene<'_> {
        self.turn_the_clock();
        self.still.forget();
        self.crossings.clear();
        self.follower.drop();
        self.tracker.pass(self.now_ns);
        let (curves, appearances) = (&mut self.curves, &mut self.appearances[..]);
        [_, self.count] = self.tracker.update(curves, 0, appearances, &self.options);
        self.followed = false;
        self.choose_meant();
        Scene {
            notice: None,
            ..self.scene()
        }
    }

    fn turn_the_clock(&mut self) {
        self.now_ns = self.due_ns();
        self.next_ns = None;
    }

    /// The time when the next image is or was taken, as far as is known.
    fn due_ns(&self) -> u64 {
        let next_ns = self.now_ns.saturating_add(FRAME_NS);
        self.next_ns.unwrap_or(next_ns)
    }

    /// Starts a new scene for an image of another size.
    fn turn_to(&mut self, image: &Image) {
        self.turn_the_clock();
        let size = (image.width(), image.height());
        if size != self.size {
            self.new_scene();
            self.size = size;
        }
    }

    /// Runs the steps from the mask to this image's own curves.
    fn trace(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        self.trace_mask(image, None, after);
    }

    /// Runs them for a mask that may be cut at the seams between strands of about this width. A cut
    /// mask becomes whole again on the way.
    fn trace_mask(&mut self, image: &Image, cut: Option<f32>, after: &mut dyn FnMut(Step)) {
        after(Step::Mask);
        let yuv = color::is_yuv(image.format());
        self.tracker.begin(self.now_ns, yuv);
        self.tracker.remember(&mut self.zones.past);
        self.skeletonize();
        let pixels = self.skeleton.pixels.iter();
        self.zones.past.check(pixels.map(Pixel::at));
        let mask = (&self.masker.mask.bits, &self.masker.mask.strips);
        let widest_half_px = most_passes(self.size) as f32;
        let known = (&self.zones.past, widest_half_px);
        let knows_some = self.zones.past.widest_half_px().is_some();
        self.has_wide = !knows_some && !self.wide.places.is_empty();
        if cut.is_none() && self.occluder.find(image, &self.skeleton, mask, known) {
            self.masker.take_out(&self.occluder.plane);
            self.skeletonize();
        }
        self.leave_wide_out();
        after(Step::Skeleton);
        self.graph.trace(&self.skeleton);
        let is_of_mask = self.options.method == Method::Skeleton;
        (self.graph).prune(&mut self.skeleton, &self.zones.past, is_of_mask);
        self.zones.find(image, &self.graph, &self.skeleton);
        // Strands that were separated no longer overlap.
        if cut.is_none() {
            self.overlaps
                .join(image, &self.graph, &self.skeleton, &mut self.zones);
        }
        // The network also finds other objects.
        let is_of_ropes = cut.is_none() && !self.masker.mask.source.is_network();
        let of_ropes = is_of_ropes.then_some(&self.masker.mask.bits);
        (self.strands).join(yuv, &self.graph, &self.skeleton, &mut self.zones, of_ropes);
        after(Step::Graph);
        let laid = self.lay_lines(image);
        let laid = cut.map_or(laid, |width_px| self.join_strands(laid, width_px, yuv));
        let source = self.masker.mask.source;
        let is_of_ropes_alone = matches!(source, MaskSource::Network { .. } | MaskSource::External);
        let scenery = Scenery {
            past: &self.zones.past,
            difference: &self.masker.mask.difference,
            level: SOMETHING,
            occluder: &self.occluder.plane,
            yuv,
            elsewhere: is_of_ropes_alone.then_some(image),
            picked: source.is_of_user().then_some(image),
        };
        let (lines, colors) = (&mut self.lines[..laid], &mut self.colors[..]);
        let joined = self.bridger.join(lines, colors, &scenery);
        let joined = if !self.masker.mask.source.is_table() {
            self.drop_noise(joined)
        } else {
            joined
        };
        self.lengthen(joined);
        // A refitted line is measured again, which would lose the centers of a clustering.
        let joined = match self.options.method {
            Method::Skeleton => self.refit(image, joined),
            _ => joined,
        };
        self.lengthen(joined);
        if self.masker.mask.source.is_network() {
            self.cut_connectors(image, joined);
        }
        self.points(image, joined);
        // Without meeting strands, the line is all there is. Something far wider is not a rope.
        if (cut.is_some() || self.zones.has_meeting()) && !self.has_wide {
            let (lines, width_px) = (&self.lines[..self.count], self.widest_px());
            self.remainder.find(&self.masker.mask.bits, lines, width_px);
        } else {
            self.remainder.clear();
        }
    }

    /// Updates the tracks with this image's curves, and finds crossings, notices and confidence.
    fn report(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        self.drop_unlikely(image);
        let (curves, appearances) = (&mut self.curves, &mut self.appearances[..]);
        let [seen, count] = (self.tracker).update(curves, self.count, appearances, &self.options);
        self.count = count;
        self.crosser
            .find(image, &self.curves[..seen], &mut self.crossings);
        self.doubt(image, seen);
        self.anchor(image, seen);
        after(Step::Points);
    }

    /// Prepares the first `seen` curves, which are visible in this image, to be followed from here
    /// on.
    fn anchor(&mut self, image: &Image, seen: usize) {
        if self.options.method != Method::Skeleton {
            return;
        }
        let is_seen = seen > 0 && seen == self.count;
        let is_plain = is_seen && !self.occluder.any();
        let curves = &self.curves[..self.count];
        (self.follower).anchor(
            image,
            (&self.masker.mask, &self.masker.background),
            curves,
            &self.crossings,
            [is_seen, is_plain],
            self.now_ns,
        );
    }

    /// The scene of the last image.
    pub fn scene(&self) -> Scene<'_> {
        let (curves, crossings) = match self.options.at.is_empty() {
            true => (&self.curves[..self.count], &self.crossings[..]),
            false => self.meant.chosen(),
        };
        Scene {
            curves,
            crossings,
            notice: self.notice(),
            followed: self.followed,
        }
    }

    /// The sentence of a notice for this extractor's user, without the remedy that its mask already
    /// is.
    pub fn sentence(&self, notice: Notice) -> String {
        notice.sentence(&self.options.mask)
    }

    /// Allocates the buffers for images of this size by extracting from a picture full of ropes,
    /// and forgets the past. Optional: without it, buffers grow when a scene first gets more
    /// complex.
    pub fn prepare(&mut self, width: usize, height: usize) {
        let pixels = warm_up::picture(width, height);
        if let Some(image) = warm_up::image(&pixels, width, height) {
            let wanted = std::mem::replace(&mut self.options.mask, Mask::Auto);
            // Twice, because the state kept from the first frame is compared with the second.
            self.extract(&image);
            self.still.forget();
            self.extract(&image);
            // A bare table is examined more closely.
            let bare = warm_up::bare(width, height);
            if let Some(image) = warm_up::image(&bare, width, height) {
                self.extract(&image);
            }
            self.options.mask = wanted;
            self.masker.prepare(&self.options.mask, width * height);
            self.reserve(width, height);
        }
        self.reset();
    }

    /// Allocates the buffers that the drawn picture does not use.
    fn reserve(&mut self, width: usize, height: usize) {
        // A rope that winds through the image four times, sampled at each pixel.
        let samples = 2 * (width + height);
        let lines = 2 * self.options.ropes;
        self.lines
            .resize_with(lines.max(self.lines.len()), Line::default);
        for line in &mut self.lines {
            line.samples.reserve(samples);
        }
        self.spaced.reserve(samples);
        match self.options.method {
            Method::Skeleton => self.centerliner.reserve(samples),
            _ => {
                let Options { points, ropes, .. } = self.options;
                self.clusterer.reserve(width, height, points, ropes);
                self.orderer.reserve(samples);
            }
        }
        let most_passes = most_passes((width, height));
        self.wide.reserve(&self.masker.mask.strips, most_passes);
        self.graph.reserve();
        self.overlaps.reserve();
        self.strands.reserve();
        self.colors.reserve(MOST_PIECES);
        self.doubts.reserve(MOST_PIECES);
        self.evidence.reserve(MOST_PIECES);
        self.appearances.reserve(MOST_PIECES);
        self.bridger.reserve(samples);
        self.connector_cutter.reserve(samples);
        self.remainder.reserve(width, height);
        self.noise_filter.reserve(MOST_PIECES);
        self.occluder.reserve(width, height);
        self.masker.reserve(width, height);
        self.tracker.reserve(self.options.points);
        let Options { points, ropes, .. } = self.options;
        self.follower.reserve(ropes, points, [width, height]);
        if !self.options.at.is_empty() {
            self.meant.reserve(&self.options);
        }
        self.tracker.remember(&mut self.zones.past);
        let scene = refit::Scene {
            past: &self.zones.past,
            moves: &self.bridger.moves,
            difference: &self.masker.mask.difference,
            mask: &self.masker.mask.bits,
            occluder: &self.occluder.plane,
            skeleton: &self.skeleton,
        };
        self.refitter.warm_up(lines, samples, &scene);
        self.kept
            .reserve([width, height], &self.curves, MOST_PIECES);
    }

    /// Forgets the past. The next image is a new scene, and its tracks are numbered from the first
    /// again.
    pub fn reset(&mut self) {
        self.new_scene();
        self.tracker.restart();
    }

    /// Continues where another extractor stopped. Its last image had `size` \[width, height\] and
    /// these curves, and was exposed at a moment of the same clock. Ropes keep their numbers and
    /// directions, and lost ropes continue to age. The other's numbers ([`tracks`](Self::tracks))
    /// are not given again. The next image gets a full extraction.
    ///
    /// It relearns the rest, such as the ropes' colors and the length of a covered rope.
    pub fn resume(&mut self, size: [usize; 2], exposed_ns: u64, curves: &[Curve], tracks: u32) {
        self.new_scene();
        self.size = size.into();
        self.now_ns = exposed_ns;
        self.tracker.resume(curves, tracks, exposed_ns);
    }

    /// Number of track numbers given to ropes until now.
    pub fn tracks(&self) -> u32 {
        self.tracker.next()
    }

    fn new_scene(&mut self) {
        self.count = 0;
        self.crossings.clear();
        self.follower.forget();
        self.masker.forget();
        self.answer = Answer::default();
        self.clusterer.forget();
        self.tracker.reset();
        self.meant.forget();
        self.still.forget();
    }

    /// The evidence behind the confidence of each curve, in the curves' order, for calibration. It
    /// is of the last image with a full extraction, without lost ropes.
    pub fn evidence(&self) -> &[Evidence] {
        &self.evidence
    }

    /// The mask of the last image.
    pub(crate) fn mask(&self) -> &BitPlane {
        &self.masker.mask.bits
    }

    /// Excludes from the skeleton the parts connected to something far too wide that its color did
    /// not separate from the ropes.
    fn leave_wide_out(&mut self) {
        if self.options.method == Method::Skeleton && !self.wide.places.is_empty() {
            self.has_wide = true;
            let (mask, rows) = (&self.masker.mask.strips, &self.masker.mask.bits);
            self.wide.leave_pieces_out(rows);
            self.thinner.thin(&self.wide.rest, most_passes(self.size));
            self.skeleton.list(&self.thinner.thin, mask, rows);
        }
    }

    /// Lists the skeleton of the mask: the thinned mask, or the links between the centers of a
    /// clustering.
    fn skeletonize(&mut self) {
        let most_passes = most_passes(self.size);
        let (mask, rows) = (&self.masker.mask.strips, &self.masker.mask.bits);
        let Options {
            method,
            points,
            ropes,
            ..
        } = self.options;
        if method == Method::Skeleton {
            let has_wide = self.wide.find(mask, rows, most_passes);
            let lines = if has_wide { &self.wide.rest } else { mask };
            self.thinner.thin(lines, most_passes);
            self.skeleton.list(&self.thinner.thin, mask, rows);
            self.skeleton.add(&self.wide.places);
            return;
        }
        self.clusterer.run(method, rows, points, ropes);
        let (nerve, body) = (&self.clusterer.nerve.plane, &mut self.body);
        body.lines.take(nerve);
        self.thinner.thin(&body.lines, most_passes);
        body.rows.copy_from(rows);
        let words = body.rows.words_mut().iter_mut().zip(nerve.words());
        words.for_each(|(word, lines)| *word |= lines);
        body.strips.take(&body.rows);
        self.skeleton
            .list(&self.thinner.thin, &body.strips, &body.rows);
    }
}

/// Number of passes for thinning a mask of this size: the widest rope's width to either side of its
/// middle, in pixels.
fn most_passes((width, height): (usize, usize)) -> u32 {
    (width.min(height) / 8).clamp(16, 128) as u32
}

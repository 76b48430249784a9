//! The steps of an extraction in their order, and their memory from frame to frame.

mod cuts;
mod hypothesis;
mod judgement;
mod lines;
mod meant;
mod seek;
mod still;
mod tracer;
mod warm_up;

use crate::bitmap::bits::BitPlane;
use crate::centerline::line::MOST_PIECES;
use crate::crossings::Crosser;
use crate::following::Follower;
use crate::graph::assignment::Alternative;
use crate::image::unpack::Unpacker;
use crate::image::{Image, color};
use crate::mask::{MaskError, Masker};
use crate::notice::Notice;
use crate::options::{Mask, Method, Options, OptionsError};
use crate::scene::{Crossing, Curve, Scene, Status};
use crate::tracking::track::Tracker;
use hypothesis::Hypothesis;
use lariat_network::Network;
use meant::Meant;
use seek::Answer;
pub(crate) use seek::SURER;
use std::sync::Arc;
use still::{Comparison, Still};
use tracer::{Observation, Tracer};

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
    /// Finds subpixel centers and widths, or puts a clustering's centers in order. Yields tracked
    /// points at equal steps of arc length.
    Points,
}

/// Times of the current image and the next one, in nanoseconds.
#[derive(Debug, Default)]
struct Clock {
    now_ns: u64,
    /// Time of the next image, as announced by the caller.
    next_ns: Option<u64>,
}

/// Turns images into centerlines, and remembers the ropes from one image to the next.
#[derive(Debug)]
pub struct Extractor {
    options: Options,
    size: (usize, usize),
    clock: Clock,
    /// The last image, to recognize it if it comes again.
    still: Still,
    unpacker: Unpacker,
    /// Follows the ropes of the last image into this one.
    follower: Follower,
    /// Makes the image's mask if following fails, and a second mask from the network if needed.
    masker: Masker,
    answer: Answer,
    /// Traces a mask, whole or cut, to hypotheses: the best one (`found`), and another that is
    /// compared with it.
    tracer: Tracer,
    found: Hypothesis,
    other: Hypothesis,
    /// The curves of the best hypothesis become tracks.
    tracker: Tracker,
    /// The most important doubt about the reported curves.
    doubt: Option<Notice>,
    crosser: Crosser,
    crossings: Vec<Crossing>,
    /// The ropes that the user asked for.
    meant: Meant,
    /// True if the last image's ropes were followed into it.
    followed: bool,
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
            clock: Clock::default(),
            still: Still::default(),
            unpacker: Unpacker::default(),
            follower: Follower::default(),
            masker: Masker::default(),
            answer: Answer::default(),
            tracer: Tracer::default(),
            found: Hypothesis::default(),
            other: Hypothesis::default(),
            tracker: Tracker::default(),
            doubt: None,
            crosser: Crosser::default(),
            crossings: Vec::new(),
            meant: Meant::default(),
            followed: false,
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

    /// Sets the time when the next image was taken, in nanoseconds of any clock. The age of ropes
    /// out of sight is measured by it. Without this call, the image counts as taken 1/30 s after
    /// the last.
    pub fn at(&mut self, exposed_ns: u64) -> &mut Self {
        self.clock.next_ns = Some(exposed_ns);
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
        self.tracker.pass(self.clock.now_ns);
        let is_seen = |curve: &&Curve| curve.status != Status::Lost;
        let seen = self.found.curves[..self.found.count]
            .iter()
            .filter(is_seen)
            .count();
        self.found.count = self
            .tracker
            .stay(&mut self.found.curves, seen, &self.options);
        self.followed = true;
        // The network is skipped for as many images as without this shortcut.
        self.is_passed_over();
        seen
    }

    /// Processes an image in a format that all steps can read. Returns whether the ropes of the
    /// last image could be followed into it. If not, it gets a full extraction.
    fn take_in(&mut self, image: &Image, after: &mut dyn FnMut(Step)) -> bool {
        if self.follower.is_ready(self.clock.now_ns) {
            let found = self.find_again(image, self.clock.now_ns);
            if found {
                self.go_on(image);
            }
            after(Step::Follow);
            if found {
                return true;
            }
        }
        self.begin_tracks(image);
        self.look(image, after);
        self.report(image, after);
        false
    }

    /// Moves the curves of the last image to their places in this one. Returns false if that fails.
    fn find_again(&mut self, image: &Image, now_ns: u64) -> bool {
        let curves = &mut self.found.curves[..self.found.count];
        let background = &self.masker.background;
        (self.follower).follow(image, background, curves, &mut self.crossings, now_ns)
    }

    /// Continues the tracks with the curves, which were found again.
    fn go_on(&mut self, image: &Image) {
        self.begin_tracks(image);
        self.tracker.go_on(self.found.seen());
    }

    /// Begins a new image of the tracks.
    fn begin_tracks(&mut self, image: &Image) {
        let yuv = color::is_yuv(image.format());
        self.tracker.begin(self.clock.now_ns, yuv);
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
        self.begin_tracks(unpacked);
        self.trace_best(unpacked, after);
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
        self.tracker.pass(self.clock.now_ns);
        let (curves, appearances) = (&mut self.found.curves, &mut self.found.appearances[..]);
        self.found.count = self.tracker.update(curves, 0, appearances, &self.options);
        self.followed = false;
        self.choose_meant();
        Scene {
            notice: None,
            ..self.scene()
        }
    }

    /// Lists the alternatives of each cluster in the next trace, for learning.
    pub fn keep_alternatives(&mut self) {
        self.tracer.assigner.study();
    }

    /// Alternatives of each cluster of the last trace, cheapest first.
    pub fn alternatives(&self) -> &[Vec<Alternative>] {
        self.tracer.assigner.alternatives()
    }

    fn turn_the_clock(&mut self) {
        self.clock.now_ns = self.due_ns();
        self.clock.next_ns = None;
    }

    /// The time when the next image is or was taken, as far as is known.
    fn due_ns(&self) -> u64 {
        let next_ns = self.clock.now_ns.saturating_add(FRAME_NS);
        self.clock.next_ns.unwrap_or(next_ns)
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

    /// Traces the mask, which may be cut at the seams between strands of about this width.
    fn trace(&mut self, image: &Image, cut: Option<f32>, after: &mut dyn FnMut(Step)) {
        let observation = Observation {
            image,
            options: &self.options,
            tracker: &self.tracker,
        };
        let found = &mut self.found;
        (self.tracer).trace(&observation, &mut self.masker, cut, found, after);
    }

    /// Updates the tracks with this image's curves, and finds crossings, notices and confidence.
    fn report(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        self.drop_unlikely();
        let (curves, appearances) = (&mut self.found.curves, &mut self.found.appearances[..]);
        let seen = self.found.count;
        self.found.count = (self.tracker).update(curves, seen, appearances, &self.options);
        self.crosser
            .find(image, &self.found.curves[..seen], &mut self.crossings);
        self.judge(seen);
        self.anchor(image, seen);
        after(Step::Points);
    }

    /// Prepares the first `seen` curves, which are visible in this image, to be followed from here
    /// on.
    fn anchor(&mut self, image: &Image, seen: usize) {
        if self.options.method != Method::Skeleton {
            return;
        }
        let is_seen = seen > 0 && seen == self.found.count;
        let is_plain = is_seen && !self.found.has_occluder;
        let curves = self.found.seen();
        (self.follower).anchor(
            image,
            (&self.masker.mask, &self.masker.background),
            curves,
            &self.crossings,
            [is_seen, is_plain],
            self.clock.now_ns,
        );
    }

    /// The scene of the last image.
    pub fn scene(&self) -> Scene<'_> {
        let (curves, crossings) = match self.options.at.is_empty() {
            true => (self.found.seen(), &self.crossings[..]),
            false => self.meant.chosen(),
        };
        Scene {
            curves,
            crossings,
            notice: self.notice(),
            followed: self.followed,
        }
    }

    /// The sentence of a notice for this extractor's user. It leaves out a remedy that the
    /// extractor's mask already provides.
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
            // Extract twice, because the state kept from the first frame is compared with the
            // second.
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
        let &Options { points, ropes, .. } = &self.options;
        (self.tracer).reserve(&self.masker.mask, &self.options, &self.tracker);
        self.masker.reserve(width, height);
        self.tracker.reserve(points);
        self.follower.reserve(ropes, points, [width, height]);
        if !self.options.at.is_empty() {
            self.meant.reserve(&self.options);
        }
        let Self { found, other, .. } = self;
        for hypothesis in [&mut *found, other] {
            hypothesis.reserve([width, height], MOST_PIECES);
        }
        other.curves.clone_from(&found.curves);
    }

    /// Forgets the past. The next image is a new scene, and its tracks are numbered from the first
    /// again.
    pub fn reset(&mut self) {
        self.new_scene();
        self.tracker.restart();
    }

    /// Continues where another extractor stopped. Its last image had `size` \[width, height\] and
    /// these curves, and was exposed at `exposed_ns` of the same clock. Ropes keep their numbers
    /// and directions, and lost ropes continue to age. Numbers that the other extractor has given
    /// ([`tracks`](Self::tracks)) are not given again. The next image gets a full extraction.
    ///
    /// It relearns the rest, such as the ropes' colors and the length of a covered rope.
    pub fn resume(&mut self, size: [usize; 2], exposed_ns: u64, curves: &[Curve], tracks: u32) {
        self.new_scene();
        self.size = size.into();
        self.clock.now_ns = exposed_ns;
        self.tracker.resume(curves, tracks, exposed_ns);
    }

    /// Number of track numbers given to ropes until now.
    pub fn tracks(&self) -> u32 {
        self.tracker.next()
    }

    fn new_scene(&mut self) {
        self.found.count = 0;
        self.crossings.clear();
        self.follower.forget();
        self.masker.forget();
        self.answer = Answer::default();
        self.tracer.forget();
        self.tracker.reset();
        self.meant.forget();
        self.still.forget();
    }

    /// The mask of the last image.
    pub(crate) fn mask(&self) -> &BitPlane {
        &self.masker.mask.bits
    }
}

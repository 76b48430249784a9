//! Pairs each frame with the depth image nearest in time, for two cameras that are not
//! synchronized.
//!
//! Frames and images arrive in the order in which they were taken, but independently of each other.
//! A frame's image is known
//!
//! - as soon as an image taken later than the frame has arrived, because all others will be farther
//!   away;
//! - earlier, if an image is within half the depth camera's period before the frame, because the
//!   next will not be nearer;
//! - at the frame's deadline, or at once while the depth camera is silent, from the images at hand.
//!
//! An image too far from the frame is not paired with it. Frames are answered in order. Nothing is
//! allocated after construction, and nothing blocks. If too many frames or images wait, the oldest
//! are dropped and counted.

use std::collections::VecDeque;

/// Maximum number of frames that wait for their image.
const MOST_FRAMES: usize = 16;
/// Maximum number of images that wait for their frame. A frame may arrive this many periods after
/// its image.
pub const MOST_IMAGES: usize = 4;

/// Numbers of frames and images with and without a partner.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PairCounts {
    /// Frames with an image.
    pub paired: u64,
    /// Frames without an image.
    pub alone: u64,
    /// Images without a frame.
    pub unpaired: u64,
}

/// The answer for a frame.
#[derive(Debug, PartialEq, Eq)]
pub enum Paired<F, I> {
    /// No image is near enough.
    Alone(F),
    /// The frame and its image, which belongs to no other frame.
    With(F, I),
    /// The frame. Its image is [`Pairing::shared`], which the next frame may need too.
    Sharing(F),
}

/// Frames `F` and depth images `I` that wait for each other.
#[derive(Debug)]
pub struct Pairing<F, I> {
    within_ns: u64,
    half_period_ns: Option<u64>,
    frames: VecDeque<Waiting<F>>,
    /// Time, image, and whether it was paired with a frame; oldest first.
    images: VecDeque<(u64, I, bool)>,
    /// When the last answered frame was taken, and its interval to the one before.
    last: (Option<u64>, Option<u64>),
    is_silent: bool,
    counts: PairCounts,
}

#[derive(Debug)]
struct Waiting<F> {
    exposed_ns: u64,
    until_ns: u64,
    frame: F,
}

impl<F, I> Pairing<F, I> {
    /// Creates a pairing. `within_ns` is the maximum interval between a frame and its image.
    /// `period_ns` is the period of the depth camera, if known. The depth camera counts as silent
    /// until its first image.
    pub fn new(within_ns: u64, period_ns: Option<u64>) -> Self {
        Self {
            within_ns,
            half_period_ns: period_ns.map(|ns| ns / 2),
            frames: VecDeque::with_capacity(MOST_FRAMES),
            images: VecDeque::with_capacity(MOST_IMAGES),
            last: (None, None),
            is_silent: true,
            counts: PairCounts::default(),
        }
    }

    /// Adds a frame taken at `exposed_ns`, which waits for its image until `until_ns` on the same
    /// clock. If the oldest frame has to make room, it is returned, without an image.
    pub fn frame(&mut self, frame: F, exposed_ns: u64, until_ns: u64) -> Option<F> {
        let oldest = match self.frames.len() {
            MOST_FRAMES => self.frames.pop_front(),
            _ => None,
        };
        self.counts.alone += u64::from(oldest.is_some());
        self.frames.push_back(Waiting {
            exposed_ns,
            until_ns,
            frame,
        });
        oldest.map(|waiting| waiting.frame)
    }

    /// Adds an image taken at `exposed_ns`.
    pub fn image(&mut self, image: I, exposed_ns: u64) {
        self.is_silent = false;
        // The clock went back, so earlier images no longer mean anything.
        while (self.images.back()).is_some_and(|&(before_ns, ..)| before_ns > exposed_ns) {
            let last = self.images.pop_back();
            self.let_go(last);
        }
        if self.images.len() == MOST_IMAGES {
            let oldest = self.images.pop_front();
            self.let_go(oldest);
        }
        self.images.push_back((exposed_ns, image, false));
    }

    /// Reports that the depth camera is silent. Until its next image, no frame waits.
    pub fn silence(&mut self) {
        self.is_silent = true;
    }

    /// When the next frame is answered even if nothing arrives; `None` if no frame waits.
    pub fn due_ns(&self) -> Option<u64> {
        self.frames.front().map(|frame| frame.until_ns)
    }

    /// Returns the answer for the next frame, if it is known.
    pub fn next(&mut self, now_ns: u64) -> Option<Paired<F, I>> {
        let &Waiting {
            exposed_ns,
            until_ns,
            ..
        } = self.frames.front()?;
        let nearest =
            (0..self.images.len()).min_by_key(|&at| self.images[at].0.abs_diff(exposed_ns));
        let apart_ns = nearest.map(|at| self.images[at].0.abs_diff(exposed_ns));
        let has_later = (self.images.back()).is_some_and(|&(taken_ns, ..)| taken_ns >= exposed_ns);
        let is_nearest = apart_ns
            .zip(self.half_period_ns)
            .is_some_and(|(apart, half)| apart <= half);
        if !(has_later || is_nearest || self.is_silent || now_ns >= until_ns) {
            return None;
        }
        let step_ns = self.step_to(exposed_ns);
        let frame = self.frames.pop_front()?.frame;
        // Later frames cannot be nearer to images before this frame's nearest one.
        for _ in 0..nearest.unwrap_or(0) {
            let older = self.images.pop_front();
            self.let_go(older);
        }
        if apart_ns.is_none_or(|apart_ns| apart_ns > self.within_ns) {
            self.counts.alone += 1;
            return Some(Paired::Alone(frame));
        }
        self.counts.paired += 1;
        let (taken_ns, _, was_taken) = self.images.front_mut()?;
        *was_taken = true;
        let next_ns = match (self.frames.front(), step_ns) {
            (Some(next), _) => Some(next.exposed_ns),
            (None, step_ns) => step_ns.map(|step_ns| exposed_ns + step_ns),
        };
        // If nothing is known about the next frame, the image is kept for it.
        if next_ns.is_none_or(|next_ns| next_ns <= *taken_ns + self.within_ns) {
            return Some(Paired::Sharing(frame));
        }
        let (_, image, _) = self.images.pop_front()?;
        Some(Paired::With(frame, image))
    }

    /// The image of the last frame answered with [`Paired::Sharing`].
    pub fn shared(&self) -> Option<&I> {
        self.images.front().map(|(_, image, _)| image)
    }

    /// Returns the current counts, without images that still wait.
    pub fn counts(&self) -> PairCounts {
        self.counts
    }

    /// Ends the pairing: counts the images that still wait.
    pub fn end(&mut self) -> PairCounts {
        while let Some(image) = self.images.pop_front() {
            self.let_go(Some(image));
        }
        self.counts
    }

    /// Estimates the interval between frames from the last one and this one. A lost frame lengthens
    /// a step, so the shorter of two steps counts.
    fn step_to(&mut self, exposed_ns: u64) -> Option<u64> {
        let (last_ns, before) = self.last;
        let step_ns = last_ns.map(|last_ns| exposed_ns.saturating_sub(last_ns));
        self.last = (Some(exposed_ns), step_ns);
        step_ns.map(|step_ns| before.map_or(step_ns, |before| step_ns.min(before)))
    }

    fn let_go(&mut self, image: Option<(u64, I, bool)>) {
        self.counts.unpaired += u64::from(matches!(image, Some((_, _, false))));
    }
}

#[cfg(test)]
mod tests;

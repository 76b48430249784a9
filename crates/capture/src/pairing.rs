//! Which depth image belongs to which frame, where two cameras take them by clocks of their own: the one nearest in time.
//!
//! Frames and images come in the order in which they were taken, each camera's whenever it likes. A frame's image is known
//!
//! - as soon as one is there that was taken later than the frame: those to come are farther away;
//! - earlier, if one lies within half the depth camera's period before the frame: the next is then no nearer;
//! - at the frame's own last moment, and at once while the depth camera is silent, from what is there.
//!
//! An image too far from the frame is not its own. Frames are answered in their order. Nothing is allocated after the beginning, and
//! nobody waits: with too many at a time the oldest make room, and are counted.

use std::collections::VecDeque;

/// Frames that can wait for their image at a time.
const MOST_FRAMES: usize = 16;
/// Images that can wait for their frame at a time: as many periods may a frame come later than its image.
pub const MOST_IMAGES: usize = 4;

/// What found a partner, and what did not.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PairCounts {
    /// Frames with an image.
    pub paired: u64,
    /// Frames without.
    pub alone: u64,
    /// Images that were no frame's.
    pub unpaired: u64,
}

/// A frame's answer.
#[derive(Debug, PartialEq, Eq)]
pub enum Paired<F, I> {
    /// No image is near enough.
    Alone(F),
    /// Its image, which is no other frame's.
    With(F, I),
    /// Its image is that of [`Pairing::shared`], which the next frame may want too.
    Sharing(F),
}

/// Frames `F` and depth images `I` that wait for each other.
#[derive(Debug)]
pub struct Pairing<F, I> {
    within_ns: u64,
    half_period_ns: Option<u64>,
    frames: VecDeque<Waiting<F>>,
    /// The oldest first, each with whether it was a frame's.
    images: VecDeque<(u64, I, bool)>,
    /// When the last frame that was answered was taken, and how long after the one before.
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
    /// `within_ns`: how far from its frame an image may be. `period_ns`: from one image of the depth camera to the next, if known. Until
    /// the first image comes the depth camera is silent.
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

    /// A frame was taken at that moment; it waits for its image until another, of the same clock. Returns the oldest frame if that
    /// has to make room: it is alone.
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

    /// An image was taken at that moment.
    pub fn image(&mut self, image: I, exposed_ns: u64) {
        self.is_silent = false;
        // A clock that has gone back: what was before says nothing any more.
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

    /// The depth camera has none to give for now: until the next comes no frame waits.
    pub fn silence(&mut self) {
        self.is_silent = true;
    }

    /// When the next frame is answered even if nothing comes; `None`: no frame waits.
    pub fn due_ns(&self) -> Option<u64> {
        self.frames.front().map(|frame| frame.until_ns)
    }

    /// The next frame's answer, if it is known.
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
        // Frames to come are later than this one: nothing before its nearest image is nearer to them.
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
        // Where nothing is known of the next frame it is kept for it.
        if next_ns.is_none_or(|next_ns| next_ns <= *taken_ns + self.within_ns) {
            return Some(Paired::Sharing(frame));
        }
        let (_, image, _) = self.images.pop_front()?;
        Some(Paired::With(frame, image))
    }

    /// The image of the frame that was answered last with [`Paired::Sharing`].
    pub fn shared(&self) -> Option<&I> {
        self.images.front().map(|(_, image, _)| image)
    }

    /// What was counted. Images that still wait are not.
    pub fn counts(&self) -> PairCounts {
        self.counts
    }

    /// No frame is to come: the images that wait are counted.
    pub fn end(&mut self) -> PairCounts {
        while let Some(image) = self.images.pop_front() {
            self.let_go(Some(image));
        }
        self.counts
    }

    /// How far the frames are apart, by the last one and this. A frame that is lost makes a step longer, so the shorter of two counts.
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

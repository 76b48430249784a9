//! What is kept of each rope from frame to frame: its filter, the size of its curve.

use lariat_wire::MAX_CURVES;

/// Something for each of as many ropes as a frame can have.
pub(super) struct Ropes<T> {
    ropes: Vec<Kept<T>>,
}

struct Kept<T> {
    track: Option<u32>,
    asked_ns: u64,
    of: T,
}

impl<T> Ropes<T> {
    /// Each is made for its place, counted from 0.
    ///
    /// # Errors
    /// One cannot be made.
    pub(super) fn new<E>(mut make: impl FnMut(usize) -> Result<T, E>) -> Result<Self, E> {
        let kept = |place| {
            Ok(Kept {
                track: None,
                asked_ns: 0,
                of: make(place)?,
            })
        };
        let ropes = (0..MAX_CURVES).map(kept).collect::<Result<_, E>>()?;
        Ok(Self { ropes })
    }

    /// This rope's own; or that of the rope that was asked for least recently, once it has been made to forget that one.
    pub(super) fn of_track(
        &mut self,
        track: u32,
        asked_ns: u64,
        forget: impl FnOnce(&mut T),
    ) -> &mut T {
        let ropes = &mut self.ropes;
        let known = ropes.iter().position(|rope| rope.track == Some(track));
        let index = known.unwrap_or_else(|| {
            let ages = ropes.iter().map(|rope| rope.asked_ns).enumerate();
            let oldest = ages.min_by_key(|&(_, asked_ns)| asked_ns);
            let index = oldest.map_or(0, |(index, _)| index);
            forget(&mut ropes[index].of);
            ropes[index].track = Some(track);
            index
        });
        ropes[index].asked_ns = asked_ns;
        &mut ropes[index].of
    }

    /// This rope's own, if it has been asked for and not given to another since.
    pub(super) fn of_known(&self, track: u32) -> Option<&T> {
        let known = self.ropes.iter().find(|rope| rope.track == Some(track));
        known.map(|rope| &rope.of)
    }

    /// Makes all of them forget their ropes, each when it is next asked for.
    pub(super) fn forget(&mut self) {
        for rope in &mut self.ropes {
            rope.track = None;
        }
    }
}

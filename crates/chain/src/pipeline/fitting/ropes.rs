//! State that is kept for each rope from frame to frame: its filter, and the size of its curve.

use lariat_wire::MAX_CURVES;

/// One value for each of the maximum number of ropes in a frame.
pub(super) struct Ropes<T> {
    ropes: Vec<Kept<T>>,
}

struct Kept<T> {
    track: Option<u32>,
    asked_ns: u64,
    of: T,
}

impl<T> Ropes<T> {
    /// Creates all values. `make` receives the index of each.
    ///
    /// # Errors
    /// Returns the first error of `make`.
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

    /// Returns the value of this rope. For a new rope, the value of the least recently used one is
    /// reset with `forget` and reassigned.
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

    /// Returns the value of this rope, unless it was never assigned or was reassigned.
    pub(super) fn of_known(&self, track: u32) -> Option<&T> {
        let known = self.ropes.iter().find(|rope| rope.track == Some(track));
        known.map(|rope| &rope.of)
    }

    /// Forgets all ropes. Each value is reset when it is next used.
    pub(super) fn forget(&mut self) {
        for rope in &mut self.ropes {
            rope.track = None;
        }
    }
}

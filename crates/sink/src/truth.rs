//! Brings what was measured in a frame and what is true of it together, whichever comes first.
//!
//! Truth, centerlines and descriptors come over three services, each at its own time, and any of them may be lost. Each
//! waits for the others in a ring of the last frames, found by the source's number; the moment of exposure, where both
//! know it, tells the frames of a source that began again from those before.

use crate::drawn::points_along;
use crate::error::{Compared, Frame};
use crate::polyline::{Point, Polylines};
use lariat_message::{Centerlines, Descriptors, MAX_CURVES, Status, Trace, Unit};

/// How many frames' truth waits: a quarter of a second at 1000 frames/s. It is known when the frame is taken, and the chain
/// may be many frames behind.
const KNOWN: usize = 256;

/// How many frames' measurements wait: their truth was sent before, and has at most been read a little later.
const MEASURED: usize = 32;

/// Points at which a fitted curve is held against the truth, evenly spaced in ρ: four for each control point that a curve
/// can have, so that it has no room to leave the rope between them.
const SAMPLES: usize = 128;

/// Whether the curve is seen in its frame: neither lost nor of a status that this version does not know.
pub(crate) fn is_seen(status: Option<Status>) -> bool {
    !matches!(status, Some(Status::Lost) | None)
}

/// Which frame a message is about.
#[derive(Debug, Clone, Copy, Default)]
struct Key {
    sequence: u64,
    exposed_ns: u64,
}

impl Key {
    fn of(trace: &Trace) -> Self {
        Self {
            sequence: trace.sequence,
            exposed_ns: trace.exposed_ns,
        }
    }

    fn matches(self, other: Self) -> bool {
        self.sequence == other.sequence
            && (self.exposed_ns == other.exposed_ns
                || self.exposed_ns == 0
                || other.exposed_ns == 0)
    }
}

/// The last frames' values.
#[derive(Debug)]
struct Ring<T> {
    slots: Vec<(Option<Key>, T)>,
}

impl<T: Default> Ring<T> {
    fn new(frames: usize) -> Self {
        Self {
            slots: (0..frames).map(|_| (None, T::default())).collect(),
        }
    }

    fn slot(&mut self, key: Key) -> &mut (Option<Key>, T) {
        let frames = self.slots.len() as u64;
        &mut self.slots[(key.sequence % frames) as usize]
    }

    /// A place for a frame's value, in the stead of an older frame's.
    fn insert(&mut self, key: Key) -> &mut T {
        let slot = self.slot(key);
        slot.0 = Some(key);
        &mut slot.1
    }

    /// A frame's value, if it is there.
    fn get(&mut self, key: Key) -> Option<&mut T> {
        let (holds, value) = self.slot(key);
        holds.is_some_and(|held| held.matches(key)).then_some(value)
    }

    /// A frame's value, once.
    fn take(&mut self, key: Key) -> Option<&mut T> {
        let (holds, value) = self.slot(key);
        holds.take_if(|held| held.matches(key)).map(|_| value)
    }
}

/// A frame's truth, and what it has been compared with.
#[derive(Debug, Default)]
struct FrameTruth {
    ropes: Polylines,
    centerlines_done: bool,
    descriptors_done: bool,
}

/// Points on a frame's curves that were seen.
#[derive(Debug)]
struct Drawn {
    /// With whether it is closed.
    curves: Vec<([Point; SAMPLES], bool)>,
}

impl Default for Drawn {
    fn default() -> Self {
        Self {
            curves: Vec::with_capacity(MAX_CURVES),
        }
    }
}

/// Everything that waits to be compared with the truth.
#[derive(Debug)]
pub(crate) struct Truth {
    known: Ring<FrameTruth>,
    centerlines: Ring<Polylines>,
    drawn: Ring<Drawn>,
}

impl Truth {
    pub(crate) fn new() -> Self {
        Self {
            known: Ring::new(KNOWN),
            centerlines: Ring::new(MEASURED),
            drawn: Ring::new(MEASURED),
        }
    }

    /// The true centerlines of a frame.
    pub(crate) fn truth(&mut self, message: &Centerlines, compared: &mut Compared) {
        let key = Key::of(&message.trace);
        if self.known.get(key).is_some() {
            return;
        }
        let known = self.known.insert(key);
        known.ropes.set(message);
        let centerlines = self.centerlines.take(key);
        known.centerlines_done = centerlines.is_some();
        if let Some(centerlines) = centerlines {
            compare_centerlines(compared.centerline.frame(&known.ropes), centerlines);
        }
        let drawn = self.drawn.take(key);
        known.descriptors_done = drawn.is_some();
        if let Some(drawn) = drawn {
            compare_drawn(compared.curve.frame(&known.ropes), drawn);
        }
    }

    /// The measured centerlines of a frame.
    pub(crate) fn centerlines(&mut self, message: &Centerlines, compared: &mut Compared) {
        let key = Key::of(&message.trace);
        match self.known.get(key) {
            Some(known) if known.centerlines_done => {}
            known => {
                let centerlines = self.centerlines.insert(key);
                centerlines.set(message);
                if let Some(known) = known {
                    known.centerlines_done = true;
                    compare_centerlines(compared.centerline.frame(&known.ropes), centerlines);
                    self.centerlines.take(key);
                }
            }
        }
    }

    /// The fitted curves of a frame. Such as are not in pixels of the image cannot be compared.
    pub(crate) fn descriptors(&mut self, message: &Descriptors, compared: &mut Compared) {
        if message.unit() != Some(Unit::Pixel) {
            compared.elsewhere = true;
            return;
        }
        let key = Key::of(&message.trace);
        match self.known.get(key) {
            Some(known) if known.descriptors_done => {}
            known => {
                let drawn = self.drawn.insert(key);
                compared.unknown_basis += drawn.set(message);
                if let Some(known) = known {
                    known.descriptors_done = true;
                    compare_drawn(compared.curve.frame(&known.ropes), drawn);
                    self.drawn.take(key);
                }
            }
        }
    }
}

impl Drawn {
    /// Takes over the curves of a message that are seen. Returns how many others this version does not know.
    fn set(&mut self, message: &Descriptors) -> u64 {
        self.curves.clear();
        let mut unknown = 0;
        for descriptor in message.curves() {
            if !is_seen(descriptor.status()) {
                continue;
            }
            let mut points = [[0.0; 2]; SAMPLES];
            if points_along(descriptor, &mut points) {
                self.curves.push((points, descriptor.closed != 0));
            } else {
                unknown += 1;
            }
        }
        unknown
    }
}

fn compare_centerlines(mut frame: Frame, centerlines: &Polylines) {
    for line in centerlines.iter() {
        let points = line.points.iter().map(|point| point.map(f64::from));
        frame.curve(points, line.closed);
    }
    frame.end();
}

fn compare_drawn(mut frame: Frame, drawn: &Drawn) {
    for (points, closed) in &drawn.curves {
        frame.curve(points.iter().copied(), *closed);
    }
    frame.end();
}

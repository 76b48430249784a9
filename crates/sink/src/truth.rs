//! Pairs the measurements of a frame with its truth, whichever comes first.
//!
//! Truth, centerlines and descriptors arrive on three services at different times, and any of them
//! may be lost. Each waits for the others in a ring of the last frames, indexed by the source's
//! number. The exposure time, if both have one, distinguishes the frames of a restarted source from
//! earlier ones.

use crate::drawn::points_along;
use crate::error::{Compared, Frame};
use crate::polyline::{Point, Polylines};
use lariat_message::{Centerlines, Descriptors, MAX_CURVES, Status, Trace, Unit};

/// Number of frames whose truth is kept until it is compared: a quarter of a second at 1000
/// frames/s. The truth is known when the frame is taken, and the chain may be many frames behind.
const KNOWN: usize = 256;

/// Number of frames whose measurements are kept until the truth is read. The truth was sent before
/// them, so it is read at most a little later.
const MEASURED: usize = 32;

/// Number of points at which a fitted curve is compared with the truth, evenly spaced in ρ. There
/// are four for each control point that a curve can have, so the curve cannot leave the rope
/// between two of them.
const SAMPLES: usize = 128;

/// Returns true if the curve is visible in its frame: it is not lost, and this version knows its
/// status.
pub(crate) fn is_seen(status: Option<Status>) -> bool {
    !matches!(status, Some(Status::Lost) | None)
}

/// Identifies the frame of a message.
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

/// Values of the last frames.
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

    /// Returns a place for a frame's value, which replaces that of an older frame.
    fn insert(&mut self, key: Key) -> &mut T {
        let slot = self.slot(key);
        slot.0 = Some(key);
        &mut slot.1
    }

    /// Returns a frame's value, if it is there.
    fn get(&mut self, key: Key) -> Option<&mut T> {
        let (holds, value) = self.slot(key);
        holds.is_some_and(|held| held.matches(key)).then_some(value)
    }

    /// Returns a frame's value and removes it.
    fn take(&mut self, key: Key) -> Option<&mut T> {
        let (holds, value) = self.slot(key);
        holds.take_if(|held| held.matches(key)).map(|_| value)
    }
}

/// A frame's truth, and which comparisons were made.
#[derive(Debug, Default)]
struct FrameTruth {
    ropes: Polylines,
    centerlines_done: bool,
    descriptors_done: bool,
}

/// Points on the visible curves of a frame.
#[derive(Debug)]
struct Drawn {
    /// Points of each curve, and whether it is closed.
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

    /// Takes the true centerlines of a frame.
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

    /// Takes the measured centerlines of a frame.
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

    /// Takes the fitted curves of a frame. They can only be compared if they are in image pixels.
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
    /// Copies the visible curves of a message. Returns the number of curves that this version does
    /// not know.
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

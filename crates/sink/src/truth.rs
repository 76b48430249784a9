//! Brings what was measured in a frame and what is true of it together, whichever comes first.
//!
//! Truth, centerlines and descriptors come over three services, each at its own time, and any of them may be lost. Each
//! waits for the others in a ring of the last frames, found by the source's number; the moment of exposure, where both
//! know it, tells the frames of a source that began anew from those before.

use crate::error::{Comparison, Frame};
use crate::polyline::{Point, Polylines};
use lariat_wire::{Basis, Centerlines, Descriptors, MAX_CONTROL_POINTS, MAX_CURVES, Status, Trace};

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
    matches!(status, Some(Status::Ok | Status::Partial))
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
struct Known {
    ropes: Polylines,
    centerlines_done: bool,
    descriptors_done: bool,
}

/// A frame's Bezier curves that were seen, their control points one after the other.
#[derive(Debug)]
struct Beziers {
    control_points: Vec<Point>,
    ends: [usize; MAX_CURVES],
    closed: [bool; MAX_CURVES],
    count: usize,
}

impl Default for Beziers {
    fn default() -> Self {
        Self {
            control_points: Vec::with_capacity(MAX_CURVES * MAX_CONTROL_POINTS),
            ends: [0; MAX_CURVES],
            closed: [false; MAX_CURVES],
            count: 0,
        }
    }
}

/// Everything that is compared with the truth.
#[derive(Debug)]
pub(crate) struct Truth {
    known: Ring<Known>,
    centerlines: Ring<Polylines>,
    beziers: Ring<Beziers>,
    /// Centerlines against the truth.
    pub(crate) centerline: Comparison,
    /// Fitted curves against the truth.
    pub(crate) curve: Comparison,
    /// Fitted curves in a basis that is not evaluated here.
    pub(crate) not_bezier: u64,
}

impl Truth {
    pub(crate) fn new() -> Self {
        Self {
            known: Ring::new(KNOWN),
            centerlines: Ring::new(MEASURED),
            beziers: Ring::new(MEASURED),
            centerline: Comparison::new(),
            curve: Comparison::new(),
            not_bezier: 0,
        }
    }

    /// The true centerlines of a frame.
    pub(crate) fn truth(&mut self, message: &Centerlines) {
        let key = Key::of(&message.trace);
        if self.known.get(key).is_some() {
            return;
        }
        let known = self.known.insert(key);
        known.ropes.set(message);
        let centerlines = self.centerlines.take(key);
        known.centerlines_done = centerlines.is_some();
        if let Some(centerlines) = centerlines {
            compare_centerlines(self.centerline.frame(&known.ropes), centerlines);
        }
        let beziers = self.beziers.take(key);
        known.descriptors_done = beziers.is_some();
        if let Some(beziers) = beziers {
            compare_beziers(self.curve.frame(&known.ropes), beziers);
        }
    }

    /// The measured centerlines of a frame.
    pub(crate) fn centerlines(&mut self, message: &Centerlines) {
        let key = Key::of(&message.trace);
        match self.known.get(key) {
            Some(known) if known.centerlines_done => {}
            known => {
                let centerlines = self.centerlines.insert(key);
                centerlines.set(message);
                if let Some(known) = known {
                    known.centerlines_done = true;
                    compare_centerlines(self.centerline.frame(&known.ropes), centerlines);
                    self.centerlines.take(key);
                }
            }
        }
    }

    /// The fitted curves of a frame.
    pub(crate) fn descriptors(&mut self, message: &Descriptors) {
        let key = Key::of(&message.trace);
        match self.known.get(key) {
            Some(known) if known.descriptors_done => {}
            known => {
                let beziers = self.beziers.insert(key);
                self.not_bezier += beziers.set(message);
                if let Some(known) = known {
                    known.descriptors_done = true;
                    compare_beziers(self.curve.frame(&known.ropes), beziers);
                    self.beziers.take(key);
                }
            }
        }
    }
}

impl Beziers {
    /// Takes over the curves of a message that are seen and have numbers for control points. Returns how many others
    /// are of a basis that is not evaluated here.
    fn set(&mut self, message: &Descriptors) -> u64 {
        self.control_points.clear();
        self.count = 0;
        let mut not_bezier = 0;
        for curve in message.curves() {
            let control_points = curve.control_points();
            if !is_seen(curve.status())
                || control_points.is_empty()
                || !control_points.as_flattened().iter().all(|x| x.is_finite())
            {
                continue;
            }
            if curve.basis() != Some(Basis::Bezier) {
                not_bezier += 1;
                continue;
            }
            self.control_points.extend_from_slice(control_points);
            self.ends[self.count] = self.control_points.len();
            self.closed[self.count] = curve.closed != 0;
            self.count += 1;
        }
        not_bezier
    }
}

fn compare_centerlines(mut frame: Frame, centerlines: &Polylines) {
    for line in centerlines.iter() {
        let points = line.points.iter().map(|point| point.map(f64::from));
        frame.curve(points, line.closed);
    }
    frame.end();
}

fn compare_beziers(mut frame: Frame, beziers: &Beziers) {
    let mut start = 0;
    for (end, closed) in beziers.ends.iter().zip(beziers.closed).take(beziers.count) {
        let control_points = &beziers.control_points[start..*end];
        let points =
            (0..SAMPLES).map(|i| bezier_point(control_points, i as f64 / (SAMPLES - 1) as f64));
        frame.curve(points, closed);
        start = *end;
    }
    frame.end();
}

/// A point of a Bezier curve by de Casteljau's algorithm, which takes only averages and is stable at any order.
fn bezier_point(control_points: &[Point], rho: f64) -> Point {
    let mut points = [[0.0; 2]; MAX_CONTROL_POINTS];
    points[..control_points.len()].copy_from_slice(control_points);
    for left in (1..control_points.len()).rev() {
        for i in 0..left {
            let ([ax, ay], [bx, by]) = (points[i], points[i + 1]);
            points[i] = [ax + rho * (bx - ax), ay + rho * (by - ay)];
        }
    }
    points[0]
}

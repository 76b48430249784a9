//! A simulated chain: frames with known times, lost where the test says.

use lariat_message::{Basis, Centerlines, Curve, Descriptor, Descriptors, Status, Trace};

/// Exposure time of the first frame.
pub(crate) const START_NS: u64 = 1_000_000_000_000;

/// Frame period at 30 frames per second.
pub(crate) const PERIOD_NS: u64 = 33_333_333;

/// The stages, in the order of the data. The last is the sink.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stage {
    Capture,
    Extract,
    Fit,
    Sink,
}

impl Stage {
    pub(crate) const ALL: [Self; 4] = [Self::Capture, Self::Extract, Self::Fit, Self::Sink];
}

/// Counters of the stages.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Chain {
    pub(crate) sequence: u64,
    /// Frames that capture, extract and fit have sent, and that the sink has received.
    pub(crate) sent: [u64; 4],
}

impl Chain {
    /// Sends the next frame, which is lost before `lost_before`. With `None` it arrives.
    pub(crate) fn frame(&mut self, lost_before: Option<Stage>) -> Option<Trace> {
        self.sequence += 1;
        for stage in Stage::ALL {
            if lost_before == Some(stage) {
                return None;
            }
            self.sent[stage as usize] += 1;
        }
        Some(self.trace())
    }

    /// Returns a frame's trace: 40 µs of capture, 20 µs of waiting, 250 µs of extraction, 15 µs of
    /// waiting, and 10 µs of fitting. [`received_ns`] adds a wait of 25 µs.
    fn trace(&self) -> Trace {
        let exposed_ns = START_NS + self.sequence * PERIOD_NS;
        Trace {
            sequence: self.sequence,
            captured: self.sent[0],
            extracted: self.sent[1],
            fitted: self.sent[2],
            exposed_ns,
            captured_ns: exposed_ns + 40_000,
            extract_started_ns: exposed_ns + 60_000,
            extracted_ns: exposed_ns + 310_000,
            fit_started_ns: exposed_ns + 325_000,
            fitted_ns: exposed_ns + 335_000,
            ..Trace::EMPTY
        }
    }
}

/// Returns when a frame is received if nothing delays it.
pub(crate) fn received_ns(trace: &Trace) -> u64 {
    trace.fitted_ns + 25_000
}

/// Returns a message with these Bezier curves.
pub(crate) fn descriptors(trace: Trace, curves: &[&[[f64; 2]]]) -> Box<Descriptors> {
    let mut message = Box::new(Descriptors::EMPTY);
    message.trace = trace;
    (message.width, message.height) = (640, 480);
    message.count = curves.len() as u32;
    for (into, control_points) in message.curves.iter_mut().zip(curves) {
        *into = Descriptor {
            status: Status::Ok as u32,
            basis: Basis::Bezier as u32,
            degree: control_points.len() as u32 - 1,
            count: control_points.len() as u32,
            ..Descriptor::EMPTY
        };
        into.control_points[..control_points.len()].copy_from_slice(control_points);
    }
    message
}

/// Returns a message with these centerlines.
pub(crate) fn centerlines(trace: Trace, curves: &[&[[f32; 2]]]) -> Box<Centerlines> {
    let mut message = Box::new(Centerlines::EMPTY);
    message.trace = trace;
    message.count = curves.len() as u32;
    for (into, points) in message.curves.iter_mut().zip(curves) {
        *into = Curve {
            count: points.len() as u32,
            ..Curve::EMPTY
        };
        into.points[..points.len()].copy_from_slice(points);
    }
    message
}

/// Returns a straight rope from (100, y) to (219, y): 120 points, one pixel apart.
pub(crate) fn straight(y: f32) -> Vec<[f32; 2]> {
    (0..120).map(|i| [100.0 + i as f32, y]).collect()
}

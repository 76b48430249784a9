//! Counters and times of a frame.

use pyo3::prelude::*;

/// Counters and times of a frame on its way through the chain. The times are nanoseconds of
/// `time.monotonic_ns()`, 0 before they are known.
#[pyclass(frozen, get_all, module = "lariat")]
pub(crate) struct Trace {
    /// Frame number of the source, from 1.
    sequence: u64,
    /// Frames sent by capture, this one included.
    captured: u64,
    /// Frames sent by extract, this one included.
    extracted: u64,
    /// Frames sent by fit, this one included.
    fitted: u64,
    /// Messages written by a bridge on this machine; 0 without a bridge.
    bridged: u64,
    /// Exposure time; for files, when the frame was due.
    exposed_ns: u64,
    /// When capture had the frame ready to send.
    captured_ns: u64,
    /// When extract began.
    extract_started_ns: u64,
    /// When extract had its result ready to send.
    extracted_ns: u64,
    /// When fit began.
    fit_started_ns: u64,
    /// When fit had its result ready to send.
    fitted_ns: u64,
    /// Settings version of the sender: 0 at the chain's start, one more per change.
    settings: u32,
    /// Restarts of capture, extract and fit, modulo 256.
    restarts: (u8, u8, u8),
}

impl From<lariat_wire::Trace> for Trace {
    fn from(trace: lariat_wire::Trace) -> Self {
        let restarts = trace.restarts().into();
        let lariat_wire::Trace {
            sequence,
            captured,
            extracted,
            fitted,
            bridged,
            exposed_ns,
            captured_ns,
            extract_started_ns,
            extracted_ns,
            fit_started_ns,
            fitted_ns,
            settings,
            restarts: _,
        } = trace;
        Self {
            sequence,
            captured,
            extracted,
            fitted,
            bridged,
            exposed_ns,
            captured_ns,
            extract_started_ns,
            extracted_ns,
            fit_started_ns,
            fitted_ns,
            settings,
            restarts,
        }
    }
}

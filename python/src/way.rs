//! A frame's way through the chain.

use pyo3::prelude::*;

/// The way of a frame through the chain: counts of what each stage sent, and times in nanoseconds of
/// `time.monotonic_ns()`, 0 before they are known.
#[pyclass(frozen, get_all, module = "lariat")]
pub(crate) struct Trace {
    /// The source's own frame number, from 1.
    sequence: u64,
    /// How many frames capture has sent, this one included.
    captured: u64,
    /// How many extract has sent.
    extracted: u64,
    /// How many fit has sent.
    fitted: u64,
    /// How many a bridge has written on this machine; 0 if it came over none.
    bridged: u64,
    /// When the image was taken: for files, the moment the frame was due.
    exposed_ns: u64,
    /// When capture had it ready to send.
    captured_ns: u64,
    /// When extract had it in hand.
    extract_started_ns: u64,
    /// When extract had its result ready to send.
    extracted_ns: u64,
    /// When fit had it in hand.
    fit_started_ns: u64,
    /// When fit had its result ready to send.
    fitted_ns: u64,
    /// By which settings the sender went: 0 by those that its chain began with, one more for each change since.
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

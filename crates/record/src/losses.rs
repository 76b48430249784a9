//! Losses, as recorded.

use crate::cdr::{Cdr, CdrError, Decoder, Encoder, fields};
use crate::messages::{Record, record};
use crate::schema::{Schema, schema};

/// Losses since the recording began, up to a time: by the chain on each link, and by the recorder.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Losses {
    /// The time, on the clock of the traces.
    pub at_ns: u64,
    /// Frames lost at the source: numbered, but never sent.
    pub source: u64,
    /// Frames lost between capture and extract, or for lack of a mask.
    pub capture: u64,
    /// Frames lost between extract and fit.
    pub extract: u64,
    /// On another machine: frames whose descriptors the bridge never wrote there.
    pub bridge: u64,
    /// Frames whose descriptors did not reach the recorder for another reason.
    pub fit: u64,
    /// Frames that the recorder missed or dropped. Their images are not in the recording.
    pub dropped_frames: u64,
    /// Centerlines that the recorder missed or dropped.
    pub dropped_centerlines: u64,
    /// Descriptors that arrived but were dropped.
    pub dropped_descriptors: u64,
    /// True centerlines that the recorder missed or dropped.
    pub dropped_truth: u64,
    /// Masks that the recorder missed or dropped.
    pub dropped_masks: u64,
    /// Depth images that the recorder missed or dropped.
    pub dropped_depths: u64,
    /// 3-D descriptors that arrived but were dropped.
    pub dropped_descriptors3: u64,
}

fields!(Losses {
    at_ns,
    source,
    capture,
    extract,
    bridge,
    fit,
    dropped_frames,
    dropped_centerlines,
    dropped_descriptors,
    dropped_truth,
    dropped_masks,
    dropped_depths,
    dropped_descriptors3,
});
record!(Losses, schema!("lariat_msgs/msg/Losses", "Losses.msg"));

//! What was lost, as it stands in a recording.

use crate::cdr::{Cdr, CdrError, Decoder, Encoder, fields};
use crate::messages::{Record, record};
use crate::schema::{Schema, schema};

/// What was lost since the recording began, up to a moment: by the chain on each link, and by the recorder.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Losses {
    /// The moment, on the clock of the traces.
    pub at_ns: u64,
    /// Frames lost at the source: numbered, never sent.
    pub source: u64,
    /// Frames lost between capture and extract, or for want of a mask.
    pub capture: u64,
    /// Frames lost between extract and fit.
    pub extract: u64,
    /// On another machine: frames whose descriptors the bridge never wrote there.
    pub bridge: u64,
    /// Frames whose descriptors never came to the recorder, for another reason than that.
    pub fit: u64,
    /// Frames that the recorder did not get or had no room for: their images are not in the recording.
    pub dropped_frames: u64,
    /// Centerlines likewise.
    pub dropped_centerlines: u64,
    /// Descriptors that came and that the recorder had no room for.
    pub dropped_descriptors: u64,
    /// True centerlines likewise.
    pub dropped_truth: u64,
    /// Masks likewise.
    pub dropped_masks: u64,
    /// Depth images likewise.
    pub dropped_depths: u64,
    /// Descriptors in space likewise.
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

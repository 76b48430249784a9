//! What a chain consists of.

use super::child::Run;
use crate::settings::Stage;
use crate::stages;

/// What the chain starts, in the order of the data. Beside the stages, if there is a recording, the recorder: it starts before
/// those that send and ends after them, so that all is in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Sends frames.
    Capture,
    /// Finds centerlines in them.
    Extract,
    /// Makes descriptors of those.
    Fit,
    /// Counts and times what arrives.
    Sink,
    /// Writes what the others say to a file.
    Recorder,
}

impl Part {
    pub(super) const ALL: [Self; 5] = {
        use Part::{Capture, Extract, Fit, Recorder, Sink};
        [Capture, Extract, Fit, Sink, Recorder]
    };
    /// From the end to the beginning, so that every message finds its reader there. Readers of a channel are woken in the order
    /// in which they came: the sink is not to wait for the recorder.
    pub(super) const START_ORDER: [Self; Self::ALL.len()] = {
        use Part::{Capture, Extract, Fit, Recorder, Sink};
        [Sink, Recorder, Fit, Extract, Capture]
    };

    /// As the command line names it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Capture => Stage::Capture.name(),
            Self::Extract => Stage::Extract.name(),
            Self::Fit => Stage::Fit.name(),
            Self::Sink => Stage::Sink.name(),
            Self::Recorder => "recorder",
        }
    }

    /// The stage before it, if it is a stage.
    pub(super) fn before(self) -> Option<Self> {
        match self {
            Self::Capture | Self::Recorder => None,
            Self::Extract => Some(Self::Capture),
            Self::Fit => Some(Self::Extract),
            Self::Sink => Some(Self::Fit),
        }
    }

    /// What it does as a thread of the chain's own process, if it can be one: all can but those that report on the others.
    pub(super) fn fused(self) -> Option<Run> {
        match self {
            Self::Capture => Some(stages::capture::run),
            Self::Extract => Some(stages::extract::run),
            Self::Fit => Some(stages::fit::run),
            Self::Sink | Self::Recorder => None,
        }
    }

    /// Whether it is told at its end what the others sent.
    pub fn is_told_the_last_word(self) -> bool {
        match self {
            Self::Capture | Self::Extract | Self::Fit => false,
            Self::Sink | Self::Recorder => true,
        }
    }
}

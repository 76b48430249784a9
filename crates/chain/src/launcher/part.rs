//! The parts of a chain.

use super::child::Run;
use crate::settings::Stage;
use crate::stages;

/// A part of the chain, in the order of the data. The recorder is a part only if a recording is
/// made. It starts before the writers and ends after them, so that it records everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Sends frames.
    Capture,
    /// Finds centerlines in frames.
    Extract,
    /// Fits descriptors to centerlines.
    Fit,
    /// Counts and times the messages that arrive.
    Sink,
    /// Records the messages of the stages to a file.
    Recorder,
}

impl Part {
    pub(super) const ALL: [Self; 5] = {
        use Part::{Capture, Extract, Fit, Recorder, Sink};
        [Capture, Extract, Fit, Sink, Recorder]
    };
    /// Starting order: from the last part to the first, so that every message finds its reader.
    /// Readers of a channel are woken in the order in which they joined, so the sink comes before
    /// the recorder.
    pub(super) const START_ORDER: [Self; Self::ALL.len()] = {
        use Part::{Capture, Extract, Fit, Recorder, Sink};
        [Sink, Recorder, Fit, Extract, Capture]
    };

    /// Returns the name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Capture => Stage::Capture.name(),
            Self::Extract => Stage::Extract.name(),
            Self::Fit => Stage::Fit.name(),
            Self::Sink => Stage::Sink.name(),
            Self::Recorder => "recorder",
        }
    }

    /// Returns the stage before this one, if any.
    pub(super) fn before(self) -> Option<Self> {
        match self {
            Self::Capture | Self::Recorder => None,
            Self::Extract => Some(Self::Capture),
            Self::Fit => Some(Self::Extract),
            Self::Sink => Some(Self::Fit),
        }
    }

    /// Returns the stage's main function if the stage can run as a thread of the chain's process.
    /// The sink and the recorder cannot, because they report on the others.
    pub(super) fn fused(self) -> Option<Run> {
        match self {
            Self::Capture => Some(stages::capture::run),
            Self::Extract => Some(stages::extract::run),
            Self::Fit => Some(stages::fit::run),
            Self::Sink | Self::Recorder => None,
        }
    }

    /// Returns true if the part receives the totals of the others at the end.
    pub fn is_told_the_last_word(self) -> bool {
        match self {
            Self::Capture | Self::Extract | Self::Fit => false,
            Self::Sink | Self::Recorder => true,
        }
    }
}

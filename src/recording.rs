//! Opens recordings for the commands that read them. [`lariat_chain::recorded`] reads their frames
//! and settings.

use anyhow::{Context, Result};
use clap::Args;
use lariat_capture::Position;
use lariat_record::{Place, Recording, Span};
use std::path::{Path, PathBuf};

/// Choice of a recording, for every command that reads one.
#[derive(Debug, Clone, Args)]
pub(crate) struct RecordingArgs {
    /// Recording from `lariat record`, or another MCAP file of ROS 2 with images
    #[arg(value_name = "FILE.mcap")]
    pub(crate) file: PathBuf,
    /// Image topic, if there are several cameras
    #[arg(long, value_name = "TOPIC")]
    pub(crate) topic: Option<String>,
}

impl RecordingArgs {
    /// Opens the recording, and reports what is missing at its end.
    pub(crate) fn open(&self) -> Result<Recording> {
        let shown = self.file.display();
        let recording = Recording::open_topic(&self.file, self.topic.as_deref())
            .with_context(|| shown.to_string())?;
        if let Some(sentence) = recording.cut_off() {
            eprintln!("lariat: {shown}: {sentence}");
        }
        if let (Some(topic), None, [_, _, ..]) =
            (recording.images(), &self.topic, recording.cameras())
        {
            eprintln!(
                "lariat: {shown}: there are images of several cameras, on {}; its frames are those on {topic} (--topic)",
                recording.cameras().join(", ")
            );
        } else if let (Some(topic), None, false) =
            (recording.images(), &self.topic, recording.has_traces())
        {
            eprintln!(
                "lariat: {shown}: lariat did not make this; its frames are the images on {topic} (--topic)"
            );
        }
        Ok(recording)
    }
}

/// Part of a recording. Both ends are included if they are frames; a time as the end is excluded.
pub(crate) fn span(from: Option<Position>, to: Option<Position>) -> Span {
    Span {
        from: from.map(|from| match from {
            Position::Frame(number) => Place::Frame(number),
            Position::Time(time) => Place::After(time),
        }),
        to: to.map(|to| match to {
            Position::Frame(number) => Place::Frame(number.saturating_add(1)),
            Position::Time(time) => Place::After(time),
        }),
    }
}

/// Name of a file for messages.
pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string()
}

//! Recordings, as the commands about them need them: opened. Frame by frame, and with their settings:
//! [`lariat_chain::recorded`].

use anyhow::{Context, Result};
use clap::Args;
use lariat_capture::Position;
use lariat_record::{Place, Recording, Span};
use std::path::{Path, PathBuf};

/// Which recording, for every command that reads one.
#[derive(Debug, Clone, Args)]
pub(crate) struct RecordingArgs {
    /// Recording of `lariat record`, or another MCAP file of ROS 2 with images
    #[arg(value_name = "FILE.mcap")]
    pub(crate) file: PathBuf,
    /// Image topic, if there are several cameras
    #[arg(long, value_name = "TOPIC")]
    pub(crate) topic: Option<String>,
}

impl RecordingArgs {
    /// Opens it, and says what is missing at its end.
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

/// A part of a recording: both ends included where they are frames, the last one not where it is a time.
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

/// A file's name, as it is spoken of.
pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string()
}

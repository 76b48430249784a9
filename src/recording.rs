//! Recordings, as the commands about them need them: opened, with their settings. Frame by frame:
//! [`lariat_chain::recorded`].

use crate::record::versioned_name;
use anyhow::{Context, Result};
use clap::Args;
use lariat_capture::Position;
use lariat_chain::settings::{Flags, Settings, version_of};
use lariat_record::{Place, Recording, Span};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The settings that a recording holds for.
pub(crate) const SETTINGS: &str = "lariat.toml";
/// What the settings' `calibration` names.
pub(crate) const CALIBRATION: &str = "calibration.yaml";
/// What the settings' `plane` names.
pub(crate) const PLANE: &str = "plane.toml";

/// Which recording, for every command that reads one.
#[derive(Debug, Clone, Args)]
pub(crate) struct RecordingArgs {
    /// A recording, as `lariat record` makes them; or another MCAP file of ROS 2 with images
    #[arg(value_name = "FILE.mcap")]
    pub(crate) file: PathBuf,
    /// The topic whose images are the frames, where there are several cameras
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

/// The settings that a recording was made with, and the files they name.
pub(crate) struct RecordedSettings {
    pub(crate) settings: Settings,
    folder: TempDir,
}

impl RecordedSettings {
    /// `None` if there are none in it.
    ///
    /// # Errors
    /// They make no sense to this release.
    pub(crate) fn of(recording: &Recording) -> Result<Option<Self>> {
        Self::named(recording, 0)
    }

    /// Those of a later version; `None` if they are not in it.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub(crate) fn of_version(&self, recording: &Recording, version: u32) -> Result<Option<Self>> {
        if version == self.settings.version {
            return Self::of(recording);
        }
        Self::named(recording, version)
    }

    fn named(recording: &Recording, version: u32) -> Result<Option<Self>> {
        let Some(text) = text_of(recording, &versioned_name(SETTINGS, version))? else {
            return Ok(None);
        };
        let about = || "the recording's own settings cannot be used";
        let mut table: toml::Table = text.parse().with_context(about)?;
        let folder = tempfile::tempdir().with_context(about)?;
        // Where these files were is not where they are now.
        if let Some(camera) = table.get_mut("camera").and_then(toml::Value::as_table_mut) {
            for (key, name) in [("calibration", CALIBRATION), ("plane", PLANE)] {
                if camera.contains_key(key) {
                    let path = folder.path().join(name);
                    let of_version = text_of(recording, &versioned_name(name, version))?;
                    let text = of_version
                        .map_or_else(|| text_of(recording, name), |text| Ok(Some(text)))?;
                    let text = text.with_context(|| {
                        format!(
                            "the recording's settings name a {key}, and it is not in the recording"
                        )
                    })?;
                    std::fs::write(&path, text).with_context(about)?;
                    camera.insert(key.to_owned(), path.to_string_lossy().into_owned().into());
                }
            }
        }
        let path = folder.path().join(SETTINGS);
        std::fs::write(&path, table.to_string()).with_context(about)?;
        let mut settings = Settings::of_file(&path).with_context(about)?;
        settings.version = version_of(&text);
        Ok(Some(Self { settings, folder }))
    }

    /// As a settings file, to be overruled by flags.
    pub(crate) fn file(&self) -> PathBuf {
        self.folder.path().join(SETTINGS)
    }

    /// The settings that flags and, if one is named, a settings file ask for: in the stead of the file that may lie in this
    /// folder, the recording's own.
    pub(crate) fn changed(&self, flags: &Flags) -> Result<Settings> {
        let mut flags = flags.clone();
        flags.config.get_or_insert_with(|| self.file());
        Settings::resolve(&flags)
    }
}

fn text_of(recording: &Recording, name: &str) -> Result<Option<String>> {
    let bytes = recording.attachment(name)?;
    bytes
        .map(String::from_utf8)
        .transpose()
        .with_context(|| format!("{name} in the recording is no text"))
}

/// A file's name, as it is spoken of.
pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string()
}

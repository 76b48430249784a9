//! The settings that a recording was made with, and the files that they name. All of them are
//! attached to the recording.

use std::path::PathBuf;

use anyhow::{Context, Result};
use lariat_record::Recording;
use tempfile::TempDir;

use crate::settings::{Flags, Settings, renamed, version_of};

/// Name of the attached settings.
pub const SETTINGS: &str = "lariat.toml";
/// Name of the attached file that the settings call `calibration`.
pub const CALIBRATION: &str = "calibration.yaml";
/// Name of the attached file that the settings call `plane`.
pub const PLANE: &str = "plane.toml";

/// The settings that a recording was made with, and the files that they name.
#[derive(Debug)]
pub struct RecordedSettings {
    /// All settings in force. The paths lead to temporary files that exist until this is dropped.
    pub settings: Settings,
    folder: TempDir,
}

impl RecordedSettings {
    /// Reads the settings at the start of a recording. Returns `None` if they are missing.
    ///
    /// # Errors
    /// Returns an error if they are invalid in this release.
    pub fn of(recording: &Recording) -> Result<Option<Self>> {
        Self::named(recording, 0)
    }

    /// Reads a later version of the settings. Returns `None` if the recording does not have it.
    ///
    /// # Errors
    /// Fails like [`of`](Self::of).
    pub fn of_version(&self, recording: &Recording, version: u32) -> Result<Option<Self>> {
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
        renamed::renew(&mut table);
        // Replace the original paths by those of the extracted files.
        if let Some(camera) = table.get_mut("camera").and_then(toml::Value::as_table_mut) {
            let files = [
                ("calibration", CALIBRATION),
                ("plane", PLANE),
                ("depth", "depth.yaml"),
                ("second", "second.yaml"),
                ("pose", "pose.yaml"),
            ];
            for (key, name) in files {
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
        // These settings apply to pictures or cameras, and a recording is neither.
        if let Some(capture) = table.get_mut("capture").and_then(toml::Value::as_table_mut) {
            capture.remove("depth_images");
            capture.remove("depth_source");
        }
        let path = folder.path().join(SETTINGS);
        std::fs::write(&path, table.to_string()).with_context(about)?;
        let mut settings = Settings::of_file(&path).with_context(about)?;
        settings.version = version_of(&text);
        Ok(Some(Self { settings, folder }))
    }

    /// Returns the path of the settings as a file. Flags can override them.
    pub fn file(&self) -> PathBuf {
        self.folder.path().join(SETTINGS)
    }

    /// Resolves flags against the recording's settings, which replace a `lariat.toml` in the
    /// current folder. A settings file that the flags name takes precedence.
    pub fn changed(&self, flags: &Flags) -> Result<Settings> {
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
        .with_context(|| format!("{name} in the recording is not text"))
}

/// Returns the name of a file for a later version of the settings: `lariat.toml`, `lariat.2.toml`.
pub fn versioned_name(name: &str, version: u32) -> String {
    match (version, name.rsplit_once('.')) {
        (0, _) | (_, None) => name.to_owned(),
        (version, Some((stem, ending))) => format!("{stem}.{version}.{ending}"),
    }
}

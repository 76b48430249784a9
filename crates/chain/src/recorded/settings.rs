//! The settings that a recording was made with, and the files that they name: all attached to it.

use std::path::PathBuf;

use anyhow::{Context, Result};
use lariat_record::Recording;
use tempfile::TempDir;

use crate::settings::{Flags, Settings, renamed, version_of};

/// The settings that a recording holds for.
pub const SETTINGS: &str = "lariat.toml";
/// What the settings' `calibration` names.
pub const CALIBRATION: &str = "calibration.yaml";
/// What the settings' `plane` names.
pub const PLANE: &str = "plane.toml";

/// The settings that a recording was made with, and the files they name.
#[derive(Debug)]
pub struct RecordedSettings {
    /// All that held, with the paths of the files as they lie here until this is dropped.
    pub settings: Settings,
    folder: TempDir,
}

impl RecordedSettings {
    /// `None` if there are none in it.
    ///
    /// # Errors
    /// They make no sense to this release.
    pub fn of(recording: &Recording) -> Result<Option<Self>> {
        Self::named(recording, 0)
    }

    /// Those of a later version; `None` if they are not in it.
    ///
    /// # Errors
    /// As [`of`](Self::of).
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
        // Where these files were is not where they are now.
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
        // They lay beside pictures or cameras, and the recording is neither.
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

    /// As a settings file, to be overruled by flags.
    pub fn file(&self) -> PathBuf {
        self.folder.path().join(SETTINGS)
    }

    /// The settings that flags and, if one is named, a settings file ask for: in the stead of the file that may lie in this
    /// folder, the recording's own.
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

/// What a file of a later version of the settings is called: `lariat.toml`, `lariat.2.toml`.
pub fn versioned_name(name: &str, version: u32) -> String {
    match (version, name.rsplit_once('.')) {
        (0, _) | (_, None) => name.to_owned(),
        (version, Some((stem, ending))) => format!("{stem}.{version}.{ending}"),
    }
}

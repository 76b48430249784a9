//! The description of a recording. Its metadata say how it was made. Its attachments are the rig's
//! settings and the files that they name, so that a replay needs nothing else.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lariat_record::{Clock, Ended, Recorder};
use lariat_sink::Machine;
use lariat_wire::{Member, members, now_ns};
use toml::{Table, Value};

use super::STAGE;
use lariat_chain::bounded;
use lariat_chain::recorded::versioned_name;
use lariat_chain::settings::{
    COMPRESSIONS, Camera, FILE_NAME, IMAGES, Settings, settings_of, version_line, version_of,
};

/// Files that settings name and a replay needs: key in the settings, name in the recording, and
/// media type.
const FILES: [(&str, &str, &str); 5] = [
    ("calibration", "calibration.yaml", "application/yaml"),
    ("plane", "plane.toml", "application/toml"),
    ("depth", "depth.yaml", "application/yaml"),
    ("second", "second.yaml", "application/yaml"),
    ("pose", "pose.yaml", "application/yaml"),
];

/// Metadata that say how the recording is made.
pub(super) fn metadata(settings: &Settings, clock: Clock) -> BTreeMap<String, String> {
    let name = |found: Option<&str>| found.unwrap_or_default().to_owned();
    let record = &settings.record;
    let images = IMAGES.iter().find(|(_, kind)| *kind == record.images);
    let compression = COMPRESSIONS
        .iter()
        .find(|(_, kind)| *kind == record.compression);
    let machine = Machine::this();
    [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("rig", settings.run.rig.clone()),
        ("arch", std::env::consts::ARCH.to_owned()),
        ("cpu", machine.cpu.unwrap_or_default()),
        ("kernel", machine.kernel),
        (
            "monotonic_to_wall_ns",
            clock.monotonic_to_wall_ns.to_string(),
        ),
        ("images", name(images.map(|(name, _)| *name))),
        ("quality", record.quality.to_string()),
        ("compression", name(compression.map(|(name, _)| *name))),
        ("lossless", settings.run.lossless.to_string()),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into()
}

/// Source of a recording's settings.
pub(super) enum Rig {
    /// The chain that this process belongs to; its settings are this process's own.
    Ours(Box<Settings>),
    /// An independent rig, which may start later and restart; its stages announce their settings.
    Theirs {
        /// Name of the rig.
        name: String,
        /// Settings as announced last.
        said: Option<String>,
        /// Fit stage as announced last.
        fit: Option<Member>,
    },
}

impl Rig {
    /// Takes the chain's changed settings.
    pub(super) fn change(&mut self, settings: Settings) {
        *self = Self::Ours(Box::new(settings));
    }

    /// Lens and plane of the rig, and the version of the settings that name them, if known.
    pub(super) fn camera(&self) -> Option<(u32, Camera)> {
        match self {
            Self::Ours(settings) => Some((settings.version, settings.camera.clone())),
            Self::Theirs { fit, .. } => {
                let fit = fit.as_ref()?;
                Some((version_of(&fit.settings), settings_of(fit).ok()?.camera))
            }
        }
    }

    /// Attaches the settings to the recording if they are known and have changed. Their name
    /// includes their version if other settings are already attached.
    pub(super) fn attach(&mut self, to: &mut Recorder, is_first: bool) -> Result<(), Ended> {
        match self {
            Self::Ours(settings) => {
                let version = (!is_first).then_some(settings.version);
                let called = |name: &str| versioned_name(name, version.unwrap_or(0));
                attach_text(to, &called(FILE_NAME), settings.text())?;
                let camera = &settings.camera;
                let paths = [
                    &camera.calibration,
                    &camera.plane,
                    &camera.depth,
                    &camera.second,
                    &camera.pose,
                ];
                for ((_, name, media_type), path) in FILES.iter().zip(paths) {
                    if let Some(path) = path {
                        attach_file(to, path, &called(name), media_type)?;
                    }
                }
                Ok(())
            }
            Self::Theirs { name, said, fit } => {
                let stages = members().unwrap_or_default();
                let stages = stages.iter().filter(|member| member.rig == *name);
                *fit = stages.clone().find(|member| member.stage == "fit").cloned();
                let newest = stages.clone().map(|member| version_of(&member.settings));
                let version = newest.max().unwrap_or(0);
                let (settings, folder) = joined(stages);
                let text = version_line(version) + &settings.to_string();
                if settings.is_empty() || said.as_ref() == Some(&text) {
                    return Ok(());
                }
                let version = if is_first { 0 } else { version };
                for (key, called, media_type) in FILES {
                    let named = settings.get("camera").and_then(|camera| camera.get(key));
                    if let Some(path) = named.and_then(Value::as_str) {
                        let called = versioned_name(called, version);
                        attach_file(to, &folder.join(path), &called, media_type)?;
                    }
                }
                attach_text(to, &versioned_name(FILE_NAME, version), text.clone())?;
                *said = Some(text);
                Ok(())
            }
        }
    }
}

fn attach_text(to: &mut Recorder, called: &str, text: String) -> Result<(), Ended> {
    to.attach(called, "application/toml", now_ns(), text.into_bytes())
}

fn attach_file(
    to: &mut Recorder,
    path: &Path,
    called: &str,
    media_type: &'static str,
) -> Result<(), Ended> {
    match bounded::read(path, bounded::LONGEST_TEXT) {
        Ok(bytes) => to.attach(called, media_type, now_ns(), bytes),
        Err(cause) => {
            tracing::warn!(
                "{} is not in the recording, as it could not be read: {cause}",
                path.display()
            );
            Ok(())
        }
    }
}

/// Joins the settings of a rig: each section comes from the stage that uses it. Also returns the
/// folder that relative paths in `[camera]` start from.
fn joined<'a>(stages: impl Iterator<Item = &'a Member>) -> (Table, PathBuf) {
    let mut settings = Table::new();
    let mut folder = PathBuf::new();
    for member in stages {
        let sections: &[&str] = match member.stage.as_str() {
            "capture" => &["run", "capture"],
            "extract" => &["extract"],
            "fit" => {
                folder.clone_from(&member.folder);
                &["camera", "fit"]
            }
            "sink" => &["sink"],
            _ => &[],
        };
        let Ok(said) = member.settings.parse::<Table>() else {
            continue;
        };
        for section in sections {
            if let Some(values) = said.get(*section) {
                settings.insert((*section).to_owned(), values.clone());
            }
        }
    }
    (settings, folder)
}

/// Returns true if the settings announced by a recorder say that it keeps the last seconds.
pub(super) fn keeps_a_ring(settings: &str) -> bool {
    let settings: Table = settings.parse().unwrap_or_default();
    let record = settings.get(STAGE);
    record.is_some_and(|record| record.get("ring_s").is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn member(stage: &str, settings: &str) -> Member {
        Member {
            rig: "default".into(),
            stage: stage.into(),
            pid: 1,
            version: "0".into(),
            folder: format!("/{stage}").into(),
            settings: settings.into(),
        }
    }

    #[test]
    fn each_section_is_from_the_stage_that_goes_by_it() {
        let everywhere = |points| {
            format!(
                "[run]\nrig = \"default\"\n[extract]\npoints = {points}\n[fit]\ncontrol_points = {points}\n"
            )
        };
        let stages = [
            member("extract", &everywhere(100)),
            member("fit", &everywhere(8)),
            member("record", &everywhere(3)),
            member("capture", "this is no TOML"),
        ];
        let (settings, folder) = joined(stages.iter());
        assert_eq!(
            settings.to_string(),
            "[extract]\npoints = 100\n\n[fit]\ncontrol_points = 8\n"
        );
        assert_eq!(folder, Path::new("/fit"));
    }

    #[test]
    fn a_recorder_of_the_last_seconds_is_told_from_others() {
        let mut settings = Settings::default();
        assert!(!keeps_a_ring(&settings.text()));
        settings.record.ring = Some(std::time::Duration::from_secs(30));
        assert!(keeps_a_ring(&settings.text()));
        assert!(!keeps_a_ring("nothing"));
    }
}

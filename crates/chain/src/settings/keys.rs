//! Definition of a setting, and queries on the table of all settings.

use crate::settings::Settings;
use crate::settings::flags::Flag;
use crate::settings::kind::Takes;
use toml::Value;

pub(super) use crate::settings::table::KEYS;

/// One setting.
pub(super) struct Key {
    pub(super) section: &'static str,
    pub(super) name: &'static str,
    /// Description, used as the comment above the setting in a new file.
    pub(super) about: &'static str,
    /// Applies a value, or returns why it is invalid.
    pub(super) set: fn(&mut Settings, &Value) -> Result<(), String>,
    /// Returns the value as in the file, or `None` if it is not set.
    pub(super) get: fn(&Settings) -> Option<Value>,
    /// Returns the kind of argument that the flag takes.
    pub(super) takes: fn() -> Takes,
    /// Returns a value to show if the setting is unset by default.
    pub(super) example: fn() -> &'static str,
    pub(super) flag: Option<Flag>,
}

/// Description of each section.
const SECTIONS: [(&str, &str); 8] = [
    ("run", "The chain as a whole."),
    ("capture", "The source of frames."),
    (
        "simulation",
        "The simulated rope, for the source \"simulated\".",
    ),
    ("camera", "Lens, plane, depth: from pixels to millimetres."),
    ("extract", "Finding ropes, and their centerlines."),
    ("fit", "The curve that describes the centerline."),
    ("sink", "The live line."),
    ("record", "The contents and the format of recordings."),
];

/// Returns the indices in [`KEYS`] of a section's settings.
pub(super) fn of_section(section: &str) -> impl Iterator<Item = usize> {
    (0..KEYS.len()).filter(move |&index| KEYS[index].section == section)
}

/// Returns the index in [`KEYS`] of a setting.
pub(super) fn position(section: &str, name: &str) -> Option<usize> {
    KEYS.iter()
        .position(|key| key.section == section && key.name == name)
}

/// Returns the names of the sections.
pub(super) fn sections() -> impl Iterator<Item = &'static str> + Clone {
    SECTIONS.iter().map(|(name, _)| *name)
}

impl Settings {
    /// Returns the settings that differ from the defaults: `section.name`, and the value as in the
    /// file.
    pub fn changed(&self) -> impl Iterator<Item = (String, String)> {
        let defaults = Settings::default();
        KEYS.iter().filter_map(move |key| {
            let value = (key.get)(self);
            let is_default = value == (key.get)(&defaults);
            let value = value.map_or_else(|| "not set".to_owned(), |value| value.to_string());
            (!is_default).then(|| (format!("{}.{}", key.section, key.name), value))
        })
    }
}

/// Returns the text of a file with all sections. `entry` writes each setting.
pub(super) fn document(mut entry: impl FnMut(usize, &Key) -> String) -> String {
    let mut text = String::new();
    for (section, about) in SECTIONS {
        if !text.is_empty() {
            text.push('\n');
        }
        text.push_str(&format!("[{section}]  # {about}\n"));
        for (index, key) in KEYS.iter().enumerate() {
            if key.section == section {
                text.push_str(&entry(index, key));
            }
        }
    }
    text
}

/// Returns a new settings file: every setting at its default, with its comment.
pub fn template() -> String {
    let defaults = Settings::default();
    let settings = document(|_, key| {
        let comment: String = key
            .about
            .lines()
            .map(|line| format!("# {line}\n"))
            .collect();
        match (key.get)(&defaults) {
            Some(value) => format!("\n{comment}{} = {value}\n", key.name),
            None => format!("\n{comment}# {} = {}\n", key.name, (key.example)()),
        }
    });
    format!(
        "# Settings of lariat. Flags on the command line win over this file.\n\
         # `lariat config check` reads it critically, `lariat config show` prints what holds.\n\n{settings}"
    )
}

//! Reads `lariat.toml`: its settings with their lines, and the entries that are not settings.

use crate::exit::WrongUse;
use crate::settings::keys::{self, KEYS};
use crate::settings::problem::{Origin, Problems};
use crate::settings::{FILE_NAME, meaning, renamed};
use anyhow::{Context, Result};
use lariat_wire::user_name;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// A setting in the file.
pub(super) struct Entry {
    /// Index in [`KEYS`].
    pub(super) key: usize,
    pub(super) value: toml::Value,
    pub(super) origin: Origin,
}

/// Returns the settings file to read: the named one, or `lariat.toml` in the current folder unless
/// it belongs to another user.
pub(super) fn path(named: Option<&Path>) -> Option<PathBuf> {
    if let Some(path) = named {
        return Some(path.to_owned());
    }
    let path = PathBuf::from(FILE_NAME);
    let owner = std::fs::metadata(&path).ok()?.uid();
    if is_trusted(owner) {
        return Some(path);
    }
    // Settings name files to write and programs to connect to.
    tracing::warn!(
        "{FILE_NAME} in this folder belongs to {}, and is not read: if you trust it, name it (--config {FILE_NAME})",
        user_name(owner)
    );
    None
}

/// Returns true if a file of this owner is read without being named: our own, root's, and with sudo
/// the caller's.
fn is_trusted(owner: u32) -> bool {
    let me = rustix::process::geteuid().as_raw();
    let caller = || std::env::var("SUDO_UID").ok()?.parse::<u32>().ok();
    owner == me || owner == 0 || me == 0 && caller() == Some(owner)
}

/// Reads the settings from the file at `path`. Invalid entries are added to `problems`.
///
/// # Errors
/// Returns an error if the file cannot be read.
pub(super) fn read(path: &Path, problems: &mut Problems) -> Result<Vec<Entry>> {
    let text = crate::bounded::read_text(path).with_context(|| {
        WrongUse(format!(
            "cannot read the settings file {}: `lariat config init` writes one",
            path.display()
        ))
    })?;
    Ok(entries(path, &text, problems))
}

/// Reads the settings from a file's text.
pub(super) fn entries(path: &Path, text: &str, problems: &mut Problems) -> Vec<Entry> {
    let origin = |offset: usize| Origin::File {
        path: path.to_owned(),
        line: 1 + text[..offset.min(text.len())].matches('\n').count(),
    };
    // Parse the text twice: once for the values, once for their positions.
    let (values, places) = match (text.parse::<toml::Table>(), DeTable::parse(text)) {
        (Ok(values), Ok(places)) => (values, places.into_inner()),
        (Err(error), _) | (_, Err(error)) => {
            let offset = error.span().map_or(0, |span| span.start);
            problems.add(
                &origin(offset),
                format!("this is not TOML: {}", error.message()),
            );
            return Vec::new();
        }
    };

    let mut entries = Vec::new();
    for (section, content) in &places {
        let (name, here) = (section.get_ref().as_ref(), origin(section.span().start));
        let DeValue::Table(content) = content.get_ref() else {
            problems.add(&here, outside(name));
            continue;
        };
        if !keys::sections().any(|known| known == name) {
            problems.add(&here, unknown_section(name));
            continue;
        }
        for key in content.keys() {
            let (key_name, here) = (key.get_ref().as_ref(), origin(key.span().start));
            let value = values.get(name).and_then(|section| section.get(key_name));
            match (keys::position(name, key_name), value) {
                (Some(key), Some(value)) => entries.push(Entry {
                    key,
                    value: value.clone(),
                    origin: here,
                }),
                (None, Some(value)) => {
                    let renamed = renamed::refusal(name, key_name, value);
                    let why = renamed.unwrap_or_else(|| unknown_key(name, key_name));
                    problems.add(&here, why);
                }
                (_, None) => problems.add(&here, unknown_key(name, key_name)),
            }
        }
    }
    entries
}

/// Returns the error for a value before the first section.
fn outside(name: &str) -> String {
    match sections_with(name).first() {
        Some(section) => {
            format!("\"{name}\" stands outside any section: put it below a line [{section}]")
        }
        None => format!(
            "\"{name}\" stands outside any section, and no section has it. {}",
            the_sections()
        ),
    }
}

fn unknown_section(name: &str) -> String {
    let guess = meaning::nearest(name, keys::sections())
        .map_or(String::new(), |near| format!("Did you mean [{near}]? "));
    format!("there is no section [{name}]. {guess}{}", the_sections())
}

fn unknown_key(section: &str, name: &str) -> String {
    let known = || {
        KEYS.iter()
            .filter(move |key| key.section == section)
            .map(|key| key.name)
    };
    let guess = match (meaning::nearest(name, known()), sections_with(name).first()) {
        (Some(near), _) => format!("Did you mean \"{near}\"? "),
        (None, Some(elsewhere)) => format!("It belongs in [{elsewhere}]. "),
        (None, None) => String::new(),
    };
    let list: Vec<_> = known().collect();
    format!(
        "[{section}] has no key \"{name}\". {guess}Its keys are {}",
        list.join(", ")
    )
}

fn the_sections() -> String {
    let list: Vec<_> = keys::sections().map(|name| format!("[{name}]")).collect();
    format!("The sections are {}", list.join(", "))
}

fn sections_with(name: &str) -> Vec<&'static str> {
    KEYS.iter()
        .filter(|key| key.name == name)
        .map(|key| key.section)
        .collect()
}

//! Settings of a camera: the pixel format and controls of `[capture]`, and how frames are read.

use std::collections::BTreeMap;

use lariat_capture::{ControlSettings, FourCc, Io, RawFormat};
use toml::Value;

/// A pixel format by name.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FormatName {
    /// The camera format code with that name.
    pub code: Option<FourCc>,
    /// The raw format with that name.
    pub raw: Option<RawFormat>,
}

/// Settings that apply only to cameras, except the pixel format, which also applies to frames from
/// a pipe.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CameraSettings {
    /// The pixel format. Without it, the best format that the camera offers.
    pub pixel_format: Option<FormatName>,
    /// How frames are transferred from the driver.
    pub io: Io,
    /// Names of controls and their values.
    pub controls: BTreeMap<String, String>,
    /// True if exposure, white balance, gain and focus are locked once the picture has settled.
    pub lock: bool,
    /// True if controls are restored at the end.
    pub restore: bool,
}

impl CameraSettings {
    /// Returns the settings of the controls.
    pub fn controls(&self) -> ControlSettings {
        ControlSettings {
            values: self.controls.clone().into_iter().collect(),
            lock: self.lock,
            restore: self.restore,
        }
    }
}

/// Names of the transfer methods.
pub(super) const IO: [(&str, Io); 3] = [
    ("auto", Io::Auto),
    ("userptr", Io::UserPointer),
    ("mmap", Io::Mapped),
];

pub(super) fn pixel_format(value: &Value) -> Result<Option<FormatName>, String> {
    let asked = value.as_str().unwrap_or_default();
    if asked == "auto" {
        return Ok(None);
    }
    let name = FormatName {
        code: asked.parse().ok(),
        raw: RawFormat::from_name(asked),
    };
    if name == FormatName::default() {
        return Err(format!(
            "a pixel format is a code of up to four letters, such as \"yuyv\", \"mjpg\" or \"grey\" (`lariat devices` lists \
             the camera's), or \"auto\"; of raw frames on standard input {}",
            raw_names()
        ));
    }
    Ok(Some(name))
}

/// Returns the names of the raw formats as part of a sentence.
pub(super) fn raw_names() -> String {
    let names: Vec<_> = RawFormat::names().collect();
    match &names[..] {
        [others @ .., last] => format!("{} or {last}", others.join(", ")),
        [] => String::new(),
    }
}

pub(super) fn pixel_format_value(format: &Option<FormatName>) -> Value {
    let name = match format {
        None => "auto".to_owned(),
        // The code of a camera format may also name a raw format, and is then read back as both.
        Some(FormatName {
            code: Some(code), ..
        }) => code.to_string(),
        Some(FormatName { raw, .. }) => raw.map_or("", RawFormat::name).to_owned(),
    };
    Value::String(name.to_ascii_lowercase())
}

/// Reads names of controls and their values.
pub(super) fn controls(value: &Value) -> Result<BTreeMap<String, String>, String> {
    let Some(table) = value.as_table() else {
        return Err("controls are names and values: { auto_exposure = 1, gain = 20 }".to_owned());
    };
    let text = |(name, value): (&String, &Value)| {
        let text = match value {
            Value::Integer(number) => number.to_string(),
            Value::Boolean(yes) => if *yes { "on" } else { "off" }.to_owned(),
            Value::String(text) => text.clone(),
            _ => {
                return Err(format!(
                    "the control {name} is set to a whole number, to true or false, or to a menu's item as text"
                ));
            }
        };
        Ok((name.clone(), text))
    };
    table.iter().map(text).collect()
}

/// Returns the controls as they appear in the file, or `None` without controls.
pub(super) fn controls_value(controls: &BTreeMap<String, String>) -> Option<Value> {
    let value = |text: &String| {
        text.parse()
            .map_or_else(|_| Value::String(text.clone()), Value::Integer)
    };
    let table: toml::Table = controls
        .iter()
        .map(|(name, text)| (name.clone(), value(text)))
        .collect();
    (!table.is_empty()).then_some(Value::Table(table))
}

/// Converts a flag's `NAME=VALUE` to a value as in the file.
pub(super) fn control(text: &str) -> Result<Value, String> {
    let named = text.split_once('=');
    let named = named.map(|(name, value)| (name.trim(), value.trim()));
    match named.filter(|(name, value)| !name.is_empty() && !value.is_empty()) {
        Some((name, value)) => {
            let value = Value::String(value.to_owned());
            Ok(Value::Table(
                [(name.to_owned(), value)].into_iter().collect(),
            ))
        }
        None => Err("a control is set as NAME=VALUE, for instance exposure_auto=1".to_owned()),
    }
}

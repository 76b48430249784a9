//! The part of a file sequence that is shown: `from`, `to` and `every` in `[capture]`. Also detects
//! settings of `[capture]` that do not apply to the source.

use std::num::NonZeroU64;
use std::path::PathBuf;
use std::time::Duration;

use lariat_capture::{Position, names_a_recording};
use toml::Value;

use crate::settings::{Capture, camera, duration, meaning};

/// Reads a position in a sequence: a frame number, or a time from the beginning.
pub(super) fn position(value: &Value) -> Result<Position, String> {
    const WHY: &str = "a place is a frame's number, from 1, such as 120, or a time from the beginning, with its unit, \
                       such as \"2.5s\"";
    let text = match value {
        Value::Integer(number @ 1..) => {
            return Ok(Position::Frame(number.unsigned_abs()));
        }
        Value::String(text) => text.trim(),
        _ => return Err(WHY.to_owned()),
    };
    // A number without a unit is not a time here.
    if !text.ends_with(char::is_alphabetic) {
        return Err(WHY.to_owned());
    }
    // Zero is valid, too: the time of the first frame.
    let time = match duration::seconds(text)? {
        0.0 => Duration::ZERO,
        seconds => duration::from_s(seconds)?,
    };
    Ok(Position::Time(time))
}

/// Parses a position as a flag gives it.
pub fn position_of_flag(text: &str) -> Result<Position, String> {
    let value = match text.parse() {
        Ok(number) => Value::Integer(number),
        Err(_) => Value::String(text.to_owned()),
    };
    position(&value)
}

pub(super) fn position_value(position: &Position) -> Value {
    match position {
        Position::Frame(number) => Value::Integer(i64::try_from(*number).unwrap_or(i64::MAX)),
        Position::Time(time) => Value::String(format!("{}s", time.as_secs_f64())),
    }
}

pub(super) fn every(value: &Value) -> Result<NonZeroU64, String> {
    let number = meaning::whole(value, 1, i64::MAX)?.unsigned_abs();
    Ok(NonZeroU64::new(number).unwrap_or(NonZeroU64::MIN))
}

pub(super) fn every_value(every: &NonZeroU64) -> Value {
    Value::Integer(i64::try_from(every.get()).unwrap_or(i64::MAX))
}

/// Kinds of sources that settings distinguish.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Rendered,
    Simulated,
    Camera,
    External,
    Files,
    Pipe,
}

impl Kind {
    fn of(capture: &Capture) -> Self {
        if capture.is_camera() {
            Self::Camera
        } else if capture.is_piped() {
            Self::Pipe
        } else if capture.source[..] == [PathBuf::from("rendered")] {
            Self::Rendered
        } else if capture.is_simulated() {
            Self::Simulated
        } else if capture.is_external() {
            Self::External
        } else {
            Self::Files
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Rendered => "the rendered rope",
            Self::Simulated => "the simulated rope",
            Self::Camera => "a camera",
            Self::External => "a program of your own",
            Self::Files => "pictures and videos",
            Self::Pipe => "standard input",
        }
    }
}

/// Settings that apply to only one kind of source.
const OF_ONE_KIND: [(&str, Kind); 12] = [
    ("from", Kind::Files),
    ("to", Kind::Files),
    ("every", Kind::Files),
    ("loop", Kind::Files),
    ("follow", Kind::Files),
    ("topic", Kind::Files),
    ("depth_source", Kind::Camera),
    ("pixel_format", Kind::Camera),
    ("io", Kind::Camera),
    ("controls", Kind::Camera),
    ("lock", Kind::Camera),
    ("restore", Kind::Camera),
];

/// Returns the settings of `[capture]` that do not apply to its source, with a sentence for each.
pub(super) fn meaningless(capture: &Capture) -> impl Iterator<Item = (&'static str, String)> {
    let kind = Kind::of(capture);
    let fits = move |name: &str, of| of == kind || (name == "pixel_format" && kind == Kind::Pipe);
    let others = OF_ONE_KIND
        .into_iter()
        .filter(move |(name, of)| !fits(name, *of));
    others.map(move |(name, of)| {
        let why = format!("it is for {}, and the source is {}", of.name(), kind.name());
        (name, why)
    })
}

/// Returns a setting that contradicts another, with a sentence.
pub(super) fn contradiction(capture: &Capture) -> Option<(&'static str, String)> {
    let is_recording = matches!(&capture.source[..], [path] if names_a_recording(path));
    if capture.topic.is_some() && !is_recording {
        return Some((
            "topic",
            "it chooses among the images of a recording: name one (.mcap) as the source".to_owned(),
        ));
    }
    if capture.depth_images.is_some() && !capture.is_of_pictures() {
        return Some((
            "depth_images",
            "depth images belong to pictures, one for each: name a folder of pictures as the source".to_owned(),
        ));
    }
    if capture.is_camera() && capture.depth_source.as_ref() == capture.source.first() {
        return Some((
            "depth_source",
            "it is the source itself, and a node gives pictures or depth: name the camera's other node".to_owned(),
        ));
    }
    if let Some(name) = capture.camera.pixel_format {
        let named = camera::pixel_format_value(&Some(name));
        if capture.is_camera() && name.code.is_none() {
            return Some((
                "pixel_format",
                format!("{named} is not a pixel format code: `lariat devices` lists them"),
            ));
        }
        if capture.is_piped() && name.raw.is_none() {
            return Some((
                "pixel_format",
                format!("raw frames are in {}, not in {named}", camera::raw_names()),
            ));
        }
    }
    if capture.is_piped() && capture.size.is_some() != capture.camera.pixel_format.is_some() {
        return Some((
            if capture.size.is_some() { "size" } else { "pixel_format" },
            "raw frames on standard input need both, size and pixel format; a Y4M video needs neither".to_owned(),
        ));
    }
    if !capture.follow {
        return None;
    }
    let why = |what: &str| format!("a folder that is followed {what}: choose one of the two");
    if capture.source.len() != 1 {
        return Some((
            "follow",
            "one folder can be followed: name it alone".to_owned(),
        ));
    }
    if capture.looped {
        return Some(("loop", why("does not end, and cannot begin again")));
    }
    let range = &capture.range;
    let bound = [("from", range.from), ("to", range.to)];
    let bound = bound.into_iter().find(|(_, position)| position.is_some());
    bound.map(|(name, _)| (name, why("is shown as it grows, and has no part to choose")))
}

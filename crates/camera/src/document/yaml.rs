//! Parses the subset of YAML in calibration files: nested maps and lists of scalars, within limits.
//!
//! OpenCV starts its files with `%YAML:1.0`, which no version of YAML allows; that line is ignored.
//! Anchors and aliases, with which a short text can expand without limit, are refused, as is
//! anything too large or nested too deeply.

use super::{DEEPEST, Node};
use crate::calibration::CalibrationError;
use saphyr_parser::{Event, Parser};
use std::borrow::Cow;

/// Parses the first document of a text.
pub(super) fn read(text: &str) -> Result<Node, CalibrationError> {
    let text = without_opencv_head(text);
    // Open maps and lists, each with the key that waits for its value.
    let mut open: Vec<(Node, Option<String>)> = Vec::new();
    for event in Parser::new_from_str(&text) {
        let (event, place) = event.map_err(|error| CalibrationError::Yaml(error.to_string()))?;
        let done = match event {
            Event::Alias(_) => {
                return Err(CalibrationError::Alias(place.start.line()));
            }
            Event::Scalar(text, ..) => Node::Scalar(text.into_owned()),
            Event::SequenceStart(..) | Event::MappingStart(..) if open.len() == DEEPEST => {
                return Err(CalibrationError::TooDeep(place.start.line()));
            }
            Event::SequenceStart(..) => {
                open.push((Node::List(Vec::new()), None));
                continue;
            }
            Event::MappingStart(..) => {
                open.push((Node::Map(Vec::new()), None));
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some((node, _)) => node,
                None => continue,
            },
            Event::DocumentEnd | Event::StreamEnd => break,
            _ => continue,
        };
        match open.last_mut() {
            None => return Ok(done),
            Some((Node::List(list), _)) => list.push(done),
            Some((Node::Map(entries), key)) => match (key.take(), done) {
                (Some(key), value) => entries.push((key, value)),
                (None, Node::Scalar(name)) => *key = Some(name),
                // No key that is looked up is a map or a list.
                (None, _) => *key = Some(String::new()),
            },
            Some((Node::Scalar(_), _)) => {}
        }
    }
    Err(CalibrationError::Empty)
}

/// Turns OpenCV's first line into a comment, so that line numbers stay the same.
fn without_opencv_head(text: &str) -> Cow<'_, str> {
    match text.strip_prefix("%YAML:") {
        Some(rest) => Cow::Owned(format!("#{rest}")),
        None => Cow::Borrowed(text),
    }
}

//! YAML as far as calibration files go: nested maps and lists of plain values, within bounds.
//!
//! OpenCV begins its files with `%YAML:1.0`, which no version of YAML has ever allowed; that line is passed over. Anchors and
//! aliases, by which a short text can mean an endless one, are refused, and so is what is too large or nested too deeply.

use super::{DEEPEST, Node};
use crate::calibration::CalibrationError;
use saphyr_parser::{Event, Parser};
use std::borrow::Cow;

/// The first document of a text.
pub(super) fn read(text: &str) -> Result<Node, CalibrationError> {
    let text = without_opencv_head(text);
    // Maps and lists that are open, each with the key that waits for its value.
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
                // No key that is asked for is a map or a list.
                (None, _) => *key = Some(String::new()),
            },
            Some((Node::Scalar(_), _)) => {}
        }
    }
    Err(CalibrationError::Empty)
}

/// The text with OpenCV's first line made a comment, so that lines keep their numbers.
fn without_opencv_head(text: &str) -> Cow<'_, str> {
    match text.strip_prefix("%YAML:") {
        Some(rest) => Cow::Owned(format!("#{rest}")),
        None => Cow::Borrowed(text),
    }
}

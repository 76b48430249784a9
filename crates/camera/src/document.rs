//! Parses calibration files to a tree of maps, lists and scalars. It supports YAML, JSON, OpenCV's
//! XML and ROS's `ost.ini`, within limits.

mod ini;
mod xml;
mod yaml;

use crate::calibration::CalibrationError;
use std::borrow::Cow;

/// Maximum length of a text. OpenCV's files with all views of a calibration have about 100 kB.
const MOST_BYTES: usize = 1 << 20;
/// Maximum nesting depth of maps and lists.
const DEEPEST: usize = 12;

/// A node of the tree.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    Scalar(String),
    List(Vec<Node>),
    Map(Vec<(String, Node)>),
}

impl Node {
    /// Returns the value of this key in a map; the first if there are several.
    pub(crate) fn get(&self, is_key: impl Fn(&str) -> bool) -> Option<(&str, &Node)> {
        match self {
            Node::Map(entries) => {
                let found = entries.iter().find(|(key, _)| is_key(key));
                found.map(|(key, value)| (&key[..], value))
            }
            _ => None,
        }
    }
}

/// Parses a text. Its first characters determine the format.
pub(crate) fn read(text: &str) -> Result<Node, CalibrationError> {
    if text.len() > MOST_BYTES {
        return Err(CalibrationError::TooLarge);
    }
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let file = if text.starts_with('<') {
        xml::read(text)?
    } else if ini::is_ini(text) {
        ini::read(text)?
    } else {
        // YAML does not allow tabs, with which some programs indent JSON.
        let is_json = text.starts_with('{') && text.contains('\t');
        let text = match is_json {
            true => Cow::Owned(text.replace('\t', " ")),
            false => Cow::Borrowed(text),
        };
        yaml::read(&text)?
    };
    Ok(grouped(file))
}

/// Groups the keys `Camera.fx` and `Camera.fy` of a file into a map `Camera` with `fx` and `fy`.
fn grouped(file: Node) -> Node {
    let Node::Map(entries) = file else {
        return file;
    };
    let mut groups: Vec<(String, Node)> = Vec::new();
    for (key, value) in entries {
        let Some((group, name)) = key.split_once('.') else {
            groups.push((key, value));
            continue;
        };
        let entry = (name.to_owned(), value);
        let is_group =
            |(key, value): &&mut (String, Node)| key == group && matches!(value, Node::Map(_));
        match groups.iter_mut().find(is_group) {
            Some((_, Node::Map(entries))) => entries.push(entry),
            _ => groups.push((group.to_owned(), Node::Map(vec![entry]))),
        }
    }
    Node::Map(groups)
}

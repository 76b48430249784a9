//! Parses `ost.txt` and `ost.ini` of ROS's `camera_calibration`: sections in brackets, and names
//! with their numbers on the lines below.

use super::Node;
use crate::calibration::{self, CalibrationError};

/// Returns true if a text contains the section with which each such file begins.
pub(super) fn is_ini(text: &str) -> bool {
    text.lines().any(|line| line.trim() == "[image]")
}

/// Parses a file.
///
/// # Errors
/// The lens has four coefficients, although these files do not name its model.
pub(super) fn read(text: &str) -> Result<Node, CalibrationError> {
    let mut file: Vec<(String, Node)> = Vec::new();
    for line in text.lines().map(str::trim) {
        let section = (line.strip_prefix('[')).and_then(|line| line.strip_suffix(']'));
        if line.is_empty() || line.starts_with('#') {
        } else if let Some(section) = section {
            file.push((section.to_owned(), Node::Map(Vec::new())));
        } else if let Some((_, Node::Map(entries))) = file.last_mut() {
            let is_name = line.starts_with(|c: char| c.is_ascii_alphabetic());
            match entries.last_mut() {
                Some((_, Node::List(numbers))) if !is_name => {
                    let words = line.split_whitespace();
                    numbers.extend(words.map(|word| Node::Scalar(word.to_owned())));
                }
                _ => entries.push((line.to_owned(), Node::List(Vec::new()))),
            }
        }
    }
    let sections = file.iter_mut().filter_map(|(_, section)| match section {
        Node::Map(entries) => Some(entries),
        _ => None,
    });
    for (key, value) in sections.flatten() {
        let Node::List(numbers) = value else { continue };
        match numbers.len() {
            1 => *value = numbers.remove(0),
            4 if key == "distortion" => {
                return calibration::wrong(
                    key,
                    "four coefficients may be a fisheye's or not, and this file does not name the lens model: give the \
                     ost.yaml that was written with it",
                );
            }
            _ => {}
        }
    }
    Ok(Node::Map(file))
}

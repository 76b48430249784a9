//! Reads calibration files. OpenCV, ROS, Kalibr, SLAM programs and users' scripts give the same few
//! numbers different names.
//!
//! A file of any format is parsed to a tree ([`document`]). `cameras` finds the maps of the tree
//! that contain a camera; `matrix`, `lens` and `size` read the numbers of one. [`READ`] lists the
//! supported files.

mod cameras;
mod lens;
mod matrix;
mod names;
mod size;

use crate::camera::{Camera, CameraError};
use crate::document::{self, Node};
use cameras::Found;
pub use names::READ;
use names::{MATRIX_NAMES, squeezed};
use thiserror::Error;

/// Why a file is not a calibration.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// The text is too long.
    #[error(
        "it is longer than 1 MiB: a calibration file has some kilobytes; is it the right file?"
    )]
    TooLarge,
    /// The text is not YAML.
    #[error(
        "this is not YAML ({0}): give the file as OpenCV's FileStorage or ROS's camera_calibration wrote it"
    )]
    Yaml(String),
    /// The text is not XML.
    #[error("it begins as XML and is not ({0}): give the file as OpenCV's FileStorage wrote it")]
    Xml(String),
    /// The text contains a reference.
    #[error("line {0}: references (*name) are not read: write the value out")]
    Alias(usize),
    /// Maps or lists are nested too deeply.
    #[error(
        "line {0}: maps and lists are nested too deeply for a calibration: is it the right file?"
    )]
    TooDeep(usize),
    /// The text is empty.
    #[error("there is nothing in it: give a file with camera_matrix and distortion_coefficients")]
    Empty,
    /// A required key is missing.
    #[error(
        "it has no {0} (names looked for: {1}): add it, or give the whole file that the calibration wrote"
    )]
    Missing(&'static str, &'static str),
    /// A key has an invalid value.
    #[error("{key}: {why}")]
    Value {
        /// The key as written in the file.
        key: String,
        /// The error, and what to write instead.
        why: String,
    },
    /// The numbers do not describe a camera.
    #[error("camera matrix: {0}")]
    Camera(#[from] CameraError),
}

/// Maximum number of values in an entry: more than four times the 14 coefficients of OpenCV's
/// largest lens model.
const MOST_NUMBERS: usize = 64;

/// The entry that identifies a map as a camera.
pub(crate) const MATRIX: &str = "camera matrix";

/// Reads the first camera of a text. Also returns a sentence about the other cameras, if there are
/// any.
pub(crate) fn read(text: &str) -> Result<(Camera, Option<String>), CalibrationError> {
    let file = document::read(text)?;
    let found = cameras::cameras(&file);
    let first = first(&found)?;
    let notice = (found.len() > 1).then(|| {
        format!(
            "it has {} cameras ({}), and {} is used: for another one, give a file with that camera alone",
            found.len(),
            listed(&found),
            first.name
        )
    });
    Ok((camera_of(first)?, notice))
}

/// Reads the first camera of a file.
pub(crate) fn camera(file: &Node) -> Result<Camera, CalibrationError> {
    camera_of(first(&cameras::cameras(file))?)
}

fn first<'f, 'n>(found: &'f [Found<'n>]) -> Result<&'f Found<'n>, CalibrationError> {
    found
        .first()
        .ok_or(CalibrationError::Missing(MATRIX, MATRIX_NAMES))
}

fn listed(found: &[Found]) -> String {
    let names = found.iter().map(|found| match found.topic() {
        Some(topic) => format!("{} of {topic}", found.name),
        None => found.name.clone(),
    });
    names.collect::<Vec<_>>().join(", ")
}

fn camera_of(found: &Found) -> Result<Camera, CalibrationError> {
    let (focal_px, center_px) = matrix::read(found)?;
    let lens = lens::read(found)?;
    let size = size::size(found)?;
    let camera = Camera::new(focal_px, center_px, lens, size)?;
    match size::crop(found, size)? {
        Some(crop) => Ok(camera.cropped(crop)?),
        None => Ok(camera),
    }
}

/// Finds the first of these names in a map, in any case and with or without underscores, hyphens
/// and spaces.
pub(crate) fn find<'a>(file: &'a Node, names: &[&str]) -> Option<(&'a str, &'a Node)> {
    (names.iter()).find_map(|name| file.get(|key| squeezed(key).eq(name.chars())))
}

pub(crate) fn wrong<T>(key: &str, why: impl Into<String>) -> Result<T, CalibrationError> {
    Err(CalibrationError::Value {
        key: key.to_owned(),
        why: why.into(),
    })
}

/// Returns the numbers of an entry: a matrix with `data`, a list, or a list of rows.
pub(crate) fn numbers(key: &str, value: &Node) -> Result<Vec<f64>, CalibrationError> {
    let list = match value {
        Node::Map(_) => match value.get(|name| name == "data") {
            Some((_, data)) => data,
            None => return wrong(key, "a matrix has its numbers under data: [ … ]"),
        },
        other => other,
    };
    let Node::List(entries) = list else {
        return wrong(key, "write its numbers as a list: [ … ]");
    };
    let rows = entries.iter().flat_map(|entry| match entry {
        Node::List(row) => &row[..],
        other => std::slice::from_ref(other),
    });
    let mut numbers = Vec::new();
    for entry in rows {
        if numbers.len() == MOST_NUMBERS {
            return wrong(key, "it has far too many numbers");
        }
        match number(entry) {
            Some(number) => numbers.push(number),
            None => return wrong(key, format!("{} is not a finite number", shown(entry))),
        }
    }
    Ok(numbers)
}

pub(crate) fn number(node: &Node) -> Option<f64> {
    let Node::Scalar(text) = node else {
        return None;
    };
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

/// A value, shortened for use in a sentence.
fn shown(node: &Node) -> String {
    match node {
        Node::Scalar(text) => {
            let short: String = text.chars().filter(|c| !c.is_control()).take(24).collect();
            format!("\"{short}\"")
        }
        _ => "a map or a list".to_owned(),
    }
}

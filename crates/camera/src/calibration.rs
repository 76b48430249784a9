//! What a calibration file says: the names that OpenCV's samples, its users' scripts and ROS give the same few numbers.

use crate::camera::{Camera, CameraError};
use crate::lens::Lens;
use crate::yaml::{self, Node};
use thiserror::Error;

/// Why a file is no calibration.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CalibrationError {
    /// Too long a text.
    #[error(
        "it is longer than 1 MiB: a calibration file has some kilobytes; is it the right file?"
    )]
    TooLarge,
    /// No YAML.
    #[error(
        "it is no YAML ({0}): give the file as OpenCV's FileStorage or ROS's camera_calibration wrote it"
    )]
    Yaml(String),
    /// A reference.
    #[error("line {0}: references (*name) are not read: write the value out")]
    Alias(usize),
    /// Too deeply nested.
    #[error(
        "line {0}: maps and lists are nested too deeply for a calibration: is it the right file?"
    )]
    TooDeep(usize),
    /// Nothing there.
    #[error("there is nothing in it: give a file with camera_matrix and distortion_coefficients")]
    Empty,
    /// A key that must be there.
    #[error(
        "it has no {0}: OpenCV and ROS call it {1}; add it, or give the whole file that they wrote"
    )]
    Missing(&'static str, &'static str),
    /// A key of which the value is something else.
    #[error("{key}: {why}")]
    Value {
        /// The key as it stands there.
        key: String,
        /// What is wrong and what to write.
        why: String,
    },
    /// Numbers that make no camera.
    #[error("camera matrix: {0}")]
    Camera(#[from] CameraError),
}

/// As many numbers as any entry has that is read, and a good many more.
const MOST_NUMBERS: usize = 64;

/// What is missing where there is no camera.
pub(crate) const MATRIX: &str = "camera matrix";

pub(crate) fn read(text: &str) -> Result<Camera, CalibrationError> {
    camera(&yaml::read(text)?)
}

pub(crate) fn camera(file: &Node) -> Result<Camera, CalibrationError> {
    let (key, value) = find(file, &["cameramatrix", "k", "intrinsicmatrix"]).ok_or(
        CalibrationError::Missing(MATRIX, "camera_matrix, cameraMatrix or K"),
    )?;
    let (focal_px, center_px) = intrinsics(key, value)?;
    let lens = lens(file)?;
    let size = size(file)?;
    Ok(Camera::new(focal_px, center_px, lens, size)?)
}

/// The entry of one of these names, in whatever case and with or without underscores.
pub(crate) fn find<'a>(file: &'a Node, names: &[&str]) -> Option<(&'a str, &'a Node)> {
    names.iter().find_map(|name| {
        file.get(|key| {
            let letters = key.chars().filter(|c| *c != '_' && *c != '-');
            letters.map(|c| c.to_ascii_lowercase()).eq(name.chars())
        })
    })
}

pub(crate) fn wrong<T>(key: &str, why: impl Into<String>) -> Result<T, CalibrationError> {
    Err(CalibrationError::Value {
        key: key.to_owned(),
        why: why.into(),
    })
}

/// The numbers of an entry: a matrix with `data`, a list, or a list of rows.
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

/// A value as far as it is to be read in a sentence.
fn shown(node: &Node) -> String {
    match node {
        Node::Scalar(text) => {
            let short: String = text.chars().filter(|c| !c.is_control()).take(24).collect();
            format!("\"{short}\"")
        }
        _ => "a map or a list".to_owned(),
    }
}

type Intrinsics = ([f64; 2], [f64; 2]);

fn intrinsics(key: &str, value: &Node) -> Result<Intrinsics, CalibrationError> {
    let numbers = numbers(key, value)?;
    let [fx, skew, cx, below, fy, cy, 0.0, 0.0, 1.0] = numbers[..] else {
        return wrong(
            key,
            "a camera matrix is nine numbers, row by row, the last row 0, 0, 1",
        );
    };
    if skew != 0.0 || below != 0.0 {
        return wrong(
            key,
            "a camera with skewed pixels is not known here (nor to OpenCV's undistortPoints): its second and fourth \
             numbers must be 0",
        );
    }
    Ok(([fx, fy], [cx, cy]))
}

/// The lens: its model by name, else by how many coefficients there are.
fn lens(file: &Node) -> Result<Lens, CalibrationError> {
    let model = find(file, &["distortionmodel", "cameramodel"]);
    let fisheye_flag = find(file, &["fisheyemodel"]);
    let coefficients = find(
        file,
        &["distortioncoefficients", "distcoeffs", "distcoefs", "d"],
    );
    let (key, numbers) = match coefficients {
        Some((key, value)) => (key, numbers(key, value)?),
        None => {
            return Err(CalibrationError::Missing(
                "distortion coefficients (a list of 0 for a lens without distortion)",
                "distortion_coefficients, distCoeffs or D",
            ));
        }
    };
    if numbers.iter().any(|c| c.abs() > 1e6) {
        return wrong(key, "invalid coefficient above a million: look at the file");
    }
    let name = match model {
        Some((_, Node::Scalar(name))) => name.trim().to_ascii_lowercase(),
        Some((key, _)) => return wrong(key, MODELS),
        None => String::new(),
    };
    let flagged = fisheye_flag.is_some_and(|(_, flag)| number(flag).is_some_and(|x| x != 0.0));
    match &name[..] {
        "equidistant" | "fisheye" | "kannala_brandt" => fisheye(key, &numbers),
        "" if flagged => fisheye(key, &numbers),
        ""
        | "plumb_bob"
        | "rational_polynomial"
        | "thin_prism"
        | "pinhole"
        | "brown_conrady"
        | "radtan"
        | "none" => brown(key, &numbers),
        _ => wrong(model.map_or("", |(key, _)| key), MODELS),
    }
}

const MODELS: &str =
    "the lens models are plumb_bob (Brown-Conrady), rational_polynomial and equidistant (fisheye)";

fn brown(key: &str, numbers: &[f64]) -> Result<Lens, CalibrationError> {
    if ![0, 4, 5, 8, 12, 14].contains(&numbers.len()) {
        let why = format!(
            "{} coefficients are none of OpenCV's sets: 4, 5, 8, 12 or 14 (k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty), or \
             none",
            numbers.len()
        );
        return wrong(key, why);
    }
    Lens::brown_conrady(numbers).map_or_else(|| wrong(key, UNUSABLE), Ok)
}

fn fisheye(key: &str, numbers: &[f64]) -> Result<Lens, CalibrationError> {
    let Ok(coefficients) = numbers.try_into() else {
        let why = format!(
            "a fisheye lens has 4 coefficients, and there are {}",
            numbers.len()
        );
        return wrong(key, why);
    };
    Lens::fisheye(coefficients).map_or_else(|| wrong(key, UNUSABLE), Ok)
}

const UNUSABLE: &str =
    "with these coefficients the picture folds over in its very middle: calibrate anew";

fn size(file: &Node) -> Result<Option<[u32; 2]>, CalibrationError> {
    let width = find(file, &["imagewidth", "width"]);
    let height = find(file, &["imageheight", "height"]);
    let side = |(key, value): (&str, &Node)| match number(value) {
        Some(side) if side.fract() == 0.0 && (1.0..=65_535.0).contains(&side) => Ok(side as u32),
        _ => wrong(
            key,
            format!("{} is no number of pixels from 1 to 65535", shown(value)),
        ),
    };
    match (width, height) {
        (Some(width), Some(height)) => Ok(Some([side(width)?, side(height)?])),
        (None, None) => Ok(None),
        (Some((key, _)), None) | (None, Some((key, _))) => {
            wrong(key, "give both image_width and image_height, or neither")
        }
    }
}

//! Reads the lens. The file names its model, or the number of coefficients determines it.

use super::cameras::Found;
use super::names::{COEFFICIENT_NAMES, COEFFICIENTS, FISHEYE_FLAG, INTRINSICS, LOOSE_MODEL, MODEL};
use super::{CalibrationError, find, matrix, number, numbers, shown, squeezed, wrong};
use crate::document::Node;
use crate::lens::Lens;

/// A family of lens models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Model {
    /// Brown and Conrady's polynomial, as in OpenCV.
    Brown,
    /// The same polynomial, with its coefficients in another order or applied in the opposite
    /// direction, which OpenCV does not have. It is accepted only if there is no distortion.
    BrownVariant,
    /// Kannala and Brandt's polynomial in the angle.
    Fisheye,
    /// No distortion.
    Ideal,
    /// A projection whose distortion model is named elsewhere.
    Pinhole,
}

const MODELS: &str = "the lens models are plumb_bob (radtan, Brown-Conrady), rational_polynomial and equidistant (fisheye, \
                      Kannala-Brandt)";

/// Returns the model with this name; `None` if it is not supported.
fn model(name: &str) -> Option<Model> {
    let name: String = squeezed(name).collect();
    // librealsense's Python bindings prefix the names.
    Some(match name.strip_prefix("distortion.").unwrap_or(&name) {
        "plumbbob" | "radtan" | "radialtangential" | "radtan5" | "radtan8" | "brownconrady"
        | "brown" | "opencv" | "fullopencv" | "rationalpolynomial" | "rational" | "thinprism"
        | "pinholeradtan" | "pinholeradtan8" => Model::Brown,
        "inversebrownconrady" | "modifiedbrownconrady" => Model::BrownVariant,
        "equidistant" | "fisheye" | "kannalabrandt" | "kannalabrandt4" | "kannalabrandt8"
        | "kb4" | "kb8" | "opencvfisheye" | "equi" | "pinholeequi" | "1" => Model::Fisheye,
        "none" | "rectified" | "nodistortion" => Model::Ideal,
        "" | "pinhole" | "perspective" | "simplepinhole" | "0" => Model::Pinhole,
        _ => return None,
    })
}

pub(super) fn read(found: &Found) -> Result<Lens, CalibrationError> {
    if let Some((key, _)) = found.own(&["xi", "mirrorparameters"]) {
        return wrong(
            key,
            format!("cameras with a mirror (omni, Mei) are not read: {MODELS}"),
        );
    }
    let entry = found.own(&COEFFICIENTS);
    let model = named(found, entry.map(|(_, value)| value))?;
    let (key, coefficients) = match entry {
        Some((key, value)) => (key, Some(coefficients(key, value, model)?)),
        None => {
            let intrinsics = found.own(&INTRINSICS).map(|(_, value)| value);
            let maps = intrinsics.into_iter().chain([found.map()]);
            let singles = maps
                .filter_map(|map| singles(map, model).transpose())
                .next();
            ("k1, k2, …", singles.transpose()?)
        }
    };
    match (model, coefficients) {
        (Some((_, Model::Ideal)), None) => Ok(Lens::IDEAL),
        // Open3D's cameras have no distortion, and only Open3D writes the matrix column by column.
        (None, None) if matrix::is_by_columns(found) => Ok(Lens::IDEAL),
        (_, None) => Err(CalibrationError::Missing(
            "distortion coefficients (a list of 0 for a lens without distortion)",
            COEFFICIENT_NAMES,
        )),
        (_, Some(numbers)) => lens(key, &numbers, model),
    }
}

fn lens(
    key: &str,
    numbers: &[f64],
    model: Option<(&str, Model)>,
) -> Result<Lens, CalibrationError> {
    if numbers.iter().any(|c| c.abs() > 1e6) {
        return wrong(key, "invalid coefficient above a million: look at the file");
    }
    let is_zero = numbers.iter().all(|c| *c == 0.0);
    match model {
        Some((_, Model::Fisheye)) => fisheye(key, numbers),
        Some((_, Model::BrownVariant)) if is_zero => Ok(Lens::IDEAL),
        Some((name, Model::BrownVariant)) => wrong(
            name,
            format!("this variant is read only if all its coefficients are 0: {MODELS}"),
        ),
        Some((name, Model::Ideal)) if !is_zero => wrong(
            name,
            format!("it names no distortion, and {key} has some: name the model. {MODELS}"),
        ),
        _ => brown(key, numbers),
    }
}

/// Returns the model that the file names, with its key; `None` if it names none.
fn named<'a>(
    found: &Found<'a>,
    coefficients: Option<&'a Node>,
) -> Result<Option<(&'a str, Model)>, CalibrationError> {
    let mut names: Vec<(&str, Model)> = Vec::new();
    let inner = coefficients.and_then(|map| find(map, &LOOSE_MODEL));
    let strict = MODEL.iter().filter_map(|name| found.any(&[name]));
    for (key, value) in inner.into_iter().chain(strict) {
        let Node::Scalar(name) = value else {
            return wrong(key, MODELS);
        };
        match model(name.trim()) {
            Some(model) => names.push((key, model)),
            None => return wrong(key, format!("{} is not read: {MODELS}", shown(value))),
        }
    }
    if let Some((key, Node::Scalar(name))) = found.any(&LOOSE_MODEL) {
        let name = name.trim();
        let is_other = [
            "omni",
            "mei",
            "ds",
            "doublesphere",
            "eucm",
            "ucm",
            "fov",
            "ftheta",
            "scaramuzza",
        ];
        if is_other
            .iter()
            .any(|other| squeezed(name).eq(other.chars()))
        {
            return wrong(key, format!("\"{name}\" is not read: {MODELS}"));
        }
        names.extend(model(name).map(|model| (key, model)));
    }
    if let Some((key, flag)) = found.any(&FISHEYE_FLAG)
        && (number(flag).is_some_and(|x| x != 0.0)
            || matches!(flag, Node::Scalar(text) if text.eq_ignore_ascii_case("true")))
    {
        names.push((key, Model::Fisheye));
    }
    names.retain(|(_, model)| *model != Model::Pinhole);
    let Some(&(key, first)) = names.first() else {
        return Ok(None);
    };
    match names.iter().find(|(_, model)| *model != first) {
        None => Ok(Some((key, first))),
        Some((other, _)) => wrong(
            other,
            format!("it contradicts {key}: leave the name of one lens model. {MODELS}"),
        ),
    }
}

fn coefficients(
    key: &str,
    value: &Node,
    model: Option<(&str, Model)>,
) -> Result<Vec<f64>, CalibrationError> {
    if let Some((key, parameters)) = find(value, &["parameters"]) {
        return numbers(key, parameters);
    }
    match singles(value, model)? {
        Some(singles) => Ok(singles),
        None => numbers(key, value),
    }
}

/// Reads coefficients that have separate names, in OpenCV's order; missing ones are 0. `None` if
/// all are missing.
fn singles(map: &Node, model: Option<(&str, Model)>) -> Result<Option<Vec<f64>>, CalibrationError> {
    const BROWN: [&str; 14] = [
        "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4", "tx", "ty",
    ];
    const FISHEYE: [&str; 4] = ["k1", "k2", "k3", "k4"];
    // camodocal numbers them by the power of the angle.
    const CAMODOCAL: [&str; 4] = ["k2", "k3", "k4", "k5"];
    let has = |name: &str| find(map, &[name]).is_some();
    let is_fisheye = matches!(model, Some((_, Model::Fisheye)));
    let names = match is_fisheye {
        true if has("k5") && !has("k1") => &CAMODOCAL[..],
        true => &FISHEYE[..],
        false => &BROWN[..],
    };
    if !["k1", "k2"].into_iter().any(has) {
        return Ok(None);
    }
    let all = names.iter().map(|name| match find(map, &[name]) {
        None => Ok(0.0),
        Some((key, value)) => match number(value) {
            Some(number) => Ok(number),
            None => wrong(key, format!("{} is not a finite number", shown(value))),
        },
    });
    let mut all = all.collect::<Result<Vec<f64>, _>>()?;
    if !is_fisheye {
        // The smallest of OpenCV's sets.
        let used = all
            .iter()
            .rposition(|c| *c != 0.0)
            .map_or(0, |last| last + 1);
        let count = [5, 8, 12, 14].into_iter().find(|count| *count >= used);
        all.truncate(count.unwrap_or(14));
    }
    Ok(Some(all))
}

fn brown(key: &str, numbers: &[f64]) -> Result<Lens, CalibrationError> {
    if ![0, 4, 5, 8, 12, 14].contains(&numbers.len()) {
        let why = format!(
            "{} coefficients are not one of OpenCV's sets: 4, 5, 8, 12 or 14 (k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tx ty), or \
             none",
            numbers.len()
        );
        return wrong(key, why);
    }
    Lens::brown_conrady(numbers).map_or_else(|| wrong(key, UNUSABLE), Ok)
}

/// Reads fisheye coefficients. Drivers whose messages always have five coefficients write a 0 after
/// the four fisheye coefficients.
fn fisheye(key: &str, numbers: &[f64]) -> Result<Lens, CalibrationError> {
    let (first, rest) = numbers.split_at(numbers.len().min(4));
    match (<[f64; 4]>::try_from(first), rest.iter().all(|c| *c == 0.0)) {
        (Ok(coefficients), true) => {
            Lens::fisheye(coefficients).map_or_else(|| wrong(key, UNUSABLE), Ok)
        }
        _ => wrong(
            key,
            format!(
                "a fisheye lens has 4 coefficients, and there are {}",
                numbers.len()
            ),
        ),
    }
}

const UNUSABLE: &str =
    "with these coefficients the image folds over in its very middle: calibrate again";

//! Reads focal lengths and principal point.

use super::cameras::{Found, is_matrix};
use super::names::{CX, CY, FX, FY, INTRINSICS, MATRIX, MATRIX_NAMES};
use super::{CalibrationError, find, number, numbers, shown, wrong};
use crate::document::Node;

type Intrinsics = ([f64; 2], [f64; 2]);

pub(super) fn read(found: &Found) -> Result<Intrinsics, CalibrationError> {
    let loose = || found.own(&INTRINSICS).filter(|(_, value)| is_matrix(value));
    let (key, intrinsics) = match found.own(&MATRIX) {
        Some((key, value)) if find(value, &FX).is_some() => (key, scalars(value)?),
        Some((key, value)) => (key, nine(key, value)?),
        None => match loose() {
            Some((key, value)) if find(value, &FX).is_some() => (key, scalars(value)?),
            Some((key, value)) => (key, four_or_nine(key, value)?),
            None => ("fx, fy, cx, cy", scalars(found.map())?),
        },
    };
    let [cx, cy] = intrinsics.1;
    // No camera has its principal point within its first pixel.
    if (0.0..1.0).contains(&cx) && (0.0..1.0).contains(&cy) && (cx, cy) != (0.0, 0.0) {
        return wrong(
            key,
            format!(
                "the principal point ({cx}, {cy}) is a share of the image: multiply the first numbers by the width and the \
                 second ones by the height, for pixels"
            ),
        );
    }
    Ok(intrinsics)
}

fn four_or_nine(key: &str, value: &Node) -> Result<Intrinsics, CalibrationError> {
    match numbers(key, value)?[..] {
        [fx, fy, cx, cy] => Ok(([fx, fy], [cx, cy])),
        [_, _, _, _, _, _, _, _, _] => nine(key, value),
        ref others => wrong(
            key,
            format!(
                "it has {} numbers: a pinhole camera has 4 (fu, fv, cu, cv), or 9 as a matrix; other projections (omni, ds, \
                 eucm) are not read: calibrate with the pinhole model",
                others.len()
            ),
        ),
    }
}

/// Reads a matrix row by row or, if the last column is 0, 0, 1, column by column, as Open3D writes
/// it.
fn nine(key: &str, value: &Node) -> Result<Intrinsics, CalibrationError> {
    let numbers = numbers(key, value)?;
    let (focal_px, center_px, skew, below) = match numbers[..] {
        [fx, skew, cx, below, fy, cy, 0.0, 0.0, 1.0] => ([fx, fy], [cx, cy], skew, below),
        [fx, below, 0.0, skew, fy, 0.0, cx, cy, 1.0] => ([fx, fy], [cx, cy], skew, below),
        _ => {
            return wrong(
                key,
                "a camera matrix is nine numbers, row by row, the last row 0, 0, 1",
            );
        }
    };
    if skew != 0.0 || below != 0.0 {
        return wrong(
            key,
            "a camera with skewed pixels is not known here (nor to OpenCV's undistortPoints): its second and fourth \
             numbers must be 0",
        );
    }
    Ok((focal_px, center_px))
}

/// Returns true if the matrix is written column by column.
pub(super) fn is_by_columns(found: &Found) -> bool {
    let matrix = found.own(&MATRIX).map(|(key, value)| numbers(key, value));
    matches!(matrix, Some(Ok(numbers)) if matches!(numbers[..], [_, _, 0.0, _, _, 0.0, _, _, 1.0]))
}

/// Reads numbers that have separate names.
fn scalars(map: &Node) -> Result<Intrinsics, CalibrationError> {
    let one = |names: &[&str]| match find(map, names) {
        None => Err(CalibrationError::Missing(super::MATRIX, MATRIX_NAMES)),
        Some((key, value)) => match number(value) {
            Some(number) => Ok(number),
            None => wrong(key, format!("{} is not a finite number", shown(value))),
        },
    };
    if let Some((key, skew)) = find(map, &["skew"])
        && number(skew).is_none_or(|skew| skew != 0.0)
    {
        return wrong(
            key,
            "a camera with skewed pixels is not known here: it must be 0",
        );
    }
    Ok(([one(&FX)?, one(&FY)?], [one(&CX)?, one(&CY)?]))
}

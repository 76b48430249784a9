//! Reads the size of the images, and the part of the sensor that the images show.

use super::cameras::Found;
use super::names::{HEIGHT, SIZE, WIDTH};
use super::{CalibrationError, find, number, numbers, shown, wrong};
use crate::camera::Crop;
use crate::document::Node;

pub(super) fn size(found: &Found) -> Result<Option<[u32; 2]>, CalibrationError> {
    let side = |(key, value): (&str, &Node)| match number(value) {
        Some(side) if is_side(side) => Ok(side as u32),
        _ => wrong(
            key,
            format!("{} is not a number of pixels from 1 to 65535", shown(value)),
        ),
    };
    if let Some((key, value)) = found.any(&SIZE) {
        return match numbers(key, value)?[..] {
            [width, height] if is_side(width) && is_side(height) => {
                Ok(Some([width as u32, height as u32]))
            }
            _ => wrong(key, "a size is two numbers of pixels: [ width, height ]"),
        };
    }
    match (found.any(&WIDTH), found.any(&HEIGHT)) {
        (Some(width), Some(height)) => Ok(Some([side(width)?, side(height)?])),
        (None, None) => Ok(None),
        (Some((key, _)), None) | (None, Some((key, _))) => {
            wrong(key, "give both image_width and image_height, or neither")
        }
    }
}

fn is_side(side: f64) -> bool {
    side.fract() == 0.0 && (1.0..=65_535.0).contains(&side)
}

/// Reads the region of interest and the binning of a `sensor_msgs/CameraInfo`; `None` if the images
/// show the whole sensor.
///
/// The matrix in such a message is for the whole, unbinned sensor. A region of 0×0 pixels and a
/// binning of 0 mean the whole sensor. A `roi` that is a list is something else:
/// `cv2.getOptimalNewCameraMatrix` uses the name for the valid part of its result.
pub(super) fn crop(
    found: &Found,
    size: Option<[u32; 2]>,
) -> Result<Option<Crop>, CalibrationError> {
    let whole = |map: &Node, name: &str| match find(map, &[name]) {
        None => Ok(0),
        Some((key, value)) => match number(value) {
            Some(number) if number == 0.0 || is_side(number) => Ok(number as u32),
            _ => wrong(
                key,
                format!("{} is not a number of pixels from 0 to 65535", shown(value)),
            ),
        },
    };
    let binning = [
        whole(found.map(), "binningx")?,
        whole(found.map(), "binningy")?,
    ];
    let binning = binning.map(|pixels| pixels.max(1));
    let region = match found.own(&["roi"]) {
        Some((key, map @ Node::Map(_))) => {
            let offset = [whole(map, "xoffset")?, whole(map, "yoffset")?];
            Some((key, offset, [whole(map, "width")?, whole(map, "height")?]))
        }
        _ => None,
    };
    let region = region.filter(|(_, offset, sides)| (*offset, *sides) != ([0; 2], [0; 2]));
    let (offset, region) = match (region, size) {
        (Some((key, offset, sides)), size) => {
            let is_inside = |i: usize| {
                sides[i] > 0
                    && size.is_none_or(|size| offset[i].saturating_add(sides[i]) <= size[i])
            };
            if !is_inside(0) || !is_inside(1) {
                return wrong(
                    key,
                    format!(
                        "a region of {}×{} pixels at ({}, {}) is no part of the image: give x_offset, y_offset, width and \
                         height, or remove it",
                        sides[0], sides[1], offset[0], offset[1]
                    ),
                );
            }
            (offset, sides)
        }
        (None, Some(size)) if binning != [1, 1] => ([0; 2], size),
        (None, _) => return Ok(None),
    };
    Ok(Some(Crop {
        offset,
        region,
        binning,
        is_part: size.is_none_or(|size| size != region),
    }))
}

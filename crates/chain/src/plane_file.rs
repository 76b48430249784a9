//! `plane.toml`: the plane on which the rope lies, written by `lariat calibrate plane` or by a
//! user.
//!
//! The file contains a homography or a pose. A homography maps ideal pixels to millimeters. It
//! comes with the image size and, if the images were undistorted, the intrinsics of the camera. A
//! pose consists of `rotation` (a Rodrigues vector or three rows) and `translation_mm` or
//! `translation_m`.

use crate::settings::number_text;
use anyhow::{Context, Result, bail};
use lariat_camera::{Camera, LEAST_MM, Mapping, Plane};
use serde::Deserialize;
use std::f64::consts::TAU;
use std::path::Path;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    homography: Option<[[f64; 3]; 3]>,
    image_size: Option<[u32; 2]>,
    /// Focal lengths and principal point of the camera whose images were undistorted, px.
    undistorted_by: Option<[f64; 4]>,
    rotation: Option<Rotation>,
    translation_mm: Option<[f64; 3]>,
    translation_m: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Rotation {
    Vector([f64; 3]),
    Rows([[f64; 3]; 3]),
}

/// Reads the plane from a file.
///
/// # Errors
/// Returns an error if the file is unreadable or invalid, or if it does not contain exactly one of
/// homography and pose. A pose without a camera is an error, too.
pub fn read(path: &Path, camera: Option<&Camera>) -> Result<Plane> {
    let shown = path.display();
    let text = crate::bounded::read_text(path).with_context(|| {
        format!("cannot read the plane {shown}: `lariat calibrate plane` makes one")
    })?;
    parse(&text, camera).with_context(|| shown.to_string())
}

fn parse(text: &str, camera: Option<&Camera>) -> Result<Plane> {
    let file: File = toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        let message = error.message().replace('\n', ", ");
        anyhow::anyhow!(
            "line {line}: {message}. A plane has homography (three rows of three numbers), image_size and undistorted_by, or \
             rotation and translation_mm (or translation_m)"
        )
    })?;
    let translation = match (file.translation_mm, file.translation_m) {
        (Some(_), Some(_)) => bail!("give translation_mm or translation_m, not both"),
        (Some(mm), None) => Some(in_plausible_mm(mm)?),
        (None, m) => m.map(|m| m.map(|c| 1000.0 * c)),
    };
    let plane = match (file.homography, file.rotation, translation) {
        (Some(homography), None, None) => {
            let mut plane = Plane::from_homography(homography)?;
            if let Some(intrinsics) = file.undistorted_by {
                plane = plane.undistorted_by(intrinsics);
            }
            plane
        }
        (None, Some(rotation), Some(translation)) => {
            let Some(camera) = camera else {
                bail!(
                    "a pose needs the camera's matrix: name its calibration too (--calibration FILE)"
                );
            };
            match rotation {
                Rotation::Vector(vector) if length(vector) > TAU => bail!(
                    "rotation = {vector:?} is more than a full turn: it is a vector of Rodrigues in radians, as cv2.solvePnP \
                     gives it"
                ),
                Rotation::Vector(vector) => Plane::from_pose(vector, translation, camera)?,
                Rotation::Rows(rows) => Plane::from_rotation(rows, translation, camera)?,
            }
        }
        _ => bail!(
            "a plane is either a homography, or a pose of both rotation and translation_mm: `lariat calibrate plane` writes \
             the former"
        ),
    };
    Ok(match file.image_size {
        Some(size) if size.contains(&0) => {
            bail!("image_size = {size:?}: both sides must be at least 1")
        }
        Some(size) => {
            let plane = plane.in_images_of(size);
            check_scale(&plane, camera, size)?;
            plane
        }
        None => plane,
    })
}

/// Checks that a translation can be in millimeters.
///
/// # Errors
/// Returns an error if it is shorter than the distance of any camera from a table. It is probably
/// in meters.
fn in_plausible_mm(translation: [f64; 3]) -> Result<[f64; 3]> {
    let size = length(translation);
    if size < LEAST_MM {
        bail!(
            "translation_mm = {translation:?} puts the table {size:.3} mm before the camera: name it translation_m if it is in metres"
        );
    }
    Ok(translation)
}

fn length(vector: [f64; 3]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Checks the scale of a homography.
///
/// # Errors Returns an error if the images show less of the table than any camera's images do. The
/// homography is probably in meters.
fn check_scale(plane: &Plane, camera: Option<&Camera>, size: [u32; 2]) -> Result<()> {
    // Another check reports if camera and plane do not fit the frames.
    let Ok(mapping) = Mapping::new(camera, Some(plane), size) else {
        return Ok(());
    };
    let [width, height] = size.map(f64::from);
    let Ok(middle) = mapping.place([0.5 * width, 0.5 * height]) else {
        return Ok(());
    };
    let longest = middle
        .jacobian
        .as_flattened()
        .iter()
        .fold(0.0_f64, |longest, d| longest.max(d.abs()));
    let shown_mm = longest * width.max(height);
    if shown_mm < LEAST_MM {
        bail!(
            "the images would show {shown_mm:.3} mm of the table: the homography must give millimetres, so multiply the first two \
             rows of one in metres by 1000"
        );
    }
    Ok(())
}

/// Returns the text of a plane's file.
pub fn text(
    homography: [[f64; 3]; 3],
    image_size: [u32; 2],
    camera: Option<&Camera>,
    about: &str,
) -> String {
    let numbers = |numbers: &[f64]| {
        numbers
            .iter()
            .map(|x| number_text(*x))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let rows = homography.map(|row| format!("    [{}],\n", numbers(&row)));
    let mut text = format!(
        "# {about}\n# From pixels to millimetres; the third coordinate is positive where the table is.\nhomography = [\n{}]\n\
         image_size = [{}, {}]\n",
        rows.concat(),
        image_size[0],
        image_size[1]
    );
    if let Some(camera) = camera {
        let ([fx, fy], [cx, cy]) = (camera.focal_px(), camera.center_px());
        text.push_str(&format!(
            "# The pixels are those of this camera without its lens's distortion: fx, fy, cx, cy.\nundistorted_by = [{}]\n",
            numbers(&[fx, fy, cx, cy])
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: [[f64; 3]; 3] = [
        [0.9, 0.1, -200.0],
        [-0.05, 1.3, -300.0],
        [1e-4, 1e-3, 1.0 / 3.0],
    ];

    fn camera() -> Camera {
        Camera::from_yaml("K: [600, 0, 320, 0, 600.5, 240, 0, 0, 1]\nD: [0.1, 0, 0, 0]").unwrap()
    }

    #[test]
    fn what_is_written_is_read_to_the_last_bit() {
        let plane = parse(
            &text(H, [640, 480], Some(&camera()), "Made by a test."),
            Some(&camera()),
        )
        .unwrap();
        assert_eq!(plane.homography(), H);
        assert!(Mapping::new(Some(&camera()), Some(&plane), [640, 480]).is_ok());
        assert!(Mapping::new(None, Some(&plane), [640, 480]).is_err());
        assert!(Mapping::new(Some(&camera()), Some(&plane), [640, 360]).is_err());
    }

    #[test]
    fn a_pose_may_be_a_vector_or_three_rows() {
        let vector = parse(
            "rotation = [0, 0, 0]\ntranslation_mm = [1, 2, 500]",
            Some(&camera()),
        )
        .unwrap();
        let rows = "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\ntranslation_mm = [1, 2, 500]";
        assert_eq!(parse(rows, Some(&camera())).unwrap(), vector);
        assert!(
            parse(rows, None)
                .unwrap_err()
                .to_string()
                .contains("--calibration")
        );
    }

    #[test]
    fn a_translation_may_be_in_metres_by_name() {
        let read = |translation: &str| {
            parse(
                &format!("rotation = [0.1, 0, 0]\n{translation}"),
                Some(&camera()),
            )
            .unwrap()
        };
        assert_eq!(
            read("translation_m = [0.01, -0.02, 0.5]"),
            read("translation_mm = [10, -20, 500]")
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, words) in [
            ("", "either a homography, or a pose"),
            ("homography = [[1, 2], [3, 4]]", "line 1"),
            ("\nhomografy = 3", "line 2: unknown field"),
            (
                "homography = [[1, 2, 3], [2, 4, 6], [0, 0, 1]]",
                "onto a line or a point",
            ),
            (
                "homography = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\nimage_size = [0, 480]",
                "at least 1",
            ),
            ("rotation = [0, 0, 0]", "either a homography, or a pose"),
            (
                "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\ntranslation_mm = [0, 0, 500]",
                "invalid rotation",
            ),
            (
                "rotation = [178, 2, 0]\ntranslation_mm = [0, 0, 500]",
                "in radians",
            ),
            (
                "rotation = [0, 0, 0]\ntranslation_mm = [0.01, -0.02, 0.5]",
                "name it translation_m",
            ),
            (
                "homography = [[5e-4, 0, -0.1], [0, 5e-4, -0.1], [0, 0, 1]]\nimage_size = [640, 480]",
                "multiply the first two rows",
            ),
        ] {
            let error = format!("{:#}", parse(text, Some(&camera())).unwrap_err());
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}

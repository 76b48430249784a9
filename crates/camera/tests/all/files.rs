//! Calibration files from real tools.

use lariat_camera::{CalibrationError, Camera, Lens};
use proptest::prelude::*;

/// Written by `rosrun camera_calibration`.
const ROS: &str = "image_width: 640
image_height: 480
camera_name: head_camera
camera_matrix:
  rows: 3
  cols: 3
  data: [618.94, 0, 322.7, 0, 619.2, 241.3, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.2, 0.001, -0.002, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [630.1, 0, 322, 0, 0, 631.2, 240, 0, 0, 0, 1, 0]
";

/// Written by OpenCV 2 to 4, with broken lines.
const OPENCV: &str = "%YAML:1.0
---
calibration_time: \"Tue 01 Jul 2025 10:11:12 CEST\"
nframes: 17
image_width: 1280
image_height: 720
flags: 0
fisheye_model: 0
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 9.1e+02, 0., 6.395e+02, 0., 9.1e+02,
       3.595e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -1.1e-01, .25, 0., 0.,
       -1.e-02 ]
avg_reprojection_error: 3.1e-01
";

#[test]
fn a_file_of_ros_is_read_as_it_is() {
    let camera = Camera::from_yaml(ROS).unwrap();
    assert_eq!(camera.focal_px(), [618.94, 619.2]);
    assert_eq!(camera.center_px(), [322.7, 241.3]);
    assert_eq!(camera.size(), Some([640, 480]));
    let lens = Lens::brown_conrady(&[0.1, -0.2, 0.001, -0.002, 0.0]).unwrap();
    assert_eq!(*camera.lens(), lens);
    let fisheye = ROS
        .replace("plumb_bob", "equidistant")
        .replace(", 0]\nrect", "]\nrect");
    let lens = Lens::fisheye([0.1, -0.2, 0.001, -0.002]).unwrap();
    assert_eq!(*Camera::from_yaml(&fisheye).unwrap().lens(), lens);
}

#[test]
fn a_file_of_opencv_is_read_as_it_is() {
    let camera = Camera::from_yaml(OPENCV).unwrap();
    assert_eq!(camera.focal_px(), [910.0; 2]);
    assert_eq!(camera.center_px(), [639.5, 359.5]);
    let lens = Lens::brown_conrady(&[-0.11, 0.25, 0.0, 0.0, -0.01]).unwrap();
    assert_eq!(*camera.lens(), lens);
    let windows = OPENCV.replace('\n', "\r\n");
    assert_eq!(Camera::from_yaml(&windows), Ok(camera));
}

#[test]
fn the_names_of_scripts_and_of_messages_are_understood() {
    let plain =
        Camera::from_yaml("K: [[600, 0, 320], [0, 600, 240], [0, 0, 1]]\nD: [0.1, 0, 0, 0]\n")
            .unwrap();
    assert_eq!((plain.focal_px(), plain.size()), ([600.0; 2], None));
    let message = "height: 480\nwidth: 640\ndistortion_model: plumb_bob\nd: [0.1, 0, 0, 0, 0]\n\
                   k: [600, 0, 320, 0, 600, 240, 0, 0, 1]\n---\n";
    assert_eq!(Camera::from_yaml(message).unwrap().size(), Some([640, 480]));
    let script =
        "cameraMatrix: {data: [600, 0, 320, 0, 600, 240, 0, 0, 1]}\ndistCoeffs: {data: []}\n";
    assert_eq!(*Camera::from_yaml(script).unwrap().lens(), Lens::IDEAL);
}

#[test]
fn what_is_wrong_is_said_with_its_key() {
    let said = |text: &str| Camera::from_yaml(text).unwrap_err().to_string();
    let with = |from: &str, to: &str| said(&ROS.replace(from, to));
    for (sentence, words) in [
        (said(""), "there is nothing in it"),
        (said("a: 1"), "it has no camera matrix"),
        (with("camera_matrix", "camera"), "it has no camera matrix"),
        (
            with("distortion_coefficients", "distortions"),
            "it has no distortion coefficients",
        ),
        (
            with("618.94", "oops"),
            "camera_matrix: \"oops\" is not a finite number",
        ),
        (with("618.94", ".nan"), "camera_matrix: \".nan\" is not"),
        (with("618.94", "NaN"), "camera_matrix: \"NaN\" is not"),
        (with("618.94", "-618.94"), "focal lengths of -618.94"),
        (with("[618.94, 0,", "[618.94, 3,"), "skewed"),
        (with("[618.94, 0,", "[618.94,"), "nine numbers"),
        (
            with("plumb_bob", "double_sphere"),
            "distortion_model: \"double_sphere\" is not read: the lens models are",
        ),
        (
            said(
                &ROS.replace("plumb_bob", "equidistant")
                    .replace("-0.002, 0]", "-0.002, 0.1]"),
            ),
            "has 4 coefficients, and there are 5",
        ),
        (
            with("-0.002, 0]", "-0.002, 0, 1]"),
            "6 coefficients are not one of OpenCV's sets",
        ),
        (with("image_height: 480\n", ""), "image_width: give both"),
        (
            with("image_height: 480", "image_height: 0"),
            "image_height: \"0\" is not a number of pixels",
        ),
        (
            with("image_height: 480", "image_height: [4, 8]"),
            "image_height: a map or a list",
        ),
        (
            with("  data: [618.94", "  date: [618.94"),
            "camera_matrix: a matrix has its numbers under data",
        ),
        (with("[618.94,", "[618.94"), "camera_matrix:"),
        (
            with("camera_name: head_camera", "camera_name: &a 640\nalias: *a"),
            "references",
        ),
        (with("data: [0.1,", "data: [-0.1e9,"), "above a million"),
        (said("{a: [1, 2"), "this is not YAML"),
        (said(&"[".repeat(200)), "nested too deeply"),
        (said(&"x".repeat(1 << 21)), "longer than 1 MiB"),
    ] {
        assert!(sentence.contains(words), "{sentence}");
    }
}

#[test]
fn a_lens_that_folds_in_its_middle_is_refused() {
    let folded = ROS.replace("[0.1, -0.2,", "[-90000, 0,");
    let error = Camera::from_yaml(&folded).unwrap_err();
    assert!(matches!(error, CalibrationError::Value { .. }), "{error}");
}

proptest! {
    #[test]
    fn a_damaged_file_is_read_or_refused(place in 0..ROS.len(), with in ".{0,6}", cut in 0..40usize) {
        let mut text = ROS.to_owned();
        text.replace_range(place..(place + cut).min(ROS.len()), &with);
        let _ = Camera::from_yaml(&text);
    }

    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,200}", marks in "[\\[\\]{}:,&*!|>'\"%#\n -]{0,200}") {
        let _ = (Camera::from_yaml(&text), Camera::from_yaml(&marks));
    }
}

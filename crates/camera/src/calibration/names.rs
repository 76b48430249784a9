//! Names in calibration files, squeezed: in lower case and without underscores, hyphens and spaces.

/// Removes differences in case, underscores, hyphens and spaces from a name.
pub(super) fn squeezed(key: &str) -> impl Iterator<Item = char> {
    let letters = key.chars().filter(|c| !matches!(c, '_' | '-' | ' '));
    letters.map(|c| c.to_ascii_lowercase())
}

/// Names of a camera matrix, whatever its value looks like.
pub(super) const MATRIX: [&str; 7] = [
    "cameramatrix",
    "intrinsicmatrix",
    "mtx",
    "k",
    "camk",
    "cameraintrinsicmatrix",
    "kmatrix",
];
/// Names of a camera matrix, or of focal lengths and principal point, depending on the value.
pub(super) const INTRINSICS: [&str; 5] = [
    "intrinsics",
    "intrinsic",
    "cameraintrinsics",
    "projectionparameters",
    "intrinsicparameters",
];
/// Names of the focal lengths and of both coordinates of the principal point, px.
pub(super) const FX: [&str; 4] = ["fx", "fu", "flx", "mu"];
pub(super) const FY: [&str; 4] = ["fy", "fv", "fly", "mv"];
pub(super) const CX: [&str; 4] = ["cx", "ppx", "cu", "u0"];
pub(super) const CY: [&str; 4] = ["cy", "ppy", "cv", "v0"];
/// Suffixes of names: none for a single camera, or those of the first camera of a pair in one map.
pub(super) const SIDES: [&str; 3] = ["", "1", "left"];
/// Suffixes for the second camera of a pair.
pub(super) const OTHER_SIDES: [&str; 2] = ["2", "right"];

/// Names of lens coefficients.
pub(super) const COEFFICIENTS: [&str; 13] = [
    "distortioncoefficients",
    "distcoeffs",
    "distcoefs",
    "d",
    "dist",
    "distcoeff",
    "distcoef",
    "distortioncoeffs",
    "distortioncoeff",
    "distortion",
    "distortionparameters",
    "distortioncoefs",
    "coeffs",
];
/// Unambiguous keys of a lens model.
pub(super) const MODEL: [&str; 8] = [
    "distortionmodel",
    "cameramodel",
    "modeltype",
    "distortiontype",
    "lensmodel",
    "cameratype",
    "projectionmodel",
    "lenstype",
];
/// Keys that may contain a lens model or something else, such as a product name.
pub(super) const LOOSE_MODEL: [&str; 2] = ["type", "model"];
/// Keys of a flag for a fisheye lens.
pub(super) const FISHEYE_FLAG: [&str; 3] = ["fisheyemodel", "fisheye", "isfisheye"];

/// Names of the images' width, height, or both.
pub(super) const WIDTH: [&str; 3] = ["imagewidth", "width", "w"];
pub(super) const HEIGHT: [&str; 3] = ["imageheight", "height", "h"];
pub(super) const SIZE: [&str; 4] = ["resolution", "imagesize", "imgsize", "imageresolution"];
/// Names of the topic with a camera's images.
pub(super) const TOPIC: [&str; 3] = ["rostopic", "imagetopic", "topic"];

/// Names of a camera matrix, as listed in a sentence.
pub(super) const MATRIX_NAMES: &str =
    "camera_matrix, cameraMatrix, K, mtx, intrinsics, Camera.fx, or fx, fy, cx and cy";
/// Names of coefficients, as listed in a sentence.
pub(super) const COEFFICIENT_NAMES: &str = "distortion_coefficients, distCoeffs, D, dist, distortion_coeffs, distortion, or k1, k2, p1 and p2";

/// Supported calibration files: their writers, their names, their lens models.
pub const READ: [[&str; 3]; 9] = [
    [
        "OpenCV `FileStorage`, YAML, XML or JSON",
        "`camera_matrix`, `distortion_coefficients`, `fisheye_model`; of a stereo pair `cameraMatrix1`, `distCoeffs1`",
        "4, 5, 8, 12 or 14 coefficients; fisheye",
    ],
    [
        "ROS `camera_calibration` (`ost.yaml`, `ost.txt`, `ost.ini`) and `CameraInfo`",
        "`camera_matrix` or `K`, `distortion_coefficients` or `D`, `roi`, `binning_x`",
        "`plumb_bob`, `rational_polynomial`, `equidistant`",
    ],
    [
        "Kalibr's camchain, EuRoC's `sensor.yaml`",
        "`intrinsics: [fu, fv, cu, cv]`, `distortion_coeffs`, `resolution`, `rostopic`",
        "`pinhole` with `radtan`, `radial-tangential`, `equidistant` or `none`",
    ],
    [
        "ORB-SLAM 2 and 3",
        "`Camera.fx` or `Camera1.fx`, `Camera1.k1`, `Camera.type`",
        "`PinHole`, `KannalaBrandt8`, `Rectified`",
    ],
    [
        "VINS, camodocal",
        "`projection_parameters`, `distortion_parameters`, `model_type`",
        "`PINHOLE`, `KANNALA_BRANDT`",
    ],
    [
        "maplab",
        "`intrinsics: {data: …}`, `distortion: {type, parameters}`",
        "`radial-tangential`, `equidistant`",
    ],
    [
        "Python scripts, YAML or JSON",
        "`mtx` and `dist`, `camera_matrix` and `dist_coeff`, rows or nine numbers",
        "by the number of coefficients",
    ],
    [
        "RealSense, Open3D, nerfstudio, DepthAI, Basalt, JSON",
        "`fx`, `ppx`, `coeffs`; `intrinsic_matrix`; `fl_x`; `intrinsicMatrix`, `distortionCoeff`; `intrinsics: {fx, …}`",
        "`brown_conrady`, `OPENCV`, `OPENCV_FISHEYE`, `kb4`",
    ],
    [
        "several cameras in one file",
        "any of these in maps of their own (`cam0`, `left`, …)",
        "the first, with a notice that names the others",
    ],
];

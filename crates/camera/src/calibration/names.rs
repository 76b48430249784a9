//! The names that calibration files use, squeezed: in lower case and without underscores, hyphens and spaces.

/// A name without what files write differently: its case, underscores, hyphens and spaces.
pub(super) fn squeezed(key: &str) -> impl Iterator<Item = char> {
    let letters = key.chars().filter(|c| !matches!(c, '_' | '-' | ' '));
    letters.map(|c| c.to_ascii_lowercase())
}

/// A camera matrix, whatever its value looks like.
pub(super) const MATRIX: [&str; 7] = [
    "cameramatrix",
    "intrinsicmatrix",
    "mtx",
    "k",
    "camk",
    "cameraintrinsicmatrix",
    "kmatrix",
];
/// A camera matrix, or focal lengths and principal point, if the value looks like one.
pub(super) const INTRINSICS: [&str; 5] = [
    "intrinsics",
    "intrinsic",
    "cameraintrinsics",
    "projectionparameters",
    "intrinsicparameters",
];
/// Horizontal and vertical focal lengths, and both coordinates of the principal point, px.
pub(super) const FX: [&str; 4] = ["fx", "fu", "flx", "mu"];
pub(super) const FY: [&str; 4] = ["fy", "fv", "fly", "mv"];
pub(super) const CX: [&str; 4] = ["cx", "ppx", "cu", "u0"];
pub(super) const CY: [&str; 4] = ["cy", "ppy", "cv", "v0"];
/// Endings of the names of a pair of cameras in one map: none for a single camera.
pub(super) const SIDES: [&str; 3] = ["", "1", "left"];
/// The same of the second camera.
pub(super) const OTHER_SIDES: [&str; 2] = ["2", "right"];

/// Coefficients of a lens.
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
/// A lens model by a key that means nothing else.
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
/// A lens model under a key that may hold something else, such as a product name.
pub(super) const LOOSE_MODEL: [&str; 2] = ["type", "model"];
/// A yes or no for a fisheye lens.
pub(super) const FISHEYE_FLAG: [&str; 3] = ["fisheyemodel", "fisheye", "isfisheye"];

/// Images' width, height, or both.
pub(super) const WIDTH: [&str; 3] = ["imagewidth", "width", "w"];
pub(super) const HEIGHT: [&str; 3] = ["imageheight", "height", "h"];
pub(super) const SIZE: [&str; 4] = ["resolution", "imagesize", "imgsize", "imageresolution"];
/// The topic of a camera's images.
pub(super) const TOPIC: [&str; 3] = ["rostopic", "imagetopic", "topic"];

/// The names of a camera matrix, as a sentence lists them.
pub(super) const MATRIX_NAMES: &str =
    "camera_matrix, cameraMatrix, K, mtx, intrinsics, Camera.fx, or fx, fy, cx and cy";
/// Likewise of coefficients.
pub(super) const COEFFICIENT_NAMES: &str = "distortion_coefficients, distCoeffs, D, dist, distortion_coeffs, distortion, or k1, k2, p1 and p2";

/// The calibration files that are read: their writers, their names, their lens models.
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

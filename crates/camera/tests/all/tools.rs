//! Calibration files of tools other than OpenCV's samples and ROS's `camera_calibration`. All
//! describe the same camera.
//!
//! The expected pixels come from `cv2.undistortPoints` (or `cv2.fisheye.undistortPoints`) with `P =
//! K`, iterated to 1e-15, of OpenCV 5.0.0.

use lariat_camera::{Camera, Lens, Mapping, Pose};

/// Two pixels as they are seen, and their places without distortion.
type Points = [[[f64; 2]; 2]; 2];

const SEEN: [[f64; 2]; 2] = [[40.0, 30.0], [600.0, 400.0]];
const RADTAN: Points = [
    [SEEN[0], [-64.619203662, -39.9610790073]],
    [SEEN[1], [630.8310584724, 420.0374375793]],
];
const EQUIDISTANT: Points = [
    [SEEN[0], [-353.9610240525, -267.2207725883]],
    [SEEN[1], [845.9277563188, 539.2060558919]],
];
const PLUMB_BOB: Points = [
    [SEEN[0], [43.9433056486, 32.464566617]],
    [SEEN[1], [597.2456831269, 398.08119159]],
];
const ORB: Points = [
    [SEEN[0], [48.2553399849, 38.3587875536]],
    [SEEN[1], [592.6792471143, 397.4405169877]],
];

#[track_caller]
fn check(text: &str, points: Points, size: Option<[u32; 2]>) {
    let camera = Camera::from_yaml(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(camera.size(), size, "{text}");
    for [seen, ideal] in points {
        let found = camera.undistort(seen).expect("within the lens").point;
        let off = (found[0] - ideal[0]).hypot(found[1] - ideal[1]);
        assert!(off < 1e-6, "{found:?} instead of {ideal:?}\n{text}");
    }
}

const VGA: Option<[u32; 2]> = Some([640, 480]);

#[test]
fn kalibr_and_its_relatives_are_read() {
    let camchain = "cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
  distortion_model: radtan
  intrinsics: [458.654, 457.296, 367.215, 248.375]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
";
    check(camchain, RADTAN, Some([752, 480]));
    let euroc = "sensor_type: camera
T_BS: {cols: 4, rows: 4, data: [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
";
    check(euroc, RADTAN, Some([752, 480]));
    let maplab = "label: \"ncamera\"
cameras:
  - camera:
      label: c0
      image_height: 480
      image_width: 752
      type: pinhole
      intrinsics: {cols: 1, rows: 4, data: [458.654, 457.296, 367.215, 248.375]}
      distortion:
        type: radial-tangential
        parameters: {cols: 1, rows: 4, data: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]}
    T_B_C: {cols: 4, rows: 4, data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
";
    check(maplab, RADTAN, Some([752, 480]));
    let fisheye = "cam0:
  camera_model: pinhole
  distortion_coeffs: [-0.012, 0.021, -0.017, 0.004]
  distortion_model: equidistant
  intrinsics: [285.0, 286.2, 321.4, 242.3]
  resolution: [640, 480]
";
    check(fisheye, EQUIDISTANT, VGA);
    let second = fisheye.replace("cam0", "cam1");
    let (first, notice) = Camera::first_of(&format!("{camchain}{second}")).unwrap();
    assert_eq!(first.focal_px(), [458.654, 457.296]);
    let notice = notice.expect("there are two");
    assert!(
        notice.contains("2 cameras (cam0 of /cam0/image_raw, cam1), and cam0 is used"),
        "{notice}"
    );
    assert_eq!(Camera::first_of(camchain).unwrap().1, None);
}

#[test]
fn slam_programs_files_are_read() {
    let orb = "%YAML:1.0
---
Camera.fx: 517.306408
Camera.fy: 516.469215
Camera.cx: 318.643040
Camera.cy: 255.313989
Camera.k1: 0.262383
Camera.k2: -0.953104
Camera.p1: -0.005358
Camera.p2: 0.002628
Camera.k3: 1.163314
Camera.width: 640
Camera.height: 480
Camera.fps: 30.0
ORBextractor.nFeatures: 1000
";
    check(orb, ORB, VGA);
    let orb3 = orb
        .replace("Camera.", "Camera1.")
        .replace("Camera1.width", "Camera.width")
        .replace("Camera1.height", "Camera.height")
        .replace(
            "---\n",
            "---\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\n",
        );
    check(&orb3, ORB, VGA);
    let fisheye = "Camera.type: \"KannalaBrandt8\"
Camera1.fx: 285.0
Camera1.fy: 286.2
Camera1.cx: 321.4
Camera1.cy: 242.3
Camera1.k1: -0.012
Camera1.k2: 0.021
Camera1.k3: -0.017
Camera1.k4: 0.004
Camera.width: 640
Camera.height: 480
";
    check(fisheye, EQUIDISTANT, VGA);
    let rectified = "Camera.type: \"Rectified\"\nCamera1.fx: 500\nCamera1.fy: 500\nCamera1.cx: 320\nCamera1.cy: 240\n";
    assert_eq!(*Camera::from_yaml(rectified).unwrap().lens(), Lens::IDEAL);
    let vins = "%YAML:1.0
---
model_type: PINHOLE
camera_name: camera
image_width: 752
image_height: 480
distortion_parameters:
   k1: -0.28340811
   k2: 0.07395907
   p1: 0.00019359
   p2: 1.76187114e-05
projection_parameters:
   fx: 458.654
   fy: 457.296
   cx: 367.215
   cy: 248.375
";
    check(vins, RADTAN, Some([752, 480]));
    let camodocal = "model_type: KANNALA_BRANDT
image_width: 640
image_height: 480
projection_parameters:
   k2: -0.012
   k3: 0.021
   k4: -0.017
   k5: 0.004
   mu: 285.0
   mv: 286.2
   u0: 321.4
   v0: 242.3
";
    check(camodocal, EQUIDISTANT, VGA);
}

#[test]
fn scripts_and_json_of_tools_are_read() {
    let mtx = "mtx: [[618.94, 0, 322.7], [0, 619.2, 241.3], [0, 0, 1]]\ndist: [[0.1, -0.2, 0.001, -0.002, 0]]\n";
    check(mtx, PLUMB_BOB, None);
    check(
        &mtx.replace("mtx", "camera_matrix")
            .replace("dist:", "dist_coeff:"),
        PLUMB_BOB,
        None,
    );
    let json = "{\n\t\"camera_matrix\": [[618.94, 0, 322.7], [0, 619.2, 241.3], [0, 0, 1]],\n\t\"dist_coeffs\": [[0.1, -0.2, 0.001, -0.002, 0]],\n\t\
                \"image_size\": [640, 480]\n}\n";
    check(json, PLUMB_BOB, VGA);
    let nerfstudio = "{\"camera_model\": \"OPENCV\", \"fl_x\": 618.94, \"fl_y\": 619.2, \"cx\": 322.7, \"cy\": 241.3, \"w\": 640, \"h\": 480, \
                      \"k1\": 0.1, \"k2\": -0.2, \"p1\": 0.001, \"p2\": -0.002, \"frames\": [{\"file_path\": \"a.png\"}]}";
    check(nerfstudio, PLUMB_BOB, VGA);
    let depthai = "{\"boardName\": \"\", \"cameraData\": [[0, {\"cameraType\": 0, \"distortionCoeff\": [0.1, -0.2, 0.001, -0.002, 0, 0, 0, 0, 0, \
                   0, 0, 0, 0, 0], \"height\": 480, \"width\": 640, \"intrinsicMatrix\": [[618.94, 0, 322.7], [0, 619.2, 241.3], [0, 0, 1]]}]]}";
    check(depthai, PLUMB_BOB, VGA);
    let nested = "camera_matrix: {fx: 618.94, fy: 619.2, cx: 322.7, cy: 241.3}\n\
                  distortion: {k1: 0.1, k2: -0.2, p1: 0.001, p2: -0.002}\nimage_width: 640\nimage_height: 480\n";
    check(nested, PLUMB_BOB, VGA);
    let basalt = "{\"value0\": {\"intrinsics\": [{\"camera_type\": \"kb4\", \"intrinsics\": {\"fx\": 285.0, \"fy\": 286.2, \"cx\": 321.4, \
                  \"cy\": 242.3, \"k1\": -0.012, \"k2\": 0.021, \"k3\": -0.017, \"k4\": 0.004}}], \"resolution\": [[640, 480]]}}";
    check(basalt, EQUIDISTANT, VGA);
    let pinhole = |text: &str| {
        let camera = Camera::from_yaml(text).unwrap();
        assert_eq!(
            (camera.focal_px(), camera.center_px()),
            ([600.0, 601.0], [320.5, 240.5])
        );
        assert_eq!((*camera.lens(), camera.size()), (Lens::IDEAL, VGA));
    };
    pinhole(
        "{\"width\": 640, \"height\": 480, \"ppx\": 320.5, \"ppy\": 240.5, \"fx\": 600, \"fy\": 601, \"model\": \
         \"distortion.inverse_brown_conrady\", \"coeffs\": [0, 0, 0, 0, 0]}",
    );
    pinhole(
        "{\"width\": 640, \"height\": 480, \"intrinsic_matrix\": [600, 0, 0, 0, 601, 0, 320.5, 240.5, 1]}",
    );
    let stereo = "M1: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n\
                  cameraMatrix1: [618.94, 0, 322.7, 0, 619.2, 241.3, 0, 0, 1]\ndistCoeffs1: [0.1, -0.2, 0.001, -0.002, 0]\n\
                  cameraMatrix2: [600, 0, 322.7, 0, 600, 241.3, 0, 0, 1]\ndistCoeffs2: [0, 0, 0, 0]\n";
    check(stereo, PLUMB_BOB, None);
    let notice = Camera::first_of(stereo).unwrap().1.expect("there are two");
    assert!(notice.contains("camera 1, camera 2"), "{notice}");
}

#[test]
fn opencvs_xml_and_the_ini_of_ros_are_read() {
    let xml = "<?xml version=\"1.0\"?>
<opencv_storage>
<calibration_Time>\"Thu 01 Jul 2025\"</calibration_Time>
<image_Width>640</image_Width>
<image_Height>480</image_Height>
<Camera_Matrix type_id=\"opencv-matrix\">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    6.1894e+02 0. 3.227e+02 0. 6.192e+02 2.413e+02 0. 0. 1.</data></Camera_Matrix>
<Distortion_Coefficients type_id=\"opencv-matrix\">
  <rows>5</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    0.1 -2.e-01 1.e-03 -2.e-03 0.</data></Distortion_Coefficients>
</opencv_storage>
";
    check(xml, PLUMB_BOB, VGA);
    let ini = "# oST version 5.0 parameters


[image]

width
640

height
480

[narrow_stereo]

camera matrix
618.940000 0.000000 322.700000
0.000000 619.200000 241.300000
0.000000 0.000000 1.000000

distortion
0.100000 -0.200000 0.001000 -0.002000 0.000000

rectification
1.000000 0.000000 0.000000
0.000000 1.000000 0.000000
0.000000 0.000000 1.000000

projection
630.0 0.000000 322.0 0.000000
0.000000 631.0 240.0 0.000000
0.000000 0.000000 1.000000 0.000000
";
    check(ini, PLUMB_BOB, VGA);
    let fisheye = ini.replace(" -0.002000 0.000000", " -0.002000");
    let refused = Camera::from_yaml(&fisheye).unwrap_err().to_string();
    assert!(refused.contains("give the ost.yaml"), "{refused}");
    let deep = "<a>".repeat(100_000) + &"</a>".repeat(100_000);
    assert!(Camera::from_yaml(&deep).is_err());
    let refused = Camera::from_yaml("<a><b>").unwrap_err().to_string();
    assert!(refused.contains("begins as XML and is not"), "{refused}");
}

#[test]
fn every_spelling_of_a_lens_model_is_understood() {
    let brown = "K: [618.94, 0, 322.7, 0, 619.2, 241.3, 0, 0, 1]\nD: [0.1, -0.2, 0.001, -0.002, 0]\ndistortion_model: ";
    for name in [
        "plumb_bob",
        "Plumb Bob",
        "plumb-bob",
        "radtan",
        "radial-tangential",
        "Brown Conrady",
        "pinhole",
    ] {
        check(&format!("{brown}{name}\n"), PLUMB_BOB, None);
    }
    let fisheye = "K: [285.0, 0, 321.4, 0, 286.2, 242.3, 0, 0, 1]\nD: [-0.012, 0.021, -0.017, 0.004, 0.0]\ndistortion_model: ";
    for name in [
        "equidistant",
        "kannala_brandt4",
        "Kannala_Brandt4",
        "kannala_brandt",
        "kb4",
        "fisheye",
    ] {
        check(&format!("{fisheye}{name}\n"), EQUIDISTANT, None);
    }
}

#[test]
fn cameras_that_are_not_read_are_refused_by_name() {
    let said = |text: &str| Camera::from_yaml(text).unwrap_err().to_string();
    let omni = "cam0:\n  camera_model: omni\n  distortion_coeffs: [0, 0, 0, 0]\n  distortion_model: radtan\n  intrinsics: [1.2, 400, 400, 320, 240]\n";
    let k = "K: [600, 0, 320, 0, 600, 240, 0, 0, 1]\n";
    for (text, words) in [
        (omni.to_owned(), "pinhole camera has 4"),
        (omni.replace("[1.2, ", "["), "\"omni\" is not read: the lens models are"),
        (format!("{k}D: [0.1, 0, 0, 0]\ndistortion_model: fov\n"), "\"fov\" is not read"),
        (format!("{k}D: [0.1, 0, 0, 0, 0]\nmodel: inverse_brown_conrady\n"), "only if all its coefficients are 0"),
        (format!("{k}D: [0.1, 0, 0, 0]\ndistortion_model: none\n"), "names no distortion"),
        (format!("{k}D: [0.1, 0, 0, 0]\ndistortion_model: radtan\nfisheye_model: 1\n"), "contradicts"),
        (format!("{k}D: [0.1, 0, 0, 0, 0.1]\ndistortion_model: equidistant\n"), "4 coefficients, and there are 5"),
        ("fx: 600\nfy: 600\ncx: 320\ncy: 240\n".to_owned(), "no distortion coefficients"),
        ("fx: 0.9\nfy: 1.2\ncx: 0.5\ncy: 0.5\nD: []\n".to_owned(), "is a share of the image"),
        ("camera: {}\n".to_owned(), "names looked for: camera_matrix, cameraMatrix, K, mtx"),
        ("model_type: MEI\nprojection_parameters: {fx: 1, fy: 1, cx: 1, cy: 1}\nmirror_parameters: {xi: 1}\n".to_owned(), "mirror"),
    ] {
        let sentence = said(&text);
        assert!(sentence.contains(words), "{sentence}\n{text}");
    }
}

/// The content of a `CameraInfo` message.
const ROI: &str = "width: 1280\nheight: 960\ndistortion_model: plumb_bob\nD: [-0.28, 0.09, 0, 0, 0]\n\
                   K: [1040, 0, 640, 0, 1042, 480, 0, 0, 1]\nbinning_x: 0\nbinning_y: 0\n\
                   roi: {x_offset: 320, y_offset: 240, height: 480, width: 640, do_rectify: false}\n";

#[test]
fn the_matrix_of_a_region_of_the_sensor_is_moved_by_its_offset() {
    // cv2.undistortPoints with cx = 320, cy = 240.
    let points = [
        [[77.0, 240.0], [73.1778380337, 240.0]],
        [[600.0, 100.0], [607.4438805565, 96.2780597218]],
    ];
    check(ROI, points, VGA);
    // The same pixels, binned two by two and aligned by their edges.
    let binned = ROI
        .replace("binning_x: 0", "binning_x: 2")
        .replace("binning_y: 0", "binning_y: 2");
    let points = [[[77.0, 120.0], [76.4054534188, 120.0017962132]]; 2];
    check(&binned, points, Some([320, 240]));
    let only_binned = "width: 1280\nheight: 960\nD: []\nK: [1040, 0, 640, 0, 1042, 480, 0, 0, 1]\nbinning_x: 2\nbinning_y: 1\n";
    let camera = Camera::from_yaml(only_binned).unwrap();
    assert_eq!(
        (camera.focal_px(), camera.center_px()),
        ([520.0, 1042.0], [319.75, 480.0])
    );
    assert_eq!(camera.size(), Some([640, 960]));
}

#[test]
fn a_region_that_does_not_fit_is_refused_and_the_whole_sensor_is_none() {
    let camera = Camera::from_yaml(ROI).unwrap();
    let refused = Mapping::new(Some(&camera), None, [1280, 960])
        .unwrap_err()
        .to_string();
    assert!(refused.contains("remove roi"), "{refused}");
    assert!(Mapping::new(Some(&camera), None, [640, 480]).is_ok());
    let whole = "roi: {x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false}";
    let region = ROI.lines().last().unwrap();
    let camera = Camera::from_yaml(&ROI.replace(region, whole)).unwrap();
    assert_eq!(
        (camera.center_px(), camera.size()),
        ([640.0, 480.0], Some([1280, 960]))
    );
    assert!(Mapping::new(Some(&camera), None, [2560, 1920]).is_ok());
    let outside = ROI.replace("x_offset: 320", "x_offset: 641");
    let refused = Camera::from_yaml(&outside).unwrap_err().to_string();
    assert!(refused.contains("is no part of the image"), "{refused}");
    // The valid part from cv2.getOptimalNewCameraMatrix is a list.
    let list = ROI.replace(region, "roi: [320, 240, 640, 480]");
    assert_eq!(
        Camera::from_yaml(&list).unwrap().center_px(),
        [640.0, 480.0]
    );
}

#[test]
fn lengths_in_metres_are_read_by_name_and_refused_as_millimetres() {
    let turn = "rotation: [0, 0, 0, 1]\n";
    let metres = Pose::from_yaml(&format!("{turn}translation_m: [0.1, 0.2, 0.3]\n")).unwrap();
    assert_eq!(metres.point([0.0; 3]), [100.0, 200.0, 300.0]);
    let refused = Pose::from_yaml(&format!("{turn}translation_mm: [0.1, 0.2, 0.3]\n")).unwrap_err();
    assert!(
        refused.to_string().contains("name them translation_m"),
        "{refused}"
    );
    assert!(Pose::from_yaml(&format!("{turn}translation_mm: [0, 0, 0]\n")).is_ok());
    let color = Camera::from_yaml(
        "width: 640\nheight: 480\nK: [600, 0, 320, 0, 600, 240, 0, 0, 1]\nD: []\n",
    )
    .unwrap();
    let depth = |line: &str| {
        let text = format!("{turn}translation_mm: [-15, 0, 0]\n{line}\n");
        lariat_camera::DepthCalibration::from_yaml(&text, color).map_err(|error| error.to_string())
    };
    assert!(depth("").is_ok());
    assert!(depth("depth_unit_mm: 0.2").is_ok());
    for (line, words) in [
        ("depth_unit_mm: 0.001", "a step of 0.001 m is 1"),
        ("depth_unit_mm: 1000", "1000 steps in a metre are 1"),
        ("noise_mm_at_1m: 0.0036", "it is in millimetres"),
        ("range_mm: [0.2, 1.5]", "it is in millimetres"),
    ] {
        let refused = depth(line).unwrap_err();
        assert!(refused.contains(words), "{line}: {refused}");
    }
    let text = format!("{turn}translation_mm: [-0.015, 0, 0]\n");
    let refused = lariat_camera::DepthCalibration::from_yaml(&text, color).unwrap_err();
    assert!(
        refused.to_string().contains("a shift of 0.015 mm"),
        "{refused}"
    );
}

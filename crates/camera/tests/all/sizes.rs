//! Calibrations for images of other sizes, and invalid planes.

use lariat_camera::{Camera, HomographyError, Lens, Mapping, Pair, Plane, PlaneError, SizeError};

fn camera(size: Option<[u32; 2]>) -> Camera {
    let lens = Lens::brown_conrady(&[-0.2, 0.05, 1e-3, -1e-3]).unwrap();
    Camera::new([900.0, 910.0], [651.3, 355.2], lens, size).unwrap()
}

#[test]
fn a_calibration_holds_for_the_same_picture_in_another_size() {
    let camera = camera(Some([1280, 720]));
    let whole = Mapping::new(Some(&camera), None, [1280, 720]).unwrap();
    let half = Mapping::new(Some(&camera), None, [640, 360]).unwrap();
    for pixel in [[0.0, 0.0], [100.5, 300.25], [1279.0, 719.0]] {
        // The center of a pixel at half the size is between four pixels of the whole.
        let smaller = pixel.map(|c| (c + 0.5) / 2.0 - 0.5);
        let expected = whole
            .place(pixel)
            .unwrap()
            .point
            .map(|c| (c + 0.5) / 2.0 - 0.5);
        let found = half.place(smaller).unwrap().point;
        assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-9));
    }
    // 1280×720 at a width of 854 has a height of 480.4.
    assert!(Mapping::new(Some(&camera), None, [854, 480]).is_ok());
}

#[test]
fn another_ratio_of_the_sides_is_refused_with_both_sizes() {
    let error = Mapping::new(Some(&camera(Some([1280, 720]))), None, [640, 480]).unwrap_err();
    let sentence = error.to_string();
    assert!(
        sentence.contains("1280×720") && sentence.contains("640×480"),
        "{sentence}"
    );
    let plane =
        Plane::from_homography([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).unwrap();
    let plane = plane.in_images_of([640, 480]);
    let error = Mapping::new(None, Some(&plane), [1280, 720]).unwrap_err();
    assert!(matches!(error, SizeError::Aspect { .. }));
    // The plane, too, is for the same image at another size.
    let mapping = Mapping::new(None, Some(&plane), [1280, 960]).unwrap();
    assert_eq!(mapping.place([0.5, 0.5]).unwrap().point, [0.0, 0.0]);
}

#[test]
fn a_calibration_without_a_size_must_have_its_middle_in_the_frames() {
    assert!(Mapping::new(Some(&camera(None)), None, [1280, 720]).is_ok());
    let error = Mapping::new(Some(&camera(None)), None, [640, 480]).unwrap_err();
    assert!(matches!(error, SizeError::Center { .. }), "{error}");
}

#[test]
fn a_plane_of_undistorted_pixels_goes_with_its_own_camera_only() {
    let own = camera(Some([1280, 720]));
    let plane = Plane::from_pose([0.3, 0.0, 0.0], [0.0, 0.0, 700.0], &own).unwrap();
    assert!(Mapping::new(Some(&own), Some(&plane), [1280, 720]).is_ok());
    let error = Mapping::new(None, Some(&plane), [1280, 720]).unwrap_err();
    assert_eq!(error, SizeError::NoCamera);
    let other = Camera::new([950.0; 2], [640.0, 360.0], Lens::IDEAL, Some([1280, 720])).unwrap();
    let error = Mapping::new(Some(&other), Some(&plane), [1280, 720]).unwrap_err();
    assert_eq!(error, SizeError::OtherCamera);
}

fn pairs(pixels: &[[f64; 2]], plane: &[[f64; 2]]) -> Vec<Pair> {
    let both = pixels.iter().zip(plane);
    both.map(|(&pixel, &plane_mm)| Pair { pixel, plane_mm })
        .collect()
}

const CORNERS: [[f64; 2]; 4] = [[10.0, 10.0], [600.0, 20.0], [610.0, 450.0], [20.0, 460.0]];
const SHEET: [[f64; 2]; 4] = [[0.0, 0.0], [297.0, 0.0], [297.0, 210.0], [0.0, 210.0]];

#[test]
fn points_that_determine_no_plane_are_refused_and_named() {
    let refused = |pixels: &[[f64; 2]], plane: &[[f64; 2]]| {
        Plane::from_pairs(&pairs(pixels, plane)).unwrap_err()
    };
    assert_eq!(
        refused(&CORNERS[..3], &SHEET[..3]),
        HomographyError::TooFew(3)
    );
    let mut line = CORNERS;
    line[2] = [305.0, 15.2];
    let sentence = refused(&line, &SHEET).to_string();
    assert!(
        sentence.contains("points 1, 2 and 3") && sentence.contains("in the picture"),
        "{sentence}"
    );
    let mut line = SHEET;
    line[3] = [150.0, 105.0];
    let sentence = refused(&CORNERS, &line).to_string();
    assert!(
        sentence.contains("points 1, 3 and 4") && sentence.contains("on the plane"),
        "{sentence}"
    );
    let crossed = [SHEET[0], SHEET[2], SHEET[1], SHEET[3]];
    assert_eq!(refused(&CORNERS, &crossed), HomographyError::BothSides);
    let mut lost = CORNERS;
    lost[1][0] = f64::NAN;
    assert_eq!(refused(&lost, &SHEET), HomographyError::NotAPoint(2));
    let many: Vec<[f64; 2]> = (0..9)
        .map(|i| [40.0 * f64::from(i), 10.0 * f64::from(i)])
        .collect();
    assert_eq!(refused(&many, &many), HomographyError::Degenerate);
    assert_eq!(refused(&[[5.0; 2]; 9], &many), HomographyError::Degenerate);
}

#[test]
fn a_mirrored_table_is_a_table() {
    // Millimeters with y up, as drawn on paper.
    let up = SHEET.map(|[x, y]| [x, -y]);
    let plane = Plane::from_pairs(&pairs(&CORNERS, &up)).unwrap();
    let mapping = Mapping::new(None, Some(&plane), [640, 480]).unwrap();
    for (pixel, mm) in CORNERS.iter().zip(up) {
        let found = mapping.place(*pixel).unwrap().point;
        assert!((found[0] - mm[0]).hypot(found[1] - mm[1]) < 1e-9);
    }
}

#[test]
fn planes_that_are_none_are_refused() {
    let camera = camera(None);
    let flat = Plane::from_homography([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0]]);
    assert_eq!(flat, Err(PlaneError::Singular));
    let half_turn = std::f64::consts::FRAC_PI_2;
    let edge_on = Plane::from_pose([half_turn, 0.0, 0.0], [0.0, 0.0, 500.0], &camera);
    assert_eq!(edge_on, Err(PlaneError::EdgeOn));
    let mirrored = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let mirrored = Plane::from_rotation(mirrored, [0.0, 0.0, 500.0], &camera);
    assert_eq!(mirrored, Err(PlaneError::Rotation));
    let endless = Plane::from_pose([f64::INFINITY, 0.0, 0.0], [0.0, 0.0, 500.0], &camera);
    assert_eq!(endless, Err(PlaneError::NotFinite));
}

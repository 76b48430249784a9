//! Compares lenses, homographies and poses with OpenCV. The script next to the fixture says how it
//! was made.

use lariat_camera::{Camera, Lens, Mapping, Pair, Plane};
use serde_json::Value;

fn fixture() -> Value {
    serde_json::from_str(include_str!("../opencv.json")).unwrap()
}

fn points(value: &Value) -> Vec<[f64; 2]> {
    let rows = value.as_array().expect("the fixture holds lists of points");
    rows.iter()
        .map(|row| [0, 1].map(|axis| row[axis].as_f64().expect("and points of two numbers")))
        .collect()
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn every_lens_is_opencvs_to_a_millionth_of_a_pixel() {
    let fixture = fixture();
    let lenses = fixture["lenses"].as_array().unwrap();
    assert_eq!(lenses.len(), 8);
    for case in lenses {
        let name = case["name"].as_str().unwrap();
        let camera = Camera::from_yaml(case["yaml"].as_str().unwrap()).unwrap();
        let (ideal, seen) = (points(&case["ideal"]), points(&case["seen"]));
        for ((ideal, seen), back) in ideal.iter().zip(&seen).zip(points(&case["back"])) {
            let distorted = camera.distort(*ideal).unwrap().point;
            assert!(
                apart(distorted, *seen) < 1e-6,
                "{name}: {ideal:?} {distorted:?} {seen:?}"
            );
            let undistorted = camera.undistort(*seen).unwrap().point;
            assert!(
                apart(undistorted, *ideal) < 1e-6,
                "{name}: {seen:?} {undistorted:?} {ideal:?}"
            );
            // Compared only if OpenCV's own iteration returned to the original point.
            if apart(back, *ideal) < 1e-6 {
                assert!(
                    apart(undistorted, back) < 1e-6,
                    "{name}: {undistorted:?} {back:?}"
                );
            }
        }
    }
}

#[test]
fn homographies_are_opencvs_to_a_millionth_of_a_millimetre() {
    let fixture = fixture();
    let cases = fixture["homographies"].as_array().unwrap();
    assert_eq!(cases.len(), 5);
    for case in cases {
        let (pixels, plane) = (points(&case["pixels"]), points(&case["plane"]));
        let pairs: Vec<Pair> = pixels
            .iter()
            .zip(&plane)
            .map(|(&pixel, &plane_mm)| Pair { pixel, plane_mm })
            .collect();
        let plane = Plane::from_pairs(&pairs).unwrap();
        let mapping = Mapping::new(None, Some(&plane), [640, 480]).unwrap();
        // With more than four pairs, OpenCV stops a few millionths of a millimeter short of the
        // least squares.
        let opencv = if pairs.len() == 4 { 1e-6 } else { 1e-5 };
        let (lies, least) = (points(&case["lies"]), points(&case["least"]));
        for ((asked, lies), least) in points(&case["asked"]).into_iter().zip(lies).zip(least) {
            let found = mapping.place(asked).unwrap().point;
            let count = pairs.len();
            assert!(
                apart(found, lies) < opencv,
                "{count} pairs: {found:?} {lies:?}"
            );
            assert!(
                apart(found, least) < 1e-6,
                "{count} pairs: {found:?} {least:?}"
            );
            assert!(apart(mapping.pixel(found).unwrap(), asked) < 1e-8);
        }
    }
}

#[test]
fn poses_are_opencvs_to_a_millionth_of_a_millimetre() {
    let fixture = fixture();
    let camera = Camera::new(
        [610.0, 605.0],
        [322.5, 238.0],
        Lens::IDEAL,
        Some([640, 480]),
    )
    .unwrap();
    for case in fixture["poses"].as_array().unwrap() {
        let three = |value: &Value| [0, 1, 2].map(|i| value[i].as_f64().unwrap());
        let t = three(&case["translation"]);
        let matrix = [0, 1, 2].map(|i| three(&case["matrix"][i]));
        for plane in [
            Plane::from_pose(three(&case["rotation"]), t, &camera).unwrap(),
            Plane::from_rotation(matrix, t, &camera).unwrap(),
        ] {
            let mapping = Mapping::new(Some(&camera), Some(&plane), [640, 480]).unwrap();
            for (seen, lies) in points(&case["seen"])
                .into_iter()
                .zip(points(&case["plane"]))
            {
                let found = mapping.place(seen).unwrap().point;
                assert!(apart(found, lies) < 1e-6, "{t:?}: {found:?} {lies:?}");
            }
        }
    }
}

//! `lariat calibrate plane`, and the use of its file.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn lariat(folder: &Path) -> Command {
    let mut command: Command = assert_cmd::cargo::cargo_bin_cmd!("lariat");
    command.current_dir(folder);
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("lariat writes UTF-8")
}

/// Runs a command that must fail, and returns its standard error.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = lariat(folder).args(arguments).output().unwrap();
    assert!(!output.status.success(), "{arguments:?}");
    text(&output.stderr)
}

fn picture() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/rope.png")
}

const YAML: &str = "image_width: 480\nimage_height: 360\nK: [500, 0, 240, 0, 500, 180, 0, 0, 1]\nD: [-0.2, 0.05, 0, 0]\n";
/// Points in a picture of 480×360 pixels, with half a millimeter per pixel.
const POINTS: &str = "40,40=20,20 440,40=220,20 440,320=220,160 40,320=20,160";

/// Makes `plane.toml` in the folder, and returns the command's output.
fn made_plane(folder: &Path, of: &[&str]) -> String {
    let made = lariat(folder)
        .args(["calibrate", "plane"])
        .args(of)
        .args(["--points", POINTS, "--out", "plane.toml"])
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", text(&made.stderr));
    text(&made.stdout)
}

#[test]
fn four_points_make_a_plane_and_a_trace_in_millimetres() {
    let folder = tempfile::tempdir().unwrap();
    let image = picture();
    let image = image.to_str().unwrap();
    let table = made_plane(folder.path(), &[image]);
    assert!(
        table.contains("mm per pixel: 0.500 at the middle, 0.500 top left"),
        "{table}"
    );

    let traced = |arguments: &[&str]| -> Value {
        let output = lariat(folder.path())
            .args(["trace", "--json", image])
            .args(arguments)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let (px, mm) = (
        traced(&[]),
        traced(&["--plane", "plane.toml", "--overlay", "drawn"]),
    );
    let [px_curve, mm_curve] = [&px, &mm].map(|report| &report["curves"][0]);
    // Results in the picture remain in pixels.
    assert_eq!(px_curve["points"], mm_curve["points"]);
    let [px, mm] = [px_curve, mm_curve].map(|curve| &curve["descriptor"]);
    assert_eq!(
        (&px["unit"], &mm["unit"]),
        (&Value::from("px"), &Value::from("mm"))
    );
    let number = |value: &Value| value.as_f64().unwrap();
    assert!((number(&mm["length"]) - 0.5 * number(&px["length"])).abs() < 0.5);
    for j in 0..9 {
        for axis in 0..2 {
            let [a, b] = [px, mm].map(|d| number(&d["control_points"][j][axis]));
            // The centerline's points have equal steps to a few hundredths, and a control point's
            // gain is 25.
            assert!((b - 0.5 * a).abs() < 2.0, "{a} px, {b} mm");
        }
    }
    assert!(folder.path().join("drawn/rope.png").exists());
}

#[test]
fn a_region_of_a_picture_has_its_points_in_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let output = lariat(folder.path())
        .args(["trace", "--json", "--roi", "20,10,440,340"])
        .arg(picture())
        .output()
        .unwrap();
    let part: Value = serde_json::from_slice(&output.stdout).unwrap();
    let output = lariat(folder.path())
        .args(["trace", "--json"])
        .arg(picture())
        .output()
        .unwrap();
    let whole: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&part["width"], &part["height"]),
        (&whole["width"], &whole["height"])
    );
    let first = |report: &Value| {
        [0, 1].map(|axis| report["curves"][0]["points"][0][axis].as_f64().unwrap())
    };
    let (a, b) = (first(&part), first(&whole));
    assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 2.0, "{a:?} {b:?}");
}

#[test]
fn what_is_wrong_is_said_before_anything_starts() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("camera.yaml"), YAML).unwrap();
    std::fs::write(here.join("broken.yaml"), YAML.replace("500", "oops")).unwrap();
    std::fs::write(
        here.join("half.toml"),
        "homography = [[1, 0, 0], [0, 1, 0]]",
    )
    .unwrap();
    made_plane(here, &["--calibration", "camera.yaml"]);
    for (arguments, words) in [
        (&["--unit", "mm"][..], "needs the plane"),
        (
            &["--calibration", "absent.yaml"],
            "cannot read the calibration absent.yaml",
        ),
        (
            &["--calibration", "broken.yaml"],
            "broken.yaml: K: \"oops\" is not a finite number",
        ),
        (&["--plane", "half.toml"], "half.toml: line 1"),
        (
            &["--plane", "absent.toml"],
            "`lariat calibrate plane` makes one",
        ),
        (&["--plane", "plane.toml"], "name the lens calibration"),
        (
            &[
                "--plane",
                "plane.toml",
                "--calibration",
                "camera.yaml",
                "--size",
                "640x360",
            ],
            "the sides' ratio differs",
        ),
        (&["--unit", "inch"], "The units are"),
        (&["--roi", "700,0,10,10"], "nothing of it is left"),
        (&["--roi", "1,2,3"], "a region is four whole numbers"),
        (&["--roi", "0,0,0,5"], "a region is four whole numbers"),
    ] {
        let error = refused(here, &[&["run", "--frames", "1"], arguments].concat());
        assert!(error.contains(words), "{arguments:?}: {error}");
    }
    for (arguments, words) in [
        (&["--points", POINTS][..], "say how large the images are"),
        (&["--size", "640x480"], "name four points or more"),
        (
            &["--size", "640x480", "--points", "1,2=3,4"],
            "1 points do not determine a plane",
        ),
        (
            &[
                "--size",
                "640x480",
                "--points",
                "0,0=0,0 1,1=1,1 2,2=2,2 0,9=0,9",
            ],
            "points 1, 2 and 3 lie in one line",
        ),
        (
            &["--size", "640x480", "--points", "1,2,3,4"],
            "is no pair of points",
        ),
        (
            &["--size", "huge", "--points", POINTS],
            "a size is width and height",
        ),
    ] {
        let error = refused(here, &[&["calibrate", "plane"], arguments].concat());
        assert!(error.contains(words), "{arguments:?}: {error}");
    }
}

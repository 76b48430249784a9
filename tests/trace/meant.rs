//! Only the ropes selected by `--at`.

use tempfile::TempDir;

use super::{lines, points, rope_picture, save, trace};

/// Two ropes across the picture, at y = 60 and at y = 180.
fn two(t: f64) -> [f64; 2] {
    let (t, y) = if t < 0.5 { (t, 60.0) } else { (t - 0.5, 180.0) };
    [40.0 + 480.0 * t, y]
}

#[test]
fn only_the_ropes_that_are_meant_are_reported() {
    let folder = TempDir::new().unwrap();
    save(&folder, "two.png", &rope_picture(320, 240, two));
    let heights = |args: &[&str]| -> Vec<f64> {
        let args = [&["two.png", "--json"], args].concat();
        let output = trace(&folder, &args).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let report = lines(&output.stdout)[0].clone();
        let curves = report["curves"].as_array().unwrap().clone();
        curves
            .iter()
            .map(|c| points(&c["points"])[60][1].round())
            .collect()
    };
    assert_eq!(heights(&[]), [60.0, 180.0]);
    assert_eq!(heights(&["--at", "200,181"]), [180.0]);
    assert_eq!(heights(&["--at", "100,60,100,180"]).len(), 2);
    assert!(
        heights(&["--at", "160,120"]).is_empty(),
        "nothing lies here"
    );
}

#[test]
fn a_position_that_is_none_is_named() {
    let folder = TempDir::new().unwrap();
    save(&folder, "two.png", &rope_picture(320, 240, two));
    for wrong in ["160", "160,120,7", "left", "nan,3"] {
        let output = trace(&folder, &["two.png", "--at", wrong])
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let complaint = String::from_utf8(output.stderr).unwrap();
        assert!(
            complaint.contains("positions are two numbers of pixels each"),
            "{complaint}"
        );
    }
}

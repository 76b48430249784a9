//! Tests of the command on drawn ropes.

use std::fs;
use std::process::Command;

use tempfile::TempDir;

fn accuracy() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lariat-bench"));
    command.arg("accuracy");
    command
}

#[test]
fn a_class_is_a_row_a_picture_a_line_and_an_overlay() {
    let out = TempDir::new().unwrap();
    let (csv, overlay) = (out.path().join("all.csv"), out.path().join("overlays"));
    let mut command = accuracy();
    command.args(["--rendered", "--class", "thin", "--size", "320x240"]);
    command
        .args(["--seed", "9", "--seeds", "2", "--csv"])
        .arg(&csv);
    let done = command.arg("--overlay").arg(&overlay).output().unwrap();
    assert!(done.status.success(), "{done:?}");
    let table = String::from_utf8(done.stdout).unwrap();
    let row = table.lines().find(|l| l.starts_with("thin ")).unwrap();
    assert_eq!(row.split_whitespace().nth(1), Some("2"), "{row}");
    assert_eq!(fs::read_to_string(csv).unwrap().lines().count(), 3);
    for name in ["thin-9.png", "thin-10.png"] {
        let picture = fs::read(overlay.join(name)).unwrap();
        assert_eq!(image::load_from_memory(&picture).unwrap().width(), 960);
    }
}

#[test]
fn what_to_measure_must_be_said() {
    let done = accuracy().output().unwrap();
    assert!(!done.status.success());
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(
        said.contains("--rendered") && said.contains("--dataset"),
        "{said}"
    );
}

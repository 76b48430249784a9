//! Tests of the command that runs the rivals, with a Python that does not exist.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

fn rivals(python: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lariat-bench"));
    command.arg("rivals").arg("--python").arg(python);
    command.args(["--frames", "1", "--passes", "1", "--rounds", "1"]);
    command.args(more).output().unwrap()
}

fn table(python: &Path) -> String {
    let done = rivals(python, &[]);
    assert!(done.status.success(), "{done:?}");
    String::from_utf8(done.stdout).unwrap()
}

/// Creates a program that always prints this line.
#[cfg(unix)]
fn python_that_prints(folder: &TempDir, line: &str) -> std::path::PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.path().join("python");
    std::fs::write(&path, format!("#!/bin/sh\necho '{line}'\n")).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

#[test]
fn without_python_lariats_own_figures_and_the_reason_are_given() {
    let said = table(Path::new("/nonexistent"));
    let reason = said
        .lines()
        .find(|l| l.starts_with("Not measured"))
        .unwrap();
    assert!(
        reason.contains("`/nonexistent` cannot be run") && reason.contains("requirements.txt"),
        "{reason}"
    );
    assert!(
        said.lines()
            .any(|l| l.starts_with("whole chain, 120 points")),
        "{said}"
    );
    assert!(said.contains("mBEST"), "{said}");
}

#[cfg(unix)]
#[test]
fn what_is_not_installed_is_named() {
    let folder = TempDir::new().unwrap();
    let python = python_that_prints(&folder, r#"{"missing": "scikit-image"}"#);
    let said = table(&python);
    assert!(
        said.contains("has no scikit-image: install it by"),
        "{said}"
    );
}

#[cfg(unix)]
#[test]
fn a_rivals_time_stands_beside_lariats_with_its_version() {
    let folder = TempDir::new().unwrap();
    let line =
        r#"{"picture": 0, "median_ms": 123456.789, "rounds": 1, "versions": {"Slow": "1.2"}}"#;
    let said = table(&python_that_prints(&folder, line));
    let row = said
        .lines()
        .find(|l| l.starts_with("scikit-image thinning"))
        .unwrap();
    assert!(
        row.contains("123456.789") && row.contains('×') && row.ends_with("Slow 1.2"),
        "{row}"
    );
    assert!(!said.contains("Not measured"), "{said}");
}

#[test]
fn a_picture_that_cannot_be_read_is_refused() {
    let done = rivals(Path::new("/nonexistent"), &["--images", "/nowhere.png"]);
    assert_eq!(done.status.code(), Some(1));
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(said.contains("cannot read /nowhere.png"), "{said}");
}

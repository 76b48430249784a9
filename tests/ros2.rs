//! `lariat ros2`: which program it becomes, with which words, and what it says where there is none. The program itself is held
//! against other nodes of a graph by `tests/ros2/run`.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

/// A lariat in a folder of its own, so that what lies beside it is this test's.
fn lariat_in(folder: &Path) -> PathBuf {
    let lariat = folder.join("lariat");
    fs::copy(assert_cmd::cargo::cargo_bin!("lariat"), &lariat).expect("a copy");
    lariat
}

/// A program that says its name and its words, and ends with 3.
fn program(folder: &Path, name: &str) {
    let path = folder.join("lariat-ros2");
    fs::write(&path, format!("#!/bin/sh\necho {name} \"$@\"\nexit 3\n")).expect("a script");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("permissions");
}

#[test]
fn it_becomes_the_program_beside_it_else_the_one_on_the_path_else_says_how_to_get_it() {
    let [home, path] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let lariat = lariat_in(home.path());
    let words = ["--rig", "a", "--ros-args", "-r", "__ns:=/cell", "--", "-x"];
    let run = || {
        Command::new(&lariat)
            .arg("ros2")
            .args(words)
            .env("PATH", path.path())
            .assert()
    };
    let refused = run().code(1).get_output().stderr.clone();
    let said = String::from_utf8(refused).expect("text");
    assert!(said.contains("cargo install --path crates/ros2"), "{said}");

    for (folder, name) in [(&path, "path"), (&home, "beside")] {
        program(folder.path(), name);
        run()
            .code(3)
            .stdout(format!("{name} {}\n", words.join(" ")));
    }
}

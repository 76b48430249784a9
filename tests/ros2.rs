//! `lariat ros2` and `lariat bridge`: which program each becomes, with which words, and what it says where there is none. The programs themselves are held
//! by `tests/ros2/run`, and by `crates/bridge/tests` and `tests/bridge/run`. And the package of its messages (`ros/lariat_msgs`), which has none of its own.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use lariat_record::{Losses, Record};
use lariat_wire::{Centerlines, Descriptors, Descriptors3, FrameHeader};

/// A lariat in a folder of its own, so that what lies beside it is this test's.
fn lariat_in(folder: &Path) -> PathBuf {
    let lariat = folder.join("lariat");
    fs::copy(assert_cmd::cargo::cargo_bin!("lariat"), &lariat).expect("a copy");
    lariat
}

/// A program that says its name and its words, and ends with 3.
fn program(folder: &Path, file: &str, name: &str) {
    let path = folder.join(file);
    fs::write(&path, format!("#!/bin/sh\necho {name} \"$@\"\nexit 3\n")).expect("a script");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("permissions");
}

#[test]
fn each_becomes_the_program_beside_it_else_the_one_on_the_path_else_says_how_to_get_it() {
    for command in ["ros2", "bridge"] {
        let [home, path] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
        let lariat = lariat_in(home.path());
        let words = ["--rig", "a", "--ros-args", "-r", "__ns:=/cell", "--", "-x"];
        let run = || {
            Command::new(&lariat)
                .arg(command)
                .args(words)
                .env("PATH", path.path())
                .assert()
        };
        let refused = run().code(1).get_output().stderr.clone();
        let said = String::from_utf8(refused).expect("text");
        let how = format!("cargo install --locked --path crates/{command}");
        assert!(said.contains(&how), "{said}");

        for (folder, name) in [(&path, "path"), (&home, "beside")] {
            program(folder.path(), &format!("lariat-{command}"), name);
            run()
                .code(3)
                .stdout(format!("{name} {}\n", words.join(" ")));
        }
    }
}

/// The messages that a schema of lariat's asks for, itself among them.
fn with_parts(message: &str, into: &mut BTreeSet<String>) {
    if !into.insert(message.to_owned()) {
        return;
    }
    let path = repository().join(format!("crates/record/schemas/{message}.msg"));
    let schema = fs::read_to_string(path).expect("a schema");
    for part in schema.split("lariat_msgs/").skip(1) {
        let name: String = part
            .chars()
            .take_while(char::is_ascii_alphanumeric)
            .collect();
        with_parts(&name, into);
    }
}

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_package_of_messages_has_those_of_recordings_and_all_that_they_are_made_of() {
    let mut meant = BTreeSet::new();
    for whole in [
        Descriptors::SCHEMA,
        Descriptors3::SCHEMA,
        Centerlines::SCHEMA,
        FrameHeader::SCHEMA,
        Losses::SCHEMA,
    ] {
        let message = whole
            .name
            .strip_prefix("lariat_msgs/msg/")
            .expect("lariat's");
        with_parts(message, &mut meant);
    }
    let cmake = fs::read_to_string(repository().join("ros/lariat_msgs/CMakeLists.txt"));
    let cmake = cmake.expect("the package's");
    let (_, list) = cmake.split_once("set(messages").expect("a list");
    let (list, _) = list.split_once(')').expect("its end");
    let listed: BTreeSet<String> = list.split_whitespace().map(str::to_owned).collect();
    assert_eq!(listed, meant);
}

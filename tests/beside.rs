//! Commands that run a separate program (`lariat ros2`, `bridge`, `bench`, `compare`, `paper`,
//! `servo`): the program of each, its arguments, and the message if it is missing. The programs
//! themselves are tested by `tests/ros2/run`, `crates/bridge/tests`, `tests/bridge/run` and
//! `bench/tests`.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use assert_cmd::Command;

/// Copies lariat into a separate folder, so that only this test's programs are next to it.
fn lariat_in(folder: &Path) -> PathBuf {
    let lariat = folder.join("lariat");
    fs::copy(assert_cmd::cargo::cargo_bin!("lariat"), &lariat).expect("a copy");
    lariat
}

/// Writes a program that prints its name and its arguments, and exits with 3.
fn program(folder: &Path, file: &str, name: &str) {
    let path = folder.join(file);
    fs::write(&path, format!("#!/bin/sh\necho {name} \"$@\"\nexit 3\n")).expect("a script");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("permissions");
}

/// Held while programs are written and run. A child forked meanwhile by another thread briefly
/// holds the file open for writing, and such a file cannot be run.
static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[test]
fn each_becomes_the_program_beside_it_else_the_one_on_the_path_else_says_how_to_get_it() {
    let _alone = alone();
    let [top, ros2, bridge] = ["top", "ros2", "bridge"]
        .map(|name| format!("cargo install --locked --path crates/{name}"));
    let bench = "--manifest-path bench/Cargo.toml".to_owned();
    for (command, file, first, how) in [
        ("top", "lariat-top", "", top),
        ("ros2", "lariat-ros2", "", ros2),
        ("bridge", "lariat-bridge", "", bridge),
        ("bench", "lariat-bench", "latency ", bench.clone()),
        ("compare", "lariat-bench", "compare ", bench.clone()),
        ("paper", "lariat-bench", "paper ", bench.clone()),
        ("servo", "lariat-bench", "servo ", bench),
    ] {
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
        assert!(said.contains(&how), "{said}");

        for (folder, name) in [(&path, "path"), (&home, "beside")] {
            program(folder.path(), file, name);
            run()
                .code(3)
                .stdout(format!("{name} {first}{}\n", words.join(" ")));
        }
    }
}

#[test]
fn a_measurement_is_asked_for_its_own_help() {
    let _alone = alone();
    let home = tempfile::tempdir().expect("a folder");
    let lariat = lariat_in(home.path());
    program(home.path(), "lariat-bench", "bench");
    let mut asked = Command::new(&lariat);
    let asked = asked.args(["bench", "--help"]).assert();
    asked.code(3).stdout("bench latency --help\n");
}

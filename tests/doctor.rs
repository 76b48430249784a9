//! `lariat doctor` on the machine that runs the tests.

use std::collections::HashMap;
use std::fs;
use std::time::{Duration, SystemTime};

use assert_cmd::Command;
use serde_json::Value;

/// Uses a domain that no other test run shares.
fn doctor(arguments: &[&str]) -> Command {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("lariat");
    command
        .arg("doctor")
        .args(arguments)
        .env("LARIAT_DOMAIN", format!("d{}", std::process::id()));
    command
}

#[test]
fn a_machine_that_runs_lariat_is_told_so_and_each_advice_is_under_its_finding() {
    let output = doctor(&[]).assert().success().get_output().stdout.clone();
    let text = String::from_utf8(output).expect("text");
    for line in text.lines() {
        let begins = ["ok  ", "could be better  ", "                 "];
        assert!(begins.iter().any(|begin| line.starts_with(begin)), "{line}");
    }
    assert!(text.contains("shared memory"), "{text}");
}

#[test]
fn as_json_every_check_has_a_verdict() {
    let output = doctor(&["--json"]).assert().success().get_output().clone();
    let diagnosis: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(diagnosis["schema"], 1);
    assert_eq!(diagnosis["works"], true);
    let verdicts: HashMap<_, _> = diagnosis["checks"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|check| (check["name"].as_str(), check["verdict"].as_str()))
        .collect();
    assert!(verdicts.len() > 10);
    for (name, verdict) in &verdicts {
        assert!(
            matches!(verdict, Some("ok" | "could_be_better")),
            "{name:?}"
        );
    }
    // A test with its own limit would change another finding; shared memory exists on any machine.
    assert_eq!(verdicts[&Some("transport")], Some("ok"));
}

/// Writes a file that looks a minute old.
fn old_file(path: &str) {
    fs::write(path, "left").expect("written");
    let file = fs::File::options().write(true).open(path).expect("there");
    let minute_ago = SystemTime::now() - Duration::from_secs(60);
    file.set_modified(minute_ago).expect("its own file");
}

#[test]
fn what_a_dead_process_left_is_found_and_cleaned_away_and_what_lives_is_neither() {
    let name = format!("l{}", std::process::id());
    let dead = format!("{name}dead");
    let living = lariat_wire::Domain::named(&name).expect("a domain");
    let word = "0".repeat(40);
    let rig = lariat_wire::Rig::default();
    let reader = lariat_wire::Receiver::descriptors(&living, &rig).expect("a reader");
    let prefix = format!("lariat_{name}_");
    let shared = fs::read_dir("/dev/shm").expect("readable").flatten();
    let of_the_living: Vec<_> = shared
        .filter(|file| file.file_name().to_string_lossy().starts_with(&prefix))
        .map(|file| file.path())
        .collect();
    assert!(!of_the_living.is_empty());
    let beside_the_living = format!("/dev/shm/lariat_{name}_{word}_1.data");
    let of_the_dead = format!("/dev/shm/lariat_{dead}_{word}_1.data");
    // A starting process creates its files before it is visible as alive.
    let of_the_newborn = format!("/dev/shm/lariat_{dead}new_{word}_1.data");
    for folder in [dead.clone(), format!("{dead}new")] {
        fs::create_dir_all(format!("/tmp/lariat-{folder}/services")).expect("made");
    }
    let service = format!("/tmp/lariat-{dead}/services/lariat_{dead}_{word}.service");
    for file in [&beside_the_living, &of_the_dead, &service] {
        old_file(file);
    }
    fs::write(&of_the_newborn, "left").expect("written");

    let left = lariat_wire::leftovers();
    let mine = |domain: &str| {
        left.iter()
            .find(|of| of.domain.as_deref() == Some(domain))
            .cloned()
    };
    let found = mine(&dead).expect("found");
    assert_eq!((found.files, found.bytes), (1, 4));
    assert_eq!(found.prefix, format!("/dev/shm/lariat_{dead}_"));
    assert_eq!((mine(&name), mine(&format!("{dead}new"))), (None, None));

    let told = |arguments: &[&str]| {
        let output = doctor(arguments).assert().success().get_output().clone();
        let diagnosis: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let checks = diagnosis["checks"].as_array().expect("a list").clone();
        checks
            .into_iter()
            .find(|check| check["name"] == "leftovers")
            .expect("looked at")
    };
    // The domain shared by all users in older releases; skipped if other iceoryx2 programs use it.
    let shared = "/tmp/iceoryx2/lariat-roster";
    let is_ours = fs::create_dir("/tmp/iceoryx2").is_ok();
    if is_ours {
        fs::create_dir(shared).expect("made");
        let folder = fs::File::open(shared).expect("there");
        let minute_ago = SystemTime::now() - Duration::from_secs(60);
        folder.set_modified(minute_ago).expect("its own folder");
    }
    let before = told(&["--json"]);
    assert_eq!(before["advice"], "`lariat doctor --clean`", "{before}");
    let found = before["found"].as_str().expect("a sentence");
    assert!(!is_ours || found.contains("/tmp/iceoryx2"), "{found}");
    assert!(
        fs::exists(&of_the_dead).expect("readable"),
        "only looked at"
    );
    let cleaned = told(&["--json", "--clean"]);
    assert_eq!(cleaned["verdict"], "ok", "{cleaned}");
    let is_there = |path: &str| fs::exists(path).expect("readable");
    assert!(of_the_living.iter().all(|file| file.exists()));
    assert!(is_there(&of_the_newborn) && !is_there(&beside_the_living));
    assert!(!is_there(&of_the_dead) && !is_there(&format!("/tmp/lariat-{dead}")));
    assert!(!is_ours || !is_there("/tmp/iceoryx2"));

    fs::remove_file(&of_the_newborn).expect("removed");
    drop((reader, living));
    for folder in [name, format!("{dead}new")] {
        let _ = fs::remove_dir_all(format!("/tmp/lariat-{folder}"));
    }
}

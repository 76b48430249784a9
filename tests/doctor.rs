//! `lariat doctor`: on whatever machine the tests run.

use std::collections::HashMap;
use std::fs;

use assert_cmd::Command;
use serde_json::Value;

/// A domain that no other test run shares.
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
    // Under a limit of its own making a finding would be another; the machine's shared memory is there in any case.
    assert_eq!(verdicts[&Some("transport")], Some("ok"));
}

#[test]
fn what_a_dead_process_left_is_found_and_what_lives_is_not() {
    let name = format!("l{}", std::process::id());
    let living = lariat_wire::Domain::named(&name).expect("a domain");
    let word = "0".repeat(40);
    let of_the_living = format!("/dev/shm/lariat_{name}_{word}_1.data");
    let of_the_dead = format!("/dev/shm/lariat_{name}dead_{word}_1.data");
    for file in [&of_the_living, &of_the_dead] {
        fs::write(file, "left").expect("written");
    }
    let left = lariat_wire::leftovers();
    for file in [&of_the_living, &of_the_dead] {
        fs::remove_file(file).expect("removed");
    }
    drop(living);
    let _ = fs::remove_dir_all(format!("/tmp/lariat-{name}"));
    let mine = |domain: &str| left.iter().find(|of| of.domain == domain).cloned();
    assert_eq!(mine(&name), None);
    let dead = mine(&format!("{name}dead")).expect("found");
    assert_eq!((dead.files, dead.bytes), (1, 4));
    assert_eq!(dead.prefix, format!("/dev/shm/lariat_{name}dead_"));
}

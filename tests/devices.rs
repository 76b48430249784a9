//! `lariat devices` on the machine that runs the tests, which usually has no camera.

use assert_cmd::Command;
use serde_json::Value;

fn devices(arguments: &[&str]) -> std::process::Output {
    let mut command: Command = assert_cmd::cargo::cargo_bin_cmd!("lariat");
    command.arg("devices").args(arguments).output().unwrap()
}

#[test]
fn a_machine_without_a_camera_is_told_so_and_what_to_do() {
    let output = devices(&[]);
    let (listed, said) = (
        String::from_utf8(output.stdout).unwrap(),
        String::from_utf8(output.stderr).unwrap(),
    );
    if output.status.success() {
        assert!(listed.starts_with("/dev/video"), "{listed}");
        assert_eq!(said, "");
    } else {
        assert_eq!(output.status.code(), Some(1));
        assert_eq!(listed, "");
        assert!(said.contains("no camera"), "{said}");
        assert!(said.contains("Plug one in"), "{said}");
    }
}

#[test]
fn as_json_the_list_may_be_empty_but_is_a_list() {
    let output = devices(&["--json"]);
    let list: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(list["schema"], 1);
    let cameras = list["cameras"].as_array().expect("a list");
    assert_eq!(output.status.success(), !cameras.is_empty());
    for camera in cameras {
        assert!(camera["path"].as_str().unwrap().starts_with("/dev/video"));
        assert!(camera["formats"].is_array() || camera["problem"].is_string());
    }
}

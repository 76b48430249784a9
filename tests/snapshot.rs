//! `lariat snapshot` on sources that every machine has.

use assert_cmd::Command;
use image::{GrayImage, Luma, Rgb, RgbImage};
use tempfile::TempDir;

fn snapshot(folder: &TempDir, arguments: &[&str]) -> Command {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("lariat");
    command.current_dir(folder).arg("snapshot").args(arguments);
    command
}

/// Runs a command that must fail and leave only these files; returns its error message.
fn complaint(folder: &TempDir, arguments: &[&str], left: &[&str]) -> String {
    let output = snapshot(folder, arguments).assert().failure();
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, left);
    String::from_utf8(output.get_output().stderr.clone()).unwrap()
}

#[test]
fn a_frame_of_the_rendered_rope_is_a_picture_of_the_size_asked_for() {
    let folder = TempDir::new().unwrap();
    let seeded = |file, seed| ["--size", "320x240", "--seed", seed, file];
    for (file, seed) in [("one.png", "1"), ("again.png", "1"), ("other.png", "2")] {
        snapshot(&folder, &seeded(file, seed)).assert().success();
    }
    let open = |file| image::open(folder.path().join(file)).unwrap().into_rgb8();
    assert_eq!(open("one.png").dimensions(), (320, 240));
    assert_eq!(open("one.png"), open("again.png"));
    assert_ne!(open("one.png"), open("other.png"));
    snapshot(
        &folder,
        &["--size", "320x240", "--after", "200ms", "later.png"],
    )
    .assert()
    .success();
    assert_ne!(open("one.png"), open("later.png"), "the rope moves");
}

#[test]
fn a_frame_of_a_picture_is_that_picture() {
    let folder = TempDir::new().unwrap();
    let colours = RgbImage::from_fn(70, 65, |x, y| Rgb([x as u8, 2 * y as u8, 128]));
    let grey = GrayImage::from_fn(70, 65, |x, y| Luma([(x + y) as u8]));
    colours.save(folder.path().join("colours.png")).unwrap();
    grey.save(folder.path().join("grey.png")).unwrap();
    for source in ["colours.png", "grey.png"] {
        snapshot(&folder, &["out.png", "--force", "--source", source])
            .assert()
            .success();
        let [out, source] =
            ["out.png", source].map(|file| image::open(folder.path().join(file)).unwrap());
        assert_eq!(out, source);
    }
}

#[test]
fn without_a_frame_no_file_is_written() {
    let folder = TempDir::new().unwrap();
    let camera = ["out.png", "--source", "/dev/video4711"];
    assert!(complaint(&folder, &camera, &[]).contains("there is no /dev/video4711"));
    let said = complaint(&folder, &["out.jpg"], &[]);
    assert!(said.contains("ends in .png, not out.jpg"), "{said}");
    let said = complaint(&folder, &["missing/out.png"], &[]);
    assert!(said.contains("cannot write missing/out.png"), "{said}");

    RgbImage::new(70, 65)
        .save(folder.path().join("only.png"))
        .unwrap();
    let late = ["out.png", "--source", "only.png", "--after", "1s"];
    let said = complaint(&folder, &late, &["only.png"]);
    assert!(said.contains("ended after 1 frames"), "{said}");
}

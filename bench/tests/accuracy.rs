//! Tests of the command on small data sets, valid and invalid.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use image::{GrayImage, Luma, Rgb, RgbImage};
use tempfile::TempDir;

/// Returns 1 within the bar, 0 on the table.
fn is_rope(x: u32, y: u32) -> u8 {
    u8::from((20..180).contains(&x) && (40..50).contains(&y))
}

/// Creates a data set with one picture of a dark bar.
fn dataset() -> TempDir {
    let root = TempDir::new().unwrap();
    for folder in ["bars/images", "bars/labels"] {
        fs::create_dir_all(root.path().join(folder)).unwrap();
    }
    RgbImage::from_fn(200, 100, |x, y| Rgb([220 - 180 * is_rope(x, y); 3]))
        .save(root.path().join("bars/images/bar.png"))
        .unwrap();
    GrayImage::from_fn(200, 100, |x, y| Luma([is_rope(x, y)]))
        .save(root.path().join("bars/labels/bar.png"))
        .unwrap();
    root
}

fn accuracy(dataset: &Path, more: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lariat-bench"));
    command.args(["accuracy", "--dataset"]).arg(dataset);
    for (option, path) in ["--csv", "--overlay"].iter().zip(more) {
        command.arg(option).arg(path);
    }
    command.output().unwrap()
}

/// Returns the error for an invalid data set. Checks that nothing is written.
fn refusal(dataset: &Path) -> String {
    let out = TempDir::new().unwrap();
    let (csv, overlay) = (out.path().join("all.csv"), out.path().join("overlays"));
    let done = accuracy(dataset, &[&csv, &overlay]);
    assert_eq!(done.status.code(), Some(1));
    assert!(done.stdout.is_empty());
    assert_eq!(fs::read_dir(out.path()).unwrap().count(), 0);
    String::from_utf8(done.stderr).unwrap()
}

#[test]
fn a_good_set_gives_a_table_a_csv_and_overlays() {
    let (data, out) = (dataset(), TempDir::new().unwrap());
    let (csv, overlay) = (out.path().join("all.csv"), out.path().join("overlays"));
    let done = accuracy(data.path(), &[&csv, &overlay]);
    assert!(done.status.success(), "{done:?}");
    let table = String::from_utf8(done.stdout).unwrap();
    let row = table.lines().find(|l| l.starts_with("bars ")).unwrap();
    let dice: f64 = row.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((0.97..=1.0).contains(&dice), "{row}");
    assert_eq!(fs::read_to_string(csv).unwrap().lines().count(), 2);
    for name in ["bar.png", "contact.png"] {
        let picture = fs::read(overlay.join("bars").join(name)).unwrap();
        let picture = image::load_from_memory(&picture).unwrap();
        assert!(picture.width() > 0);
    }
}

#[test]
fn a_folder_that_is_no_data_set_is_refused() {
    let root = TempDir::new().unwrap();
    let none = refusal(&root.path().join("nowhere"));
    assert!(none.contains("cannot list the folder") && none.contains("nowhere"));
    assert!(refusal(root.path()).contains("has no set"));
}

#[test]
fn a_picture_without_its_label_is_refused() {
    let data = dataset();
    fs::remove_file(data.path().join("bars/labels/bar.png")).unwrap();
    assert!(refusal(data.path()).contains("bar.png has no label"));
}

#[test]
fn a_label_of_another_size_is_refused() {
    let data = dataset();
    GrayImage::new(100, 200)
        .save(data.path().join("bars/labels/bar.png"))
        .unwrap();
    let said = refusal(data.path());
    assert!(
        said.contains("200×100") && said.contains("100×200"),
        "{said}"
    );
}

#[test]
fn a_label_in_colour_is_refused() {
    let data = dataset();
    RgbImage::new(200, 100)
        .save(data.path().join("bars/labels/bar.png"))
        .unwrap();
    assert!(refusal(data.path()).contains("must be 8-bit grey"));
}

#[test]
fn a_broken_picture_is_refused_after_good_ones_too() {
    let data = dataset();
    let set = data.path().join("bars");
    fs::copy(set.join("labels/bar.png"), set.join("labels/zebra.png")).unwrap();
    let whole = fs::read(set.join("images/bar.png")).unwrap();
    fs::write(set.join("images/zebra.png"), &whole[..whole.len() / 2]).unwrap();
    let said = refusal(data.path());
    assert!(
        said.contains("cannot read") && said.contains("zebra.png"),
        "{said}"
    );
}

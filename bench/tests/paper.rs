//! Tests of `lariat-bench paper` from outside: the page, its numbers, and rejected input.

use image::{Rgb, RgbImage};
use lariat_drawn::scenes::{Class, draw};
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn lariat_bench(folder: &TempDir, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lariat-bench"));
    command.current_dir(folder).args(args).output().unwrap()
}

/// Returns the names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn save_rope(path: &Path) {
    let still = draw(Class::Crossings1, 7, 320, 240).unwrap();
    let picture = RgbImage::from_raw(320, 240, still.rgb).unwrap();
    picture.save(path).unwrap();
}

#[test]
fn a_page_and_the_numbers_behind_each_figure_are_written() {
    let folder = TempDir::new().unwrap();
    let output = lariat_bench(&folder, &["paper", "--quick", "--out", "report/of/it"]);
    assert!(output.status.success(), "{output:?}");
    let written = names(&folder.path().join("report/of/it"));
    let html = std::fs::read_to_string(folder.path().join("report/of/it/report.html")).unwrap();
    assert!(html.starts_with("<!DOCTYPE html>") && html.ends_with("</html>\n"));
    assert_eq!(written.last().unwrap(), "report.html");
    for csv in &written[..written.len() - 1] {
        assert!(csv.starts_with("figure-") && csv.ends_with(".csv"), "{csv}");
        assert!(html.contains(csv.as_str()), "{csv}");
    }
    let said = String::from_utf8(output.stdout).unwrap();
    for figure in ["Figure 1.", "Figure 3. The paper's finding", "Figure 14."] {
        assert!(said.contains(figure), "{said}");
    }
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(
        told,
        "lariat-bench: the report is report/of/it/report.html\n"
    );
}

#[test]
fn real_pictures_are_measured_against_the_skeleton_and_the_page_says_so() {
    let folder = TempDir::new().unwrap();
    std::fs::create_dir(folder.path().join("pictures")).unwrap();
    save_rope(&folder.path().join("pictures/rope.png"));
    let args = ["paper", "--quick", "--out", "out", "--images", "pictures"];
    let output = lariat_bench(&folder, &args);
    assert!(output.status.success(), "{output:?}");
    let html = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(html.contains("rope.png"));
    assert!(html.contains("the centerline that the skeleton gives"));
    // The light and rest experiments need a ground truth that a picture does not have.
    let written = names(&folder.path().join("out"));
    assert!(
        !written
            .iter()
            .any(|name| name.contains("light") || name.contains("rest"))
    );
    assert!(written.contains(&"figure-2-fits.csv".to_owned()));
}

#[test]
fn what_is_no_good_is_refused_with_a_sentence_and_nothing_is_written() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("empty")).unwrap();
    std::fs::write(at("file"), "not a folder").unwrap();
    std::fs::write(at("broken.png"), "not a picture").unwrap();
    let table = RgbImage::from_pixel(200, 160, Rgb([210, 205, 200]));
    table.save(at("table.png")).unwrap();
    for (out, images, why) in [
        ("file", None, "cannot write to the folder file"),
        ("file/in/it", None, "cannot write to the folder file/in/it"),
        (
            "/proc/no/such",
            None,
            "cannot write to the folder /proc/no/such",
        ),
        (
            "new",
            Some("empty"),
            "there is no picture (PNG, JPEG, WebP, TIFF, BMP or PGM) in the folder empty",
        ),
        (
            "new",
            Some("nowhere.png"),
            "cannot open the picture nowhere.png",
        ),
        ("new", Some("broken.png"), "broken.png cannot be decoded"),
        (
            "new",
            Some("table.png"),
            "no open rope that is wholly seen was found in the 1 picture",
        ),
    ] {
        let mut args = vec!["paper", "--quick", "--out", out];
        args.extend(images.iter().flat_map(|images| ["--images", images]));
        let output = lariat_bench(&folder, &args);
        assert_eq!(output.status.code(), Some(1), "{args:?}");
        assert!(output.stdout.is_empty(), "{args:?}");
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(told.starts_with(&format!("lariat-bench: {why}")), "{told}");
        assert_eq!(told.lines().count(), 1, "{told}");
        assert!(!at("new").exists(), "{args:?}");
    }
    assert_eq!(
        names(folder.path()),
        ["broken.png", "empty", "file", "table.png"]
    );
}

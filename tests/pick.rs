//! `lariat pick` on pictures drawn here.

use assert_cmd::Command;
use image::{GrayImage, Rgb, RgbImage};
use serde_json::Value;
use std::process::Output;
use tempfile::TempDir;

fn lariat(folder: &TempDir, args: &[&str]) -> Output {
    let mut command: Command = assert_cmd::cargo::cargo_bin_cmd!("lariat");
    command.current_dir(folder).args(args).output().unwrap()
}

/// Saves a table with a blue bar and a red one, each 11 px high and shaded like a round rope.
fn save_bars(folder: &TempDir) {
    let round = |color: [u8; 3], row: u32| {
        let off = (row as f32 - 5.0) / 5.5;
        let light = 1.1 - 0.3 * off * off;
        Rgb(color.map(|level| (f32::from(level) * light) as u8))
    };
    let picture = RgbImage::from_fn(240, 160, |x, y| {
        let along = (20..220).contains(&x);
        match y {
            40..51 if along => round([40, 90, 190], y - 40),
            110..121 if along => round([190, 30, 40], y - 110),
            _ => Rgb([225, 220, 210]),
        }
    });
    picture.save(folder.path().join("bars.png")).unwrap();
}

fn mask(folder: &TempDir, name: &str) -> GrayImage {
    image::open(folder.path().join(name)).unwrap().into_luma8()
}

fn rows(mask: &GrayImage) -> Vec<u32> {
    (0..160)
        .filter(|&y| mask.get_pixel(120, y).0[0] == 255)
        .collect()
}

#[test]
fn what_is_printed_is_a_settings_file_that_finds_the_ropes() {
    let folder = TempDir::new().unwrap();
    save_bars(&folder);
    let output = lariat(&folder, &["pick", "bars.png"]);
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    // Both masks show the same pixels.
    let (compared, drawn) = said.split_once('\n').unwrap();
    let confidences = compared
        .strip_prefix("lariat: confidence of the ropes: ")
        .unwrap();
    let [by_color, automatic] = ["by this mask", "by the automatic one"].map(|whose| {
        let said = confidences
            .split(", ")
            .find_map(|part| part.strip_suffix(whose));
        said.unwrap().trim().parse::<f32>().unwrap()
    });
    assert!(by_color > 0.5 && automatic > 0.5, "{said}");
    assert_eq!(drawn, "lariat: the mask is drawn in bars-mask.png\n");
    let bars: Vec<u32> = (40..51).chain(110..121).collect();
    assert_eq!(rows(&mask(&folder, "bars-mask.png")), bars);

    std::fs::write(folder.path().join("lariat.toml"), &output.stdout).unwrap();
    let shown = lariat(&folder, &["config", "check"]);
    assert!(shown.status.success(), "{shown:?}");
    let traced = lariat(&folder, &["trace", "bars.png", "--json"]);
    let report: Value = serde_json::from_slice(&traced.stdout).unwrap();
    assert_eq!(report["curves"].as_array().unwrap().len(), 2);

    // The mask itself can be used as an input, too.
    std::fs::create_dir(folder.path().join("masks")).unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::rename(at("bars-mask.png"), at("masks/bars.png")).unwrap();
    let traced = lariat(
        &folder,
        &["trace", "bars.png", "--masks", "masks", "--json"],
    );
    let report: Value = serde_json::from_slice(&traced.stdout).unwrap();
    assert_eq!(report["curves"].as_array().unwrap().len(), 2);
}

#[test]
fn a_point_chooses_one_rope() {
    let folder = TempDir::new().unwrap();
    save_bars(&folder);
    for (at, bar) in [("100,45", 40..51), ("100.5, 114", 110..121)] {
        let output = lariat(
            &folder,
            &[
                "pick", "bars.png", "--at", at, "--out", "mask.png", "--force",
            ],
        );
        assert!(output.status.success(), "{output:?}");
        let printed = String::from_utf8(output.stdout).unwrap();
        assert_eq!(printed.matches("hue_deg").count(), 1, "{printed}");
        assert_eq!(rows(&mask(&folder, "mask.png")), bar.collect::<Vec<_>>());
    }
}

#[test]
fn several_points_choose_several_colors() {
    let folder = TempDir::new().unwrap();
    save_bars(&folder);
    let bars: Vec<u32> = (40..51).chain(110..121).collect();
    for at in [
        &["--at", "100,45", "--at", "60,114"][..],
        &["--at", "100,45,60,114"],
    ] {
        let args = ["pick", "bars.png", "--force"];
        let output = lariat(&folder, &[&args, at].concat());
        assert!(output.status.success(), "{output:?}");
        assert_eq!(rows(&mask(&folder, "bars-mask.png")), bars);
        // `trace` accepts the positions in the same form.
        let traced = lariat(&folder, &[&["trace", "bars.png", "--json"], at].concat());
        assert!(traced.status.success(), "{traced:?}");
        let report: Value = serde_json::from_slice(&traced.stdout).unwrap();
        assert_eq!(report["curves"].as_array().unwrap().len(), 2);
    }
}

#[test]
fn no_file_is_replaced_that_the_user_did_not_name() {
    let folder = TempDir::new().unwrap();
    save_bars(&folder);
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("bars-mask.png"), "mine").unwrap();
    let output = lariat(&folder, &["pick", "bars.png"]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("there is a file bars-mask.png already: name another one"),
        "{said}"
    );
    assert_eq!(std::fs::read(at("bars-mask.png")).unwrap(), b"mine");
    // The colors are found nevertheless.
    assert!(
        String::from_utf8(output.stdout)
            .unwrap()
            .contains("hue_deg")
    );

    let before = std::fs::read(at("bars.png")).unwrap();
    let onto = ["pick", "bars.png", "--out", "bars.png", "--force"];
    let output = lariat(&folder, &onto);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("bars.png is what is read here, and is not overwritten"),
        "{said}"
    );
    assert_eq!(std::fs::read(at("bars.png")).unwrap(), before);

    let output = lariat(&folder, &["pick", "bars.png", "--out", "mask.jpg"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("give it a name that ends in .png, not mask.jpg"),
        "{said}"
    );
}

#[test]
fn colors_that_are_not_enough_are_said() {
    let folder = TempDir::new().unwrap();
    // Nine short strokes of one color.
    RgbImage::from_fn(240, 160, |x, y| {
        let (along, across) = (x.wrapping_sub(20) % 70, y.wrapping_sub(30) % 45);
        match (20..220).contains(&x) && (30..150).contains(&y) && along < 40 && across < 5 {
            true => Rgb([40, 90, 190]),
            false => Rgb([225, 220, 210]),
        }
    })
    .save(folder.path().join("strokes.png"))
    .unwrap();
    let output = lariat(&folder, &["pick", "strokes.png", "--at", "40,32"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("the mask falls into 9 pieces"), "{said}");
    // The result is printed nevertheless.
    assert!(
        String::from_utf8(output.stdout)
            .unwrap()
            .contains("hue_deg")
    );
    assert!(folder.path().join("strokes-mask.png").exists());
}

#[test]
fn what_cannot_be_picked_is_said_in_a_sentence() {
    let folder = TempDir::new().unwrap();
    save_bars(&folder);
    RgbImage::from_pixel(64, 48, Rgb([225, 220, 210]))
        .save(folder.path().join("table.png"))
        .unwrap();
    std::fs::write(folder.path().join("letter.png"), "Dear rope,\n").unwrap();
    for (args, sentence) in [
        (
            &["bars.png", "--at", "240,45"][..],
            "bars.png: the point (240, 45) is outside of the image, whose last pixel is (239, 159)",
        ),
        (
            &["bars.png", "--at", "-7,45"],
            "bars.png: the point (-7, 45) is outside of the image, whose last pixel is (239, 159)",
        ),
        (
            &["bars.png", "--at", "100,80"],
            "bars.png: at (100, 80) is the table, and no rope within 10 pixels: give a point on the rope",
        ),
        (
            &["table.png"],
            "table.png: no rope stands out from the table by itself: give a point on it",
        ),
        (&["letter.png"], "letter.png cannot be decoded"),
        (&["missing.png"], "cannot open the picture missing.png"),
        (
            &["bars.png", "--at", "middle"],
            "positions are two numbers of pixels each",
        ),
    ] {
        let output = lariat(&folder, &[&["pick"], args].concat());
        assert!(!output.status.success(), "{output:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(sentence), "{said}");
        assert!(output.stdout.is_empty());
    }
}

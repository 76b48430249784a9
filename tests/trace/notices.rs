//! Notices about the doubts of the automatic mask, picture by picture.

use image::{Rgb, RgbImage};
use tempfile::TempDir;

use super::{TABLE, lines, save, trace, wave_picture};

/// A bent stroke of 86 pixels on a checkered table.
fn checkered() -> RgbImage {
    RgbImage::from_fn(320, 240, |x, y| {
        let along = x as f32 - 100.0;
        let middle = 100.0 + 0.6 * along + 12.0 * (along / 70.0 * std::f32::consts::PI).sin();
        match (x / 20 + y / 20) % 2 {
            _ if (100..170).contains(&x) && (y as f32 - middle).abs() < 4.5 => Rgb([30, 30, 120]),
            0 => TABLE,
            _ => Rgb([120, 116, 110]),
        }
    })
}

#[test]
fn an_unsure_curve_is_named_with_what_to_do() {
    let folder = TempDir::new().unwrap();
    save(&folder, "cloth.png", &checkered());
    save(&folder, "wave.png", &wave_picture());
    let args = ["cloth.png", "wave.png", "--json"];
    let output = trace(&folder, &args).output().unwrap();
    // It is a warning: the exit code is that of success.
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    let text = said.strip_prefix("lariat: cloth.png: ").unwrap();
    let kinds = [
        ("unsure", "a curve may not be a rope"),
        ("like-a-mark", "something small is unlike"),
    ];
    let said_of = |(_, begin): &&(&str, &str)| text.starts_with(begin);
    let (kind, _) = kinds.iter().find(said_of).expect(&said);
    assert!(text.contains("lariat pick"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");

    let reports = lines(&output.stdout);
    let [notice] = &reports[0]["notices"].as_array().unwrap()[..] else {
        panic!("one notice in {}", reports[0]["notices"]);
    };
    assert_eq!(notice["kind"], *kind);
    assert_eq!(notice["text"], text.trim_end());
    assert_eq!(reports[1]["notices"].as_array().unwrap().len(), 0);
}

#[test]
fn a_picture_that_is_all_black_is_named_and_an_empty_table_is_not() {
    let folder = TempDir::new().unwrap();
    save(&folder, "black.png", &RgbImage::new(320, 240));
    save(&folder, "table.png", &RgbImage::from_pixel(320, 240, TABLE));
    let output = trace(&folder, &["black.png", "table.png"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.starts_with("lariat: black.png: the whole image is black"),
        "{said}"
    );
    assert_eq!(said.lines().count(), 1, "{said}");
}

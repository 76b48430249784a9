//! External masks in a folder.

use image::imageops::{FilterType, blur, resize};
use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage};
use serde_json::Value;
use tempfile::TempDir;

use super::{TABLE, distance_to_wave, lines, points, save, trace, wave_picture};

#[test]
fn a_mask_from_a_folder_is_taken_in_the_place_of_ones_own() {
    let folder = TempDir::new().unwrap();
    std::fs::create_dir(folder.path().join("masks")).unwrap();
    // Only the mask distinguishes this rope from its table.
    save(&folder, "table.jpg", &RgbImage::from_pixel(320, 240, TABLE));
    let mask = wave_picture();
    let white = |pixel: &Rgb<u8>| if pixel.0[0] < 130 { 255 } else { 0 };
    let mask = GrayImage::from_fn(320, 240, |x, y| image::Luma([white(mask.get_pixel(x, y))]));
    mask.save(folder.path().join("masks/table.png")).unwrap();
    let args = ["table.jpg", "--masks", "masks", "--json"];
    let output = trace(&folder, &args).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let report = &lines(&output.stdout)[0];
    assert_eq!(report["curves"].as_array().unwrap().len(), 1);
    for p in points(&report["curves"][0]["points"]) {
        assert!(distance_to_wave(p) < 1.0, "{p:?}");
    }
}

#[test]
fn a_network_that_is_missing_or_none_is_named() {
    let folder = TempDir::new().unwrap();
    save(&folder, "wave.png", &wave_picture());
    let complaint = |file: &str| {
        let args = ["wave.png", "--mask", "network", "--network", file];
        let output = trace(&folder, &args).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    assert_eq!(
        complaint("my.weights"),
        "lariat: cannot read my.weights: No such file or directory (os error 2)\n"
    );
    std::fs::write(folder.path().join("my.weights"), "none").unwrap();
    assert_eq!(
        complaint("my.weights"),
        "lariat: my.weights: These are not weights of lariat's network, which begin with LARIATN1: give the file that \
         training has written.\n"
    );
}

#[test]
fn a_network_that_is_never_asked_is_refused() {
    let folder = TempDir::new().unwrap();
    save(&folder, "wave.png", &wave_picture());
    let weights = include_bytes!("../../crates/network/ropes.weights");
    std::fs::write(folder.path().join("my.weights"), weights).unwrap();
    let blue = "[{ hue_deg = [190, 250] }]";
    let args = ["wave.png", "--mask", blue, "--network", "my.weights"];
    let output = trace(&folder, &args).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "lariat: a network is given, which colour ranges and masks from elsewhere have no use for: leave it out, or take the \
         mask \"auto\" or \"network\"\n"
    );
}

#[test]
fn the_network_finds_a_rope_where_it_is_asked_to() {
    let folder = TempDir::new().unwrap();
    save(&folder, "wave.png", &wave_picture());
    let weights = include_bytes!("../../crates/network/ropes.weights");
    std::fs::write(folder.path().join("my.weights"), weights).unwrap();
    let seen = |args: &[&str]| {
        let args = [&["wave.png", "--json", "--mask", "network"], args].concat();
        let output = trace(&folder, &args).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        lines(&output.stdout)[0].clone()
    };
    let report = seen(&[]);
    assert_eq!(report["curves"].as_array().unwrap().len(), 1);
    for p in points(&report["curves"][0]["points"]) {
        assert!(distance_to_wave(p) < 2.0, "{p:?}");
    }
    assert_eq!(
        seen(&["--network", "my.weights"])["curves"],
        report["curves"]
    );
}

#[test]
fn a_mask_that_is_missing_or_of_another_size_is_named() {
    let folder = TempDir::new().unwrap();
    save(&folder, "wave.png", &wave_picture());
    let complaint = |args: &[&str], code| {
        let output = trace(&folder, args).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let said = |args: &[&str]| complaint(args, 1);
    assert_eq!(
        said(&["wave.png", "--masks", "masks"]),
        "lariat: there is no folder masks: --masks takes a folder of pictures, white for rope\n"
    );
    std::fs::create_dir(folder.path().join("masks")).unwrap();
    assert_eq!(
        said(&["wave.png", "--masks", "masks"]),
        "lariat: there is no mask of wave.png: it would be masks/wave.png\n"
    );
    save(&folder, "masks/wave.png", &RgbImage::new(20, 10));
    assert_eq!(
        said(&["wave.png", "--masks", "masks"]),
        "lariat: masks/wave.png: the mask is 20×10 pixels and its image 320×240: give each image a mask of its own \
         size, or of its proportions\n"
    );
    std::fs::write(
        folder.path().join("lariat.toml"),
        "[extract]\nmask = \"external\"\n",
    )
    .unwrap();
    assert_eq!(
        complaint(&["wave.png"], 2),
        "lariat: the settings say mask = \"external\": name the masks' folder with --masks DIR\n"
    );
}

/// A folder with the wave's picture, and an empty one for masks.
fn wave_without_masks() -> TempDir {
    let folder = TempDir::new().unwrap();
    save(&folder, "wave.png", &wave_picture());
    std::fs::create_dir(folder.path().join("masks")).unwrap();
    folder
}

/// The wave's mask: 255 on the rope.
fn wave_mask() -> GrayImage {
    let picture = wave_picture();
    let level = |x, y| {
        if picture.get_pixel(x, y).0[0] < 130 {
            255
        } else {
            0
        }
    };
    GrayImage::from_fn(320, 240, |x, y| Luma([level(x, y)]))
}

/// Returns the trace with this mask, and the messages on standard error.
fn traced(name: &str, mask: impl Into<DynamicImage>) -> (Value, String) {
    let folder = wave_without_masks();
    mask.into()
        .save(folder.path().join("masks").join(name))
        .unwrap();
    let args = ["wave.png", "--masks", "masks", "--json"];
    let output = trace(&folder, &args).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    (lines(&output.stdout)[0].clone(), said)
}

fn assert_wave(report: &Value, mean_px: f64) {
    let curves = report["curves"].as_array().unwrap();
    assert_eq!(curves.len(), 1, "{report}");
    let points = points(&curves[0]["points"]);
    let sum: f64 = points.iter().map(|&p| distance_to_wave(p)).sum();
    let mean = sum / points.len() as f64;
    assert!(mean < mean_px, "{mean}");
}

#[test]
fn masks_of_numbers_show_their_ropes_and_that_is_told() {
    let mask = wave_mask();
    let of = |value: u8| {
        GrayImage::from_fn(320, 240, |x, y| {
            Luma([value * (mask.get_pixel(x, y).0[0] / 255)])
        })
    };
    let two = GrayImage::from_fn(320, 240, |x, y| {
        Luma([(1 + u8::from(x > 150)) * (mask.get_pixel(x, y).0[0] / 255)])
    });
    let wide = ImageBuffer::from_fn(320, 240, |x, y| Luma([u16::from(two.get_pixel(x, y).0[0])]));
    for mask in [of(1).into(), two.into(), DynamicImage::ImageLuma16(wide)] {
        let (report, said) = traced("wave.png", mask);
        assert_wave(&report, 0.6);
        assert!(said.contains("numbers"), "{said}");
        assert_eq!(report["notices"][0]["kind"], "mask");
    }
}

#[test]
fn masks_coloured_by_instance_show_their_ropes() {
    let mask = wave_mask();
    for colors in [
        [[128, 0, 0], [0, 128, 0]],
        [[90, 0, 0], [0, 0, 180]],
        [[0, 0, 9], [7, 0, 0]],
    ] {
        let colored = RgbImage::from_fn(320, 240, |x, y| {
            let is_rope = mask.get_pixel(x, y).0[0] > 0;
            Rgb(if is_rope {
                colors[usize::from(x > 150)]
            } else {
                [0; 3]
            })
        });
        let (report, _) = traced("wave.png", colored);
        assert_wave(&report, 0.6);
    }
}

#[test]
fn a_weak_soft_mask_is_cut_by_its_own_histogram() {
    let soft = blur(&wave_mask(), 2.0);
    for strength in [0.25, 0.45] {
        let weak = |x, y| Luma([(f64::from(soft.get_pixel(x, y).0[0]) * strength) as u8]);
        let (report, said) = traced("wave.png", GrayImage::from_fn(320, 240, weak));
        assert_wave(&report, 0.6);
        assert_eq!(said, "");
    }
    let noise = |x, y| Luma([((x * 7919 + y * 104_729) % 41) as u8]);
    let (report, said) = traced("wave.png", GrayImage::from_fn(320, 240, noise));
    assert_eq!(report["curves"].as_array().unwrap().len(), 0);
    assert!(said.contains("brightest level is 40 of 255"), "{said}");
}

#[test]
fn a_mask_black_on_white_is_turned_and_a_white_one_refused() {
    let mut inverted = wave_mask();
    image::imageops::invert(&mut inverted);
    let (report, said) = traced("wave.png", inverted);
    assert_wave(&report, 0.6);
    assert!(
        said.contains("its dark part is taken for the ropes"),
        "{said}"
    );
    let folder = wave_without_masks();
    let white = GrayImage::from_pixel(320, 240, Luma([255]));
    white.save(folder.path().join("masks/wave.png")).unwrap();
    let output = trace(&folder, &["wave.png", "--masks", "masks"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("masks/wave.png") && said.contains("level 255 everywhere"),
        "{said}"
    );
}

#[test]
fn masks_of_a_networks_size_kind_and_name_are_taken() {
    let mask = wave_mask();
    for (name, size, mean_px) in [
        ("wave.png", [160, 120], 0.6),
        ("wave.png", [640, 480], 0.6),
        ("wave.png", [256, 256], 0.6),
        ("wave.jpg", [320, 240], 0.6),
        ("wave_mask.png", [320, 240], 0.6),
        ("wave.mask.png", [320, 240], 0.6),
    ] {
        let scaled = resize(&mask, size[0], size[1], FilterType::Triangle);
        let (report, said) = traced(name, scaled);
        assert_wave(&report, mean_px);
        assert_eq!(
            said.contains("is scaled from"),
            size != [320, 240],
            "{said}"
        );
        assert_eq!(said.contains("square"), size == [256, 256], "{said}");
    }
}

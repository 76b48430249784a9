//! Masks from elsewhere, in a folder.

use image::{GrayImage, Rgb, RgbImage};
use tempfile::TempDir;

use super::{TABLE, distance_to_wave, lines, points, save, trace, wave_picture};

#[test]
fn a_mask_from_a_folder_is_taken_in_the_place_of_ones_own() {
    let folder = TempDir::new().unwrap();
    std::fs::create_dir(folder.path().join("masks")).unwrap();
    // Nothing tells this rope from its table but the mask.
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
        "lariat: my.weights: These are no weights of lariat's network, which begin with LARIATN1: give the file that \
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
        "lariat: there is no folder masks: --masks takes a folder of PNG pictures, white for rope\n"
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
         size\n"
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

//! Unusable sources, and unusual but usable ones.

use std::fs;

use image::{GrayImage, Luma, Rgb, RgbImage};

use crate::rig::Bench;

/// Runs the chain on an unusable source, and returns its output.
fn refused(bench: &Bench, source: &str) -> String {
    let output = bench.run(&["run", "--source", source, "--fps", "max"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    bench.assert_nothing_is_left();
    said
}

/// Runs the chain on a source. Returns the number of frames, and the number of frames with a curve.
fn accepted(bench: &Bench, source: &str) -> (u64, u64) {
    let output = bench.run(&[
        "run",
        "--source",
        source,
        "--fps",
        "max",
        "--lossless",
        "--out",
        "out",
    ]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    bench.assert_nothing_is_left();
    let frames = &bench.summary("out")["frames"];
    let count = |key: &str| frames[key].as_u64().unwrap();
    (count("received"), count("with_curve"))
}

fn rope_on_a_table(width: u32, height: u32) -> RgbImage {
    let middle = height / 2;
    RgbImage::from_fn(width, height, |x, y| {
        let rope = y.abs_diff(middle) <= 5 && (width / 8..width - width / 8).contains(&x);
        if rope {
            Rgb([20, 60, 160])
        } else {
            Rgb([190, 185, 175])
        }
    })
}

#[test]
fn what_is_not_there_is_named() {
    let bench = Bench::new();
    assert!(refused(&bench, "nowhere.png").contains("nowhere.png"));
}

#[test]
fn a_truncated_png_is_refused() {
    let bench = Bench::new();
    let path = bench.path("cut.png");
    rope_on_a_table(320, 240).save(&path).unwrap();
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert!(refused(&bench, "cut.png").contains("cut.png"));
}

#[test]
fn a_folder_without_images_is_refused() {
    let bench = Bench::new();
    fs::create_dir(bench.path("empty")).unwrap();
    assert!(refused(&bench, "empty").contains("empty"));
}

#[test]
fn a_video_of_0_bytes_is_refused() {
    let bench = Bench::new();
    fs::write(bench.path("nothing.y4m"), b"").unwrap();
    assert!(refused(&bench, "nothing.y4m").contains("nothing.y4m"));
}

#[test]
fn an_image_of_one_pixel_has_no_rope() {
    let bench = Bench::new();
    GrayImage::from_pixel(1, 1, Luma([200]))
        .save(bench.path("one.png"))
        .unwrap();
    assert_eq!(accepted(&bench, "one.png"), (1, 0));
}

#[test]
fn an_image_without_a_rope_is_answered_with_none() {
    let bench = Bench::new();
    RgbImage::from_pixel(320, 240, Rgb([190, 185, 175]))
        .save(bench.path("table.png"))
        .unwrap();
    assert_eq!(accepted(&bench, "table.png"), (1, 0));
}

#[test]
fn an_image_of_48_megapixels_goes_through_or_is_too_large_for_shared_memory() {
    let bench = Bench::new();
    rope_on_a_table(8000, 6000)
        .save(bench.path("large.png"))
        .unwrap();
    let output = bench.run(&[
        "run",
        "--source",
        "large.png",
        "--fps",
        "max",
        "--out",
        "out",
    ]);
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        let frames = &bench.summary("out")["frames"];
        assert_eq!(
            (frames["received"].as_u64(), frames["with_curve"].as_u64()),
            (Some(1), Some(1))
        );
    } else {
        assert!(said.contains("/dev/shm has "), "{said}");
    }
    bench.assert_nothing_is_left();
}

#[test]
fn a_folder_of_pictures_comes_in_natural_order_and_whole() {
    let bench = Bench::new();
    fs::create_dir(bench.path("pictures")).unwrap();
    for number in [1, 2, 10] {
        rope_on_a_table(300 + number, 200)
            .save(bench.path(&format!("pictures/img{number}.png")))
            .unwrap();
    }
    assert_eq!(accepted(&bench, "pictures"), (3, 3));
}

#[test]
fn a_table_that_cannot_be_told_from_a_rope_is_named_once() {
    let bench = Bench::new();
    let folder = bench.path("cloth");
    fs::create_dir(&folder).unwrap();
    let cloth = RgbImage::from_fn(320, 240, |x, y| match (x / 20 + y / 20) % 2 {
        0 => Rgb([190, 185, 175]),
        _ => Rgb([90, 85, 75]),
    });
    for frame in 0..40 {
        cloth.save(folder.join(format!("{frame}.png"))).unwrap();
    }
    let arguments = ["run", "--source", "cloth", "--fps", "max", "--lossless"];
    let output = bench.run(&arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_eq!(said.matches("the table is checkered").count(), 1, "{said}");
    bench.assert_nothing_is_left();
}

#[test]
fn a_part_of_a_folder_is_shown_and_nothing_of_the_rest_is_lost() {
    let bench = Bench::new();
    fs::create_dir(bench.path("pictures")).unwrap();
    for number in 1..=10 {
        rope_on_a_table(300, 200)
            .save(bench.path(&format!("pictures/{number}.png")))
            .unwrap();
    }
    let arguments = [
        "run",
        "--source",
        "pictures",
        "--fps",
        "max",
        "--lossless",
        "--out",
        "out",
        "--from",
        "2",
        "--to",
        "9",
        "--every",
        "3",
    ];
    let output = bench.run(&arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("frame n is frame 2 + 3 (n - 1)"), "{said}");
    let frames = &bench.summary("out")["frames"];
    assert_eq!(frames["received"].as_u64(), Some(3));
    assert_eq!(frames["lost"]["source"].as_u64(), Some(0));
    bench.assert_nothing_is_left();
}

#[test]
fn a_folder_that_is_followed_from_its_first_picture_on_ends_after_so_many() {
    let bench = Bench::new();
    let folder = bench.path("growing");
    fs::create_dir(&folder).unwrap();
    let arguments = [
        "--source", "growing", "--follow", "--frames", "3", "--out", "out",
    ];
    let chain = bench.start(&arguments);
    for number in 1..=3 {
        let beside = bench.path("beside.png");
        rope_on_a_table(320, 240).save(&beside).unwrap();
        fs::rename(&beside, folder.join(format!("{number}.png"))).unwrap();
    }
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let frames = &bench.summary("out")["frames"];
    assert_eq!(frames["received"].as_u64(), Some(3));
    assert_eq!(frames["with_curve"].as_u64(), Some(3));
    bench.assert_nothing_is_left();
}

#[test]
fn a_folder_that_stays_empty_is_followed_until_the_chain_is_told_to_end() {
    let bench = Bench::new();
    fs::create_dir(bench.path("empty")).unwrap();
    let arguments = [
        "run",
        "--source",
        "empty",
        "--follow",
        "--duration",
        "300ms",
    ];
    let output = bench.run(&arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("no picture is there yet"), "{said}");
    let chain = bench.start(&["--source", "empty", "--follow"]);
    chain.signal_chain(rustix::process::Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}

#[test]
fn what_was_recorded_is_seen_again_as_it_was() {
    let bench = Bench::new();
    let recorded = [
        "run",
        "--fps",
        "max",
        "--frames",
        "40",
        "--lossless",
        "--record",
        "run.mcap",
    ];
    let output = bench.run(&recorded);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    // The whole recording at its own pace, and a part of it as fast as possible.
    let whole = ["--source", "run.mcap", "--lossless", "--out", "whole"];
    let part = [
        "--source",
        "run.mcap",
        "--lossless",
        "--out",
        "part",
        "--fps",
        "max",
        "--from",
        "11",
        "--to",
        "30",
        "--every",
        "2",
    ];
    for (arguments, folder, count) in [(&whole[..], "whole", 40), (&part, "part", 10)] {
        let output = bench.run(&[&["run"], arguments].concat());
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let summary = bench.summary(folder);
        assert_eq!(summary["frames"]["received"].as_u64(), Some(count));
        assert_eq!(summary["frames"]["lost"]["source"].as_u64(), Some(0));
        // The truth is recorded, too, and the curves are close to it.
        let error = summary["error_px"]["centerline"]["mean"].as_f64();
        assert!(error.is_some_and(|error| error < 0.3), "{summary}");
    }
    bench.assert_nothing_is_left();
}

//! Once warm, no frame allocates.

use crate::drawing::{Rope, Table, extractor};
use lariat_extract::{Extractor, HsvRange, Image, Mask, Method, Options, PixelFormat};
use lariat_test_support::allocations;

/// Two moving ropes, the first with a self-crossing.
fn film() -> Vec<Vec<u8>> {
    let mut table = Table::new(320, 240, [215.0, 212.0, 205.0]);
    table.noise = 2.0;
    (0..40)
        .map(|frame| {
            let phase = frame as f32 * std::f32::consts::TAU / 40.0;
            let (sin, cos) = (0.3 * phase.sin()).sin_cos();
            let first = Rope::along(7.0, [30.0, 60.0, 130.0], move |t| {
                let a = -4.4 + 8.8 * t;
                let (x, y) = (
                    16.0 * a - (36.0 + 6.0 * phase.cos()) * a.sin(),
                    40.0 * a.cos(),
                );
                [150.0 + x * cos - y * sin, 110.0 + x * sin + y * cos]
            });
            let second = Rope::along(7.0, [160.0, 60.0, 60.0], move |t| {
                [30.0 + 240.0 * t, 190.0 + 15.0 * (4.0 * t + phase).sin()]
            });
            table.seed = frame;
            table.draw(&[first, second])
        })
        .collect()
}

#[test]
fn no_frame_of_a_moving_rope_allocates_once_warm() {
    let frames = film();
    let mut extractor = extractor();
    // As an external mask, the inverted green channel is as good as any.
    let masks: Vec<Vec<u8>> = frames
        .iter()
        .map(|rgb| rgb.chunks_exact(3).map(|pixel| 255 - pixel[1]).collect())
        .collect();
    let mut run_masked = |frames: &[Vec<u8>]| {
        let mut curves = 0;
        for (rgb, mask) in frames.iter().zip(&masks) {
            let image = Image::new(rgb, 320, 240, 960, PixelFormat::Rgb8).expect("a whole image");
            let mask = Image::new(mask, 320, 240, 320, PixelFormat::Gray8).expect("a whole image");
            let scene = extractor.extract_masked(&image, &mask);
            curves += scene.expect("a mask of the size").curves.len();
        }
        curves
    };
    run_masked(&frames);
    let before = allocations();
    assert_eq!(run_masked(&frames), 80);
    assert_eq!(allocations() - before, 0, "with masks from elsewhere");

    let mut run = |frames: &[Vec<u8>]| {
        let mut curves = 0;
        for rgb in frames {
            let image = Image::new(rgb, 320, 240, 960, PixelFormat::Rgb8).expect("a whole image");
            curves += extractor.extract(&image).curves.len();
        }
        curves
    };
    run(&frames);
    let before = allocations();
    assert_eq!(run(&frames), 80);
    assert_eq!(allocations() - before, 0);
}

#[test]
fn no_frame_that_is_followed_by_its_edges_allocates_once_warm() {
    let frames = film();
    let red_and_blue = [[200.0, 250.0], [350.0, 10.0]].map(|hue_deg| HsvRange {
        hue_deg,
        saturation: [0.3, 1.0],
        value: [0.1, 1.0],
    });
    let options = Options::default().mask(Mask::Hsv(red_and_blue.into()));
    let mut extractor = Extractor::new(options).expect("the options are valid");
    extractor.prepare(320, 240);
    let mut run = || {
        let (mut curves, mut followed) = (0, 0);
        for rgb in &frames {
            let image = Image::new(rgb, 320, 240, 960, PixelFormat::Rgb8).expect("a whole image");
            let scene = extractor.extract(&image);
            (curves, followed) = (
                curves + scene.curves.len(),
                followed + usize::from(scene.followed),
            );
        }
        (curves, followed)
    };
    run();
    let before = allocations();
    let (curves, followed) = run();
    assert_eq!((curves, allocations() - before), (80, 0));
    assert!(followed > 10, "{followed} of 40 frames followed");
}

#[test]
fn no_frame_of_a_clustering_allocates_after_preparation() {
    let frames = film();
    for method in [
        Method::KMeans,
        Method::Som,
        Method::Mixture,
        Method::FuzzyMeans,
    ] {
        // The last one is slow: its first frame takes 300 rounds.
        let most = if method == Method::FuzzyMeans { 4 } else { 40 };
        let options = Options::default().method(method);
        let mut extractor = Extractor::new(options).expect("the options are valid");
        extractor.prepare(320, 240);
        let before = allocations();
        let mut curves = 0;
        for rgb in &frames[..most] {
            let image = Image::new(rgb, 320, 240, 960, PixelFormat::Rgb8).expect("a whole image");
            curves += extractor.extract(&image).curves.len();
        }
        let grown = allocations() - before;
        assert!(curves >= 2 * most, "{method}: {curves}");
        assert_eq!(grown, 0, "{method}");
    }
}

#[test]
fn no_frame_without_a_clear_rope_allocates_after_preparation() {
    let mut frames = Vec::new();
    for contrast in [0.0, 5.0, 8.0] {
        let mut table = Table::new(320, 240, [190.0; 3]).flat();
        table.noise = 1.5;
        let rope = Rope::along(9.0, [190.0 - contrast; 3], |t| {
            [20.0 + 280.0 * t, 120.0 + 60.0 * (6.0 * t).sin()]
        });
        frames.push(table.draw(&[rope]));
    }
    // Adds a pattern of stripes.
    let stripes = |i: usize| if i / 960 % 20 < 10 { 120 } else { 180 };
    frames.push((0..320 * 240 * 3).map(stripes).collect());
    let mut extractor = extractor();
    extractor.prepare(320, 240);
    for rgb in &frames {
        let image = Image::new(rgb, 320, 240, 960, PixelFormat::Rgb8).expect("a whole image");
        let before = allocations();
        let scene = extractor.extract(&image);
        let grown = allocations() - before;
        assert_eq!((scene.curves.len(), grown), (0, 0), "{:?}", scene.notice);
    }
}

//! The automatic mask reports doubts, but not about clear ropes and empty tables.

use crate::drawing;

use drawing::{Rope, Table, extractor};
use lariat_extract::{Extractor, HsvRange, Image, Mask, Notice, Options, PixelFormat};
use proptest::prelude::*;

const WIDTH: usize = 320;
const HEIGHT: usize = 240;

fn notice_of(rgb: &[u8]) -> Option<Notice> {
    let image = Image::new(rgb, WIDTH, HEIGHT, 3 * WIDTH, PixelFormat::Rgb8).expect("whole");
    extractor().extract(&image).notice
}

/// A table of one color with noise, with each pixel's light changed by this many levels.
fn shaded(noise: f32, ropes: &[Rope], levels: impl Fn(f32, f32) -> f32) -> Vec<u8> {
    let mut table = Table::new(WIDTH, HEIGHT, [200.0, 195.0, 185.0]).flat();
    table.noise = noise;
    let mut rgb = table.draw(ropes);
    for (i, pixel) in rgb.chunks_exact_mut(3).enumerate() {
        let change = levels((i % WIDTH) as f32, (i / WIDTH) as f32);
        for level in pixel {
            *level = (f32::from(*level) + change).round().clamp(0.0, 255.0) as u8;
        }
    }
    rgb
}

fn rope(width_px: f32, color: [f32; 3]) -> Rope {
    Rope::along(width_px, color, |t| {
        [30.0 + 260.0 * t, 120.0 + 70.0 * (7.0 * t).sin()]
    })
}

/// Squares turned by an angle.
fn checkered(cell_px: f32, levels: f32, turn: f32) -> impl Fn(f32, f32) -> f32 {
    let (sin, cos) = turn.sin_cos();
    move |x, y| {
        let (u, v) = (x * cos + y * sin, y * cos - x * sin);
        let is_dark = ((u / cell_px).floor() + (v / cell_px).floor()).rem_euclid(2.0) > 0.5;
        if is_dark { -levels } else { 0.0 }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn a_checkered_table_is_named(
        cell_px in 8.0f32..60.0, levels in 12.0f32..150.0, turn in 0.0f32..0.7, noise in 0.5f32..2.5,
    ) {
        let rgb = shaded(noise, &[], checkered(cell_px, levels, turn));
        prop_assert_eq!(notice_of(&rgb), Some(Notice::CheckeredTable));
    }

    #[test]
    fn a_rope_that_cannot_be_told_from_the_squares_under_it_is_not_passed_over(
        cell_px in 8.0f32..60.0, levels in 50.0f32..120.0, turn in 0.0f32..0.7,
    ) {
        let rope = rope(9.0, [60.0, 80.0, 150.0]);
        let rgb = shaded(1.5, std::slice::from_ref(&rope), checkered(cell_px, levels, turn));
        let image = Image::new(&rgb, WIDTH, HEIGHT, 3 * WIDTH, PixelFormat::Rgb8).expect("whole");
        let mut extractor = extractor();
        let scene = extractor.extract(&image);
        let is_right = |curve| drawing::error(curve, &rope).mean_px < 1.0;
        let is_found = scene.curves.len() == 1 && is_right(&scene.curves[0]);
        prop_assert!(is_found || scene.notice.is_some());
    }

    #[test]
    fn a_rope_of_the_table_s_color_is_named(
        contrast in 4.0f32..12.0, width_px in 7.0f32..14.0, noise in 0.5f32..1.4,
    ) {
        let rope = rope(width_px, [200.0 - contrast, 195.0 - contrast, 185.0 - contrast]);
        let rgb = shaded(noise, &[rope], |_, _| 0.0);
        prop_assert_eq!(notice_of(&rgb), Some(Notice::LikeTheTable));
    }

    #[test]
    fn an_empty_table_is_an_answer_and_no_doubt(
        noise in 0.0f32..7.5, slope in -60.0f32..40.0, bow in 0.0f32..50.0,
    ) {
        let rgb = shaded(noise, &[], |x, y| {
            let (u, v) = (x / WIDTH as f32 - 0.5, y / HEIGHT as f32 - 0.5);
            slope * (u + 0.3 * v) - bow * (u * u + v * v)
        });
        prop_assert_eq!(notice_of(&rgb), None);
    }

    #[test]
    fn a_table_so_noisy_that_a_faint_rope_is_hidden_is_named(noise in 11.0f32..14.0) {
        prop_assert_eq!(notice_of(&shaded(noise, &[], |_, _| 0.0)), Some(Notice::Noisy));
    }

    #[test]
    fn a_clear_rope_on_a_pattern_faint_beside_it_is_sure(
        cell_px in 8.0f32..60.0, levels in 0.0f32..9.0, noise in 0.0f32..2.0,
    ) {
        let rope = rope(9.0, [40.0, 70.0, 160.0]);
        let rgb = shaded(noise, &[rope], checkered(cell_px, levels, 0.3));
        prop_assert_eq!(notice_of(&rgb), None);
    }
}

#[test]
fn stripes_and_grain_are_a_pattern() {
    for period_px in [8.0, 20.0, 60.0] {
        for levels in [10.0, 30.0, 80.0] {
            let stripes = |_, y: f32| levels * (y / period_px * std::f32::consts::TAU).sin() / 2.0;
            let grain = |x: f32, y: f32| {
                let bent = y + 8.0 * (x / 70.0).sin();
                let phase = bent / period_px * std::f32::consts::TAU;
                levels * ((phase).sin() + (0.37 * phase + 1.0).sin()) / 4.0
            };
            let named = Some(Notice::CheckeredTable);
            assert_eq!(
                notice_of(&shaded(1.0, &[], stripes)),
                named,
                "{period_px} {levels}"
            );
            assert_eq!(
                notice_of(&shaded(1.0, &[], grain)),
                named,
                "{period_px} {levels}"
            );
        }
    }
}

#[test]
fn a_net_is_no_rope() {
    let net = |x: f32, y: f32| match x.rem_euclid(24.0) < 4.0 || y.rem_euclid(24.0) < 4.0 {
        true => -100.0,
        false => 0.0,
    };
    let seen = notice_of(&shaded(1.0, &[], net));
    assert_eq!(seen, Some(Notice::CheckeredTable));
}

#[test]
fn a_lamp_s_spot_on_an_empty_table_is_uneven_light() {
    let spot = |x: f32, y: f32| {
        let square = (x - 110.0).powi(2) + (y - 90.0).powi(2);
        -110.0 * (1.0 - (-square / (2.0 * 80.0 * 80.0)).exp())
    };
    let seen = notice_of(&shaded(1.0, &[], spot));
    assert_eq!(seen, Some(Notice::UnevenTable));
}

#[test]
fn a_hand_that_covers_the_table_is_more_than_ropes() {
    let hand = |x: f32, y: f32| match (x - 90.0).hypot(y - 120.0) < 95.0 {
        true => -80.0,
        false => 0.0,
    };
    let seen = notice_of(&shaded(1.0, &[], hand));
    assert_eq!(seen, Some(Notice::Covered));
}

#[test]
fn black_and_white_images_are_named() {
    let pixels = 3 * WIDTH * HEIGHT;
    assert_eq!(notice_of(&vec![0; pixels]), Some(Notice::Black));
    assert_eq!(notice_of(&vec![255; pixels]), Some(Notice::White));
    assert_eq!(notice_of(&vec![128; pixels]), None);
}

#[test]
fn a_rope_on_a_black_table_needs_no_word() {
    let mut table = Table::new(WIDTH, HEIGHT, [2.0; 3]);
    table.noise = 1.0;
    let rgb = table.draw(&[rope(9.0, [180.0, 60.0, 50.0])]);
    assert_eq!(notice_of(&rgb), None);
}

#[test]
fn a_pattern_is_seen_in_every_format() {
    let rgb = shaded(1.0, &[], checkered(20.0, 40.0, 0.2));
    let luma: Vec<u8> = rgb.chunks_exact(3).map(|pixel| pixel[1]).collect();
    let yuyv: Vec<u8> = luma.iter().flat_map(|&y| [y, 128]).collect();
    let uyvy: Vec<u8> = luma.iter().flat_map(|&y| [128, y]).collect();
    let mut nv12 = luma.clone();
    nv12.resize(WIDTH * HEIGHT * 3 / 2, 128);
    for (bytes, stride, format) in [
        (&rgb, 3 * WIDTH, PixelFormat::Bgr8),
        (&luma, WIDTH, PixelFormat::Gray8),
        (&yuyv, 2 * WIDTH, PixelFormat::Yuyv),
        (&uyvy, 2 * WIDTH, PixelFormat::Uyvy),
        (&nv12, WIDTH, PixelFormat::Nv12),
    ] {
        let image = Image::new(bytes, WIDTH, HEIGHT, stride, format).expect("whole");
        let seen = extractor().extract(&image).notice;
        assert_eq!(seen, Some(Notice::CheckeredTable), "{format:?}");
    }
}

#[test]
fn only_the_automatic_mask_has_doubts() {
    let rgb = shaded(1.0, &[], checkered(20.0, 80.0, 0.0));
    let image = Image::new(&rgb, WIDTH, HEIGHT, 3 * WIDTH, PixelFormat::Rgb8).expect("whole");
    let blue = HsvRange {
        hue_deg: [200.0, 260.0],
        saturation: [0.4, 1.0],
        value: [0.1, 1.0],
    };
    let mut by_color =
        Extractor::new(Options::default().mask(Mask::Hsv(vec![blue]))).expect("valid options");
    assert_eq!(by_color.extract(&image).notice, None);

    let nothing = vec![0; WIDTH * HEIGHT];
    let mask = Image::new(&nothing, WIDTH, HEIGHT, WIDTH, PixelFormat::Gray8).expect("whole");
    let mut automatic = extractor();
    assert!(automatic.extract(&image).notice.is_some());
    let seen = automatic
        .extract_masked(&image, &mask)
        .expect("a mask of the size");
    assert_eq!(seen.notice, None);
}

#[test]
fn a_notice_is_a_sentence_that_says_what_to_do() {
    for notice in [
        Notice::CheckeredTable,
        Notice::UnevenTable,
        Notice::LikeTheTable,
        Notice::Covered,
        Notice::Black,
        Notice::White,
    ] {
        let (cause, advice) = notice
            .to_string()
            .split_once(": ")
            .map(|(a, b)| (a.len(), b.len()))
            .expect("two parts");
        assert!(cause > 20 && advice > 20, "{notice}");
    }
}

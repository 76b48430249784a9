//! Objects that look like ropes, next to real ones. They are doubted, but true ropes never are.

use crate::drawing;

use drawing::{Rope, Table, Vec2};
use lariat_extract::{
    Extractor, HsvRange, Image, Mask, Notice, Options, PixelFormat, Scene, Status,
};

const SIZE: [usize; 2] = [480, 360];
const LIGHT: [f32; 3] = [205.0, 200.0, 190.0];
const RED: [f32; 3] = [150.0, 40.0, 45.0];
const BLUE: [f32; 3] = [40.0, 60.0, 150.0];
const GRAY: [f32; 3] = [110.0, 107.0, 102.0];
const BLACK: [f32; 3] = [25.0, 25.0, 24.0];

fn wave(t: f32) -> Vec2 {
    [60.0 + 360.0 * t, 130.0 + 55.0 * (6.0 * t).sin()]
}

fn rope(color: [f32; 3]) -> Rope {
    Rope::along(10.0, color, wave)
}

/// A rope parallel to [`rope`], at this distance everywhere.
fn parallel(color: [f32; 3], apart_px: f32) -> Rope {
    Rope::along(10.0, color, move |t| {
        let slope = 55.0 * 6.0 * (6.0 * t).cos() / 360.0;
        let length = (1.0 + slope * slope).sqrt();
        let [x, y] = wave(t);
        [x - apart_px * slope / length, y + apart_px / length]
    })
}

fn pen(color: [f32; 3], y: f32) -> Rope {
    Rope::along(14.0, color, move |t| [150.0 + 180.0 * t, y + 30.0 * t])
}

fn draw(ropes: &[Rope], seed: u64) -> Vec<u8> {
    let table = Table {
        noise: 2.0,
        gradient: 0.1,
        seed,
        ..Table::new(SIZE[0], SIZE[1], LIGHT)
    };
    table.draw(ropes)
}

/// The curves' lengths and statuses, and the notice.
fn seen(extractor: &mut Extractor, pixels: &[u8]) -> (Vec<(f32, Status)>, Option<Notice>) {
    let [width, height] = SIZE;
    let image = Image::new(pixels, width, height, 3 * width, PixelFormat::Rgb8);
    let scene: Scene = extractor.extract(&image.expect("a whole image"));
    let curves = scene.curves.iter();
    (
        curves
            .map(|curve| (curve.length_px, curve.status))
            .collect(),
        scene.notice,
    )
}

fn seen_once(ropes: &[Rope]) -> (Vec<(f32, Status)>, Option<Notice>) {
    let mut extractor = Extractor::new(Options::default()).expect("the defaults are valid");
    seen(&mut extractor, &draw(ropes, 1))
}

/// Asserts that there are two curves, and neither is treated as something else.
fn assert_two_ropes(curves: &[(f32, Status)]) {
    assert_eq!(curves.len(), 2);
    let undoubted = curves.iter().all(|curve| curve.1 == Status::Ok);
    assert!(undoubted, "{curves:?}");
}

#[test]
fn ropes_without_an_inside_are_no_shadow_of_each_other() {
    for width_px in [1.6, 2.0, 2.4] {
        for apart_px in [6.0, 9.0, 14.0] {
            let thin = |rope: Rope| Rope { width_px, ..rope };
            let ropes = [thin(rope(RED)), thin(parallel(GRAY, apart_px))];
            let (curves, notice) = seen_once(&ropes);
            let what = format!("{width_px} px wide at {apart_px}: {curves:?} {notice:?}");
            assert_eq!(curves.len(), 2, "{what}");
            assert_eq!(notice, None, "{what}");
        }
    }
}

#[test]
fn ropes_that_lie_parallel_are_all_ropes() {
    let colors = [RED, BLUE, GRAY, BLACK];
    for (i, first) in colors.into_iter().enumerate() {
        for (k, second) in colors.into_iter().enumerate() {
            for apart_px in [14.0, 20.0, 32.0] {
                let (curves, notice) = seen_once(&[rope(first), parallel(second, apart_px)]);
                let what = format!("{i} beside {k} at {apart_px}: {curves:?} {notice:?}");
                assert_eq!(curves.len(), 2, "{what}");
                assert!(curves.iter().all(|curve| curve.1 == Status::Ok), "{what}");
                assert_eq!(notice, None, "{what}");
            }
        }
    }
}

#[test]
fn a_black_ropes_shadow_is_told_by_its_light() {
    let [width, height] = SIZE;
    let step = [17.0, 12.0];
    let shadow = LIGHT.map(|level| 0.55 * level);
    let cast = Rope::along(10.0, shadow, |t| {
        [wave(t)[0] + step[0], wave(t)[1] + step[1]]
    });
    let pixels = draw(&[cast, rope(BLACK)], 1);
    let mut extractor = Extractor::new(Options::default()).expect("the defaults are valid");
    let (curves, notice) = seen(&mut extractor, &pixels);
    assert_eq!((curves.len(), notice), (1, None));
    // The same in gray pictures.
    let gray: Vec<u8> = pixels.chunks_exact(3).map(|pixel| pixel[1]).collect();
    let image = Image::new(&gray, width, height, width, PixelFormat::Gray8);
    extractor.reset();
    let scene = extractor.extract(image.as_ref().expect("a whole image"));
    assert_eq!((scene.curves.len(), scene.notice), (1, None));
}

#[test]
fn a_straight_copy_of_a_rope_is_never_a_sure_rope() {
    let line = |color, x: f32, y: f32| {
        Rope::along(10.0, color, move |t| {
            [60.0 + x + 340.0 * t, 100.0 + y + 60.0 * t]
        })
    };
    let (curves, notice) = seen_once(&[line(RED, 0.0, 0.0), line(GRAY, 10.0, 30.0)]);
    // Either the network is sure that the other one is the only rope, or this one is in doubt.
    let undoubted = curves.iter().filter(|curve| curve.1 == Status::Ok);
    assert_eq!(undoubted.count(), 1, "{curves:?}");
    assert!(curves.len() == 1 || notice == Some(Notice::MaybeShadow));
}

#[test]
fn a_pen_is_none_beside_a_rope_and_unsure_by_itself() {
    // The network is confident of the rope, which is round, and sees no other.
    let shine = Rope::along(4.0, BLUE.map(|level| 0.5 * (level + 255.0)), wave);
    let (curves, notice) = seen_once(&[rope(BLUE), shine, pen(BLACK, 260.0)]);
    assert_eq!((curves.len(), curves[0].1, notice), (1, Status::Ok, None));
    let (curves, notice) = seen_once(&[pen(BLACK, 260.0)]);
    assert_eq!(curves.len(), 1);
    assert!(matches!(notice, Some(Notice::LikeAPen | Notice::Unsure)));
}

#[test]
fn a_piece_of_the_same_rope_is_a_rope() {
    let piece = Rope::along(10.0, BLUE, |t| [150.0 + 110.0 * t, 290.0]);
    let (curves, notice) = seen_once(&[rope(BLUE), piece]);
    assert_two_ropes(&curves);
    assert_eq!(notice, None);
}

#[test]
fn a_mask_that_the_user_gave_is_not_doubted() {
    let dark = HsvRange {
        hue_deg: [0.0, 360.0],
        saturation: [0.0, 1.0],
        value: [0.0, 0.65],
    };
    let mut extractor =
        Extractor::new(Options::default().mask(Mask::Hsv(vec![dark]))).expect("a valid range");
    let drawn = draw(&[rope(BLUE), pen(BLACK, 260.0)], 1);
    // A straight, flat object is uncertain in every mask, but the user may have meant it.
    let (curves, notice) = seen(&mut extractor, &drawn);
    assert_two_ropes(&curves);
    assert_eq!(notice, Some(Notice::Unsure));
}

#[test]
fn a_rope_that_was_one_for_a_while_stays_one_and_a_new_thing_is_doubted() {
    let mut extractor = Extractor::new(Options::default()).expect("the defaults are valid");
    let mut last = |ropes: &[Rope], seeds: std::ops::Range<u64>| {
        let frames = seeds.map(|seed| seen(&mut extractor, &draw(ropes, seed)).0);
        frames.last().expect("some frames")
    };
    // First a short rope, then also a long one next to it.
    let short = Rope::along(14.0, BLACK, |t| {
        [150.0 + 200.0 * t, 260.0 + 40.0 * (3.0 * t).sin()]
    });
    let alone = last(std::slice::from_ref(&short), 1..40);
    assert_eq!(alone[0].1, Status::Ok);
    let both = last(&[short, rope(BLUE)], 40..44);
    assert!(both.iter().all(|curve| curve.1 == Status::Ok), "{both:?}");
    // Next to a known rope, a pen is not treated as a rope, and remains in doubt.
    extractor.reset();
    let mut last = |ropes: &[Rope], seeds: std::ops::Range<u64>| {
        let frames = seeds.map(|seed| seen(&mut extractor, &draw(ropes, seed)));
        frames.last().expect("some frames")
    };
    last(&[rope(BLUE)], 1..20);
    for seed in 20..60 {
        let (both, notice) = last(&[pen(BLACK, 260.0), rope(BLUE)], seed..seed + 1);
        assert_eq!((both.len(), notice), (2, Some(Notice::LikeAPen)), "{seed}");
        let doubtful = both.iter().filter(|curve| curve.1 == Status::Doubtful);
        assert_eq!(doubtful.count(), 1, "{seed}: {both:?}");
    }
}

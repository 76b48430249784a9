//! Ropes without a plain table: they are found by the network, and by their shape where it is
//! blind.

use crate::drawing;

use drawing::{Rope, Table};
use lariat_drawn::scenes::{self, Class};
use lariat_extract::{Extractor, Image, Maker, Notice, Options, PixelFormat, Scene};
use lariat_portable::SplitMix64;

const SIZE: (usize, usize) = (480, 360);

/// Ropes over a ground, with camera noise.
fn over(ground: impl Fn(usize, usize) -> [u8; 3], ropes: &[Rope]) -> Vec<u8> {
    let draw = |level: f32| Table::new(SIZE.0, SIZE.1, [level; 3]).draw(ropes);
    let (black, white) = (draw(0.0), draw(255.0));
    let mut random = SplitMix64::new(7);
    (0..black.len())
        .map(|i| {
            let (x, y) = (i / 3 % SIZE.0, i / 3 / SIZE.0);
            let through = f32::from(white[i]) - f32::from(black[i]);
            let level = f32::from(black[i]) + through / 255.0 * f32::from(ground(x, y)[i % 3]);
            (level + 2.0 * drawing::normal(&mut random)).clamp(0.0, 255.0) as u8
        })
        .collect()
}

/// A checkered cloth.
fn squares(x: usize, y: usize) -> [u8; 3] {
    [[100, 95, 90], [200, 195, 185]][(x / 24 + y / 24) % 2]
}

/// A painter's floor: discs of many colors.
fn splashes(seed: u64) -> impl Fn(usize, usize) -> [u8; 3] {
    let mut random = SplitMix64::new(seed);
    let mut ground = vec![[150, 140, 130]; SIZE.0 * SIZE.1];
    for _ in 0..900 {
        let color = std::array::from_fn(|_| (40.0 + 180.0 * random.unit()) as u8);
        let radius = 2.0 + 9.0 * random.unit() as f32;
        let at = [SIZE.0, SIZE.1].map(|side| side as f32 * random.unit() as f32);
        for y in drawing::around(at[1], radius, SIZE.1) {
            for x in drawing::around(at[0], radius, SIZE.0) {
                if drawing::distance([x as f32, y as f32], at) < radius {
                    ground[y * SIZE.0 + x] = color;
                }
            }
        }
    }
    move |x, y| ground[y * SIZE.0 + x]
}

/// Two ropes that cross.
fn two() -> [Rope; 2] {
    let wave = Rope::along(11.0, [205.0, 25.0, 35.0], |t| {
        [40.0 + 400.0 * t, 180.0 + 80.0 * (5.0 * t).sin()]
    });
    let arc = Rope::along(9.0, [25.0, 60.0, 210.0], |t| {
        [150.0 + 160.0 * t * t, 330.0 - 300.0 * t]
    });
    [wave, arc]
}

/// Returns whether one of the scene's curves is this rope, whole.
fn is_found(scene: &Scene, rope: &Rope) -> bool {
    let mut errors = scene.curves.iter().map(|curve| drawing::error(curve, rope));
    errors.any(|error| error.mean_px < 0.6 && error.ends_px < 5.0)
}

fn seen<'a>(extractor: &'a mut Extractor, bytes: &[u8]) -> Scene<'a> {
    let image = Image::new(bytes, SIZE.0, SIZE.1, 3 * SIZE.0, PixelFormat::Rgb8);
    extractor.extract(&image.expect("a whole image"))
}

#[test]
fn ropes_on_a_checkered_table_are_found() {
    let (mut extractor, ropes) = (drawing::extractor(), two());
    let bytes = over(squares, &ropes);
    let scene = seen(&mut extractor, &bytes);
    assert_eq!(scene.curves.len(), 2, "{:?}", scene.notice);
    assert!(ropes.iter().all(|rope| is_found(&scene, rope)));
    assert_eq!(
        scene.notice, None,
        "both are sure, whatever the table is like"
    );
    let bytes = over(squares, &[]);
    extractor.reset();
    let scene = seen(&mut extractor, &bytes);
    assert_eq!(
        (scene.curves.len(), scene.notice),
        (0, Some(Notice::CheckeredTable))
    );
}

#[test]
fn a_table_that_was_not_plain_is_taken_for_such_for_a_while() {
    let mut extractor = drawing::extractor();
    let bytes = over(squares, &two());
    seen(&mut extractor, &bytes);
    let plain = |_: usize, _: usize| [210, 205, 195];
    let mut makers = Vec::new();
    for k in 0..40 {
        // Too far from one frame to the next to be followed.
        let y = if k % 2 == 0 { 90.0 } else { 270.0 };
        let rope = Rope::along(11.0, [205.0, 25.0, 35.0], |t| {
            [60.0 + 360.0 * t, y + 40.0 * (5.0 * t).sin()]
        });
        let bytes = over(plain, std::slice::from_ref(&rope));
        let scene = seen(&mut extractor, &bytes);
        assert!(is_found(&scene, &rope), "frame {k}");
        makers.push(extractor.evidence().next().expect("a curve").maker);
    }
    assert_eq!([makers[0], makers[39]], [Maker::Network, Maker::Own]);
}

#[test]
fn ropes_on_a_painters_floor_are_found() {
    let ropes = two();
    for seed in 0..3 {
        let mut extractor = drawing::extractor();
        let bytes = over(splashes(seed), &ropes);
        let scene = seen(&mut extractor, &bytes);
        assert_eq!(scene.curves.len(), 2, "{seed}");
        assert!(ropes.iter().all(|rope| is_found(&scene, rope)), "{seed}");
    }
}

#[test]
fn a_floor_without_a_rope_has_none() {
    for seed in 3..6 {
        let mut extractor = drawing::extractor();
        let bytes = over(splashes(seed), &[]);
        assert_eq!(seen(&mut extractor, &bytes).curves, [], "{seed}");
    }
}

#[test]
fn a_table_that_ends_in_the_picture_is_no_rope() {
    let ropes = &two()[..1];
    let ground = |_: usize, y: usize| match y {
        0..300 => [215, 210, 200],
        300..330 => [120, 85, 50],
        _ => [60, 60, 65],
    };
    let mut extractor = drawing::extractor();
    let bytes = over(ground, ropes);
    let scene = seen(&mut extractor, &bytes);
    assert_eq!(scene.curves.len(), 1);
    assert!(is_found(&scene, &ropes[0]));
    assert_eq!(scene.notice, None);
}

#[test]
fn a_large_picture_is_looked_at_smaller_and_its_ropes_are_as_thin_as_they_are() {
    let scale = 3;
    let large = |x: usize, y: usize| squares(x / scale, y / scale);
    let size = (SIZE.0 * scale, SIZE.1 * scale);
    let ropes = two().map(|rope| Rope {
        width_px: rope.width_px * scale as f32,
        points: rope
            .points
            .iter()
            .map(|at| at.map(|c| c * scale as f32))
            .collect(),
        ..rope
    });
    let draw = |level: f32| Table::new(size.0, size.1, [level; 3]).draw(&ropes);
    let (black, white) = (draw(0.0), draw(255.0));
    let mix = |i: usize| {
        let through = f32::from(white[i]) - f32::from(black[i]);
        let ground = large(i / 3 % size.0, i / 3 / size.0)[i % 3];
        (f32::from(black[i]) + through / 255.0 * f32::from(ground)) as u8
    };
    let bytes: Vec<u8> = (0..black.len()).map(mix).collect();
    let image = Image::new(&bytes, size.0, size.1, 3 * size.0, PixelFormat::Rgb8).expect("whole");
    let mut extractor = Extractor::new(Options::default()).expect("valid");
    let scene = extractor.extract(&image);
    assert_eq!(scene.curves.len(), 2);
    for (rope, width_px) in ropes.iter().zip([33.0, 27.0]) {
        let curve = scene
            .curves
            .iter()
            .find(|curve| drawing::error(curve, rope).mean_px < 1.5);
        let found_px = curve.expect("it is found").width_px;
        assert!(
            (found_px - width_px).abs() < 3.0,
            "{found_px} for {width_px}"
        );
    }
}

/// If what seems a plain table yields an uncertain curve, the network is run as well. Its ropes
/// have higher confidence.
#[test]
fn a_pen_or_a_rim_beside_a_rope_is_no_rope() {
    let [width, height] = [640, 480];
    let is_alone = |seed: u64| {
        let still = scenes::draw(Class::Things, seed, width, height).expect("it fits");
        let image = Image::new(&still.rgb, width, height, 3 * width, PixelFormat::Rgb8);
        let mut extractor = Extractor::new(Options::default()).expect("the defaults are valid");
        extractor
            .extract(&image.expect("the bytes are made for it"))
            .curves
            .len()
            == 1
    };
    let alone = (0..12).filter(|&seed| is_alone(seed)).count();
    assert!(alone >= 8, "{alone} of 12");
}

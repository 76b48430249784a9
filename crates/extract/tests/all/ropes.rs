//! Drawn ropes of every kind are found where they are.

use crate::drawing;
use lariat_portable::SplitMix64;

use drawing::formats::formats;
use drawing::{Rope, Table, Vec2, distance, distance_to, error, extractor, see};
use lariat_extract::{Extractor, HsvRange, Image, Mask, Options, PixelFormat, Status};

const GRAY: [f32; 3] = [128.0; 3];
const WHITE: [f32; 3] = [215.0, 212.0, 205.0];
const BLACK: [f32; 3] = [18.0, 18.0, 20.0];
const RED: [f32; 3] = [200.0, 60.0, 70.0];
const BLUE: [f32; 3] = [30.0, 60.0, 130.0];
const GREEN: [f32; 3] = [150.0, 190.0, 70.0];

/// A wave across a 320×240 image.
fn wave(phase: f32) -> impl Fn(f32) -> Vec2 {
    move |t| {
        let x = 40.0 + 240.0 * t;
        [x, 120.0 + 50.0 * (6.0 * t + phase).sin()]
    }
}

/// A rope with one self-crossing.
fn looped(t: f32) -> Vec2 {
    let a = -4.4 + 8.8 * t;
    [160.0 + 22.0 * a - 50.0 * a.sin(), 110.0 + 60.0 * a.cos()]
}

fn assert_near(curve: &lariat_extract::Curve, rope: &Rope, what: &str) {
    let error = error(curve, rope);
    assert!(error.mean_px <= 0.3, "{what}: {error:?}");
    assert!(error.ends_px <= 1.0, "{what}: {error:?}");
    assert!(error.correspondence_px <= 2.0, "{what}: {error:?}");
    let off = (curve.width_px - rope.width_px).abs();
    assert!(
        off <= 0.5,
        "{what}: width {} for {}",
        curve.width_px,
        rope.width_px
    );
}

/// Pieces of a rope that widens over its second half, like one that rises toward the camera.
fn rising(from_px: f32, to_px: f32) -> Vec<Rope> {
    let pieces = 60;
    let part = |i: usize| {
        let first = i as f32 / pieces as f32;
        let risen = (2.0 * first - 1.0).max(0.0);
        let width_px = from_px + risen * (to_px - from_px);
        Rope::along(width_px, RED, move |t| wave(0.0)(first + t / pieces as f32))
    };
    (0..pieces).map(part).collect()
}

#[test]
fn a_rope_that_rises_to_the_camera_is_measured_where_it_is_wide() {
    for (from_px, to_px) in [(8.0, 13.5), (12.0, 8.0), (6.0, 9.5)] {
        let table = Table::new(320, 240, BLACK);
        let rgb = table.draw(&rising(from_px, to_px));
        let mut extractor = extractor();
        let scene = see(&mut extractor, &rgb, &table);
        let [curve] = scene.curves else {
            panic!("{from_px} to {to_px} px: {} ropes", scene.curves.len());
        };
        let axis = Rope::along(from_px, RED, wave(0.0));
        let error = error(curve, &axis);
        assert!(error.mean_px < 0.3, "{from_px} to {to_px} px: {error:?}");
        assert!(error.ends_px < 1.0, "{from_px} to {to_px} px: {error:?}");
        let far = |&p: &Vec2| distance_to(p, &axis.points);
        let worst = curve.points.iter().map(far).fold(0.0, f32::max);
        assert!(worst < 1.0, "{from_px} to {to_px} px: {worst} px beside it");
        let first = curve.widths_px[curve.widths_px.len() / 20];
        let last = curve.widths_px[curve.widths_px.len() * 19 / 20];
        let (least, most) = (first.min(last), first.max(last));
        assert!(
            most > 1.4 * least,
            "{from_px} to {to_px} px: {first} to {last}"
        );
    }
}

/// A rope that runs from the left to a bend, and from there upward. Its width changes to `leg_px`
/// at the bend.
fn bent(width_px: f32, leg_px: f32) -> [Rope; 2] {
    let along = |t: f32| [280.0 - 190.0 * t, 150.0 + 40.0 * (5.0 * t + 0.6).sin()];
    let bend = along(1.0);
    let up = move |t: f32| {
        [
            bend[0] - 35.0 * t,
            bend[1] - 70.0 * t + 8.0 * (3.0 * t).sin(),
        ]
    };
    [
        Rope::along(width_px, RED, along),
        Rope::along(leg_px, RED, up),
    ]
}

#[test]
fn a_rope_that_points_at_the_camera_behind_a_bend_is_measured_where_it_is_wide() {
    for (width_px, leg_px) in [(3.0, 5.0), (6.0, 10.0), (9.0, 15.0)] {
        let what = format!("{width_px} px, then {leg_px}");
        let table = Table::new(320, 240, BLACK).flat();
        let ropes = bent(width_px, leg_px);
        let rgb = table.draw(&ropes);
        let mut extractor = extractor();
        let scene = see(&mut extractor, &rgb, &table);
        let [curve] = scene.curves else {
            panic!("{what}: {} ropes", scene.curves.len());
        };
        let axis: Vec<Vec2> = ropes.iter().flat_map(|rope| rope.points.clone()).collect();
        let far = |&p: &Vec2| distance_to(p, &axis);
        let worst = curve.points.iter().map(far).fold(0.0, f32::max);
        // In the bend, the two are drawn over each other.
        assert!(worst < 0.25 * leg_px, "{what}: {worst} px beside it");
        let [last] = ropes[1].points[ropes[1].points.len() - 1..] else {
            panic!("{what}: the leg has no end");
        };
        let on_leg = curve.points.iter().zip(&curve.widths_px);
        // At its tip, the rope's usual width is the best guess.
        let is_between = |&p: &Vec2| (0.6 * leg_px..50.0).contains(&distance(p, last));
        let on_leg = on_leg.filter(|(p, _)| is_between(p));
        let off = |(&p, width_px): (&Vec2, &f32)| far(&p).max((width_px - leg_px).abs());
        let worst = on_leg.map(off).fold(0.0, f32::max);
        assert!(worst < 0.5, "{what}: {worst} px off on the leg");
    }
}

/// Two highly lifted ropes that cross themselves where they are much wider than elsewhere. The wide
/// part must not be treated as part of the crossing.
#[test]
fn a_rope_is_measured_up_to_a_crossing_beside_which_it_rises_to_the_camera() {
    use lariat_drawn::space::{Eye, LiftOptions, LiftedRope, picture};
    let [width, height] = [848, 480];
    let lifted = LiftOptions {
        length_mm: 600.0,
        radius_mm: 4.0,
        lift_mm: 160.0,
        crossings: 1,
    };
    for seed in [18, 20] {
        let eye = Eye::above(610.0, [width, height], 500.0, 15.0, 40.0 * seed as f64);
        let rope = LiftedRope::new(&lifted, &eye, seed).expect("a rope that fits");
        let rgb = picture(&rope, &eye, seed);
        let image = Image::new(&rgb, width, height, 3 * width, PixelFormat::Rgb8);
        let mut extractor = extractor();
        let scene = extractor.extract(&image.expect("an image"));
        assert_eq!(scene.curves.len(), 1, "seed {seed}");
        let pixel = |&p: &[f64; 3]| eye.pixel(eye.see(p)).map(|c| c as f32);
        let axis: Vec<Vec2> = rope.points.iter().map(pixel).collect();
        let far = |&p: &Vec2| distance_to(p, &axis);
        let worst = scene.curves[0].points.iter().map(far).fold(0.0, f32::max);
        assert!(worst < 4.0, "seed {seed}: {worst} px beside it");
    }
}

#[test]
fn ropes_of_every_width_and_color_come_out_where_they_are() {
    let mut random = SplitMix64::new(7);
    let looks = [
        (BLUE, WHITE),
        (WHITE, BLACK),
        (RED, BLACK),
        (BLACK, GRAY),
        (GREEN, GRAY),
    ];
    for (i, width_px) in [4.0, 6.0, 9.0, 13.0, 20.0].into_iter().enumerate() {
        for (rope_color, table_color) in looks {
            let mut table = Table::new(320, 240, table_color).flat();
            table.gradient = random.uniform_f32(-0.4, 0.4);
            table.noise = random.uniform_f32(0.0, 4.0);
            table.seed = random.next_u64();
            let rope = Rope::along(width_px, rope_color, wave(i as f32));
            let mut extractor = extractor();
            let scene = see(
                &mut extractor,
                &table.draw(std::slice::from_ref(&rope)),
                &table,
            );
            let what = format!("{width_px} px, {rope_color:?} on {table_color:?}");
            assert_eq!(scene.curves.len(), 1, "{what}");
            let curve = &scene.curves[0];
            assert_eq!(
                (curve.closed, curve.border, curve.status),
                (false, [false; 2], Status::Ok)
            );
            assert_near(curve, &rope, &what);
        }
    }
}

#[test]
fn points_stand_at_equal_steps() {
    let table = Table::new(320, 240, WHITE);
    let rgb = table.draw(&[Rope::along(8.0, BLUE, wave(0.4))]);
    let options = Options::default().points(33);
    let mut extractor = Extractor::new(options).expect("valid options");
    let curve = &see(&mut extractor, &rgb, &table).curves[0];
    assert_eq!((curve.points.len(), curve.widths_px.len()), (33, 33));
    let step = curve.length_px / 32.0;
    for pair in curve.points.windows(2) {
        let chord = distance(pair[0], pair[1]);
        assert!(
            chord <= step * 1.001 && chord > step * 0.97,
            "{chord} for {step}"
        );
    }
}

#[test]
fn a_hose_under_thin_cables_is_one_rope() {
    for width_px in [14.0, 18.0, 20.0] {
        let table = Table::new(320, 240, WHITE).flat();
        let hose = Rope::along(width_px, BLACK, |t| {
            let turn = std::f32::consts::PI * t;
            [160.0 - 110.0 * turn.cos(), 190.0 - 130.0 * turn.sin()]
        });
        let cables = [100.0, 170.0, 240.0]
            .map(|x: f32| Rope::along(8.0, RED, move |t| [x + 30.0 * t, 20.0 + 200.0 * t]));
        let ropes = [&[hose][..], &cables].concat();
        // The automatic mask takes straight flat things for edges.
        let white = |rope: &Rope| Rope {
            color: WHITE,
            ..rope.clone()
        };
        let white: Vec<_> = ropes.iter().map(white).collect();
        let mask = Table::new(320, 240, [0.0; 3]).flat().draw(&white);
        let mask: Vec<u8> = mask.chunks_exact(3).map(|pixel| pixel[0]).collect();
        let mask = Image::new(&mask, 320, 240, 320, PixelFormat::Gray8).expect("a whole mask");
        let drawn = table.draw(&ropes);
        let image = Image::new(&drawn, 320, 240, 960, PixelFormat::Rgb8).expect("a whole image");
        let mut extractor = extractor();
        let scene = extractor.extract_masked(&image, &mask);
        let scene = scene.expect("a mask of the image's size");
        assert_eq!(scene.curves.len(), ropes.len(), "{width_px} px");
        for rope in &ropes {
            let found = |curve: &&lariat_extract::Curve| error(curve, rope).mean_px < 2.0;
            assert!(
                scene.curves.iter().any(|curve| found(&curve)),
                "{width_px} px"
            );
        }
    }
}

#[test]
fn a_rope_that_crosses_itself_is_one_rope() {
    for width_px in [4.0, 7.0, 12.0] {
        let mut table = Table::new(320, 240, BLACK);
        table.noise = 2.0;
        let rope = Rope::along(width_px, RED, looped);
        let mut extractor = extractor();
        let scene = see(
            &mut extractor,
            &table.draw(std::slice::from_ref(&rope)),
            &table,
        );
        assert_eq!(scene.curves.len(), 1, "{width_px}");
        assert_near(&scene.curves[0], &rope, &format!("loop of {width_px} px"));
    }
}

#[test]
fn two_ropes_that_cross_stay_two() {
    for angle_deg in [26.0f32, 35.0, 50.0, 70.0, 90.0] {
        for width_px in [4.0, 8.0, 12.0] {
            let mut table = Table::new(320, 240, WHITE);
            table.noise = 2.0;
            let ropes = [-0.5, 0.5].map(|side: f32| {
                let (sin, cos) = (side * angle_deg.to_radians()).sin_cos();
                Rope::along(width_px, BLUE, move |t| {
                    let (along, bow) = (230.0 * (t - 0.5), 8.0 * (t - 0.5) * (t - 0.5));
                    [
                        160.0 + along * cos - bow * sin,
                        120.0 + along * sin + bow * cos,
                    ]
                })
            });
            let mut extractor = extractor();
            let scene = see(&mut extractor, &table.draw(&ropes), &table);
            let what = format!("{width_px} px at {angle_deg}°");
            assert_eq!(scene.curves.len(), 2, "{what}");
            for curve in scene.curves {
                let near = |r: &&Rope| distance_to(curve.points[10], &r.points) < 2.0;
                let rope = ropes
                    .iter()
                    .find(near)
                    .expect("the curve is one of the two");
                assert_near(curve, rope, &what);
            }
        }
    }
}

#[test]
fn strands_that_run_along_each_other_keep_their_own_centers() {
    for (width_px, stretch) in [(8.0, 25.0), (8.0, 50.0), (12.0, 40.0)] {
        let mut table = Table::new(320, 240, WHITE);
        table.noise = 1.5;
        let ropes = [-1.0f32, 1.0].map(|side| {
            Rope::along(width_px, BLUE, move |t| {
                let x = 30.0 + 260.0 * t;
                let apart = ((x - 160.0).abs() - stretch).max(0.0);
                [x, 120.0 + side * (0.48 * width_px + apart * apart / 220.0)]
            })
        });
        let mut extractor = extractor();
        let scene = see(&mut extractor, &table.draw(&ropes), &table);
        let what = format!("{width_px} px for {stretch} px");
        assert_eq!(scene.curves.len(), 2, "{what}");
        for curve in scene.curves {
            let best = ropes
                .iter()
                .map(|r| error(curve, r).mean_px)
                .fold(f32::MAX, f32::min);
            // A strand on the wrong side, or in the middle of both, would be half a width off.
            assert!(best <= 1.0, "{what}: {best}");
        }
    }
}

#[test]
fn a_rope_that_leaves_the_image_is_whole() {
    let table = Table::new(200, 160, WHITE);
    let rope = Rope::along(10.0, BLUE, |t| [-30.0 + 180.0 * t, 40.0 + 60.0 * t]);
    let mut extractor = extractor();
    let scene = see(
        &mut extractor,
        &table.draw(std::slice::from_ref(&rope)),
        &table,
    );
    assert_eq!(scene.curves.len(), 1);
    let curve = &scene.curves[0];
    assert_eq!(curve.border, [true, false]);
    assert!(curve.points[0][0] < 1.0, "{:?}", curve.points[0]);
    assert!(distance(curve.points[119], [150.0, 100.0]) < 1.0);
    assert!(
        curve
            .points
            .iter()
            .all(|&p| distance_to(p, &rope.points) < 0.5)
    );
}

#[test]
fn a_ring_has_no_ends() {
    let table = Table::new(240, 240, BLACK);
    let mut ring = Rope::along(9.0, GREEN, |t| {
        let (sin, cos) = (t * std::f32::consts::TAU).sin_cos();
        [120.0 + 80.0 * cos, 118.0 + 60.0 * sin]
    });
    ring.closed = true;
    let mut extractor = extractor();
    let scene = see(
        &mut extractor,
        &table.draw(std::slice::from_ref(&ring)),
        &table,
    );
    assert_eq!(scene.curves.len(), 1);
    let curve = &scene.curves[0];
    assert!(curve.closed);
    let mean = curve
        .points
        .iter()
        .map(|&p| distance_to(p, &ring.points))
        .sum::<f32>()
        / 120.0;
    assert!(mean < 0.2, "{mean}");
    let step = distance(curve.points[0], curve.points[1]);
    assert!((distance(curve.points[119], curve.points[0]) - step).abs() < 0.1 * step);
}

#[test]
fn a_ring_that_a_rope_crosses_stays_a_ring() {
    for off_px in [-25.0, 0.0, 25.0] {
        let table = Table::new(320, 240, BLACK);
        let mut ring = Rope::along(9.0, GREEN, |t| {
            let (sin, cos) = (t * std::f32::consts::TAU).sin_cos();
            [160.0 + 60.0 * cos, 120.0 + 60.0 * sin]
        });
        ring.closed = true;
        let rope = Rope::along(9.0, GREEN, |t| {
            let x = 20.0 + 280.0 * t;
            [x, 120.0 + off_px + 6.0 * (3.0 * t).sin()]
        });
        let mut extractor = extractor();
        let scene = see(&mut extractor, &table.draw(&[ring, rope.clone()]), &table);
        let mut closed: Vec<_> = scene.curves.iter().map(|c| c.closed).collect();
        closed.sort_unstable();
        assert_eq!(closed, [false, true], "{off_px} px off the middle");
        let open = scene.curves.iter().find(|c| !c.closed);
        assert_near(open.expect("one is open"), &rope, &format!("{off_px} px"));
    }
}

#[test]
fn an_empty_table_has_no_rope() {
    for (i, color) in [WHITE, BLACK, GRAY, [255.0; 3], [0.0; 3]]
        .into_iter()
        .enumerate()
    {
        for noise in [0.0, 1.0, 4.0, 12.0] {
            let mut table = Table::new(320, 240, color);
            (table.gradient, table.noise, table.seed) = (0.5, noise, i as u64);
            let mut extractor = extractor();
            let scene = see(&mut extractor, &table.draw(&[]), &table);
            assert_eq!(scene.curves, [], "{color:?} with noise {noise}");
            assert_eq!(scene.crossings, []);
        }
    }
}

#[test]
fn every_pixel_format_gives_the_same_rope() {
    for (width, height) in [(320, 240), (319, 239)] {
        let mut table = Table::new(width, height, WHITE);
        (table.noise, table.gradient) = (1.5, 0.2);
        let rope = Rope::along(9.0, BLUE, wave(0.9));
        let rgb = table.draw(std::slice::from_ref(&rope));
        for (format, bytes, stride) in formats(&rgb, width, height) {
            let image = Image::new(&bytes, width, height, stride, format).expect("a whole image");
            let mut extractor = extractor();
            let scene = extractor.extract(&image);
            assert_eq!(scene.curves.len(), 1, "{format:?}");
            let error = error(&scene.curves[0], &rope);
            assert!(
                error.mean_px < 0.5 && error.ends_px < 1.3,
                "{format:?}: {error:?}"
            );
        }
    }
}

/// A color filter mosaic blurs each color by about a pixel, but does not shift it.
#[test]
fn behind_a_mosaic_a_rope_lies_where_it_lies_in_full_colour() {
    let (width, height) = (320, 240);
    for (k, color) in [BLUE, RED, BLACK].into_iter().enumerate() {
        let mut table = Table::new(width, height, WHITE).flat();
        (table.noise, table.seed) = (1.5, k as u64);
        let rope = Rope::along(9.0, color, wave(0.9));
        let rgb = table.draw(std::slice::from_ref(&rope));
        let mut seen = Vec::new();
        for (format, bytes, stride) in formats(&rgb, width, height) {
            let is_mosaic = format!("{format:?}").starts_with("Bayer");
            if !is_mosaic && format != PixelFormat::Rgb8 {
                continue;
            }
            let image = Image::new(&bytes, width, height, stride, format).expect("a whole image");
            let mut extractor = extractor();
            let scene = extractor.extract(&image);
            assert_eq!(scene.curves.len(), 1, "{format:?}");
            let curve = &scene.curves[0];
            // Leave out the ends, which the blur moves slightly along the rope.
            let points = &curve.points[10..110];
            let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f32>() / 100.0;
            seen.push((format, error(curve, &rope), [mean(0), mean(1)]));
        }
        let (_, in_full, middle) = &seen[0];
        for (format, error, own) in &seen[1..] {
            let about = format!("{color:?} {format:?}: {error:?}, {own:?} for {middle:?}");
            assert!(error.mean_px < in_full.mean_px + 0.05, "{about}");
            assert!(error.ends_px < in_full.ends_px + 0.5, "{about}");
            assert!(
                (0..2).all(|axis| (own[axis] - middle[axis]).abs() < 0.05),
                "{about}"
            );
        }
    }
}

#[test]
fn padding_between_rows_is_not_read() {
    let table = Table::new(300, 240, WHITE);
    let rgb = table.draw(&[Rope::along(9.0, BLUE, wave(0.2))]);
    let mut padded = Vec::new();
    for row in rgb.chunks_exact(900) {
        padded.extend_from_slice(row);
        padded.extend([7, 250, 99, 0, 13]);
    }
    padded.truncate(padded.len() - 5);
    let image = Image::new(&padded, 300, 240, 905, PixelFormat::Rgb8).expect("a whole image");
    let (mut plain, mut strided) = (extractor(), extractor());
    assert_eq!(
        see(&mut plain, &rgb, &table).curves,
        strided.extract(&image).curves
    );
}

#[test]
fn color_ranges_take_only_the_ropes_of_those_colors() {
    let table = Table::new(320, 240, WHITE);
    let blue = Rope::along(9.0, BLUE, |t| [40.0 + 240.0 * t, 70.0 + 20.0 * t]);
    let red = Rope::along(9.0, RED, |t| [40.0 + 240.0 * t, 180.0 - 30.0 * t]);
    let rgb = table.draw(&[blue.clone(), red.clone()]);
    let range = |low, high| HsvRange {
        hue_deg: [low, high],
        saturation: [0.4, 1.0],
        value: [0.0, 1.0],
    };
    for (ranges, expected) in [
        (vec![range(200.0, 260.0)], vec![&blue]),
        (vec![range(330.0, 20.0)], vec![&red]),
        (
            vec![range(200.0, 260.0), range(330.0, 20.0)],
            vec![&blue, &red],
        ),
    ] {
        let options = Options::default().mask(Mask::Hsv(ranges));
        let mut extractor = Extractor::new(options).expect("valid options");
        let scene = see(&mut extractor, &rgb, &table);
        assert_eq!(scene.curves.len(), expected.len());
        for rope in expected {
            let errors = scene.curves.iter().map(|c| error(c, rope));
            assert!(
                errors
                    .into_iter()
                    .any(|e| e.mean_px < 0.5 && e.ends_px < 1.5)
            );
        }
    }
}

#[test]
fn the_start_is_the_end_that_the_user_names() {
    let table = Table::new(320, 240, WHITE);
    let rgb = table.draw(&[Rope::along(9.0, BLUE, wave(0.0))]);
    for (start, x) in [
        (None, 40.0),
        (Some([280.0, 100.0]), 280.0),
        (Some([0.0, 0.0]), 40.0),
    ] {
        let mut extractor = Extractor::new(Options::default().start(start)).expect("valid options");
        let scene = see(&mut extractor, &rgb, &table);
        assert!((scene.curves[0].points[0][0] - x).abs() < 2.0, "{start:?}");
    }
}

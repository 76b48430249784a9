//! Ropes are followed from frame to frame by reading only around them, as long as that is enough.

use crate::drawing;

use drawing::formats::formats;
use drawing::{Rope, Table, Vec2, distance, error, extractor, see};
use lariat_extract::{Image, PixelFormat, Status};

const WHITE: [f32; 3] = [215.0, 212.0, 205.0];
const BLUE: [f32; 3] = [30.0, 60.0, 130.0];
const RED: [f32; 3] = [190.0, 60.0, 60.0];

fn table() -> Table {
    let mut table = Table::new(320, 240, WHITE);
    (table.noise, table.gradient) = (2.0, 0.2);
    table
}

/// A swaying rope that crosses itself once.
fn loop_at(frame: usize) -> Rope {
    let phase = frame as f32 / 20.0;
    let (sin, cos) = (0.3 * phase.sin()).sin_cos();
    Rope::along(8.0, BLUE, move |t| {
        let a = -3.2 + 6.4 * t;
        let wide = 62.0 + 6.0 * (1.7 * phase).cos();
        let (x, y) = (34.0 * a - wide * a.sin(), 52.0 * a.cos());
        [160.0 + x * cos - y * sin, 128.0 + x * sin + y * cos]
    })
}

/// A waving rope without a crossing.
fn wave_at(frame: usize) -> Rope {
    let phase = frame as f32 / 15.0;
    Rope::along(8.0, BLUE, move |t| {
        let x = 40.0 + 240.0 * t + 6.0 * phase.sin();
        [x, 80.0 + 35.0 * (5.0 * t + 0.4 * phase).sin()]
    })
}

#[test]
fn a_rope_that_is_followed_is_as_right_as_one_that_is_extracted() {
    let mut table = table();
    for (name, rope_at) in [("wave", wave_at as fn(usize) -> Rope), ("loop", loop_at)] {
        let (mut tracked, mut cold) = (extractor(), extractor());
        let (mut followed, mut means) = (0, [0.0f32; 2]);
        for frame in 0..100 {
            table.seed = frame as u64;
            let rope = rope_at(frame);
            let rgb = table.draw(std::slice::from_ref(&rope));
            cold.reset();
            let extracted = error(&see(&mut cold, &rgb, &table).curves[0], &rope);
            let scene = see(&mut tracked, &rgb, &table);
            assert_eq!(scene.curves.len(), 1, "{name} {frame}");
            assert_eq!(scene.curves[0].status, Status::Ok, "{name} {frame}");
            if scene.followed {
                let error = error(&scene.curves[0], &rope);
                followed += 1;
                (means[0], means[1]) = (means[0] + error.mean_px, means[1] + extracted.mean_px);
                let limit_px = extracted.correspondence_px + 0.8;
                assert!(
                    error.correspondence_px < limit_px,
                    "{name} {frame}: {error:?}"
                );
                assert!(error.ends_px < 1.0, "{name} {frame}: {error:?}");
            }
        }
        assert!(followed >= 60, "{name}: {followed} of 100 frames followed");
        let [followed_px, extracted_px] = means.map(|sum| sum / followed as f32);
        assert!(
            followed_px < extracted_px + 0.05,
            "{name}: {followed_px} px off in the mean, {extracted_px} extracted"
        );
    }
}

#[test]
fn a_thin_rope_is_followed_too() {
    let mut table = table();
    let mut extractor = extractor();
    let mut followed = 0;
    for frame in 0..60 {
        table.seed = frame as u64;
        let mut rope = wave_at(frame);
        rope.width_px = 2.4;
        let rgb = table.draw(std::slice::from_ref(&rope));
        let scene = see(&mut extractor, &rgb, &table);
        followed += usize::from(scene.followed);
        let error = error(&scene.curves[0], &rope);
        assert!(
            error.mean_px < 0.25 && error.ends_px < 1.5,
            "{frame}: {error:?}"
        );
    }
    assert!(followed >= 50, "{followed} of 60 frames followed");
}

#[test]
fn a_part_that_moves_far_is_followed_from_the_parts_beside_it() {
    let table = table();
    // The rope moves beyond the search reach for its width, but stays too near to be another rope.
    for (width_px, far_px) in [(2.4, 6.0), (8.0, 14.0)] {
        let mut extractor = extractor();
        let rope_at = |frame: usize| {
            let mut rope = Rope::along(width_px, BLUE, |t| [30.0 + 260.0 * t, 100.0]);
            let moved_px = far_px * frame.saturating_sub(7) as f32;
            for point in &mut rope.points {
                let off = (point[0] - 160.0) / 40.0;
                point[1] += moved_px * (-off * off).exp();
            }
            rope
        };
        for frame in 0..10 {
            let rope = rope_at(frame);
            let rgb = table.draw(std::slice::from_ref(&rope));
            let scene = see(&mut extractor, &rgb, &table);
            assert!(frame < 7 || scene.followed, "{width_px} px wide: {frame}");
            let error = error(&scene.curves[0], &rope);
            assert!(
                error.mean_px < 0.3,
                "{width_px} px wide, {frame}: {error:?}"
            );
        }
    }
}

#[test]
fn a_crossing_goes_along_with_its_ropes() {
    let table = table();
    let mut extractor = extractor();
    for frame in 0..60 {
        let rgb = table.draw(&[loop_at(frame)]);
        let scene = see(&mut extractor, &rgb, &table);
        assert_eq!(scene.crossings.len(), 1, "frame {frame}");
        let crossing = &scene.crossings[0];
        let points = &scene.curves[0].points;
        for rho in [crossing.over_rho, crossing.under_rho] {
            let place = rho * (points.len() - 1) as f32;
            let near = points[place.round() as usize];
            assert!(distance(near, crossing.at) < 4.0, "frame {frame}");
        }
    }
}

/// Draws the waving rope until it is followed. Returns the extractor.
fn followed(table: &Table) -> lariat_extract::Extractor {
    let mut extractor = extractor();
    for frame in 0..8 {
        let rgb = table.draw(&[wave_at(frame)]);
        let scene = see(&mut extractor, &rgb, table);
        assert!(frame < 7 || scene.followed, "the rope is plain to see");
    }
    extractor
}

#[test]
fn a_second_rope_is_seen_when_it_comes() {
    let table = table();
    let mut extractor = followed(&table);
    // The upright rope crosses a row that is read in every frame, the flat one is found within some
    // frames.
    let upright = Rope::along(8.0, RED, |t| [290.0, 130.0 + 100.0 * t]);
    let flat = Rope::along(8.0, RED, |t| [60.0 + 160.0 * t, 200.0]);
    let rgb = table.draw(&[wave_at(8), upright]);
    assert_eq!(see(&mut extractor, &rgb, &table).curves.len(), 2);
    let mut extractor = followed(&table);
    let seen = (8..40).position(|frame| {
        let rgb = table.draw(&[wave_at(frame), flat.clone()]);
        see(&mut extractor, &rgb, &table).curves.len() == 2
    });
    assert!(seen.is_some_and(|frames| frames < 30), "{seen:?}");
}

#[test]
fn a_rope_that_goes_or_jumps_is_not_made_up() {
    let table = table();
    let mut extractor = followed(&table);
    let bare = table.draw(&[]);
    let scene = see(&mut extractor, &bare, &table);
    assert!(
        !scene.followed
            && scene
                .curves
                .iter()
                .all(|curve| curve.status == Status::Lost)
    );
    let mut extractor = followed(&table);
    let mut jumped = wave_at(8);
    jumped.points.iter_mut().for_each(|point| point[1] += 60.0);
    let rgb = table.draw(std::slice::from_ref(&jumped));
    let scene = see(&mut extractor, &rgb, &table);
    assert!(!scene.followed);
    assert!(error(&scene.curves[0], &jumped).mean_px < 0.5);
}

#[test]
fn a_tip_that_slides_and_a_hand_over_the_rope_are_seen() {
    let table = table();
    let mut extractor = followed(&table);
    // A quarter of the rope is pulled out of sight.
    let mut short = wave_at(8);
    let left = short.points.len() * 3 / 4;
    short.points.truncate(left);
    let rgb = table.draw(std::slice::from_ref(&short));
    let scene = see(&mut extractor, &rgb, &table);
    let tip: Vec2 = short.points[left - 1];
    let ends = [scene.curves[0].points[0], scene.curves[0].points[119]];
    assert!(ends.iter().any(|&end| distance(end, tip) < 2.0), "{ends:?}");
    let mut extractor = followed(&table);
    let hand = Rope::along(50.0, [224.0, 172.0, 140.0], |t| [150.0, 20.0 + 110.0 * t]);
    let rgb = table.draw(&[wave_at(8), hand]);
    let scene = see(&mut extractor, &rgb, &table);
    assert!(!scene.followed && scene.curves[0].status != Status::Ok);
}

#[test]
fn ropes_are_followed_in_every_pixel_format() {
    // An odd size, so that the last pixel pair is half outside.
    let mut table = Table::new(319, 239, WHITE);
    table.noise = 1.5;
    let film: [_; 24] = std::array::from_fn(|frame| {
        table.seed = frame as u64;
        let rope = wave_at(frame);
        let rgb = table.draw(std::slice::from_ref(&rope));
        (rope, formats(&rgb, 319, 239))
    });
    for k in 0..12 {
        let mut extractor = extractor();
        let mut followed = 0;
        for (frame, (rope, pictures)) in film.iter().enumerate() {
            let (format, ref bytes, stride) = pictures[k];
            let image = Image::new(bytes, 319, 239, stride, format).expect("a whole image");
            let scene = extractor.extract(&image);
            followed += usize::from(scene.followed);
            let error = error(&scene.curves[0], rope);
            let limits_px = match format {
                PixelFormat::Rgb8
                | PixelFormat::Bgr8
                | PixelFormat::Bgra8
                | PixelFormat::Gray8
                | PixelFormat::Gray16 => (0.25, 1.0),
                // Pixels that share their color blur it.
                PixelFormat::Yuyv | PixelFormat::Uyvy | PixelFormat::Nv12 => (0.5, 1.5),
                // Pixels with one of three channels blur it more, and each edge differently.
                _ => (0.25, 2.0),
            };
            assert!(
                error.mean_px < limits_px.0 && error.ends_px < limits_px.1,
                "{format:?} {frame}: {error:?}"
            );
        }
        assert!(followed >= 12, "format {k}: {followed} of 24 followed");
    }
}

//! A rope remains one rope under a cover, and an image without a rope reports none.

use crate::drawing;
use lariat_portable::SplitMix64;

use std::time::Duration;

use drawing::{Rope, Table, Vec2, distance_to, extractor, see};
use lariat_extract::{Extractor, Image, Options, PixelFormat, Status};

const WHITE: [f32; 3] = [215.0, 212.0, 205.0];
const BLUE: [f32; 3] = [30.0, 60.0, 130.0];
const GRAY: [u8; 3] = [110, 108, 104];

fn wave(shift: f32) -> Rope {
    Rope::along(8.0, BLUE, move |t| {
        [30.0 + 260.0 * t, 110.0 + shift + 35.0 * (5.0 * t).sin()]
    })
}

/// Paints a plate over the picture.
fn cover(rgb: &mut [u8], table: &Table, from: [usize; 2], to: [usize; 2], color: [u8; 3]) {
    for y in from[1]..to[1] {
        for x in from[0]..to[0] {
            let i = 3 * (y * table.width + x);
            rgb[i..i + 3].copy_from_slice(&color);
        }
    }
}

fn noisy() -> Table {
    let mut table = Table::new(320, 240, WHITE);
    table.noise = 2.0;
    table
}

fn worst(points: &[Vec2], rope: &Rope) -> f32 {
    let off = points.iter().map(|&p| distance_to(p, &rope.points));
    off.fold(0.0, f32::max)
}

#[test]
fn what_a_gripper_hides_is_bridged_and_marked() {
    let table = noisy();
    let mut extractor = extractor();
    for frame in 0..30 {
        let rope = wave(0.3 * frame as f32);
        let mut rgb = table.draw(std::slice::from_ref(&rope));
        // The plate appears suddenly, and then moves along the rope.
        let left = 110 + 2 * frame;
        let (from, to) = ([left, 70], [left + 45, 200]);
        if frame >= 5 {
            cover(&mut rgb, &table, from, to, GRAY);
        }
        let scene = see(&mut extractor, &rgb, &table);
        assert_eq!(scene.curves.len(), 1, "frame {frame}");
        let curve = &scene.curves[0];
        let expected = if frame < 5 {
            Status::Ok
        } else {
            Status::Partial
        };
        assert_eq!((curve.track, curve.status), (0, expected), "frame {frame}");
        assert!(worst(&curve.points, &rope) < 4.0, "frame {frame}");
        for (p, &hidden) in curve.points.iter().zip(&curve.hidden) {
            let inside = p[0] - from[0] as f32;
            let is_under = frame >= 5 && (4.0..41.0).contains(&inside);
            let is_free = frame < 5 || !(-6.0..51.0).contains(&inside);
            assert!(hidden || !is_under, "frame {frame}: {p:?} is hidden");
            assert!(!hidden || !is_free, "frame {frame}: {p:?} is seen");
        }
    }
}

#[test]
fn a_cover_of_the_tables_own_color_makes_no_two_ropes_of_one() {
    let table = noisy();
    let mut extractor = extractor();
    let rope = wave(0.0);
    let mut rgb = table.draw(std::slice::from_ref(&rope));
    for _ in 0..4 {
        see(&mut extractor, &rgb, &table);
    }
    cover(
        &mut rgb,
        &table,
        [150, 40],
        [190, 200],
        WHITE.map(|c| c as u8),
    );
    let scene = see(&mut extractor, &rgb, &table);
    assert_eq!(scene.curves.len(), 1);
    let curve = &scene.curves[0];
    assert_eq!((curve.track, curve.status), (0, Status::Partial));
    assert!(worst(&curve.points, &rope) < 2.0);
}

#[test]
fn a_rope_first_seen_under_a_gripper_is_one_rope() {
    let table = noisy();
    let rope = wave(0.0);
    let mut rgb = table.draw(std::slice::from_ref(&rope));
    cover(&mut rgb, &table, [180, 50], [225, 180], GRAY);
    let mut extractor = extractor();
    let scene = see(&mut extractor, &rgb, &table);
    assert_eq!(scene.curves.len(), 1);
    assert_eq!(scene.curves[0].status, Status::Partial);
    assert!(worst(&scene.curves[0].points, &rope) < 8.0);
}

#[test]
fn two_ropes_in_one_line_stay_two() {
    let table = noisy();
    let piece =
        |from: f32, to: f32| Rope::along(8.0, BLUE, move |t| [from + (to - from) * t, 120.0]);
    let rgb = table.draw(&[piece(30.0, 140.0), piece(180.0, 290.0)]);
    let mut extractor = extractor();
    for frame in 0..5 {
        let scene = see(&mut extractor, &rgb, &table);
        assert_eq!(scene.curves.len(), 2, "frame {frame}");
        assert!(
            scene.curves.iter().all(|c| c.status == Status::Ok),
            "frame {frame}"
        );
    }
}

#[test]
fn a_covered_end_is_told_from_a_shorter_rope() {
    let table = noisy();
    let mut extractor = extractor();
    let mut rgb = table.draw(&[wave(0.0)]);
    for _ in 0..4 {
        assert_eq!(
            see(&mut extractor, &rgb, &table).curves[0].status,
            Status::Ok
        );
    }
    // Twenty pixels of 280: by its length alone the rope might be whole.
    cover(
        &mut rgb,
        &table,
        [270, 60],
        [310, 160],
        WHITE.map(|c| c as u8),
    );
    assert_eq!(
        see(&mut extractor, &rgb, &table).curves[0].status,
        Status::Partial
    );
}

#[test]
fn a_lost_rope_tells_its_age_and_is_dropped_after_its_time() {
    const MS: u64 = 1_000_000;
    let table = noisy();
    let options = Options::default().keep_lost(Duration::from_millis(250));
    let mut extractor = Extractor::new(options).expect("valid options");
    let (shown, empty) = (table.draw(&[wave(0.0)]), table.draw(&[]));
    let mut ages = Vec::new();
    for k in 0..20u64 {
        let rgb = if k < 10 { &shown } else { &empty };
        let image = Image::new(rgb, 320, 240, 960, PixelFormat::Rgb8).expect("a whole image");
        let scene = extractor.at(7_000 * MS + k * 50 * MS).extract(&image);
        ages.extend(
            scene
                .curves
                .iter()
                .map(|c| (c.status == Status::Lost, c.age_ns / MS)),
        );
    }
    assert!(ages[..10].iter().all(|&age| age == (false, 0)));
    let lost: Vec<_> = (1..=5).map(|k| (true, 50 * k)).collect();
    assert_eq!(ages[10..], lost);
}

#[test]
fn a_cut_takes_no_shape_over() {
    let table = noisy();
    let mut extractor = extractor();
    let before = table.draw(&[wave(0.0)]);
    let other = Rope::along(6.0, [150.0, 40.0, 40.0], |t| {
        [60.0 + 60.0 * t, 30.0 + 180.0 * t * t]
    });
    for _ in 0..6 {
        see(&mut extractor, &before, &table);
    }
    let after = table.draw(std::slice::from_ref(&other));
    for frame in 0..40 {
        let scene = see(&mut extractor, &after, &table);
        let (seen, lost): (Vec<_>, Vec<_>) =
            scene.curves.iter().partition(|c| c.status != Status::Lost);
        assert_eq!(seen.len(), 1, "frame {frame}");
        assert_eq!(
            (seen[0].track, seen[0].status),
            (1, Status::Ok),
            "frame {frame}"
        );
        // Its tip bends with a radius of 10 px, and smoothing straightens it by 1 px.
        let worst_px = worst(&seen[0].points, &other);
        assert!(worst_px < 1.5, "frame {frame}: {worst_px}");
        assert_eq!(lost.len(), usize::from(frame < 30), "frame {frame}");
    }
}

#[test]
fn a_frame_of_noise_is_no_rope_and_changes_none() {
    let table = noisy();
    let mut extractor = extractor();
    let shown = table.draw(&[wave(0.0)]);
    let mut random = SplitMix64::new(5);
    let noise: Vec<u8> = (0..shown.len())
        .map(|_| (random.next_u64() >> 40) as u8)
        .collect();
    for round in 0..5 {
        for _ in 0..4 {
            let curve = &see(&mut extractor, &shown, &table).curves[0];
            assert_eq!(
                (curve.track, curve.status),
                (0, Status::Ok),
                "round {round}"
            );
        }
        let scene = see(&mut extractor, &noise, &table);
        let none_seen = scene.curves.iter().all(|c| c.status == Status::Lost);
        assert!(none_seen, "round {round}");
    }
}

#[test]
fn another_pixel_format_is_the_same_scene() {
    let table = noisy();
    let mut extractor = extractor();
    let rgb = table.draw(&[wave(0.0)]);
    let gray: Vec<u8> = rgb.chunks_exact(3).map(|p| p[1]).collect();
    // Half as many chroma samples as pixels, as an ordinary camera sends them.
    let yuyv: Vec<u8> = rgb
        .chunks_exact(6)
        .flat_map(|p| [p[1], 128 + (p[2] / 4) - (p[0] / 4), p[4], 120])
        .collect();
    let uyvy: Vec<u8> = yuyv.chunks_exact(2).flat_map(|p| [p[1], p[0]]).collect();
    let formats = [
        (&rgb, 960, PixelFormat::Rgb8),
        (&gray, 320, PixelFormat::Gray8),
        (&yuyv, 640, PixelFormat::Yuyv),
        (&uyvy, 640, PixelFormat::Uyvy),
        (&rgb, 960, PixelFormat::Bgr8),
    ];
    for (bytes, stride, format) in formats.into_iter().cycle().take(15) {
        let image = Image::new(bytes, 320, 240, stride, format).expect("a whole image");
        let scene = extractor.extract(&image);
        assert_eq!(scene.curves.len(), 1, "{format:?}");
        let curve = &scene.curves[0];
        assert_eq!((curve.track, curve.status), (0, Status::Ok), "{format:?}");
    }
}

#[test]
fn without_an_image_a_rope_is_lost_where_it_was_and_comes_back_as_itself() {
    let table = noisy();
    let mut extractor = extractor();
    let rgb = table.draw(&[wave(0.0)]);
    let mut at_ns = 0;
    let mut last = Vec::new();
    let mut track = 0;
    for _ in 0..20 {
        at_ns += 40_000_000;
        extractor.at(at_ns);
        let scene = see(&mut extractor, &rgb, &table);
        assert_eq!(scene.curves[0].status, Status::Ok);
        (track, last) = (scene.curves[0].track, scene.curves[0].points.clone());
    }
    let seen_ns = at_ns;
    for _ in 0..5 {
        at_ns += 100_000_000;
        let scene = extractor.at(at_ns).blank();
        assert_eq!(scene.curves.len(), 1);
        let curve = &scene.curves[0];
        assert_eq!((curve.track, curve.status), (track, Status::Lost));
        assert_eq!(curve.age_ns, at_ns - seen_ns);
        assert_eq!(curve.points, last);
        assert!(scene.crossings.is_empty());
    }
    at_ns += 40_000_000;
    extractor.at(at_ns);
    let scene = see(&mut extractor, &rgb, &table);
    assert_eq!(scene.curves.len(), 1);
    let curve = &scene.curves[0];
    assert_eq!((curve.track, curve.status), (track, Status::Ok));
    assert_eq!(curve.age_ns, 0);
    // Out of sight for too long, it is forgotten.
    let scene = extractor.at(at_ns + 60_000_000_000).blank();
    assert!(scene.curves.is_empty());
}

#[test]
fn before_the_first_image_there_is_nothing_to_lose() {
    let mut extractor = extractor();
    assert!(extractor.at(5).blank().curves.is_empty());
}

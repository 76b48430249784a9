//! A rope keeps its number and its direction from frame to frame.

use crate::drawing;

use std::time::Duration;

use drawing::{Rope, Table, Vec2, distance, extractor, see};
use lariat_extract::{Curve, Extractor, Options, Status};

const WHITE: [f32; 3] = [215.0, 212.0, 205.0];
const BLUE: [f32; 3] = [30.0, 60.0, 130.0];

/// A rope that swings about its middle, with a loop that grows and shrinks.
fn swinging(frame: usize) -> Rope {
    let time = frame as f32 / 40.0;
    Rope::along(7.0, BLUE, move |t| {
        let a = -4.4 + 8.8 * t;
        let wide = 46.0 + 8.0 * (3.0 * time).sin();
        let (x, y) = (20.0 * a - wide * a.sin(), 45.0 * a.cos());
        let (sin, cos) = (2.0 * time).sin_cos();
        [160.0 + x * cos - y * sin, 150.0 + x * sin + y * cos]
    })
}

#[test]
fn a_moving_rope_keeps_its_track_and_its_direction() {
    let mut table = Table::new(320, 300, WHITE);
    table.noise = 2.0;
    let mut extractor = extractor();
    let mut forward = None;
    let mut first_track = None;
    for frame in 0..160 {
        table.seed = frame as u64;
        let rope = swinging(frame);
        let scene = see(
            &mut extractor,
            &table.draw(std::slice::from_ref(&rope)),
            &table,
        );
        assert_eq!(scene.curves.len(), 1, "frame {frame}");
        let curve = &scene.curves[0];
        assert_eq!(curve.status, Status::Ok, "frame {frame}");
        let (start, end) = (rope.points[0], rope.points[rope.points.len() - 1]);
        let starts_at = |tip: Vec2| distance(curve.points[0], tip);
        let is_forward = starts_at(start) < starts_at(end);
        assert_eq!(
            *forward.get_or_insert(is_forward),
            is_forward,
            "frame {frame}"
        );
        assert_eq!(
            *first_track.get_or_insert(curve.track),
            curve.track,
            "frame {frame}"
        );
        assert!(starts_at(start).min(starts_at(end)) < 1.5, "frame {frame}");
    }
}

#[test]
fn another_extractor_that_goes_on_keeps_tracks_and_directions_and_gives_no_number_again() {
    let table = Table::new(320, 300, WHITE);
    let mut first = extractor();
    let low = Rope::along(8.0, BLUE, |t| [40.0 + 200.0 * t, 270.0]);
    for frame in 0..20 {
        let ropes = [swinging(frame), low.clone()];
        see(&mut first, &table.draw(&ropes), &table);
    }
    // One rope leaves.
    let mut before = Vec::new();
    for frame in 20..60 {
        let drawn = table.draw(&[swinging(frame)]);
        before = see(&mut first, &drawn, &table).curves.to_vec();
    }
    let [start, end] = [before[0].points[0], before[0].points[119]];
    let ropes = [swinging(60), low];
    let drawn = table.draw(&ropes);
    let is_kept = |curve: &Curve| distance(curve.points[0], start) < distance(curve.points[0], end);
    // An extractor without a past begins at the other end.
    let alone = see(&mut extractor(), &drawn, &table).curves.to_vec();
    assert!(!alone.iter().any(is_kept));
    let mut second = extractor();
    second.resume([320, 300], 2_000_000_000, &before, first.tracks());
    second.at(2_033_000_000);
    let after = see(&mut second, &drawn, &table).curves.to_vec();
    let known = after.iter().find(|curve| curve.track == before[0].track);
    assert!(is_kept(known.expect("the rope that was known")));
    let new = after.iter().find(|curve| curve.track != before[0].track);
    assert_eq!(new.expect("the rope that came back").track, 2);
}

fn straight(y: f32, shift: f32) -> Rope {
    Rope::along(8.0, BLUE, move |t| {
        [40.0 + shift + 200.0 * t, y + 20.0 * (3.0 * t).sin()]
    })
}

#[test]
fn a_rope_out_of_sight_is_lost_and_comes_back_as_itself() {
    let table = Table::new(320, 240, WHITE);
    let mut extractor = extractor();
    let shown = table.draw(&[straight(100.0, 0.0)]);
    let empty = table.draw(&[]);
    let track = see(&mut extractor, &shown, &table).curves[0].track;
    for _ in 0..5 {
        see(&mut extractor, &shown, &table);
    }
    for frame in 0..10 {
        let scene = see(&mut extractor, &empty, &table);
        assert_eq!(scene.curves.len(), 1, "frame {frame}");
        assert_eq!(
            (scene.curves[0].status, scene.curves[0].track),
            (Status::Lost, track)
        );
        assert_eq!(scene.crossings, []);
    }
    let moved = table.draw(&[straight(130.0, 20.0)]);
    let scene = see(&mut extractor, &moved, &table);
    assert_eq!(scene.curves.len(), 1);
    assert_eq!(
        (scene.curves[0].status, scene.curves[0].track),
        (Status::Ok, track)
    );
}

#[test]
fn a_lost_rope_is_dropped_in_the_end() {
    let table = Table::new(320, 240, WHITE);
    let options = Options::default()
        // An image without a time counts as taken 1/30 s after the last.
        .keep_lost(Duration::from_millis(134));
    let mut extractor = Extractor::new(options).expect("valid options");
    let shown = table.draw(&[straight(100.0, 0.0)]);
    for _ in 0..5 {
        see(&mut extractor, &shown, &table);
    }
    let empty = table.draw(&[]);
    let counts: Vec<_> = (0..6)
        .map(|_| see(&mut extractor, &empty, &table).curves.len())
        .collect();
    assert_eq!(counts, [1, 1, 1, 1, 0, 0]);
}

#[test]
fn a_second_rope_gets_a_new_track_and_the_first_keeps_its_own() {
    let table = Table::new(320, 240, WHITE);
    let mut extractor = extractor();
    let one = table.draw(&[straight(60.0, 0.0)]);
    let track = see(&mut extractor, &one, &table).curves[0].track;
    let two = table.draw(&[straight(60.0, 3.0), straight(170.0, 0.0)]);
    let scene = see(&mut extractor, &two, &table);
    assert_eq!(scene.curves.len(), 2);
    let upper = scene
        .curves
        .iter()
        .find(|c| c.points[0][1] < 110.0)
        .expect("the first rope");
    let lower = scene
        .curves
        .iter()
        .find(|c| c.points[0][1] > 110.0)
        .expect("the second rope");
    assert_eq!(upper.track, track);
    assert_ne!(lower.track, track);
}

#[test]
fn a_covered_rope_is_seen_in_part() {
    let table = Table::new(320, 240, WHITE);
    let mut extractor = extractor();
    let whole = table.draw(&[straight(100.0, 0.0)]);
    assert_eq!(
        see(&mut extractor, &whole, &table).curves[0].status,
        Status::Ok
    );
    let half = Rope::along(8.0, BLUE, |t| {
        let t = 0.7 * t;
        [40.0 + 200.0 * t, 100.0 + 20.0 * (3.0 * t).sin()]
    });
    let scene = see(&mut extractor, &table.draw(&[half]), &table);
    assert_eq!(scene.curves[0].status, Status::Partial);
}

#[test]
fn another_image_size_is_a_new_scene() {
    let (small, large) = (Table::new(320, 240, WHITE), Table::new(400, 240, WHITE));
    let mut extractor = extractor();
    let rope = [straight(100.0, 0.0)];
    let before = see(&mut extractor, &small.draw(&rope), &small).curves[0].track;
    let scene = see(&mut extractor, &large.draw(&rope), &large);
    assert_eq!(scene.curves.len(), 1);
    assert_ne!(scene.curves[0].track, before);
    let scene = see(&mut extractor, &small.draw(&[]), &small);
    assert_eq!(scene.curves, [], "no shape of the other size is passed on");
}

#[test]
fn crossings_say_where_and_at_which_arc_length() {
    let table = Table::new(320, 240, WHITE);
    let green = [150.0, 190.0, 70.0];
    let under = Rope::along(9.0, BLUE, |t| [40.0 + 240.0 * t, 60.0 + 120.0 * t]);
    let over = Rope::along(9.0, green, |t| [60.0 + 150.0 * t, 190.0 - 140.0 * t]);
    let mut extractor = extractor();
    let scene = see(
        &mut extractor,
        &table.draw(&[under.clone(), over.clone()]),
        &table,
    );
    assert_eq!((scene.curves.len(), scene.crossings.len()), (2, 1));
    let crossing = scene.crossings[0];
    assert!(crossing.confidence > 0.3, "{crossing:?}");
    for (index, rho, rope) in [
        (crossing.over, crossing.over_rho, &over),
        (crossing.under, crossing.under_rho, &under),
    ] {
        let points = &scene.curves[index].points;
        assert!(drawing::distance_to(points[5], &rope.points) < 1.0);
        let nearest = points[(rho * 119.0).round() as usize];
        assert!(
            distance(nearest, crossing.at) < 2.0,
            "{nearest:?} {crossing:?}"
        );
    }
}

#[test]
fn a_rope_whose_ends_come_to_lie_along_each_other_stays_open() {
    let table = Table::new(320, 240, WHITE);
    let mut extractor = extractor();
    for frame in 0..40 {
        // Less than a turn at first; then an eighth of it overlaps itself.
        let turns = if frame < 10 { 0.97 } else { 1.12 };
        let rope = Rope::along(9.0, BLUE, |t| {
            let (sin, cos) = (std::f32::consts::TAU * turns * t).sin_cos();
            let radius = 70.0 + 4.0 * turns * t;
            [160.0 + radius * cos, 120.0 + radius * sin]
        });
        let rgb = table.draw(std::slice::from_ref(&rope));
        let scene = see(&mut extractor, &rgb, &table);
        assert_eq!(scene.curves.len(), 1, "frame {frame}");
        let curve = &scene.curves[0];
        assert!(!curve.closed && curve.track == 0, "frame {frame}");
        let first = curve.points[0];
        let off = distance(first, rope.points[0]).min(distance(first, rope.points[1500]));
        assert!(off < 20.0, "frame {frame}: {off}");
    }
}

/// A straight stem, a bend of this radius by 215°, and a straight tail that comes down on the stem.
/// The length is constant.
fn noose(radius_px: f32) -> Rope {
    const LENGTH_PX: f32 = 420.0;
    const STEM_PX: f32 = 160.0;
    let mut rope = Rope::along(8.0, BLUE, |t| [t, 0.0]);
    let (mut at, step_px) = ([40.0f32, 170.0], LENGTH_PX / rope.points.len() as f32);
    for (i, point) in rope.points.iter_mut().enumerate() {
        *point = at;
        let bent_px = (i as f32 * step_px - STEM_PX).max(0.0);
        let (sin, cos) = (bent_px / radius_px).min(3.75).sin_cos();
        at = [at[0] + step_px * cos, at[1] - step_px * sin];
    }
    rope
}

#[test]
fn a_tip_on_its_way_over_a_strand_stays_a_part_of_the_rope() {
    let table = Table::new(320, 240, WHITE);
    let mut extractor = extractor();
    for frame in 0..60 {
        let rope = noose(42.0 - 0.25 * frame as f32);
        let rgb = table.draw(std::slice::from_ref(&rope));
        let scene = see(&mut extractor, &rgb, &table);
        assert_eq!(scene.curves.len(), 1, "frame {frame}");
        let curve = &scene.curves[0];
        let tips = [rope.points[0], rope.points[rope.points.len() - 1]];
        let ends = [curve.points[0], curve.points[curve.points.len() - 1]];
        let off = |a: usize, b: usize| distance(ends[0], tips[a]).max(distance(ends[1], tips[b]));
        let off = off(0, 1).min(off(1, 0));
        assert!(off < rope.width_px, "frame {frame}: {off}");
    }
}

//! Fragments of ropes over the bare table, under a hand, and under an occluder.

use super::*;
use crate::bitmap::bits::BitPlane;
use crate::image::gray::GrayPlane;
use crate::past::{Past, State};

fn straight(from: Vec2, to: Vec2) -> Line {
    let count = vec2::distance(from, to) as usize;
    let samples = (0..=count)
        .map(|i| Sample {
            at: vec2::along(from, vec2::sub(to, from), i as f32 / count as f32),
            weight: 1.0,
            width_px: 6.0,
            side: 0.0,
        })
        .collect();
    Line {
        samples,
        closed: false,
        border: [false; 2],
    }
}

/// Data for judging ends, for a mask of the extractor's own.
fn scenery<'a>(past: &'a Past, difference: &'a GrayPlane, occluder: &'a BitPlane) -> Scenery<'a> {
    Scenery {
        past,
        difference,
        level: 20.0,
        occluder,
        yuv: false,
        elsewhere: None,
        picked: None,
    }
}

/// A strand over two fragments of another one, and a rope that ends next to them: the fragments are
/// one line.
#[test]
fn pieces_of_a_strand_under_another_are_one_line() {
    let mut lines = vec![
        straight([200.0, 20.0], [200.0, 180.0]),
        straight([100.0, 100.0], [196.0, 100.0]),
        straight([204.0, 102.0], [300.0, 110.0]),
    ];
    let mut mask = BitPlane::default();
    mask.resize(400, 200);
    (0..200).for_each(|y| mask.fill(y, 195, 206, true));
    (94..106).for_each(|y| mask.fill(y, 100, 300, true));
    let (past, occluder) = (Past::default(), BitPlane::default());
    let mut difference = GrayPlane::default();
    difference.resize(400, 200);
    let scenery = scenery(&past, &difference, &occluder);
    let mut colors = vec![[90.0; 3]; lines.len()];
    let mut bridger = Bridger::default();
    let count = bridger.join_under(&mut lines, &mut colors, &scenery, (&mask, 8.0));
    assert_eq!(count, 2);
    assert!(lines[0].length_px() > 195.0, "{}", lines[0].length_px());
    // Lines of different colors are not fragments of one rope.
    let mut lines = vec![
        straight([100.0, 100.0], [196.0, 100.0]),
        straight([204.0, 102.0], [300.0, 110.0]),
    ];
    let mut colors = vec![[90.0; 3], [200.0; 3]];
    assert_eq!(
        bridger.join_under(&mut lines, &mut colors, &scenery, (&mask, 8.0)),
        2
    );
}

#[test]
fn a_rope_that_is_joined_to_nothing_ends_under_the_strand() {
    let (mut mask, past, occluder) = (BitPlane::default(), Past::default(), BitPlane::default());
    mask.resize(400, 200);
    (0..200).for_each(|y| mask.fill(y, 195, 206, true));
    (96..104).for_each(|y| mask.fill(y, 100, 206, true));
    let mut difference = GrayPlane::default();
    difference.resize(400, 200);
    let scenery = scenery(&past, &difference, &occluder);
    let mut lines = vec![straight([100.0, 100.0], [194.0, 100.0])];
    let mut bridger = Bridger::default();
    let count = bridger.join_under(&mut lines, &mut [[90.0; 3]], &scenery, (&mask, 8.0));
    assert_eq!(count, 1);
    let ends = [0, lines[0].samples.len() - 1].map(|i| lines[0].samples[i].at[0]);
    let [free, hidden] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
    assert!((99.0..101.0).contains(&free), "{free}");
    assert!((196.0..206.0).contains(&hidden), "{hidden}");
}

fn join(lines: &mut [Line], past: &Past, is_hidden: bool) -> (usize, Vec<Gap>) {
    join_under(lines, past, is_hidden, &BitPlane::default())
}

fn join_under(
    lines: &mut [Line],
    past: &Past,
    is_hidden: bool,
    occluder: &BitPlane,
) -> (usize, Vec<Gap>) {
    let mut difference = GrayPlane::default();
    difference.resize(400, 200);
    (0..200).for_each(|y| difference.row_mut(y).fill(if is_hidden { 90 } else { 0 }));
    let scenery = scenery(past, &difference, occluder);
    let mut colors = vec![[50.0; 3]; lines.len()];
    let mut bridger = Bridger::default();
    let count = bridger.join(lines, &mut colors, &scenery);
    (count, bridger.gaps)
}

#[test]
fn pieces_of_a_known_rope_are_joined_whichever_way_they_run() {
    let mut past = Past::default();
    let points: Vec<Vec2> = (0..=60).map(|i| [20.0 + 5.0 * i as f32, 100.0]).collect();
    past.add(false, [300.0, 6.0], &points);
    let mut lines = [
        straight([120.0, 102.0], [20.0, 102.0]),
        straight([320.0, 102.0], [180.0, 102.0]),
    ];
    let (count, gaps) = join(&mut lines, &past, false);
    assert_eq!((count, gaps.len()), (1, 1));
    assert!((lines[0].length_px() - 300.0).abs() < 1.0);
    let middle = 0.5 * (gaps[0].from_px + gaps[0].to_px);
    let from_left = lines[0].samples[0].at[0] < 100.0;
    let expected = if from_left { 130.0 } else { 170.0 };
    assert!((middle - expected).abs() < 1.5, "{gaps:?}");
    assert!((gaps[0].to_px - gaps[0].from_px - 60.0).abs() < 1.5);
}

#[test]
fn pieces_that_run_on_past_each_other_are_one_rope_in_a_mask_that_is_a_guess() {
    let (mut difference, table) = (GrayPlane::default(), [200; 400 * 200]);
    difference.resize(400, 200);
    (0..200).for_each(|y| difference.row_mut(y).fill(90));
    let image = crate::Image::new(&table, 400, 200, 400, crate::PixelFormat::Gray8);
    let image = image.expect("whole");
    let (past, occluder) = (Past::default(), BitPlane::default());
    let mut scenery = scenery(&past, &difference, &occluder);
    scenery.elsewhere = Some(&image);
    let count = |aside_px: f32, scenery: &Scenery| {
        let mut lines = [
            straight([20.0, 100.0], [200.0, 100.0]),
            straight([330.0, 100.0 + aside_px], [150.0, 100.0 + aside_px]),
        ];
        Bridger::default().join(&mut lines, &mut [[50.0; 3]; 2], scenery)
    };
    assert_eq!(count(3.0, &scenery), 1);
    // Two ropes side by side.
    assert_eq!(count(6.0, &scenery), 2);
    scenery.elsewhere = None;
    assert_eq!(count(3.0, &scenery), 2);
}

#[test]
fn a_rope_is_two_where_the_bare_table_is_seen_over_more_than_what_is_missing() {
    let points: Vec<Vec2> = (0..=60).map(|i| [20.0 + 5.0 * i as f32, 100.0]).collect();
    let count = |usual_px: f32, gap_px: f32, is_hidden: bool| {
        let mut past = Past::default();
        let sizes_px = [300.0, 6.0, usual_px];
        past.add_covered(false, sizes_px, &points, [None; 2], State::SEEN);
        let mut lines = [
            straight([20.0, 100.0], [120.0, 100.0]),
            straight([120.0 + gap_px, 100.0], [320.0, 100.0]),
        ];
        join(&mut lines, &past, is_hidden).0
    };
    // The fragments alone are far longer than the rope usually is.
    assert_eq!(count(140.0, 60.0, false), 2);
    assert_eq!(count(140.0, 60.0, true), 1);
    // The fragments alone have the usual length.
    assert_eq!(count(270.0, 30.0, false), 2);
    assert_eq!(count(270.0, 30.0, true), 1);
    assert_eq!(count(270.0, 12.0, false), 1);
    // Less length is missing than the gap takes.
    assert_eq!(count(285.0, 60.0, false), 2);
    assert_eq!(count(285.0, 60.0, true), 1);
    // As much length is missing as the gap takes.
    assert_eq!(count(300.0, 30.0, false), 1);
    assert_eq!(count(300.0, 60.0, false), 1);
}

#[test]
fn strangers_are_joined_over_an_occluder_and_not_over_the_table() {
    let pieces = || {
        [
            straight([20.0, 100.0], [120.0, 100.0]),
            straight([180.0, 103.0], [320.0, 103.0]),
        ]
    };
    assert_eq!(join(&mut pieces(), &Past::default(), false).0, 2);
    assert_eq!(join(&mut pieces(), &Past::default(), true).0, 1);
    let mut aside = pieces();
    aside[1] = straight([180.0, 150.0], [320.0, 150.0]);
    assert_eq!(join(&mut aside, &Past::default(), true).0, 2);
}

/// An occluder of 60 by 80 pixels, with its upper left corner at (120, 60).
fn thing() -> BitPlane {
    let mut plane = BitPlane::default();
    plane.resize(400, 200);
    (60..140).for_each(|y| plane.fill(y, 120, 180, true));
    plane
}

#[test]
fn a_rope_that_turns_back_under_a_thing_comes_out_of_it() {
    let ends = || {
        [
            straight([20.0, 80.0], [117.0, 80.0]),
            straight([20.0, 120.0], [117.0, 120.0]),
        ]
    };
    let mut lines = ends();
    let (count, gaps) = join_under(&mut lines, &Past::default(), true, &thing());
    assert_eq!((count, gaps.len()), (1, 1));
    // Half a circle.
    let way_px = gaps[0].to_px - gaps[0].from_px;
    assert!(
        (way_px - 20.0 * std::f32::consts::PI).abs() < 4.0,
        "{way_px}"
    );
    assert_eq!(join(&mut ends(), &Past::default(), true).0, 2, "no thing");
    // With a third end, it is unclear which two belong together.
    let [a, b] = ends();
    let mut lines = [a, b, straight([300.0, 70.0], [183.0, 70.0])];
    let count = join_under(&mut lines, &Past::default(), true, &thing()).0;
    assert!(count >= 2, "{count}");
}

/// A rope enters at the left and leaves below, where two more tips point at the occluder.
#[test]
fn of_several_ends_at_a_thing_two_are_one_ropes_that_bend_far_less_than_any_others() {
    let mut lines = [
        straight([20.0, 110.0], [117.0, 110.0]),
        straight([173.0, 195.0], [160.0, 143.0]),
        straight([124.0, 195.0], [124.0, 143.0]),
        straight([131.0, 195.0], [131.0, 143.0]),
    ];
    let (count, gaps) = join_under(&mut lines, &Past::default(), true, &thing());
    assert_eq!((count, gaps.len()), (3, 1));
    let ends = [0, lines[0].samples.len() - 1].map(|i| lines[0].samples[i].at[0]);
    assert!(ends.contains(&20.0) && ends.contains(&173.0), "{ends:?}");
}

#[test]
fn a_known_way_beside_the_thing_that_hides_it_gives_way_to_one_under_it() {
    // A loop that reached far to the right, and has moved back under the occluder.
    let mut past = Past::default();
    let turn = |t: f32| {
        let (sin, cos) = (std::f32::consts::PI * (t - 0.5)).sin_cos();
        [180.0 + 60.0 * cos, 100.0 + 20.0 * sin]
    };
    let to = (0..=32).map(|i| [20.0 + 5.0 * i as f32, 80.0]);
    let back = (0..=32).map(|i| [180.0 - 5.0 * i as f32, 120.0]);
    let points: Vec<Vec2> = to
        .chain((1..32).map(|i| turn(i as f32 / 32.0)))
        .chain(back)
        .collect();
    let length_px = points.windows(2).map(|p| vec2::distance(p[0], p[1])).sum();
    past.add(false, [length_px, 6.0], &points);
    let mut lines = [
        straight([20.0, 80.0], [117.0, 80.0]),
        straight([20.0, 120.0], [117.0, 120.0]),
    ];
    let (count, gaps) = join_under(&mut lines, &past, false, &thing());
    assert_eq!((count, gaps.len()), (1, 1));
    let farthest = lines[0].samples.iter().map(|s| s.at[0]).fold(0.0, f32::max);
    assert!(farthest < 182.0, "{farthest}");
}

/// A line along straight stretches, with its samples a pixel apart.
fn along(corners: &[Vec2]) -> Line {
    let mut lines = corners.windows(2).map(|pair| straight(pair[0], pair[1]));
    let first = lines.next().expect("two corners");
    lines.fold(first, |mut line, next| {
        line.samples.extend_from_slice(&next.samples[1..]);
        line
    })
}

/// Number of times that the joined lines pass the occluder's middle, from left to right or back.
fn passes(lines: &[Line]) -> usize {
    let samples = |line: &Line| line.samples.iter().map(|s| s.at).collect::<Vec<_>>();
    let lines = lines.iter().map(samples);
    let pairs = |line: Vec<Vec2>| {
        let is_pass = |p: &&[Vec2]| (p[0][0] < 150.0) != (p[1][0] < 150.0) && p[0][1] < 140.0;
        line.windows(2).filter(is_pass).count()
    };
    lines.map(pairs).sum()
}

#[test]
fn two_hairpins_under_a_thing_give_way_to_two_ways_that_run_on() {
    // The rope enters at the left, leaves at the right, runs around below the occluder, and does
    // the same again. In the prior, it turns back on both sides.
    let around = [
        [117.0, 120.0],
        [60.0, 120.0],
        [60.0, 180.0],
        [350.0, 180.0],
        [350.0, 80.0],
        [183.0, 80.0],
    ];
    let mut corners = vec![[20.0, 80.0], [117.0, 80.0], [127.0, 90.0], [127.0, 110.0]];
    corners.extend(around);
    corners.extend([
        [173.0, 90.0],
        [173.0, 110.0],
        [183.0, 120.0],
        [330.0, 120.0],
    ]);
    let (rope, mut past) = (along(&corners), Past::default());
    let points: Vec<Vec2> = rope.samples.iter().map(|s| s.at).collect();
    past.add(false, [rope.length_px(), 6.0], &points);
    let mut lines = [
        straight([20.0, 80.0], [117.0, 80.0]),
        along(&around),
        straight([183.0, 120.0], [330.0, 120.0]),
    ];
    let (count, gaps) = join_under(&mut lines, &past, false, &thing());
    assert_eq!((count, gaps.len()), (1, 2));
    assert_eq!(passes(&lines), 2);
}

#[test]
fn a_known_way_over_the_bare_table_gives_way_to_one_under_a_thing() {
    let corners = [[183.0, 80.0], [350.0, 80.0], [350.0, 120.0], [183.0, 120.0]];
    let (rope, mut past) = (along(&corners), Past::default());
    let points: Vec<Vec2> = rope.samples.iter().map(|s| s.at).collect();
    past.add(false, [rope.length_px(), 6.0], &points);
    let mut lines = [
        straight([183.0, 80.0], [260.0, 80.0]),
        along(&[[300.0, 80.0], [350.0, 80.0], [350.0, 120.0], [183.0, 120.0]]),
    ];
    let (count, gaps) = join_under(&mut lines, &past, false, &thing());
    assert_eq!((count, gaps.len()), (1, 1));
    let on_table = |s: &Sample| s.at[1] < 90.0 && (270.0..290.0).contains(&s.at[0]);
    assert!(!lines[0].samples.iter().any(on_table));
}

#[test]
fn two_ropes_that_were_two_stay_two() {
    let mut past = Past::default();
    for from in [20.0, 130.0] {
        let points: Vec<Vec2> = (0..=20).map(|i| [from + 5.0 * i as f32, 100.0]).collect();
        past.add(false, [100.0, 6.0], &points);
    }
    let mut lines = [
        straight([20.0, 100.0], [120.0, 100.0]),
        straight([130.0, 100.0], [230.0, 100.0]),
    ];
    assert_eq!(join(&mut lines, &past, true).0, 2);
}

/// Two lines that start at `from` and leave the image at the columns `at`. The image's last row is
/// y = 199.
fn leaving(from: [Vec2; 2], at: [f32; 2]) -> [Line; 2] {
    let line = |k: usize| Line {
        border: [false, true],
        ..straight(from[k], [at[k], 199.0])
    };
    [line(0), line(1)]
}

#[test]
fn a_rope_that_leaves_the_picture_and_comes_back_is_one() {
    let outside = |lines: &[Line]| {
        let beyond = |s: &&Sample| s.at[1] > 199.5;
        lines[0].samples.iter().filter(beyond).count()
    };
    // The rope turns by 74° outside.
    let mut flat = leaving([[60.0, 154.0], [240.0, 154.0]], [120.0, 180.0]);
    let (count, gaps) = join(&mut flat, &Past::default(), false);
    assert_eq!((count, gaps.len()), (1, 1));
    assert_eq!(flat[0].border, [false; 2]);
    assert!(outside(&flat) > 30);
    // These ends are too steep to tell, point away from each other, or are far apart.
    let steep = || leaving([[110.0, 100.0], [190.0, 100.0]], [120.0, 180.0]);
    let apart = || leaving([[180.0, 154.0], [120.0, 154.0]], [120.0, 180.0]);
    let far = || leaving([[20.0, 154.0], [300.0, 154.0]], [80.0, 240.0]);
    for mut lines in [steep(), apart(), far()] {
        assert_eq!(join(&mut lines, &Past::default(), false).0, 2);
    }
    // The prior has one rope, of its usual length.
    let corners = [
        [110.0, 99.0],
        [120.0, 190.0],
        [150.0, 230.0],
        [180.0, 190.0],
        [190.0, 99.0],
    ];
    let rope = along(&corners);
    let points: Vec<Vec2> = rope.samples.iter().map(|s| s.at).collect();
    let joined_px = |longer_px: f32| {
        let mut past = Past::default();
        let length_px = rope.length_px();
        let sizes_px = [length_px, 6.0, length_px + longer_px];
        past.add_covered(false, sizes_px, &points, [None; 2], State::SEEN);
        let mut lines = steep();
        assert_eq!(join(&mut lines, &past, false).0, 1);
        assert!(outside(&lines) > 30);
        lines[0].length_px()
    };
    let longer_px = joined_px(20.0) - joined_px(0.0);
    assert!((longer_px - 20.0).abs() < 2.0, "{longer_px}");
}

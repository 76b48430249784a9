//! Ropes are followed on any ground, with any mask, where they leave the picture and under covers.

use crate::drawing;

use drawing::{Rope, Table, distance, error, see};
use lariat_drawn::moving::{Film, Judge, SeenCurve, SeenStatus, Story, Verdict};
use lariat_drawn::{RenderOptions, Rendered};
use lariat_extract::{Extractor, HsvRange, Image, Mask, Options, PixelFormat, Scene, Status};

const SIZE: (usize, usize) = (480, 360);
const FRAMES: usize = 150;

fn with_mask(mask: Mask) -> Extractor {
    let options = Options::default().mask(mask);
    Extractor::new(options).expect("valid options")
}

fn blue() -> Mask {
    Mask::Hsv(vec![HsvRange {
        hue_deg: [200.0, 250.0],
        saturation: [0.3, 1.0],
        value: [0.1, 1.0],
    }])
}

fn seen(curve: &lariat_extract::Curve) -> SeenCurve<'_> {
    SeenCurve {
        track: curve.track,
        status: match curve.status {
            Status::Ok => SeenStatus::Ok,
            Status::Partial | Status::Doubtful => SeenStatus::Partial,
            Status::Lost => SeenStatus::Lost,
        },
        points: &curve.points,
        hidden: &curve.hidden,
    }
}

/// The errors in a film, and the number of its frames that were followed. For clutter, the true
/// mask is given if requested.
fn watch(story: Story, seed: u64, mask: Mask) -> (Verdict, usize) {
    let mut film = Film::new(story, seed, SIZE.0 as u32, SIZE.1 as u32);
    let is_given = mask == Mask::External;
    let mut extractor = with_mask(mask);
    let (mut judge, mut followed) = (Judge::default(), 0);
    let (mut rgb, mut mask) = (Vec::new(), Vec::new());
    for _ in 0..FRAMES {
        let truth = film.next(&mut rgb);
        let image = Image::new(&rgb, SIZE.0, SIZE.1, 3 * SIZE.0, PixelFormat::Rgb8);
        let image = image.expect("a whole image");
        if !is_given {
            extractor.extract(&image);
        } else if extractor.follow(&image).is_none() {
            film.mask(&truth, &mut mask);
            let mask = Image::new(&mask, SIZE.0, SIZE.1, SIZE.0, PixelFormat::Gray8);
            let mask = mask.expect("a byte a pixel");
            extractor.extract_masked(&image, &mask).expect("its size");
        }
        let scene = extractor.scene();
        followed += usize::from(scene.followed);
        judge.look(&truth, &scene.curves.iter().map(seen).collect::<Vec<_>>());
    }
    (judge.verdict(), followed)
}

fn assert_followed(story: Story, seed: u64, mask: Mask, least: usize) {
    let (verdict, followed) = watch(story, seed, mask);
    let name = story.name();
    assert_eq!(verdict.places(), [0; 6], "{name}: {verdict:?}");
    assert!(
        followed >= least,
        "{name}: {followed} of {FRAMES} frames followed"
    );
}

#[test]
fn a_rope_on_clutter_is_followed_by_its_edges() {
    assert_followed(Story::Clutter, 1, Mask::External, 110);
}

#[test]
fn a_rope_on_clutter_is_followed_by_a_camera_that_moves() {
    assert_followed(Story::Handheld, 2, Mask::External, 90);
}

#[test]
fn a_rope_that_a_range_of_colors_found_is_followed() {
    assert_followed(Story::Writhing, 1, blue(), 110);
}

#[test]
fn a_rope_that_leaves_the_picture_is_followed() {
    assert_followed(Story::Leaving, 1, Mask::Auto, 100);
    assert_followed(Story::Leaving, 1, blue(), 100);
}

#[test]
fn a_rope_is_followed_under_a_gripper_that_rides_along() {
    assert_followed(Story::Gripper, 600, Mask::Auto, 110);
}

/// A swaying ring.
fn ring_at(frame: usize) -> Rope {
    let phase = frame as f32 / 12.0;
    let mut rope = Rope::along(8.0, [30.0, 60.0, 130.0], move |t| {
        let (sin, cos) = (std::f32::consts::TAU * t).sin_cos();
        let x = 160.0 + 5.0 * phase.sin() + (80.0 + 6.0 * phase.cos()) * cos;
        [x, 120.0 + 60.0 * sin + 10.0 * (2.0 * sin * cos)]
    });
    rope.closed = true;
    rope
}

#[test]
fn a_closed_rope_is_followed() {
    let mut table = Table::new(320, 240, [215.0, 212.0, 205.0]);
    table.noise = 2.0;
    for mask in [Mask::Auto, blue()] {
        let mut extractor = with_mask(mask);
        let mut followed = 0;
        for frame in 0..60 {
            table.seed = frame as u64;
            let rope = ring_at(frame);
            let scene = see(
                &mut extractor,
                &table.draw(std::slice::from_ref(&rope)),
                &table,
            );
            followed += usize::from(scene.followed);
            let [curve] = scene.curves else {
                panic!("{frame}: {} curves", scene.curves.len());
            };
            assert!(curve.closed, "{frame}");
            let off = |at: &[f32; 2]| {
                let to = |p: &[f32; 2]| distance(*at, *p);
                rope.points.iter().map(to).fold(f32::INFINITY, f32::min)
            };
            let most_px = curve.points.iter().map(off).fold(0.0, f32::max);
            assert!(most_px < 1.0, "{frame}: {most_px} px off");
        }
        assert!(followed >= 45, "{followed} of 60 frames followed");
    }
}

/// A waving rope.
fn wave_at(frame: usize) -> Rope {
    let phase = frame as f32 / 15.0;
    Rope::along(8.0, [30.0, 60.0, 130.0], move |t| {
        let x = 40.0 + 240.0 * t + 6.0 * phase.sin();
        [x, 80.0 + 35.0 * (5.0 * t + 0.4 * phase).sin()]
    })
}

/// An extractor by color that follows the waving rope.
fn followed(table: &Table) -> Extractor {
    let mut extractor = with_mask(blue());
    for frame in 0..8 {
        let scene = see(&mut extractor, &table.draw(&[wave_at(frame)]), table);
        assert!(frame < 7 || scene.followed, "the rope is plain to see");
    }
    extractor
}

#[test]
fn what_else_happens_is_left_to_a_whole_extraction() {
    let mut table = Table::new(320, 240, [215.0, 212.0, 205.0]);
    table.noise = 2.0;
    // Another rope appears. Upright, it crosses a row that is read soon; flat, it may be between
    // rows.
    let upright = Rope::along(8.0, [30.0, 90.0, 150.0], |t| [300.0, 130.0 + 100.0 * t]);
    let flat = Rope::along(8.0, [30.0, 90.0, 150.0], |t| [60.0 + 160.0 * t, 200.0]);
    for (other, most) in [(upright, 8), (flat, 30)] {
        let mut extractor = followed(&table);
        let seen = (8..40).position(|frame| {
            let rgb = table.draw(&[wave_at(frame), other.clone()]);
            see(&mut extractor, &rgb, &table).curves.len() == 2
        });
        assert!(seen.is_some_and(|frames| frames <= most), "{seen:?}");
    }
    // The rope is gone.
    let mut extractor = followed(&table);
    let scene = see(&mut extractor, &table.draw(&[]), &table);
    assert!(!scene.followed && scene.curves.iter().all(|c| c.status == Status::Lost));
    // It jumps.
    let mut extractor = followed(&table);
    let mut jumped = wave_at(8);
    jumped.points.iter_mut().for_each(|point| point[1] += 60.0);
    let scene = see(
        &mut extractor,
        &table.draw(std::slice::from_ref(&jumped)),
        &table,
    );
    assert!(!scene.followed);
    assert!(error(&scene.curves[0], &jumped).mean_px < 0.5);
}

#[test]
fn a_rope_that_is_drawn_along_itself_has_its_ends_where_they_are() {
    let mut table = Table::new(480, 240, [215.0, 212.0, 205.0]);
    table.noise = 2.0;
    let mut extractor = with_mask(blue());
    let mut drawn_px = 0.0;
    for frame in 0..20 {
        table.seed = frame as u64;
        // The rope moves along itself, faster from frame to frame. Except at its ends, it covers
        // the same places as before.
        drawn_px += 4.0 - 4.0 * (0.2 * frame as f32).cos();
        let rope = Rope::along(12.0, [30.0, 60.0, 130.0], move |t| {
            let x = 40.0 + drawn_px + 280.0 * t;
            [x, 120.0 + 60.0 * (x / 70.0).sin()]
        });
        let rgb = table.draw(std::slice::from_ref(&rope));
        let error = error(&see(&mut extractor, &rgb, &table).curves[0], &rope);
        assert!(error.ends_px < 3.0, "{frame}: {error:?}");
    }
}

#[test]
fn a_rope_whose_tip_lies_against_another_is_followed_with_it() {
    let mut table = Table::new(320, 240, [215.0, 212.0, 205.0]);
    table.noise = 2.0;
    let mut extractor = with_mask(Mask::Auto);
    let mut followed = 0;
    for frame in 0..60 {
        table.seed = frame as u64;
        let rope = wave_at(frame);
        let [x, y] = rope.points[rope.points.len() / 2];
        let other = Rope::along(8.0, [30.0, 60.0, 130.0], move |t| {
            [x + 8.0 * t, y + 8.5 + 110.0 * t]
        });
        let ropes = [rope, other];
        let scene = see(&mut extractor, &table.draw(&ropes), &table);
        assert_eq!(scene.curves.len(), 2, "{frame}");
        followed += usize::from(scene.followed);
        for rope in &ropes {
            let errors = scene.curves.iter().map(|curve| error(curve, rope));
            let nearest = errors.min_by(|a, b| a.mean_px.total_cmp(&b.mean_px));
            let nearest = nearest.expect("there are two");
            assert!(
                nearest.mean_px < 0.6 && nearest.ends_px < 3.0,
                "{frame}: {nearest:?}"
            );
        }
    }
    assert!(followed >= 30, "{followed} of 60 frames followed");
}

/// Calls `with` for frames of the simulated rope a millisecond apart, starting at `first`, with
/// each frame's number, image and scene.
fn watch_fast(seed: u64, [first, count]: [u64; 2], mut with: impl FnMut(u64, &Image, &Scene)) {
    let options = RenderOptions {
        seed,
        frame_interval_s: 0.001,
        ..RenderOptions::default()
    };
    let mut film = Rendered::new(&options).expect("valid options");
    film.pass_over(first);
    let mut extractor = with_mask(Mask::Auto);
    let size = [options.width, options.height].map(|side| side as usize);
    let mut rgb = vec![0; 3 * size[0] * size[1]];
    for frame in 0..count {
        film.advance();
        film.write(&mut rgb);
        extractor.at(1_000_000 * frame);
        let image = Image::new(&rgb, size[0], size[1], 3 * size[0], PixelFormat::Rgb8);
        let image = image.expect("a whole image");
        with(frame, &image, &extractor.extract(&image));
    }
}

#[test]
fn strands_that_come_to_lie_on_each_other_slowly_are_followed() {
    let mut followed = 0;
    let mut lengths_px = Vec::new();
    // A loop closes.
    watch_fast(2, [6430, 100], |frame, _, scene| {
        followed += usize::from(scene.followed);
        let [curve] = scene.curves else {
            panic!("{frame}: {} curves", scene.curves.len());
        };
        lengths_px.push(curve.length_px);
    });
    assert!(followed >= 80, "{followed} of 100 frames followed");
    // The distance of a hidden tip stays constant from frame to frame.
    let late_px = &lengths_px[75..];
    let off_px = late_px.iter().map(|px| (px - late_px[0]).abs());
    assert!(off_px.fold(0.0, f32::max) < 0.5, "{lengths_px:?}");
}

#[test]
fn a_fast_camera_has_no_whole_looks_in_a_row_where_both_tips_lie_on_the_rope() {
    let (mut followed, mut was_followed) = (0, false);
    // Frames a second apart get full extractions.
    let mut whole = with_mask(Mask::Auto);
    watch_fast(1, [6340, 40], |frame, image, scene| {
        if frame >= 4 {
            assert!(scene.followed || was_followed, "{frame} is whole, too");
            followed += usize::from(scene.followed);
        }
        was_followed = scene.followed;
        whole.at(1_000_000_000 * (frame + 1));
        let truth = whole.extract(image);
        let ([curve], [truth]) = (scene.curves, truth.curves) else {
            panic!("{frame}: {} curves", scene.curves.len());
        };
        let offs_px = curve.points.iter().zip(&truth.points);
        let far_px = offs_px.map(|(&a, &b)| distance(a, b)).fold(0.0, f32::max);
        assert!(far_px < 3.0, "{frame}: {far_px}");
    });
    assert!(followed >= 28, "{followed} of 36 frames followed");
}

#[test]
fn a_rope_under_something_is_followed_by_the_rest_and_marked_there() {
    let mut table = Table::new(320, 240, [215.0, 212.0, 205.0]);
    table.noise = 2.0;
    let mut extractor = followed(&table);
    let mut hidden = 0;
    for frame in 8..14 {
        // A stick slides in from above. It is not blue.
        let reach = 20.0 * (frame - 7) as f32;
        let stick = Rope::along(14.0, [90.0, 90.0, 88.0], |t| [150.0, t * (50.0 + reach)]);
        let rope = wave_at(frame);
        let scene = see(&mut extractor, &table.draw(&[rope.clone(), stick]), &table);
        assert_eq!(scene.curves.len(), 1, "{frame}");
        assert!(error(&scene.curves[0], &rope).mean_px < 0.6, "{frame}");
        hidden += usize::from(scene.curves[0].hidden.contains(&true));
    }
    assert!(hidden > 0);
}

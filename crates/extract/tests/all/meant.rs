//! Reporting only the ropes at given positions.

use crate::drawing::{Rope, Table};
use lariat_extract::{Extractor, Image, Options, OptionsError, PixelFormat, Scene, Status};
use lariat_test_support::allocations;

const SIZE: [usize; 2] = [320, 240];

/// Three ropes that move down the table. The first two cross.
fn frame(k: usize, hidden: bool) -> Vec<u8> {
    let down = 0.8 * k as f32;
    let rope = |from: f32, to: f32| {
        Rope::along(7.0, [30.0, 50.0, 130.0], move |t| {
            [30.0 + 260.0 * t, from + (to - from) * t + down]
        })
    };
    let [width, height] = SIZE;
    let ropes = [rope(30.0, 110.0), rope(110.0, 30.0), rope(170.0, 180.0)];
    let shown = if hidden { &ropes[..2] } else { &ropes[..] };
    Table::new(width, height, [215.0, 212.0, 205.0]).draw(shown)
}

fn extractor(at: &[[f32; 2]]) -> Extractor {
    let options = Options::default().at(at.to_vec());
    Extractor::new(options).expect("the options are valid")
}

fn look<'a>(extractor: &'a mut Extractor, rgb: &[u8]) -> Scene<'a> {
    let [width, height] = SIZE;
    let image = Image::new(rgb, width, height, 3 * width, PixelFormat::Rgb8);
    extractor.extract(&image.expect("a whole image"))
}

#[test]
fn the_others_are_not_told_and_a_rope_stays_meant_while_it_moves() {
    let mut all = extractor(&[]);
    let mut one = extractor(&[[60.0, 174.0]]);
    for k in 0..40 {
        let rgb = frame(k, false);
        let every = look(&mut all, &rgb);
        let scene = look(&mut one, &rgb);
        assert_eq!((every.curves.len(), scene.curves.len()), (3, 1), "{k}");
        let same = every
            .curves
            .iter()
            .find(|c| c.track == scene.curves[0].track);
        assert_eq!(same, Some(&scene.curves[0]), "{k}");
        assert!(scene.curves[0].points[0][1] > 150.0);
        assert_eq!(scene.crossings, []);
    }
}

#[test]
fn where_they_cross_is_told_by_their_new_places() {
    let rgb = frame(0, false);
    let [mut all, mut two] = [&[][..], &[[285.0, 30.0], [285.0, 110.0]]].map(extractor);
    let every = look(&mut all, &rgb);
    let scene = look(&mut two, &rgb);
    assert_eq!((scene.curves.len(), scene.crossings.len()), (2, 1));
    let (told, known) = (scene.crossings[0], every.crossings[0]);
    let tracks = |scene: &Scene, c: lariat_extract::Crossing| {
        [c.over, c.under].map(|i| scene.curves[i].track)
    };
    assert_eq!(tracks(&scene, told), tracks(&every, known));
}

#[test]
fn one_that_is_out_of_sight_is_lost_and_none_takes_its_place() {
    let mut extractor = extractor(&[[60.0, 174.0]]);
    for _ in 0..5 {
        look(&mut extractor, &frame(0, false));
    }
    let status: Vec<_> = (0..3)
        .map(|_| look(&mut extractor, &frame(0, true)).curves[0].status)
        .collect();
    assert_eq!(status, [Status::Lost; 3]);
    // Within four seconds, the whole picture is searched again.
    for _ in 0..130 {
        look(&mut extractor, &frame(0, true));
    }
    assert_eq!(extractor.scene().curves, [], "it is forgotten");
    let scene = look(&mut extractor, &frame(0, false));
    assert_eq!(scene.curves.len(), 1, "it is back");
}

#[test]
fn no_frame_allocates_once_warm() {
    let mut extractor = extractor(&[[60.0, 174.0], [60.0, 40.0]]);
    extractor.prepare(SIZE[0], SIZE[1]);
    let frames: Vec<_> = (0..12).map(|k| frame(k, false)).collect();
    let mut run = || {
        frames
            .iter()
            .map(|rgb| look(&mut extractor, rgb).curves.len())
            .sum::<usize>()
    };
    run();
    let before = allocations();
    assert_eq!(run(), 24);
    assert_eq!(allocations() - before, 0);
}

#[test]
fn a_position_is_two_numbers() {
    let options = Options::default().at(vec![[1.0, f32::NAN]]);
    assert!(matches!(Extractor::new(options), Err(OptionsError::At(_))));
}

//! The confidence of curves: evidence for ropes and for other objects, and how it persists from
//! image to image.

use crate::drawing;

use drawing::{Rope, Table};
use lariat_drawn::moving::{Film, Story};
use lariat_drawn::scenes::{self, Class};
use lariat_extract::{Extractor, Image, Mask, Notice, Options, PixelFormat, Status};
use std::time::Duration;

const SIZE: [usize; 2] = [640, 480];
const BLUE: [f32; 3] = [40.0, 70.0, 170.0];
const DARK: [f32; 3] = [60.0, 55.0, 50.0];

/// A wave from left to right around the height `y`.
fn wave(y: f32, color: [f32; 3]) -> Rope {
    Rope::along(9.0, color, move |t| {
        [60.0 + 520.0 * t, y + 30.0 * (9.0 * t).sin()]
    })
}

fn table() -> Table {
    Table {
        noise: 2.0,
        ..Table::new(SIZE[0], SIZE[1], [190.0, 180.0, 165.0])
    }
}

fn rgb(bytes: &[u8]) -> Image<'_> {
    Image::new(bytes, SIZE[0], SIZE[1], 3 * SIZE[0], PixelFormat::Rgb8).expect("a whole image")
}

/// A mask of these ropes, whatever the picture shows.
fn mask_of(ropes: &[Rope]) -> Vec<u8> {
    let white = |rope: &Rope| Rope {
        color: [255.0; 3],
        ..rope.clone()
    };
    let white: Vec<_> = ropes.iter().map(white).collect();
    let drawn = Table::new(SIZE[0], SIZE[1], [0.0; 3]).draw(&white);
    drawn.chunks_exact(3).map(|pixel| pixel[0]).collect()
}

/// The confidence of each curve from an external mask, ordered by height in the image, and the
/// notice.
fn masked(picture: &[Rope], mask: &[Rope], options: Options) -> (Vec<f32>, Option<Notice>) {
    let (bytes, mask) = (table().draw(picture), mask_of(mask));
    let mask = Image::new(&mask, SIZE[0], SIZE[1], SIZE[0], PixelFormat::Gray8);
    let options = options.mask(Mask::External);
    let mut extractor = Extractor::new(options).expect("valid options");
    let scene = extractor.extract_masked(&rgb(&bytes), &mask.expect("a whole mask"));
    let scene = scene.expect("of the image's size");
    let mut curves: Vec<_> = scene.curves.iter().collect();
    curves.sort_by(|a, b| a.points[0][1].total_cmp(&b.points[0][1]));
    (curves.iter().map(|c| c.confidence).collect(), scene.notice)
}

#[test]
fn a_plain_rope_is_sure_and_nothing_is_said() {
    let bytes = table().draw(&[wave(240.0, BLUE)]);
    let mut extractor = Extractor::new(Options::default()).expect("valid options");
    let scene = extractor.extract(&rgb(&bytes));
    assert_eq!((scene.curves.len(), scene.notice), (1, None));
    assert!(
        scene.curves[0].confidence > 0.85,
        "{:?}",
        scene.curves[0].confidence
    );
}

#[test]
fn a_strand_of_a_mask_where_the_picture_shows_none_is_not() {
    let [rope, nothing] = [wave(140.0, BLUE), wave(340.0, BLUE)];
    let (sure, notice) = masked(
        std::slice::from_ref(&rope),
        &[rope.clone(), nothing.clone()],
        Options::default(),
    );
    assert!(
        sure.len() == 2 && sure[0] > 0.8 && sure[1] < 0.35,
        "{sure:?}"
    );
    assert_eq!(notice, Some(Notice::Unsure));
    // A lower threshold leads to fewer notices.
    let options = Options::default().min_confidence(0.0);
    assert_eq!(masked(&[], &[nothing], options).1, None);
}

#[test]
fn a_rope_that_is_known_beyond_what_covers_it_is_sure() {
    for seed in [4000, 4003] {
        let (mut film, mut bytes) = (Film::new(Story::Gripper, seed, 480, 360), Vec::new());
        film.next(&mut bytes);
        let image = Image::new(&bytes, 480, 360, 3 * 480, PixelFormat::Rgb8).expect("an image");
        let mut extractor = Extractor::new(Options::default()).expect("valid options");
        let scene = extractor.extract(&image);
        let [rope] = scene.curves else {
            panic!("{seed}: {} curves", scene.curves.len());
        };
        assert_eq!((rope.status, scene.notice), (Status::Partial, None));
        assert!(rope.hidden.contains(&true) && rope.confidence > 0.8);
    }
}

#[test]
fn what_is_hardly_a_rope_goes_where_the_network_is_sure_of_all_that_it_sees() {
    for seed in [301, 306] {
        let still = scenes::draw(Class::Things, seed, SIZE[0], SIZE[1]).expect("a picture");
        let mut extractor = Extractor::new(Options::default()).expect("valid options");
        // The uncertain curve does not return when the network runs again.
        for image in 0..40 {
            let scene = extractor.extract(&rgb(&still.rgb));
            let count = scene.curves.len();
            assert_eq!(count, still.truth.ropes.len(), "{seed}, image {image}");
        }
    }
}

#[test]
fn half_of_a_rope_is_less_sure_than_all_of_it() {
    let whole = wave(240.0, BLUE);
    let mut half = whole.clone();
    half.points.truncate(half.points.len() / 2);
    let picture = [whole.clone()];
    let [all, part] = [whole, half].map(|mask| masked(&picture, &[mask], Options::default()).0[0]);
    assert!(all > 0.8 && part < all - 0.1, "{all} {part}");
}

#[test]
fn a_twisted_rope_of_two_colours_is_sure() {
    let mut strands = vec![wave(240.0, BLUE)];
    for from in (0..1500).step_by(60) {
        let mut strand = wave(240.0, [215.0, 60.0, 40.0]);
        strand.points = strand.points[from..from + 30].to_vec();
        strands.push(strand);
    }
    let (sure, _) = masked(&strands, &[wave(240.0, BLUE)], Options::default());
    assert!(sure[0] > 0.7, "{sure:?}");
}

#[test]
fn a_shadow_is_less_sure_than_its_rope() {
    let shade = [0.6 * 190.0, 0.6 * 180.0, 0.6 * 165.0];
    let ropes = [wave(140.0, BLUE), wave(340.0, shade)];
    let mut extractor = Extractor::new(Options::default()).expect("valid options");
    let bytes = table().draw(&ropes);
    let scene = extractor.extract(&rgb(&bytes));
    let blue = scene
        .curves
        .iter()
        .find(|c| c.points[0][1] < 240.0)
        .expect("seen");
    let others = scene.curves.iter().filter(|c| c.points[0][1] > 240.0);
    for shadow in others {
        assert!(
            shadow.confidence < blue.confidence,
            "{} {}",
            shadow.confidence,
            blue.confidence
        );
    }
}

#[test]
fn a_lost_rope_keeps_the_confidence_it_had_and_a_followed_one_that_of_its_last_extraction() {
    let (bytes, empty) = (table().draw(&[wave(240.0, BLUE)]), table().draw(&[]));
    let mut extractor = Extractor::new(Options::default().keep_lost(Duration::from_secs(1)))
        .expect("valid options");
    let (mut last, mut followed) = (0.0, 0);
    for _ in 0..8 {
        let scene = extractor.extract(&rgb(&bytes));
        let confidence = scene.curves[0].confidence;
        if scene.followed {
            assert_eq!(confidence, last);
            followed += 1;
        }
        last = confidence;
    }
    assert!(followed > 2 && last > 0.85, "{followed} {last}");
    let scene = extractor.extract(&rgb(&empty));
    assert_eq!(scene.curves[0].status, Status::Lost);
    assert_eq!(scene.curves[0].confidence, last);
}

/// Horizontal ropes, each shorter than the one above it.
fn rack(count: usize) -> Vec<Rope> {
    let rope = |i: usize| {
        let (y, length_px) = (14.0 + 17.0 * i as f32, 560.0 - 12.0 * i as f32);
        Rope::along(5.0, DARK, move |t| {
            [30.0 + length_px * t, y + 2.0 * (7.0 * t).sin()]
        })
    };
    (0..count).map(rope).collect()
}

#[test]
fn twenty_four_ropes_are_reported_and_of_more_the_shortest_are_left_out_and_that_is_said() {
    for (count, notice) in [(24, None), (27, Some(Notice::TooMany))] {
        let bytes = table().draw(&rack(count));
        let mut extractor = Extractor::new(Options::default()).expect("valid options");
        let scene = extractor.extract(&rgb(&bytes));
        assert_eq!((scene.curves.len(), scene.notice), (24, notice));
        let lengths: Vec<_> = scene.curves.iter().map(|c| c.length_px).collect();
        assert!(lengths.is_sorted_by(|a, b| a >= b), "{lengths:?}");
        let lowest = scene.curves.iter().map(|c| c.points[0][1]);
        assert!(lowest.fold(0.0, f32::max) < 14.0 + 17.0 * 24.0);
        assert!(scene.curves.iter().all(|c| c.confidence > 0.5));
    }
}

#[test]
fn of_more_curves_than_are_asked_for_the_surest_and_longest_stay() {
    let mut rope = wave(140.0, BLUE);
    rope.points.truncate(1200);
    let nothing = wave(340.0, BLUE);
    let options = Options::default().ropes(1);
    let (sure, _) = masked(
        std::slice::from_ref(&rope),
        &[rope.clone(), nothing],
        options,
    );
    assert!(sure.len() == 1 && sure[0] > 0.7, "{sure:?}");
}

#[test]
fn what_a_rope_needs_not_have_does_not_matter() {
    // A light rope on dark, and in gray.
    let bytes = Table {
        noise: 2.0,
        ..Table::new(SIZE[0], SIZE[1], [40.0; 3])
    }
    .draw(&[wave(240.0, [200.0; 3])]);
    let gray: Vec<u8> = bytes.chunks_exact(3).map(|pixel| pixel[0]).collect();
    let image = Image::new(&gray, SIZE[0], SIZE[1], SIZE[0], PixelFormat::Gray8);
    let mut extractor = Extractor::new(Options::default()).expect("valid options");
    let scene = extractor.extract(&image.expect("a whole image"));
    assert!(scene.curves[0].confidence > 0.85);
}

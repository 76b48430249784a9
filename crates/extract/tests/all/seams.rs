//! Overlapping ropes of one color are separated by the seams that the picture shows between them.

use lariat_drawn::moving::{Film, Judge, SeenCurve, SeenStatus, Story};
use lariat_extract::{Extractor, Image, Options, PixelFormat, Status};

const SIZE: [usize; 2] = [480, 360];

/// Returns whether both ropes of the first picture of a film of two tangled ropes are found, whole
/// and in order.
fn are_told_apart(seed: u64) -> bool {
    let [width, height] = SIZE;
    let mut film = Film::new(Story::Two, seed, width as u32, height as u32);
    let mut rgb = Vec::new();
    let truth = film.next(&mut rgb);
    let image = Image::new(&rgb, width, height, 3 * width, PixelFormat::Rgb8).expect("a picture");
    let mut extractor = Extractor::new(Options::default()).expect("options");
    let curves = extractor.extract(&image).curves.to_vec();
    let seen = curves.iter().map(|curve| SeenCurve {
        track: curve.track,
        status: match curve.status {
            Status::Ok => SeenStatus::Ok,
            Status::Lost => SeenStatus::Lost,
            _ => SeenStatus::Partial,
        },
        points: &curve.points,
        hidden: &curve.hidden,
    });
    let mut judge = Judge::default();
    judge.look(&truth, &seen.collect::<Vec<_>>());
    judge.verdict().places() == [0; 6]
}

/// The mask alone misreads all of these: a strand is left out, or two are treated as one.
#[test]
fn what_the_mask_hides_the_picture_shows() {
    for seed in [5011, 5060, 5102, 5122, 5142, 5152, 5182, 5207, 5212, 5225] {
        assert!(are_told_apart(seed), "film {seed}");
    }
}

/// Regressions: these were misread when cut at the first seams tried, or when judged only by their
/// unexplained mask.
#[test]
fn of_several_readings_the_one_without_kinks_is_told() {
    for seed in [5003, 5077, 5101, 5103, 5132, 5154, 5180, 5218, 5222, 5246] {
        assert!(are_told_apart(seed), "film {seed}");
    }
}

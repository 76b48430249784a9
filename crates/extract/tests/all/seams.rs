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

/// A rate over seeds that nobody picked: a mask alone hides the order in one picture in two.
#[test]
fn of_two_tangled_ropes_most_are_told_apart() {
    let seeds = 5300..5340;
    let told = seeds.clone().filter(|&seed| are_told_apart(seed)).count();
    assert!(told >= 28, "{told} of {}", seeds.count());
}

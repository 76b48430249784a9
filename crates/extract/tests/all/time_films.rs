//! Films of moving ropes: numbers, directions and strands, frame by frame.

use lariat_drawn::moving::{Film, Judge, SeenCurve, SeenStatus, Story, Verdict};
use lariat_extract::{Extractor, Image, Options, PixelFormat, Status};

/// The errors in the first `frames` of a film.
fn watch(story: Story, seed: u64, frames: usize) -> Verdict {
    const SIZE: (usize, usize) = (360, 270);
    let mut film = Film::new(story, seed, SIZE.0 as u32, SIZE.1 as u32);
    let mut extractor = Extractor::new(Options::default()).expect("the defaults are good");
    let mut judge = Judge::default();
    let mut rgb = Vec::new();
    for _ in 0..frames {
        let truth = film.next(&mut rgb);
        let image = Image::new(&rgb, SIZE.0, SIZE.1, 3 * SIZE.0, PixelFormat::Rgb8);
        let scene = extractor.extract(&image.expect("a whole image"));
        let curves: Vec<_> = scene
            .curves
            .iter()
            .map(|curve| SeenCurve {
                track: curve.track,
                status: match curve.status {
                    Status::Ok => SeenStatus::Ok,
                    // Counted as wrong, because there are only ropes.
                    Status::Doubtful => SeenStatus::Partial,
                    Status::Partial => SeenStatus::Partial,
                    Status::Lost => SeenStatus::Lost,
                },
                points: &curve.points,
                hidden: &curve.hidden,
            })
            .collect();
        judge.look(&truth, &curves);
    }
    judge.verdict()
}

/// The sum over films of one story.
fn watch_some(story: Story, seeds: std::ops::Range<u64>, frames: usize) -> Verdict {
    seeds.fold(Verdict::default(), |sum, seed| {
        let more = watch(story, seed, frames);
        Verdict {
            shown: sum.shown + more.shown,
            missed: sum.missed + more.missed,
            miscounted: sum.miscounted + more.miscounted,
            flips: sum.flips + more.flips,
            swaps: sum.swaps + more.swaps,
            exchanged: sum.exchanged + more.exchanged,
            invented: sum.invented + more.invented,
            misjudged: sum.misjudged + more.misjudged,
            mismarked: sum.mismarked + more.mismarked,
            marked: sum.marked + more.marked,
        }
    })
}

/// Asserts that a rope was never missed, turned around, renamed or invented.
fn assert_followed(verdict: &Verdict) {
    let Verdict {
        missed,
        flips,
        swaps,
        invented,
        ..
    } = *verdict;
    assert_eq!([missed, flips, swaps, invented], [0; 4], "{verdict:?}");
    // Ends on top of other strands are the hard part: at most one frame in fifty.
    assert!(50 * verdict.exchanged <= verdict.shown, "{verdict:?}");
    assert!(50 * verdict.miscounted <= verdict.shown, "{verdict:?}");
}

#[test]
fn a_writhing_rope_keeps_its_number_and_its_direction() {
    assert_followed(&watch_some(Story::Writhing, 1001..1003, 150));
}

#[test]
fn a_rope_that_was_gone_is_itself_from_the_first_frame_on() {
    assert_followed(&watch_some(Story::Vanishing, 1011..1013, 150));
}

#[test]
fn noise_black_and_white_frames_change_nothing() {
    assert_followed(&watch_some(Story::BadFrames, 1021..1023, 150));
}

#[test]
fn after_a_cut_nothing_is_left_of_what_was_before() {
    let verdict = watch_some(Story::Cuts, 1031..1033, 150);
    assert_eq!([verdict.missed, verdict.invented], [0, 0], "{verdict:?}");
}

#[test]
fn a_gripper_is_no_rope_and_invents_none() {
    let verdict = watch_some(Story::Gripper, 1041..1043, 150);
    assert_eq!([verdict.missed, verdict.invented], [0, 0], "{verdict:?}");
    assert!(100 * verdict.mismarked <= verdict.marked, "{verdict:?}");
}

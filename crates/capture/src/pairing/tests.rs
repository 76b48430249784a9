use lariat_test_support::allocations;
use proptest::prelude::*;

use super::*;

const MS: u64 = 1_000_000;
const LONG: u64 = 1_000_000 * MS;

/// Creates a pairing of frames and images that are named by their times, in ms.
fn pairing(period_ms: Option<u64>) -> Pairing<u64, u64> {
    Pairing::new(20 * MS, period_ms.map(|ms| ms * MS))
}

fn frame(pairing: &mut Pairing<u64, u64>, at_ms: u64) {
    assert_eq!(pairing.frame(at_ms, at_ms * MS, LONG), None);
}

fn image(pairing: &mut Pairing<u64, u64>, at_ms: u64) {
    pairing.image(at_ms, at_ms * MS);
}

/// Returns the next frame and its image.
fn answer(pairing: &mut Pairing<u64, u64>) -> Option<(u64, Option<u64>)> {
    Some(match pairing.next(0)? {
        Paired::Alone(frame) => (frame, None),
        Paired::With(frame, image) => (frame, Some(image)),
        Paired::Sharing(frame) => (frame, pairing.shared().copied()),
    })
}

#[test]
fn a_frame_has_the_nearest_image_once_it_is_known_to_be_that() {
    let mut pairing = pairing(None);
    image(&mut pairing, 95);
    frame(&mut pairing, 100);
    assert_eq!(answer(&mut pairing), None, "a nearer one may come");
    image(&mut pairing, 103);
    assert_eq!(answer(&mut pairing), Some((100, Some(103))));
    frame(&mut pairing, 110);
    image(&mut pairing, 118);
    assert_eq!(answer(&mut pairing), Some((110, Some(103))));
    assert_eq!(answer(&mut pairing), None);
}

#[test]
fn where_the_period_is_known_an_image_of_just_before_is_not_waited_behind() {
    let mut pairing = pairing(Some(30));
    image(&mut pairing, 90);
    frame(&mut pairing, 104);
    assert_eq!(answer(&mut pairing), Some((104, Some(90))));
    frame(&mut pairing, 107);
    assert_eq!(answer(&mut pairing), None, "the next may be at 120");
}

#[test]
fn an_image_too_far_away_is_no_frame_s_and_both_are_counted() {
    let mut pairing = pairing(None);
    image(&mut pairing, 100);
    frame(&mut pairing, 121);
    image(&mut pairing, 142);
    assert_eq!(answer(&mut pairing), Some((121, None)));
    let counts = PairCounts {
        paired: 0,
        alone: 1,
        unpaired: 2,
    };
    assert_eq!(pairing.end(), counts);
}

#[test]
fn a_frame_is_answered_at_its_last_moment_by_what_is_there() {
    let mut pairing = pairing(None);
    image(&mut pairing, 90);
    pairing.frame(100, 100 * MS, 125 * MS);
    pairing.frame(130, 130 * MS, 155 * MS);
    assert_eq!(pairing.due_ns(), Some(125 * MS));
    assert_eq!(pairing.next(125 * MS - 1), None);
    let paired = pairing.next(125 * MS);
    assert_eq!(paired, Some(Paired::With(100, 90)));
    assert_eq!(pairing.due_ns(), Some(155 * MS));
    assert_eq!(pairing.next(200 * MS), Some(Paired::Alone(130)));
    assert_eq!(pairing.due_ns(), None);
}

#[test]
fn no_frame_waits_for_a_depth_camera_that_is_silent() {
    let mut pairing = pairing(None);
    frame(&mut pairing, 10);
    assert_eq!(answer(&mut pairing), Some((10, None)), "it has not begun");
    image(&mut pairing, 35);
    frame(&mut pairing, 40);
    assert_eq!(answer(&mut pairing), None);
    pairing.silence();
    assert_eq!(answer(&mut pairing), Some((40, Some(35))));
    frame(&mut pairing, 70);
    assert_eq!(answer(&mut pairing), Some((70, None)));
    image(&mut pairing, 95);
    frame(&mut pairing, 100);
    assert_eq!(answer(&mut pairing), None, "it is there again");
}

#[test]
fn an_image_is_kept_only_where_the_next_frame_may_want_it() {
    // As many frames as images: each image belongs to one frame.
    let mut even = pairing(None);
    for k in 0..20 {
        frame(&mut even, 33 * k);
        image(&mut even, 33 * k + 3);
        match even.next(0) {
            Some(Paired::With(frame, image)) => assert_eq!((frame, image), (33 * k, 33 * k + 3)),
            Some(Paired::Sharing(frame)) => {
                assert!(frame <= 33, "nothing is known of the first's next")
            }
            other => panic!("{other:?}"),
        }
    }
    // Twice as many frames: each image belongs to two.
    let mut twice = pairing(None);
    let mut had = Vec::new();
    for k in 0..20 {
        image(&mut twice, 32 * k + 4);
        for frame_ms in [32 * k, 32 * k + 16] {
            frame(&mut twice, frame_ms);
            had.extend(std::iter::from_fn(|| answer(&mut twice)));
        }
    }
    for (frame, image) in had {
        assert_eq!(image, Some(frame / 32 * 32 + 4), "of {frame}");
    }
    assert_eq!(twice.end().unpaired, 0);
}

#[test]
fn images_of_a_clock_that_went_back_count_again() {
    let mut pairing = pairing(None);
    image(&mut pairing, 1000);
    image(&mut pairing, 50);
    frame(&mut pairing, 45);
    assert_eq!(answer(&mut pairing), Some((45, Some(50))));
}

#[test]
fn nothing_is_allocated_and_the_oldest_make_room() {
    let mut pairing = Pairing::new(20 * MS, None);
    image(&mut pairing, 0);
    let before = allocations();
    let mut crowded = 0;
    for k in 1..=100 {
        crowded += u64::from(pairing.frame(k, k * 40 * MS, LONG).is_some());
    }
    for k in 1..=100 {
        pairing.image(k, k * MS / 2);
    }
    assert_eq!(allocations() - before, 0);
    assert_eq!(crowded, 84);
    assert_eq!(pairing.counts().alone, 84);
    assert_eq!(pairing.end().unpaired, 101);
}

proptest! {
    #[test]
    fn every_frame_is_answered_once_in_order_by_the_nearest_of_all_images(
        frames in prop::collection::vec(1_u64..60, 1..40),
        images in prop::collection::vec(1_u64..60, 1..40),
        begins in 0_u64..200,
    ) {
        let moments = |steps: &[u64], begin: u64| -> Vec<u64> {
            steps.iter().scan(begin, |at, step| { *at += step; Some(*at) }).collect()
        };
        let (frames, images) = (moments(&frames, begins), moments(&images, 0));
        let mut pairing = pairing(None);
        // Before the first image, no frame waits.
        image(&mut pairing, 0);
        // The frames and images of both cameras, in order of time.
        let mut all: Vec<_> = frames.iter().map(|&at| (at, true)).collect();
        all.extend(images.iter().map(|&at| (at, false)));
        all.sort_unstable();
        let (mut answers, mut crowded) = (Vec::new(), Vec::new());
        for (at, is_frame) in all {
            if is_frame {
                if let Some(frame) = pairing.frame(at, at * MS, LONG) {
                    crowded.push(frame);
                    answers.push((frame, None, false));
                }
            } else {
                image(&mut pairing, at);
            }
            while let Some(answer) = pairing.next(0) {
                answers.push(match answer {
                    Paired::Alone(frame) => (frame, None, false),
                    Paired::With(frame, image) => (frame, Some(image), true),
                    Paired::Sharing(frame) => (frame, pairing.shared().copied(), false),
                });
            }
        }
        let counts = pairing.counts();
        prop_assert_eq!(counts.paired + counts.alone, answers.len() as u64);
        prop_assert!(answers.iter().map(|a| a.0).eq(frames.iter().copied().take(answers.len())));
        // An image that no later frame was expected to need is dropped with its frame, as are older
        // ones.
        let mut gone = None;
        for (frame, had, is_gone) in answers {
            let left = [0].iter().chain(&images).filter(|&&image| Some(image) > gone);
            let nearest = left.map(|&at| at.abs_diff(frame)).min();
            match had {
                Some(had) => prop_assert_eq!(Some(had.abs_diff(frame)), nearest),
                None => prop_assert!(crowded.contains(&frame) || nearest.is_none_or(|apart| apart > 20)),
            }
            gone = had.filter(|_| is_gone).or(gone);
        }
    }
}

//! Tests how a camera recovers from errors.

mod fake;

use std::io::Write;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;

use lariat_test_support::allocations;

use super::*;
use crate::pairing::{Paired, Pairing};
use fake::{Bench, DAMAGED, GOOD, SHORT, lock};

#[test]
fn frames_are_written_where_the_slots_are_and_each_slot_keeps_its_number() {
    let mut bench = Bench::new(Io::Auto, true);
    bench.hardware().buffers = 32;
    for number in 1..=50 {
        bench.expose(number as u8, GOOD);
        assert_eq!(bench.shown(), (number, number as u8));
    }
    assert!(bench.news().contains("USERPTR, 4 slots"));
    let mut numbers: Vec<_> = bench.hardware().addresses.clone();
    numbers.sort_unstable();
    numbers.dedup();
    assert_eq!(numbers.len(), 4, "{numbers:?}");
}

#[test]
fn a_driver_with_fewer_buffers_than_slots_has_what_it_can_take() {
    let mut bench = Bench::new(Io::Auto, true);
    for number in 1..=20 {
        bench.expose(number as u8, GOOD);
        assert_eq!(bench.shown(), (number, number as u8));
    }
}

#[test]
fn what_does_not_take_memory_is_copied_from() {
    let mut bench = Bench::new(Io::Auto, false);
    bench.expose(1, GOOD);
    assert_eq!(bench.shown(), (1, 77));
    assert!(bench.news().contains("MMAP"));
    assert_eq!(bench.hardware().opened, 1, "it need not be reopened");
    let mut bench = Bench::new(Io::UserPointer, false);
    let refused = bench.camera.next().expect_err("it may not be copied from");
    assert!(refused.to_string().contains("REQBUFS"), "{refused}");
}

#[test]
fn frames_in_limited_range_are_expanded_wherever_they_are() {
    // (100 − 16) · 255 / 219 ≈ 98; the fake's own memory contains 77, which becomes 71.
    for (io, shown) in [(Io::Auto, 98), (Io::Mapped, 71)] {
        let mut bench = Bench::new(io, true);
        bench.camera.shape.range = ColorRange::Limited;
        bench.expose(100, GOOD);
        assert_eq!(bench.shown(), (1, shown), "{io:?}");
    }
}

#[test]
fn without_slots_a_frame_is_kept_until_it_is_asked_for() {
    let mut bench = Bench::new(Io::Mapped, true);
    bench.camera.slots.clear();
    for number in 1..=9 {
        bench.expose(0, GOOD);
        assert_eq!(bench.shown(), (number, 77));
    }
}

#[test]
fn a_frame_allocates_nothing_once_warm() {
    for (io, takes_lent) in [(Io::Auto, true), (Io::Mapped, true)] {
        let mut bench = Bench::new(io, takes_lent);
        {
            let mut hardware = bench.hardware();
            // The fake's own records.
            hardware.addresses.reserve(1000);
            hardware.queued.reserve(1000);
        }
        let mut shown = |count| {
            let before = allocations();
            for _ in 0..count {
                bench.expose(1, GOOD);
                bench.shown();
            }
            allocations() - before
        };
        assert!(shown(20) > 0, "the counter counts");
        let allocated = shown(200);
        assert_eq!(allocated, 0, "{io:?}: {}", bench.said());
    }
}

#[test]
fn damaged_and_short_frames_are_gaps_and_said() {
    let mut bench = Bench::new(Io::Auto, true);
    for (value, flags) in [(1, GOOD), (2, DAMAGED), (3, SHORT), (4, GOOD)] {
        bench.expose(value, flags);
    }
    assert_eq!([bench.shown(), bench.shown()], [(1, 1), (4, 4)]);
    let said = bench.said();
    assert!(said.contains("a frame was lost at the source"), "{said}");
}

#[test]
fn calls_that_fail_once_are_tried_again_and_said() {
    for call in ["REQBUFS", "QBUF", "STREAMON"] {
        for io in [Io::Auto, Io::Mapped] {
            let mut bench = Bench::new(io, true);
            bench.hardware().failing.push_back((call, Errno::INVAL));
            bench.expose(5, GOOD);
            assert_eq!(bench.shown().0, 1);
            let said = bench.said();
            assert!(
                said.contains(call) && said.contains("tried twice: 1"),
                "{said}"
            );
        }
    }
}

#[test]
fn a_broken_stream_is_restarted_and_numbers_go_on() {
    let mut bench = Bench::new(Io::Auto, true);
    bench.expose(1, GOOD);
    assert_eq!(bench.shown(), (1, 1));
    bench.hardware().broken = Some(Errno::IO);
    bench.expose(2, GOOD);
    let (number, value) = bench.shown();
    assert!(number > 1);
    assert_eq!(value, 2);
    assert_eq!(bench.hardware().opened, 1);
    let said = bench.said();
    assert!(said.contains("is restarted"), "{said}");
    assert!(bench.news().contains("frames come again"));
}

#[test]
fn an_unplugged_camera_is_told_of_at_once_by_blank_frames_and_comes_back() {
    let mut bench = Bench::new(Io::Auto, true);
    bench.expose(1, GOOD);
    assert_eq!(bench.shown(), (1, 1));
    {
        let mut hardware = bench.hardware();
        hardware.broken = Some(Errno::NODEV);
        hardware.is_absent = true;
    }
    bench.expose(2, GOOD);
    for number in 2..5 {
        let frame = bench.next();
        assert_eq!((frame.width, frame.sequence, frame.slot), (0, number, None));
        assert_eq!(frame.bytes(), 0);
    }
    assert!(bench.said().contains("waited for until it comes back"));
    bench.hardware().is_absent = false;
    let (number, value) = bench.shown();
    assert!(number >= 5);
    assert_eq!((value, bench.hardware().opened), (2, 2));
    let news = bench.news();
    assert!(
        news.contains("there again") && news.contains("frames come again"),
        "{news}"
    );
}

#[test]
fn a_stall_is_said_once_and_frames_after_it_go_on() {
    let mut bench = Bench::new(Io::Auto, true);
    for number in 1..=2 {
        bench.expose(1, GOOD);
        assert_eq!(bench.shown().0, number);
    }
    bench.said();
    let (first, second) = (bench.next(), bench.next());
    assert_eq!([first.width, second.width], [0, 0]);
    assert_eq!([first.sequence, second.sequence], [3, 4]);
    assert_eq!(bench.said().matches("no frame has come").count(), 1);
    bench.expose(9, GOOD);
    assert_eq!(bench.shown().1, 9);
    assert!(bench.news().contains("frames come again"));
}

#[test]
fn before_the_first_frame_nothing_is_told_and_the_wait_can_be_ended() {
    let bench = Bench::new(Io::Auto, true);
    let mut camera = bench.camera;
    let (mut stop_in, stop) = UnixStream::pair().expect("a pair");
    stop_in.write_all(&[1]).expect("room");
    let until = Until::new(None, stop.as_fd());
    assert_eq!(camera.advance(&until).expect("no fault"), Next::Nothing);
    drop(camera);
    let hardware = lock(&bench.hardware);
    assert!(!hardware.streaming);
    assert_eq!(hardware.left, 1);
}

#[test]
fn a_depth_camera_s_images_are_paired_by_the_drivers_stamps_and_one_that_is_gone_holds_no_frame_up()
{
    let mut color = Bench::new(Io::Auto, true);
    let mut depth = Bench::new(Io::Auto, true);
    let stamp = |frame: &Frame| frame.exposed_ns.expect("the driver stamps it");
    let mut pairing = Pairing::new(u64::MAX / 2, None);
    let mut images = Vec::new();
    for number in 1..=20 {
        color.expose(number, GOOD);
        let frame = color.next_image();
        pairing.frame(frame, stamp(&frame), u64::MAX);
        // The first image ends the silence; each later one answers the frame before it.
        depth.expose(number, if number == 7 { DAMAGED } else { GOOD });
        if number != 7 {
            let image = depth.next_image();
            images.push(image);
            pairing.image(image, stamp(&image));
        }
        while let Some(paired) = pairing.next(0) {
            let (frame, image) = match paired {
                Paired::With(frame, image) => (frame, image),
                Paired::Sharing(frame) => (frame, *pairing.shared().expect("it is there")),
                Paired::Alone(frame) => panic!("frame {} has none", frame.sequence),
            };
            let apart = |image: &Frame| stamp(image).abs_diff(stamp(&frame));
            assert_eq!(images.iter().map(apart).min(), Some(apart(&image)));
        }
    }
    assert_eq!(pairing.counts().paired, 20);
    color.expose(1, GOOD);
    let frame = color.next_image();
    pairing.frame(frame, stamp(&frame), u64::MAX);
    assert_eq!(pairing.next(0), None, "a nearer image may come");
    depth.hardware().is_absent = true;
    depth.hardware().broken = Some(Errno::NODEV);
    depth.expose(0, GOOD);
    let blank = depth.next();
    assert_eq!(blank.width, 0);
    pairing.silence();
    assert!(pairing.next(0).is_some(), "there is nothing to wait for");
}

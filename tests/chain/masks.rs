//! Masks from another process. Here, the loop of the template makes them in a thread.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lariat_wire::{Delivery, Domain, FRAMES, FrameHeader, MASKS, Receiver, Rig, Writer};

use crate::frames::wait_for_next;
use crate::rig::Bench;

#[path = "../../examples/mask_network.rs"]
mod mask_network;

fn external(deadline_us: u32) -> Bench {
    let bench = Bench::new();
    let settings = format!(
        "[extract]\nmask = \"external\"\nmask_deadline_us = {deadline_us}\n[sink]\nlive = false\n"
    );
    fs::write(bench.path("lariat.toml"), settings).unwrap();
    bench
}

#[test]
fn every_frame_of_a_lossless_chain_is_seen_through_its_own_mask() {
    let bench = external(30_000_000);
    let stop = Arc::new(AtomicBool::new(false));
    let network = std::thread::spawn({
        let (domain, stop) = (bench.domain.clone(), stop.clone());
        move || {
            let domains = [(); 2].map(|()| Domain::named(&domain).unwrap());
            mask_network::serve(domains, &Rig::default(), true, &stop).unwrap();
        }
    });
    let arguments = [
        "--lossless",
        "--fps",
        "max",
        "--frames",
        "60",
        "--out",
        "out",
    ];
    let ended = bench.start(&arguments).end();
    stop.store(true, Ordering::Relaxed);
    network.join().unwrap();
    assert!(ended.status.success(), "{}", ended.stderr);
    let summary = bench.summary("out");
    let frames = &summary["frames"];
    assert_eq!(frames["received"], 60, "{summary}");
    assert_eq!(frames["with_curve"], 60, "{summary}");
    assert_eq!(frames["lost"]["mask"], 0, "{summary}");
    // The soft edge of the mask is as good as the picture itself.
    let error = summary["error_px"]["centerline"]["p95"].as_f64().unwrap();
    assert!(error < 0.5, "{summary}");
    bench.assert_nothing_is_left();
}

#[test]
fn without_a_process_that_makes_masks_every_frame_is_skipped_and_counted() {
    let bench = external(20_000);
    let ended = bench
        .start(&["--fps", "30", "--frames", "30", "--out", "out"])
        .end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let sentence = "frame 1 was skipped: no mask of it came within 20ms of its capture";
    assert_eq!(
        ended.stderr.matches(sentence).count(),
        1,
        "{}",
        ended.stderr
    );
    assert!(
        ended.stderr.contains("lariat/default/masks"),
        "{}",
        ended.stderr
    );
    assert!(ended.stdout.contains("mask too late"), "{}", ended.stdout);
    let frames = &bench.summary("out")["frames"];
    let count = |key: &str| frames["lost"][key].as_u64().unwrap();
    assert_eq!(
        (&frames["published"], &frames["received"]),
        (&30.into(), &0.into())
    );
    assert_eq!(count("mask") + count("capture"), 30, "{frames}");
    assert!(count("mask") > 0, "{frames}");
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn a_later_frames_mask_says_that_an_earlier_ones_will_not_come() {
    // The deadline is far longer than the test; the next frame's mask ends the wait.
    let bench = external(3_600_000_000);
    let domain = Domain::named(&bench.domain).unwrap();
    let delivery = Delivery::Lossless {
        stop: Arc::default(),
    };
    let rig = Rig::default();
    let frames = Receiver::create(&domain, &rig, &FRAMES, Some(&delivery)).unwrap();
    let masks = Writer::masks(&domain, &rig, &delivery, 640 * 480).unwrap();
    let chain = bench.start(&[
        "--lossless",
        "--fps",
        "max",
        "--frames",
        "6",
        "--out",
        "out",
    ]);
    for number in 1..=6 {
        let frame = wait_for_next(&frames, Instant::now() + Duration::from_secs(60));
        if number % 2 == 0 {
            let mut mask = masks.frame_slot(640 * 480).unwrap();
            mask.fill(0);
            *mask.header_mut() = frame.header().of_mask();
            mask.send().unwrap();
        }
    }
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let frames_seen = &bench.summary("out")["frames"];
    assert_eq!(
        (&frames_seen["received"], &frames_seen["lost"]["mask"]),
        (&3.into(), &3.into())
    );
    bench.assert_every_frame_is_accounted_for("out");
    drop((frames, masks, domain));
    bench.assert_nothing_is_left();
}

#[test]
fn a_mask_of_another_size_is_named_and_its_frame_answered_without_a_rope() {
    let bench = external(30_000_000);
    let domain = Domain::named(&bench.domain).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let delivery = Delivery::Lossless { stop: stop.clone() };
    let frames = Receiver::create(&domain, &Rig::default(), &FRAMES, Some(&delivery)).unwrap();
    let masks = Writer::masks(&domain, &Rig::default(), &delivery, 16).unwrap();
    let chain = bench.start(&[
        "--lossless",
        "--fps",
        "max",
        "--frames",
        "5",
        "--out",
        "out",
    ]);
    for _ in 0..5 {
        let deadline = Instant::now() + Duration::from_secs(30);
        let frame = wait_for_next(&frames, deadline);
        let mut mask = masks.frame_slot(16).unwrap();
        *mask.header_mut() = FrameHeader {
            width: 4,
            height: 4,
            stride: 4,
            ..frame.header().of_mask()
        };
        mask.send().unwrap();
    }
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    assert!(
        ended
            .stderr
            .contains("the mask is 4×4 pixels and its image 640×480"),
        "{}",
        ended.stderr
    );
    let frames_seen = &bench.summary("out")["frames"];
    assert_eq!(
        (&frames_seen["received"], &frames_seen["with_curve"]),
        (&5.into(), &0.into())
    );
    drop((frames, masks, domain));
    bench.assert_nothing_is_left();
}

#[test]
fn masks_have_one_writer_and_can_be_looked_at() {
    let bench = Bench::new();
    let domain = Domain::named(&bench.domain).unwrap();
    let rig = Rig::default();
    let reader = Receiver::create(&domain, &rig, &MASKS, None).unwrap();
    let writer = Writer::masks(&domain, &rig, &Delivery::NewestWins, 12).unwrap();
    let second = Writer::masks(&domain, &rig, &Delivery::NewestWins, 12);
    let said = second.unwrap_err().to_string();
    assert!(
        said.contains("lariat/default/masks already has a writer"),
        "{said}"
    );
    let mut mask = writer.frame_slot(12).unwrap();
    mask.fill(255);
    mask.header_mut().trace.captured = 7;
    mask.send().unwrap();
    let seen = reader.latest().unwrap().unwrap();
    assert_eq!(
        (seen.header().trace.captured, &seen[..]),
        (7, &[255; 12][..])
    );
    drop((seen, reader, writer, domain));
    bench.assert_nothing_is_left();
}

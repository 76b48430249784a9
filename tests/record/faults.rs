//! Effects of faults on a recording and on the chain.

use std::time::{Duration, Instant};

use rustix::process::{Pid, Resource, Rlimit, Signal, prlimit};

use crate::recording::Recording;
use crate::rig::{Bench, Ended, Running, send};

/// Process id of the recorder.
fn recorder(chain: &Running) -> i32 {
    let mut words = chain.introduction.split_whitespace();
    words.find(|word| *word == "recorder");
    words.next().and_then(|id| id.parse().ok()).expect("an id")
}

/// Waits until a file has this many bytes, for instance more than a chunk.
fn wait_for_bytes(bench: &Bench, name: &str, bytes: u64) {
    let deadline = Instant::now() + Duration::from_secs(30);
    while std::fs::metadata(bench.path(name)).map_or(0, |file| file.len()) < bytes {
        assert!(Instant::now() < deadline, "{name} does not grow");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Checks that the chain continued to its end, and then reported that its recording did not.
fn assert_only_the_recording_suffered(bench: &Bench, ended: &Ended, how: &str, frames: u64) {
    assert_eq!(ended.status.code(), Some(1), "{}", ended.stderr);
    let sentence = format!("the recorder {how}; the chain continues without it");
    assert!(ended.stderr.contains(&sentence), "{}", ended.stderr);
    assert_eq!(bench.summary("out")["frames"]["published"], frames);
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn a_killed_recorder_leaves_whole_chunks_and_the_chain_goes_on() {
    let bench = Bench::new();
    let flags = ["--fps", "100", "--frames", "400", "--out", "out"];
    let mut chain = bench.start(&[&flags[..], &["--record", "run.mcap"]].concat());
    chain.wait_for_frames();
    wait_for_bytes(&bench, "run.mcap", 5_000_000);
    send(recorder(&chain), Signal::KILL);
    let ended = chain.end();
    assert_only_the_recording_suffered(&bench, &ended, "was killed by signal 9 (SIGKILL)", 400);
    let recording = Recording::read(&bench.path("run.mcap"));
    assert!(!recording.is_closed);
    assert!(recording.count("image") > 0);
    for frame in recording.of("image") {
        assert!(
            lariat_record::ImageRecord::decode(&frame.cdr)
                .unwrap()
                .is_whole()
        );
    }
}

#[test]
fn a_lossless_chain_goes_on_without_its_killed_recorder() {
    let bench = Bench::new();
    let flags = [
        "--lossless",
        "--fps",
        "100",
        "--frames",
        "300",
        "--out",
        "out",
    ];
    let mut chain = bench.start(&[&flags[..], &["--record", "run.mcap"]].concat());
    chain.wait_for_frames();
    send(recorder(&chain), Signal::KILL);
    let ended = chain.end();
    assert_only_the_recording_suffered(&bench, &ended, "was killed by signal 9 (SIGKILL)", 300);
    assert_eq!(bench.summary("out")["frames"]["received"], 300);
}

#[test]
fn a_recorder_that_is_told_to_end_closes_its_file_and_the_chain_goes_on() {
    let bench = Bench::new();
    let flags = ["--fps", "100", "--frames", "300", "--out", "out"];
    let mut chain = bench.start(&[&flags[..], &["--record", "run.mcap"]].concat());
    chain.wait_for_frames();
    wait_for_bytes(&bench, "run.mcap", 5_000_000);
    send(recorder(&chain), Signal::TERM);
    let ended = chain.end();
    assert_only_the_recording_suffered(&bench, &ended, "ended before its time", 300);
    assert!(Recording::read(&bench.path("run.mcap")).is_closed);
}

#[test]
fn where_no_longer_file_may_be_the_recording_is_closed_well_and_the_chain_goes_on() {
    for delivery in [&[][..], &["--lossless"]] {
        let bench = Bench::new();
        let flags = ["--fps", "100", "--frames", "300", "--out", "out"];
        let record = ["--record", "run.mcap"];
        let mut chain = bench.start(&[&flags[..], &record, delivery].concat());
        // About fifty frames more than the current size.
        let most = 50_000_000;
        let limit = Rlimit {
            current: Some(most),
            maximum: Some(most),
        };
        prlimit(Pid::from_raw(recorder(&chain)), Resource::Fsize, limit).unwrap();
        chain.wait_for_frames();
        let ended = chain.end();
        let how = "failed with exit code 1, for the reason it gave above";
        assert_only_the_recording_suffered(&bench, &ended, how, 300);
        assert!(
            ended.stderr.contains("run.mcap ends here")
                && ended.stderr.contains("no more than 50000000 bytes"),
            "{}",
            ended.stderr
        );
        let recording = Recording::read(&bench.path("run.mcap"));
        assert!(recording.is_closed);
        let bytes = std::fs::metadata(bench.path("run.mcap")).unwrap().len();
        // The file uses all of its limit except the last part.
        assert!(bytes <= most && bytes > most - 6_000_000, "{bytes}");
        assert!(recording.count("image") > 40);
    }
}

#[test]
fn what_the_recorder_misses_or_has_no_room_for_is_counted_exactly() {
    const FRAMES: u64 = 600;
    let bench = Bench::new();
    let frames = FRAMES.to_string();
    let flags = ["--fps", "300", "--frames", &frames, "--out", "out"];
    // Space for one image.
    let record = [
        "--record",
        "run.mcap",
        "--queue",
        "1MB",
        "--compression",
        "zstd",
    ];
    let mut chain = bench.start(&[&flags[..], &record].concat());
    chain.wait_for_frames();
    // The recorder is stopped while frames pass.
    let recorder = recorder(&chain);
    send(recorder, Signal::STOP);
    crate::rings::wait_for_descriptors(&bench, 100);
    send(recorder, Signal::CONT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let recording = Recording::read(&bench.path("run.mcap"));
    assert!(recording.is_closed);
    let losses = recording.losses();
    assert!(losses.dropped_frames >= 90, "{losses:?}");
    assert_eq!(recording.frames_accounted_for(), FRAMES);
    assert_eq!(recording.count("truth") + losses.dropped_truth, FRAMES);
    let lost = losses.source + losses.capture + losses.extract + losses.fit;
    assert_eq!(
        recording.count("descriptors") + losses.dropped_descriptors + lost,
        FRAMES + losses.source
    );
    let summary = bench.summary("out");
    let extracted = FRAMES - summary["frames"]["lost"]["capture"].as_u64().unwrap();
    assert_eq!(
        recording.count("centerlines") + losses.dropped_centerlines,
        extracted
    );
    let said = format!("{} frames", losses.dropped_frames);
    assert!(ended.stderr.contains(&said), "{}", ended.stderr);
    bench.assert_nothing_is_left();
}

#[test]
fn a_recorder_that_somebody_stopped_closes_its_file() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--record", "run.mcap"]);
    chain.wait_for_frames();
    send(recorder(&chain), Signal::STOP);
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    assert!(Recording::read(&bench.path("run.mcap")).is_closed);
    bench.assert_nothing_is_left();
}

#[test]
fn a_recording_that_is_there_is_kept_and_the_chain_not_begun() {
    let bench = Bench::new();
    let run = |more: &[&str]| {
        let flags = ["run", "--fps", "max", "--frames", "5", "--record", "a.mcap"];
        bench.run(&[&flags[..], more].concat())
    };
    assert!(run(&[]).status.success());
    let before = std::fs::read(bench.path("a.mcap")).unwrap();
    let refused = run(&[]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1));
    assert!(said.contains("overwrite it with --force"), "{said}");
    assert!(!said.contains('→'), "{said}");
    assert_eq!(std::fs::read(bench.path("a.mcap")).unwrap(), before);
    assert!(run(&["--force"]).status.success());
    std::fs::write(bench.path("a.mcap"), "a letter").unwrap();
    let refused = run(&["--force"]);
    assert!(!refused.status.success());
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(
        said.contains("is not a recording, and is not overwritten"),
        "{said}"
    );
    bench.assert_nothing_is_left();
}

#[test]
fn a_killed_chain_leaves_a_recording_closed_well() {
    let bench = Bench::new();
    let flags = ["--fps", "100", "--duration", "60", "--record", "run.mcap"];
    let mut chain = bench.start(&flags);
    let recorder = recorder(&chain);
    chain.wait_for_frames();
    wait_for_bytes(&bench, "run.mcap", 5_000_000);
    chain.signal_chain(Signal::KILL);
    chain.end();
    crate::rig::wait_until_gone(recorder);
    assert!(Recording::read(&bench.path("run.mcap")).is_closed);
    bench.assert_nothing_is_left();
}

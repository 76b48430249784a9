//! Messages of all stages on the chain's standard error.

use std::fs;
use std::time::{Duration, Instant};

use rustix::process::Signal;

use crate::rig::Bench;
use crate::screen::{Screen, is_tmux_here, run};

/// Clears the live line.
const CLEAR: &str = "\r\x1b[K";

#[test]
fn messages_and_the_live_line_never_share_a_line_of_the_terminal() {
    if !is_tmux_here() {
        return;
    }
    let bench = Bench::new();
    let raw = bench.path("raw");
    let script = "read go; \"$LARIAT\" run -vv --fps 60 --duration 2s; echo left with $?; cat";
    let screen = Screen::open(&bench, script);
    let log = format!("cat > {}", raw.display());
    run(screen.tmux(&["pipe-pane", "-O", &log]));
    screen.keys("Enter");
    screen.wait_for_text("left with 0");
    let deadline = Instant::now() + Duration::from_secs(60);
    let text = loop {
        let text = String::from_utf8_lossy(&fs::read(&raw).expect("tmux writes it")).into_owned();
        if text.contains("left with 0") {
            break text;
        }
        assert!(Instant::now() < deadline, "{text}");
        std::thread::sleep(Duration::from_millis(20));
    };
    let mut messages = 0;
    for line in text.split('\n').filter(|line| line.contains("in hand")) {
        let (before, message) = line.rsplit_once(CLEAR).unwrap_or(("", line));
        assert!(before.is_empty() || before.ends_with("\x1b[K"), "{line:?}");
        assert!(!message.contains(" received, "), "{line:?}");
        messages += 1;
    }
    assert!(messages > 50, "{messages}");
    assert!(text.contains(" received, "), "the live line was shown");
    // Each message is complete: with stage, channel and number.
    assert!(text.contains("frames 10 in hand"), "{text}");
}

#[test]
fn what_a_stage_said_before_it_died_comes_before_what_is_said_of_its_end() {
    let bench = Bench::new();
    let mut chain = bench.start(&[
        "-v",
        "--fps",
        "100",
        "--duration",
        "60",
        "--control-points",
        "6",
    ]);
    chain.wait_for_frames();
    chain.signal_stage(2, Signal::KILL);
    let ended = chain.end();
    let all = ended.introduction + &ended.stderr;
    let said = all
        .find("fit: fit.control_points = 6")
        .expect("said by fit");
    let judged = all.find("lariat: fit was killed").expect("said of fit");
    assert!(said < judged, "{all}");
    bench.assert_nothing_is_left();
}

#[test]
fn a_chain_whose_standard_error_stands_still_goes_on() {
    let bench = Bench::new();
    // The test's pipe is full after 64 kB, and nothing is read from it before the chain has ended
    // by itself.
    let arguments = ["-vv", "--fps", "500", "--frames", "1500", "--out", "out"];
    let mut chain = bench.start(&arguments);
    chain.wait_until_it_says("frames received in");
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    assert!(ended.stderr.len() > 1 << 16, "{}", ended.stderr.len());
    bench.assert_every_frame_is_accounted_for("out");
}

//! Tests `lariat top` in a real terminal.

// This module was written for the chain's own tests, so parts of it are unused here.
#[allow(dead_code)]
#[path = "../../../tests/chain/rig.rs"]
mod rig;
#[path = "../../../tests/chain/screen.rs"]
mod screen;

use std::time::{Duration, Instant};

use rig::{Bench, send};
use rustix::process::Signal;
use screen::{Screen, is_tmux_here, run};

/// Shell commands that print something before and after, and check that the terminal is restored.
const SHELL: &str =
    "echo before; \"$LARIAT\" top; echo left with $?; stty -a | tr ';' '\\n' | grep icanon; cat";

impl Screen {
    /// Returns the process id of `lariat top`.
    fn top(&self) -> i32 {
        let shell = run(self.tmux(&["display-message", "-p", "#{pane_pid}"]));
        let shell = String::from_utf8_lossy(&shell.stdout).trim().to_owned();
        let children = std::fs::read_to_string(format!("/proc/{shell}/task/{shell}/children"));
        let children = children.expect("the shell lives");
        children.trim().parse().expect("one child: lariat top")
    }

    /// Checks that the terminal was restored: the previous text is back, and input is read line by
    /// line.
    fn assert_it_was_given_back(&self) {
        let text = self.wait_for_text("icanon");
        assert!(
            text.contains("before\n") && text.contains("left with 0"),
            "{text}"
        );
        assert!(!text.contains("-icanon"), "{text}");
        assert!(!text.contains("lariat top"), "{text}");
        let cursor = run(self.tmux(&["display-message", "-p", "#{cursor_flag}"]));
        assert_eq!(cursor.stdout, b"1\n", "the cursor is to be seen again");
    }
}

#[test]
fn top_shows_a_chain_as_it_comes_and_goes_and_gives_the_terminal_back() {
    if !is_tmux_here() {
        return;
    }
    let bench = Bench::new();
    let screen = Screen::open(&bench, SHELL);
    screen.wait_for_text("No chain is running here");

    let chain = bench.start(&["--fps", "100", "--duration", "120"]);
    // A process is listed once it has announced its name.
    let pid = format!("{:>7}", chain.ids[1]);
    let shown = screen.wait_for("a rope", |text| {
        ["rope  conf.", "wait for extract", "sink", "●", &pid]
            .iter()
            .all(|part| text.contains(part))
    });
    assert!(shown.contains("rig default"), "{shown}");
    // Everything fits in 80 columns and 24 rows: the right edge of the frame and the keys.
    assert!(shown.contains('┐') && shown.contains("q quit"), "{shown}");

    run(screen.tmux(&["resize-window", "-x", "100", "-y", "30"]));
    let is_wide = |text: &str| {
        text.lines()
            .any(|line| line.chars().count() == 100 && line.ends_with('┐'))
    };
    screen.wait_for("a picture of 100 columns", is_wide);
    screen.keys("+");
    screen.wait_for_text("last 10 s");
    screen.keys("p");
    screen.wait_for_text("PAUSED");
    screen.keys("p");
    screen.wait_for("going on", |text| !text.contains("PAUSED"));

    let other = bench.start(&["--fps", "100", "--duration", "120", "--rig", "arm"]);
    screen.wait_for_text("rig default · 2 of 2");
    screen.keys("Tab");
    screen.wait_for_text("rig arm · 1 of 2");
    screen.wait_for_text("rope  conf.");
    other.signal_chain(Signal::INT);
    assert!(other.end().status.success());
    screen.wait_for_text("Nothing runs on rig arm");
    // `lariat top` must not hinder a chain with the other delivery, and must follow it.
    let again = bench.start(&[
        "--fps",
        "100",
        "--duration",
        "120",
        "--rig",
        "arm",
        "--lossless",
    ]);
    screen.wait_for("the chain again", |text| {
        text.contains("lossless") && text.contains("rope  conf.")
    });
    screen.keys("q");
    screen.assert_it_was_given_back();
    for chain in [chain, again] {
        chain.signal_chain(Signal::INT);
        assert!(chain.end().status.success());
    }
    bench.assert_nothing_is_left();
}

#[test]
fn told_to_end_top_gives_the_terminal_back_too() {
    if !is_tmux_here() {
        return;
    }
    let bench = Bench::new();
    let screen = Screen::open(&bench, SHELL);
    screen.wait_for_text("No chain is running here");
    send(screen.top(), Signal::TERM);
    screen.assert_it_was_given_back();
    bench.assert_nothing_is_left();
}

#[test]
fn a_terminal_that_is_closed_ends_top() {
    if !is_tmux_here() {
        return;
    }
    let bench = Bench::new();
    let screen = Screen::open(&bench, SHELL);
    screen.wait_for_text("No chain is running here");
    let top = format!("/proc/{}", screen.top());
    drop(screen);
    let deadline = Instant::now() + Duration::from_secs(60);
    while std::path::Path::new(&top).exists() {
        assert!(
            Instant::now() < deadline,
            "lariat top goes on without a terminal"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
    bench.assert_nothing_is_left();
}

#[test]
fn without_a_terminal_top_names_what_there_is_for_scripts() {
    let bench = Bench::new();
    let output = bench.run(&["top"]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("lariat topic hz") && said.contains("--json"),
        "{said}"
    );
    assert!(output.stdout.is_empty());
    bench.assert_nothing_is_left();
}

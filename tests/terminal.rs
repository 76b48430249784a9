//! Output on a terminal and in a pipe: widths, escape codes, exit codes, and sources without a
//! flag.

#[allow(dead_code, reason = "written for the chain's own tests")]
#[path = "chain/rig.rs"]
mod rig;

use rig::Bench;
use std::process::Output;

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recordings/rope.mcap");
const PICTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/rope.png");

/// Checks that no line is wider than a standard terminal, and that there are no control codes for
/// terminals.
fn assert_fits(output: &Output, of: &[&str]) {
    for bytes in [&output.stdout, &output.stderr] {
        let text = std::str::from_utf8(bytes).expect("text");
        assert!(!text.contains(['\x1b', '\r']), "{of:?}: {text:?}");
    }
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        assert!(line.chars().count() <= 80, "{of:?}: {line}");
    }
}

fn commands(bench: &Bench) -> Vec<String> {
    let help = bench.run(&["-h"]);
    let text = String::from_utf8(help.stdout).expect("text");
    let list = text
        .lines()
        .skip_while(|line| !line.starts_with("Run "))
        .take_while(|line| !line.is_empty());
    // A group's title, names separated by commas, and a few words.
    let names = list.flat_map(|line| line[9..37].trim_end().split(", "));
    names.map(str::to_owned).collect()
}

#[test]
fn all_help_fits_a_terminal() {
    let bench = Bench::new();
    let commands = commands(&bench);
    assert!(commands.len() > 20, "{commands:?}");
    let overview = bench.run(&["--help"]).stdout;
    assert_eq!(overview, bench.run(&["-h"]).stdout);
    assert_eq!(overview, bench.run(&["help"]).stdout);
    // Separate programs, which may not be built, print the help of these.
    let others = ["help", "top", "bench", "compare", "paper", "servo"];
    for command in (commands.iter()).filter(|command| !others.contains(&command.as_str())) {
        for flag in ["-h", "--help"] {
            let words = [command.as_str(), flag];
            let output = bench.run(&words);
            assert!(output.status.success(), "{words:?}");
            assert_fits(&output, &words);
        }
    }
    for words in [
        &["-h"][..],
        &["--help"],
        &["topic", "echo", "--help"],
        &["config", "show", "-h"],
    ] {
        assert_fits(&bench.run(words), words);
    }
}

#[test]
fn the_help_of_run_has_headings_defaults_values_and_examples() {
    let bench = Bench::new();
    let long = String::from_utf8(bench.run(&["run", "--help"]).stdout).expect("text");
    for part in [
        "\nCamera:\n",
        "\nReal time:\n",
        "[default: 120]",
        "[possible values: pinv, cholesky, qr]",
        "[default: 64MB]",
        "\nExamples:\n",
    ] {
        assert!(long.contains(part), "{part:?} is not in {long}");
    }
    let short = String::from_utf8(bench.run(&["run", "-h"]).stdout).expect("text");
    let flags = short
        .lines()
        .filter(|line| line.trim_start().starts_with("--"))
        .count();
    assert!(flags > 50 && short.lines().count() < flags + 40, "{short}");
}

#[test]
fn what_is_printed_fits_a_terminal_and_pipes_get_no_escape_codes() {
    let bench = Bench::new();
    let points = "60,50=0,0 590,45=297,0 600,430=297,210 40,440=0,210";
    for words in [
        &["trace", PICTURE][..],
        &["info", GOLDEN],
        &["replay", GOLDEN, "--check"],
        &["replay", GOLDEN, "--compare"],
        &["doctor"],
        &["devices"],
        &["config", "show"],
        &[
            "calibrate",
            "plane",
            "--size",
            "640x480",
            "--points",
            points,
        ],
        &["rendered", "--frames", "40", "--out", "out"],
    ] {
        assert_fits(&bench.run(words), words);
    }
    let wide = bench
        .command(&["trace", PICTURE])
        .env("COLUMNS", "120")
        .output()
        .expect("runs");
    let narrow = bench.run(&["trace", PICTURE]);
    assert!(
        wide.stdout.len() > narrow.stdout.len(),
        "what there is room for is shown"
    );
}

#[test]
fn what_a_running_chain_says_fits_a_terminal() {
    let bench = Bench::new();
    let chain = bench.start(&["rendered", "--fps", "60"]);
    for words in [
        &["topic", "list"][..],
        &["topic", "hz", "--duration", "500ms"],
        &["topic", "bw", "--duration", "500ms"],
        &["topic", "delay", "--duration", "500ms"],
        &["topic", "echo", "--once"],
        &["topic", "echo", "frames", "--once"],
        &["topic", "echo", "centerlines", "--once"],
    ] {
        let output = bench.run(words);
        assert!(
            output.status.success() && !output.stdout.is_empty(),
            "{words:?}: {output:?}"
        );
        assert_fits(&output, words);
    }
    chain.signal_chain(rustix::process::Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn the_exit_code_is_2_where_nothing_began_and_1_where_it_failed() {
    let bench = Bench::new();
    std::fs::write(bench.path("bytes.toml"), b"\xff").expect("written");
    std::fs::write(bench.path("text.toml"), "fit").expect("written");
    for (words, code) in [
        (&["config", "show"][..], 0),
        (&["trace", PICTURE], 0),
        (&["trace", "missing.png"], 1),
        (&["run", "missing.png"], 1),
        (&["info", "missing.mcap"], 1),
        (&["topic", "list"], 1),
        (&["no-such-command"], 2),
        (&["run", "--no-such-flag"], 2),
        (&["run", "--control-points", "100"], 2),
        (&["trace", PICTURE, "--basis", "spline"], 2),
        (&["topic", "list", "--rig", "Not A Name"], 2),
        (&["replay", GOLDEN], 2),
        (&["snapshot", "picture.jpg"], 2),
        (&["calibrate", "plane", "--size", "640x480"], 2),
        (&["set", "fit.control_points=7"], 1),
        (&["set", "order=12"], 2),
        (&["set", "fit.control_points"], 2),
        (&["set", "--rig", "Not A Name"], 2),
        (&["restart", "fit"], 1),
        (&["restart", "banana"], 2),
        (&["run", "--config", "missing.toml"], 2),
        (&["run", "--config", "bytes.toml"], 2),
        (&["config", "check", "text.toml"], 2),
        (&["trace", PICTURE, "--at", "1,2,3"], 2),
        (&["pick", PICTURE, "--at", "1,2,3"], 2),
    ] {
        let output = bench.run(words);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {output:?}");
    }
}

#[test]
fn a_running_chain_refuses_wrong_use_with_2_and_all_else_with_1() {
    let bench = Bench::new();
    let chain = bench.start(&["rendered"]);
    for (words, code) in [
        (&["set", "fit.tolerance=0.2"][..], 0),
        (&["set", "order=12"], 2),
        (&["set", "fit.control_points=99"], 2),
        (&["set", "run.rig=other"], 1),
        (&["restart", "recorder"], 1),
    ] {
        let output = bench.run(words);
        assert_eq!(output.status.code(), Some(code), "{words:?}: {output:?}");
    }
    chain.signal_chain(rustix::process::Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn a_source_needs_no_flag_and_no_command() {
    let bench = Bench::new();
    std::fs::copy(PICTURE, bench.path("a.png")).expect("copied");
    std::fs::create_dir(bench.path("b")).expect("made");
    std::fs::copy(PICTURE, bench.path("b/c.png")).expect("copied");
    for (words, frames) in [
        (&["a.png", "--out", "1"][..], 1),
        (&["run", "a.png", "b", "--out", "2"], 2),
        (&["b", "--out", "3"], 1),
        (&["--quiet", "rendered", "--frames", "3", "--out", "4"], 3),
        (&[GOLDEN, "--frames", "2", "--out", "5"], 2),
    ] {
        let output = bench.run(&[words, &["--fps", "max", "--lossless"]].concat());
        assert!(output.status.success(), "{words:?}: {output:?}");
        let summary = bench.summary(words.last().expect("a folder"));
        assert_eq!(summary["frames"]["received"], frames, "{words:?}");
    }
    bench.assert_nothing_is_left();
}

#[test]
fn a_word_that_is_neither_command_nor_file_is_told_what_it_may_have_been() {
    let bench = Bench::new();
    std::fs::copy(PICTURE, bench.path("rope.png")).expect("copied");
    for (word, guess) in [
        ("tracee", "lariat trace"),
        ("rope.pgn", "lariat run rope.png"),
    ] {
        let output = bench.run(&[word]);
        let said = String::from_utf8(output.stderr).expect("text");
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains(&format!("{word} is neither a command nor a file")),
            "{said}"
        );
        assert!(said.contains(guess), "{said}");
    }
}

#[test]
fn a_stage_has_no_flag_that_it_would_ignore() {
    let bench = Bench::new();
    for words in [
        ["sink", "--control-points=4"],
        ["sink", "--loop"],
        ["extract", "--frames=3"],
        ["fit", "--duration=3s"],
        ["capture", "--basis=bspline"],
        ["extract", "--out=report"],
    ] {
        let output = bench.run(&words);
        let said = String::from_utf8(output.stderr).expect("text");
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert!(said.contains("unexpected argument"), "{said}");
    }
}

#[test]
fn a_sink_by_hand_says_what_it_waits_for_and_ends_when_it_was_told_to() {
    let bench = Bench::new();
    let output = bench.run(&["sink", "--duration", "300ms"]);
    let said = String::from_utf8(output.stderr).expect("text");
    assert!(output.status.success(), "{said}");
    assert_eq!(
        said.matches("waiting for descriptors of rig default")
            .count(),
        1,
        "{said}"
    );

    let chain = bench.start(&["rendered", "--fps", "120"]);
    let output = bench.run(&["sink", "--frames", "7", "--out", "out"]);
    assert!(output.status.success(), "{output:?}");
    assert_eq!(bench.summary("out")["frames"]["received"], 7);
    chain.signal_chain(rustix::process::Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn more_and_less_is_said_of_all_stages_as_is_asked() {
    let bench = Bench::new();
    let said = |words: &[&str], level: Option<&str>| {
        let mut command = bench.command(
            &[
                &["run", "rendered", "--frames", "2", "--control-points", "6"],
                words,
            ]
            .concat(),
        );
        command.env("RUST_LOG", level.unwrap_or_default());
        let output = command.output().expect("runs");
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stderr).expect("text")
    };
    assert_eq!(said(&["-q"], None), "");
    assert!(!said(&[], None).contains("fit.control_points = 6"));
    for verbose in [said(&["-v"], None), said(&[], Some("warn,lariat=debug"))] {
        assert!(verbose.contains("fit: fit.control_points = 6"), "{verbose}");
        assert!(!verbose.contains("frames 1 in hand"), "{verbose}");
    }
    assert!(said(&["-vv"], None).contains("frames 1 in hand"));
}

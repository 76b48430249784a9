//! `lariat topic`: inspects a running chain.

use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};

use rustix::process::Signal;
use serde_json::Value;

use crate::rig::{Bench, send, wait_until_told_by_signals};

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// JSON objects that a command prints, one per line.
fn objects(bench: &Bench, arguments: &[&str]) -> Vec<Value> {
    let output = bench.run(&[&["topic"], arguments].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let lines = text(&output.stdout);
    let parsed = lines.lines().map(serde_json::from_str);
    parsed.collect::<Result<_, _>>().expect("an object a line")
}

#[test]
fn what_is_not_there_is_said_and_nothing_is_made() {
    let bench = Bench::new();
    for command in ["list", "hz", "echo", "delay", "bw"] {
        let output = bench.run(&["topic", command]);
        assert_eq!(output.status.code(), Some(1), "{command}");
        let said = text(&output.stderr);
        assert!(said.contains("start one with `lariat run`"), "{said}");
        assert!(output.stdout.is_empty());
    }
    let empty = bench.run(&["topic", "list", "--json"]);
    assert_eq!(empty.status.code(), Some(1));
    let list: Value = serde_json::from_slice(&empty.stdout).expect("JSON");
    assert_eq!(
        (&list["schema"], &list["rigs"]),
        (&1.into(), &Value::Array(vec![]))
    );
    bench.assert_nothing_is_left();
}

#[test]
fn a_chain_is_listed_measured_and_echoed_by_whoever_asks() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--duration", "60", "--rig", "arm"]);
    chain.wait_for_frames();

    let list = bench.run(&["topic", "list", "--json"]);
    let list: Value = serde_json::from_slice(&list.stdout).expect("JSON");
    let rig = &list["rigs"][0];
    assert_eq!(
        (&rig["rig"], &rig["lossless"]),
        (&"arm".into(), &false.into())
    );
    let channels = rig["channels"].as_array().expect("a list");
    let names: Vec<_> = channels.iter().map(|one| one["channel"].as_str()).collect();
    let expected = ["frames", "centerlines", "descriptors", "truth"];
    assert_eq!(names, expected.map(Some));
    let frames = &channels[0];
    assert_eq!(frames["writer"]["stage"], "capture");
    assert_eq!(frames["writer"]["pid"], chain.ids[0]);
    assert_eq!(frames["readers"][0]["stage"], "extract");
    assert_eq!(frames["message_bytes"], 640 * 480 * 3);
    let table = text(&bench.run(&["topic", "list"]).stdout);
    assert!(table.contains("read by sink"), "{table}");

    let rate = &objects(&bench, &["hz", "--duration", "1s", "--json"])[0];
    assert_eq!(
        (&rate["rig"], &rate["channel"]),
        (&"arm".into(), &"descriptors".into())
    );
    assert!(rate["messages"].as_u64() > Some(0), "{rate}");
    let band = &objects(&bench, &["bw", "frames", "--duration", "1s", "--json"])[0];
    assert_eq!(band["message_bytes"]["max"], 640 * 480 * 3 + 128);
    let delay = &objects(
        &bench,
        &["delay", "--in-hand", "--duration", "1s", "--json"],
    )[0];
    let p50 = |step: &str| delay["latency_us"][step]["p50"].as_f64().expect("a figure");
    assert!(p50("total") > p50("extract"), "{delay}");

    let shapes = objects(&bench, &["echo", "--count", "3", "--json"]);
    let numbers: Vec<_> = shapes
        .iter()
        .map(|one| one["trace"]["fitted"].as_u64())
        .collect();
    assert!(numbers.is_sorted() && numbers.len() == 3, "{numbers:?}");
    assert_eq!(
        shapes[0]["curves"][0]["control_points"]
            .as_array()
            .map(Vec::len),
        Some(20)
    );
    let frame = text(&bench.run(&["topic", "echo", "frames", "--once"]).stdout);
    assert!(frame.contains("640×480 rgb8 from rendered"), "{frame}");

    let other = bench.run(&["topic", "hz", "--rig", "leg"]);
    assert!(text(&other.stderr).contains("there is no rig leg here: there is arm"));
    let masks = bench.run(&["topic", "echo", "masks"]);
    assert!(text(&masks.stderr).contains("mask = \"external\""));
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}

/// Starts a command that does not end by itself; returns it with its output.
fn follow(bench: &Bench, arguments: &[&str]) -> (Child, BufReader<std::process::ChildStdout>) {
    let mut command = bench.command(&[&["topic"], arguments].concat());
    let command = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the binary runs");
    let lines = BufReader::new(child.stdout.take().expect("piped"));
    (child, lines)
}

fn next(lines: &mut impl BufRead) -> String {
    let mut line = String::new();
    lines.read_line(&mut line).expect("readable");
    line
}

#[test]
fn a_channel_that_is_full_says_so_and_a_closed_pipe_or_a_signal_ends_a_reader() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--duration", "60"]);
    chain.wait_for_frames();
    // Extract also reads frames, and at most four readers can.
    let mut readers: Vec<_> = (0..3)
        .map(|_| follow(&bench, &["echo", "frames"]))
        .collect();
    for (_, lines) in &mut readers {
        assert!(next(lines).starts_with("frames: frame "));
    }
    let full = bench.run(&["topic", "hz", "frames", "--duration", "1s"]);
    assert_eq!(full.status.code(), Some(1));
    let said = text(&full.stderr);
    assert!(said.contains("already has its 4 readers"), "{said}");
    assert!(said.contains("lariat topic list"), "{said}");
    for (number, (mut reader, lines)) in readers.into_iter().enumerate() {
        let is_interrupted = number == 0;
        if is_interrupted {
            send(reader.id() as i32, Signal::INT);
            // The pipe must not be full when the command wants to end.
            std::thread::spawn(move || lines.lines().count());
        } else {
            drop(lines);
        }
        let ended = reader.wait().expect("waited for");
        assert_eq!(ended.success(), is_interrupted, "{number}");
    }
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}

#[test]
fn who_follows_a_channel_goes_with_the_chain_and_comes_back_with_the_next_however_it_delivers() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--duration", "60"]);
    chain.wait_for_frames();
    let (mut echo, mut lines) = follow(&bench, &["echo", "--json"]);
    assert!(next(&mut lines).starts_with("{\"schema\":1,\"channel\":\"descriptors\""));
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    let ended_ns = lariat_wire::now_ns();
    let mut said = BufReader::new(echo.stderr.take().expect("piped"));
    assert!(next(&mut said).contains("waiting for it"));
    // If the reader had stayed, it would prevent another delivery.
    let again = bench.start(&["--lossless", "--fps", "100", "--duration", "60"]);
    assert!(next(&mut said).contains("--lossless: it waits for this reader too"));
    let is_new = |line: String| {
        let message: Value = serde_json::from_str(&line).expect("JSON");
        message["trace"]["exposed_ns"].as_u64() > Some(ended_ns)
    };
    // The last messages of the first chain come first in the pipe.
    assert!((0..5000).any(|_| is_new(next(&mut lines))));
    wait_until_told_by_signals(echo.id());
    send(echo.id() as i32, Signal::INT);
    let rest = std::thread::spawn(move || lines.lines().count());
    assert!(echo.wait().expect("waited for").success());
    rest.join().expect("read to the end");
    again.signal_chain(Signal::INT);
    assert!(again.end().status.success());
    bench.assert_nothing_is_left();
}

#[test]
fn who_waits_may_start_before_the_chain() {
    let bench = Bench::new();
    let early = bench.run(&["topic", "echo", "--once"]);
    assert_eq!(early.status.code(), Some(1));
    let said = String::from_utf8_lossy(&early.stderr).into_owned();
    assert!(said.contains("--wait"), "{said}");
    let mut command = bench.command(&["topic", "echo", "--once", "--json", "--wait"]);
    let waiting = command.stdout(Stdio::piped()).spawn().unwrap();
    let chain = bench.start(&["--fps", "50"]);
    let seen = waiting.wait_with_output().unwrap();
    assert!(seen.status.success());
    let text = String::from_utf8(seen.stdout).unwrap();
    assert!(text.contains("\"sequence\""), "{text}");
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}

//! Frames on standard input.

use std::io::Write;
use std::process::{Output, Stdio};

use rustix::process::Signal;

use crate::rig::Bench;

const WIDTH: usize = 160;
const HEIGHT: usize = 120;

/// A gray frame with a dark rope on a light table.
fn frame(number: usize) -> Vec<u8> {
    let middle = 50 + number % 20;
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    let is_rope = |x: usize, y: usize| y.abs_diff(middle) <= 4 && (20..140).contains(&x);
    pixels
        .map(|(x, y)| if is_rope(x, y) { 40 } else { 200 })
        .collect()
}

fn video(frames: usize) -> Vec<u8> {
    let mut bytes = format!("YUV4MPEG2 W{WIDTH} H{HEIGHT} F100:1 Cmono\n").into_bytes();
    for number in 0..frames {
        bytes.extend_from_slice(b"FRAME\n");
        bytes.extend(frame(number));
    }
    bytes
}

/// Runs a command with these bytes on its standard input.
fn fed(bench: &Bench, arguments: &[&str], bytes: Vec<u8>) -> Output {
    let mut process = bench
        .command(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let mut input = process.stdin.take().expect("piped");
    // A refused input is not read to its end.
    let writer = std::thread::spawn(move || input.write_all(&bytes));
    let output = process.wait_with_output().expect("it ends");
    let _ = writer.join().expect("no panic");
    output
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const LOSSLESS: [&str; 6] = ["run", "--source", "-", "--lossless", "--out", "out"];

#[test]
fn a_video_in_a_pipe_is_shown_to_its_end() {
    for fused in [&[][..], &["--fuse"]] {
        let bench = Bench::new();
        let output = fed(&bench, &[&LOSSLESS[..], fused].concat(), video(40));
        assert!(output.status.success(), "{}", said(&output));
        let frames = &bench.summary("out")["frames"];
        assert_eq!(frames["received"].as_u64(), Some(40));
        assert_eq!(frames["with_curve"].as_u64(), Some(40));
        bench.assert_nothing_is_left();
    }
}

#[test]
fn raw_frames_are_shown_in_the_format_that_is_named() {
    let bench = Bench::new();
    let raw = [
        "--size",
        "160x120",
        "--pixel-format",
        "bgra8",
        "--fps",
        "max",
    ];
    let bytes = (0..20)
        .flat_map(frame)
        .flat_map(|level| [level, level, level, 9]);
    let output = fed(&bench, &[&LOSSLESS[..], &raw].concat(), bytes.collect());
    assert!(output.status.success(), "{}", said(&output));
    let frames = &bench.summary("out")["frames"];
    assert_eq!(frames["with_curve"].as_u64(), Some(20));
    bench.assert_nothing_is_left();
}

#[test]
fn a_video_that_breaks_off_is_reported_on_and_is_a_failure() {
    let bench = Bench::new();
    let mut bytes = video(10);
    bytes.truncate(bytes.len() - 5);
    let output = fed(&bench, &LOSSLESS, bytes);
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("ended in the middle of frame 10"), "{said}");
    assert_eq!(bench.summary("out")["frames"]["received"].as_u64(), Some(9));
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn a_writer_that_stands_still_keeps_nobody_from_stopping_the_chain() {
    let bench = Bench::new();
    let mut command = bench.command(&["run", "--source", "-", "--out", "out"]);
    command.stdin(Stdio::piped());
    let mut chain = bench.start_command(command);
    let mut input = chain.process.stdin.take().expect("piped");
    // The fourth frame is incomplete.
    let bytes = video(4);
    input
        .write_all(&bytes[..bytes.len() - 100])
        .expect("somebody reads");
    chain.wait_until_it_says("3 received, ");
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    assert_eq!(
        bench.summary("out")["frames"]["published"].as_u64(),
        Some(3)
    );
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn what_a_pipe_cannot_have_is_refused() {
    let bench = Bench::new();
    let png = b"\x89PNG\r\n\x1a\n0123456789".to_vec();
    let output = fed(&bench, &["run", "--source", "-"], png);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("a PNG picture"), "{}", said(&output));
    for (flags, part) in [
        (&["--loop"][..], "standard input"),
        (&["--from", "3"], "standard input"),
        (&["--size", "160x120"], "need both"),
        (&["--pixel-format", "rgb8"], "need both"),
        (
            &["--pixel-format", "mjpg", "--size", "160x120"],
            "not in \"mjpg\"",
        ),
    ] {
        let output = fed(
            &bench,
            &[&["run", "--source", "-"], flags].concat(),
            Vec::new(),
        );
        assert!(!output.status.success());
        assert!(said(&output).contains(part), "{flags:?}: {}", said(&output));
    }
    bench.assert_nothing_is_left();
}

#[test]
fn trace_takes_frames_out_of_a_pipe_as_one_scene() {
    let bench = Bench::new();
    let output = fed(&bench, &["trace", "-", "--json"], video(6));
    assert!(output.status.success(), "{}", said(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let lines: Vec<serde_json::Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(lines.len(), 6);
    assert_eq!(lines[5]["image"], "-/6");
    assert!(
        lines.iter().all(|line| line["curves"][0]["track"] == 0),
        "{text}"
    );
    let mut bytes = video(3);
    bytes.pop();
    let output = fed(&bench, &["trace", "-"], bytes);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        said(&output).contains("in the middle of frame 3"),
        "{}",
        said(&output)
    );
}

#[test]
fn a_video_is_shown_at_its_own_pace_unless_another_is_asked_for() {
    let bench = Bench::new();
    std::fs::write(bench.path("rope.y4m"), video(30)).unwrap();
    for (flags, period_us) in [
        (&[][..], 10_000.0),
        (&["--every", "2"], 20_000.0),
        (&["--fps", "200"], 5_000.0),
    ] {
        let show = ["run", "--source", "rope.y4m", "--out", "out", "--force"];
        let output = bench.run(&[&show[..], flags].concat());
        assert!(output.status.success(), "{}", said(&output));
        assert_eq!(
            bench.summary("out")["deadline"]["us"].as_f64(),
            Some(period_us)
        );
    }
    bench.assert_nothing_is_left();
}

//! The sink's counts survive its death. A new sink continues where the old one was killed, and
//! every message counts as received or lost. If the whole chain is killed, the last report remains.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::fd::AsRawFd;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use lariat_chain::stages::handover::Handover;
use lariat_wire::{DESCRIPTORS, Delivery, Descriptors, Domain, Rig, Trace, Writer, now_ns};
use rustix::io::{FdFlags, fcntl_setfd};
use rustix::pipe::{PipeFlags, pipe_with};
use rustix::process::Signal;

use crate::rig::{Bench, send, wait_until_gone};

/// A sink started as the chain does, with this process in the role of the chain.
struct Sink {
    process: Child,
    said: BufReader<File>,
    shown: BufReader<std::process::ChildStdout>,
}

impl Sink {
    fn start(bench: &Bench, handover: &Handover) -> Self {
        let handover = handover.file().expect("held");
        fcntl_setfd(handover, FdFlags::empty()).expect("a descriptor");
        let (said, its_end) = pipe_with(PipeFlags::empty()).expect("a pipe");
        let mut process = bench
            .command(&["sink", "--out", "report", "--lossless"])
            .env("LARIAT_HANDOVER_FD", handover.as_raw_fd().to_string())
            .env("LARIAT_STATUS_FD", its_end.as_raw_fd().to_string())
            .env("LARIAT_CHAIN_PID", std::process::id().to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the binary runs");
        let mut sink = Self {
            said: BufReader::new(File::from(said)),
            shown: BufReader::new(process.stdout.take().expect("piped")),
            process,
        };
        drop(its_end);
        let mut word = String::new();
        sink.said.read_line(&mut word).expect("readable");
        assert_eq!(word, "ready\n");
        sink
    }

    fn wait_until_it_shows(&mut self, words: &str) {
        // It shows a line every second.
        let deadline = Instant::now() + Duration::from_secs(120);
        let mut line = String::new();
        while !line.contains(words) {
            assert!(Instant::now() < deadline, "instead of {words}: {line}");
            line.clear();
            let read = self.shown.read_line(&mut line).expect("readable");
            assert!(read > 0, "the sink ended");
        }
    }

    fn kill(mut self) {
        self.process.kill().expect("it is there");
        self.process.wait().expect("waited for");
    }

    /// Sends it the stages' counts and tells it to end; returns its last output.
    fn end(mut self, counts: &str) -> String {
        let mut stdin = self.process.stdin.take().expect("piped");
        stdin.write_all(counts.as_bytes()).expect("it listens");
        drop(stdin);
        send(self.process.id() as i32, Signal::TERM);
        let mut text = String::new();
        self.shown.read_to_string(&mut text).expect("readable");
        assert!(self.process.wait().expect("waited for").success());
        text
    }
}

/// Sends messages with these numbers.
fn send_frames(writer: &Writer<Descriptors>, numbers: impl IntoIterator<Item = u64>) {
    for number in numbers {
        let now = now_ns();
        let mut slot = writer.slot().expect("a slot");
        slot.trace = Trace {
            sequence: number,
            captured: number,
            extracted: number,
            fitted: number,
            exposed_ns: now - 5000,
            captured_ns: now - 4000,
            extract_started_ns: now - 3000,
            extracted_ns: now - 2000,
            fit_started_ns: now - 1000,
            fitted_ns: now,
            ..Trace::EMPTY
        };
        (slot.width, slot.height, slot.count) = (640, 480, 0);
        assert!(slot.send().expect("sent"));
    }
}

#[test]
fn a_killed_sinks_successor_goes_on_counting_where_it_stopped() {
    let bench = Bench::new();
    let handover = Handover::make("sink").expect("memory");
    let domain = Domain::named(&bench.domain).expect("a domain");
    let rig = Rig::default();
    // A starved sink would miss messages of a writer that does not wait.
    let stop = Default::default();
    let delivery = Delivery::Lossless { stop };
    let writer = Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &delivery);
    let writer = writer.expect("the rig's only writer");

    let mut first = Sink::start(&bench, &handover);
    send_frames(&writer, 1..=100);
    first.wait_until_it_shows("100 received");
    let deadline = Instant::now() + Duration::from_secs(60);
    let timed = handover.tally().expect("held");
    while timed.newest_first().next().is_none() {
        assert!(Instant::now() < deadline, "nothing is left to a successor");
        std::thread::sleep(Duration::from_millis(10));
    }
    first.kill();
    send_frames(&writer, 101..=150);

    // The second sink is killed before anything has arrived. The third one continues nevertheless.
    Sink::start(&bench, &handover).kill();
    let mut third = Sink::start(&bench, &handover);
    send_frames(&writer, 151..=200);
    third.wait_until_it_shows("lost");
    let text = third.end("sequence 200\ncaptured 200\nextracted 200\nfitted 200\n");

    bench.assert_every_frame_is_accounted_for("report");
    let summary = bench.summary("report");
    let frames = &summary["frames"];
    let lost = &frames["lost"];
    assert_eq!(
        (&summary["finished"], &frames["published"]),
        (&true.into(), &200.into())
    );
    // The service keeps the newest message for late readers.
    let received = frames["received"].as_u64().expect("a count");
    assert!((150..=151).contains(&received), "{frames}");
    assert_eq!(lost["sink"].as_u64(), Some(200 - received), "{frames}");
    // Each of the first sink's hundred messages was timed. The third sink's first message was not,
    // because it may have waited.
    let total = fs::read_to_string(bench.path("report/total.hgrm")).expect("a histogram");
    let count = total.lines().find(|line| line.starts_with("#[Max"));
    let count = count.and_then(|line| line.rsplit('=').next());
    let count = count.map(|count| count.trim_matches([' ', ']']).parse());
    assert_eq!(count, Some(Ok(received - 1)), "{total}");
    assert!(text.contains("with a sink"), "{text}");
    assert!(text.contains("sink was restarted 2 times"), "{text}");
}

#[test]
fn a_chain_that_is_killed_leaves_its_last_report() {
    let bench = Bench::new();
    let out = ["--out", "report", "--trace", "timeline.json"];
    let chain = bench.start(&[&["--fps", "100"], &out[..]].concat());
    let ids = chain.ids;
    let deadline = Instant::now() + Duration::from_secs(120);
    // The timeline is written after the report.
    while !bench.path("timeline.json").exists() {
        assert!(
            Instant::now() < deadline,
            "no report is written while it runs"
        );
        std::thread::sleep(Duration::from_millis(10));
    }
    for id in ids {
        send(id, Signal::KILL);
    }
    chain.signal_chain(Signal::KILL);
    chain.end();
    ids.into_iter().for_each(wait_until_gone);

    bench.assert_every_frame_is_accounted_for("report");
    let summary = bench.summary("report");
    assert_eq!(summary["finished"], false);
    assert!(
        summary["frames"]["received"].as_u64() > Some(100),
        "{summary}"
    );
    assert!(
        summary["error_px"]["centerline"]["mean"].is_number(),
        "{summary}"
    );
    let text = fs::read_to_string(bench.path("report/report.txt")).expect("a table");
    assert!(text.contains("had not ended"), "{text}");
    let timeline = fs::read(bench.path("timeline.json")).expect("a timeline");
    serde_json::from_slice::<serde_json::Value>(&timeline).expect("whole");

    // The report is kept like any other.
    let again = bench.run(&[&["run", "--frames", "3"], &out[..]].concat());
    assert_eq!(again.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&again.stderr).contains("--force"));
    assert_eq!(bench.summary("report"), summary);
    let forced = bench.run(&[&["run", "--frames", "3", "--force"], &out[..]].concat());
    assert!(forced.status.success());
    assert_eq!(bench.summary("report")["finished"], true);
    bench.assert_nothing_is_left();
}

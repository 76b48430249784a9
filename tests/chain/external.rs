//! Frames written by a program of the user.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use lariat_capture::{FrameSource, RenderOptions, Source};
use lariat_wire::{
    Domain, FrameWriter, PixelFormat, Reader, Rig, Seen, Stamp, Waiting, WriteError,
};
use rustix::process::Signal;

use crate::rig::{Bench, Running};

const PATIENCE: Duration = Duration::from_secs(60);

/// A user's camera that shows the drawn rope.
struct Camera {
    rope: Box<dyn FrameSource>,
    writer: FrameWriter,
    /// Number of frames so far.
    shown: u64,
}

impl Camera {
    fn open(bench: &Bench) -> Result<Self, WriteError> {
        let domain = Domain::named(&bench.domain)?;
        Ok(Self {
            rope: lariat_capture::open(&Source::Rendered(RenderOptions::default())).unwrap(),
            writer: FrameWriter::open_in(domain, &Rig::default(), Waiting::default())?,
            shown: 0,
        })
    }

    fn shows(&mut self, sequence: Option<u64>) {
        let frame = self.rope.next().unwrap().expect("without end");
        let slot = self.writer.loan(frame.width, frame.height, frame.format);
        self.rope.write(slot.unwrap());
        let stamp = Stamp {
            sequence,
            ..Stamp::default()
        };
        self.writer.send(stamp).unwrap();
        self.shown += 1;
    }
}

fn reader(bench: &Bench) -> Reader {
    Reader::open_in(Domain::named(&bench.domain).unwrap(), &Rig::default()).unwrap()
}

/// Sends frames until a new one is answered, and returns its number.
fn wait_for_answer(camera: &mut Camera, reader: &mut Reader) -> u64 {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        camera.shows(None);
        let frame = reader.wait(Instant::now() + Duration::from_millis(500));
        let frame = frame.unwrap();
        if frame.is_new() {
            return frame.message().expect("it came").trace.captured;
        }
    }
    panic!("no frame is answered");
}

fn stop(bench: &Bench, chain: Running) {
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    bench.assert_every_frame_is_accounted_for("out");
}

#[test]
fn each_frame_that_a_program_writes_is_seen_counted_and_recorded() {
    for more in [&[][..], &["--fuse"]] {
        let bench = Bench::new();
        let arguments = ["--source", "external", "--lossless", "--frames", "40"];
        let outputs = ["--out", "out", "--record", "run.mcap"];
        let chain = bench.start(&[&arguments[..], &outputs, more].concat());
        assert!(chain.introduction.contains("external → extract"));
        let mut camera = Camera::open(&bench).unwrap();
        assert!(
            camera.writer.is_lossless(),
            "it waits, as the chain has it wait"
        );
        for sequence in 1..=40 {
            // The camera itself lost two frames.
            camera.shows(Some(if sequence > 20 {
                sequence + 2
            } else {
                sequence
            }));
        }
        let ended = chain.end();
        assert!(ended.status.success(), "{}", ended.stderr);
        let frames = &bench.summary("out")["frames"];
        for (count, wanted) in [("published", 40), ("received", 40), ("with_curve", 40)] {
            assert_eq!(frames[count], wanted, "{frames}");
        }
        assert_eq!(frames["lost"]["source"], 2, "{frames}");
        bench.assert_every_frame_is_accounted_for("out");
        drop(camera);
        let checked = bench.run(&["replay", "run.mcap", "--check"]);
        let said = String::from_utf8_lossy(&checked.stdout).into_owned();
        assert!(checked.status.success(), "{said}");
        bench.assert_nothing_is_left();
    }
}

#[test]
fn a_program_that_wrote_before_the_chain_came_owes_it_nothing_and_what_is_lost_later_is_counted() {
    let bench = Bench::new();
    let mut camera = Camera::open(&bench).unwrap();
    for _ in 0..30 {
        camera.shows(None);
    }
    let chain = bench.start(&["--source", "external", "--out", "out"]);
    let mut reader = reader(&bench);
    let first = wait_for_answer(&mut camera, &mut reader);
    assert!(first > 30);
    // Extract is stopped; the program continues without being held up.
    chain.signal_stage(1, Signal::STOP);
    for _ in 0..20 {
        camera.shows(None);
    }
    chain.signal_stage(1, Signal::CONT);
    let last = wait_for_answer(&mut camera, &mut reader);
    stop(&bench, chain);
    let frames = &bench.summary("out")["frames"];
    let published = frames["published"].as_u64().unwrap();
    // More frames may have been answered than were read.
    let most = camera.shown - 30;
    assert!((last - first..=most).contains(&published), "{frames}");
    let lost = frames["lost"]["capture"].as_u64().unwrap();
    assert!((10..=20).contains(&lost), "{frames}");
    assert_eq!(frames["lost"]["source"], 0, "{frames}");
    drop((camera, reader));
    bench.assert_nothing_is_left();
}

/// A program that writes frames in a separate process: this test itself, run by the test below.
#[test]
fn a_program_of_its_own() {
    if std::env::var_os("LARIAT_TEST_CAMERA").is_none() {
        return;
    }
    let mut writer = FrameWriter::open("default").unwrap();
    let mut reader = Reader::open("default").unwrap();
    for frame in 1.. {
        writer.loan(64, 64, PixelFormat::Gray8).unwrap().fill(9);
        writer.send(Stamp::default()).unwrap();
        println!("frame {frame}");
        // Sends at the rate of the answers.
        reader
            .wait(Instant::now() + Duration::from_millis(100))
            .unwrap();
    }
}

#[test]
fn a_program_that_is_killed_leaves_its_place_to_the_next_and_what_readers_have_gets_stale() {
    let bench = Bench::new();
    let chain = bench.start(&["--source", "external", "--out", "out"]);
    let mut program = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "external::a_program_of_its_own", "--nocapture"])
        .env("LARIAT_TEST_CAMERA", "1")
        .env("LARIAT_DOMAIN", &bench.domain)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(program.stdout.take().unwrap()).lines();
    assert!(said.any(|line| line.unwrap().ends_with("frame 20")));
    let refused = Camera::open(&bench).err().expect("there is one writer");
    assert!(matches!(refused, WriteError::FramesTaken { .. }));
    program.kill().unwrap();
    program.wait().unwrap();

    let mut camera = Camera::open(&bench).unwrap();
    let mut reader = reader(&bench);
    let end = Instant::now() + PATIENCE;
    // The rope is visible for a while, because one that was visible only for a moment is not
    // reported as lost.
    for _ in 0..20 {
        wait_for_answer(&mut camera, &mut reader);
    }
    assert!(matches!(reader.frame().only_rope(PATIENCE), Seen::Fresh(_)));
    assert!(matches!(
        reader.frame().only_rope(Duration::ZERO),
        Seen::Stale(_)
    ));
    // A camera that knows that it is blind says so, and then the rope is lost.
    camera.writer.send_blank(Stamp::default()).unwrap();
    while !matches!(reader.frame().only_rope(PATIENCE), Seen::Lost(_)) {
        let seen = format!("{}", reader.frame().only_rope(PATIENCE));
        assert!(reader.wait(end).unwrap().is_new(), "{seen}");
    }
    stop(&bench, chain);
    drop((camera, reader));
    bench.assert_nothing_is_left();
}

#[test]
fn a_chain_without_the_program_says_what_it_waits_for_and_ends_in_its_time() {
    let bench = Bench::new();
    let ended = bench
        .start(&["--source", "external", "--duration", "3s", "--out", "out"])
        .end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let sentence = "no frame has come yet: start the program that writes lariat/default/frames";
    assert_eq!(
        ended.stderr.matches(sentence).count(),
        1,
        "{}",
        ended.stderr
    );
    assert_eq!(bench.summary("out")["frames"]["published"], 0);
    bench.assert_nothing_is_left();
}

#[test]
fn frames_from_outside_are_a_chains_alone() {
    let bench = Bench::new();
    for command in [&["capture"][..], &["snapshot", "a.png"]] {
        let refused = bench.run(&[command, &["--source", "external"]].concat());
        assert!(!refused.status.success());
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(said.contains("lariat run --source external"), "{said}");
    }
}

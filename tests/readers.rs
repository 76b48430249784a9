//! Control loops next to the real chain.

#[path = "chain/rig.rs"]
#[allow(dead_code, reason = "these tests need less of it than the chain's")]
mod rig;

#[path = "../examples/control_loop.rs"]
mod control_loop;

#[path = "../examples/message_of_offsets.rs"]
mod message_of_offsets;

use std::io::{BufRead, BufReader, Read};
use std::mem::offset_of;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use lariat_wire::{
    Absent, CenterlinePoints, DESCRIPTORS, Delivery, Descriptor, Descriptors, Domain, Reader, Rig,
    Seen, Trace, Track, Writer, now_ns,
};
use rig::{Bench, send, wait_until_gone};
use rustix::process::Signal;

const PATIENCE: Duration = Duration::from_secs(60);

fn reader(bench: &Bench) -> Reader {
    Reader::open_in(Domain::named(&bench.domain).unwrap(), &Rig::default()).unwrap()
}

/// Waits until the drawn rope, which never leaves the image, is visible; returns its track.
fn wait_for_rope(reader: &mut Reader) -> Track {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        let frame = reader.wait(end).unwrap();
        if let Seen::Fresh(rope) = frame.only_rope(PATIENCE) {
            let [x, y] = rope.shape().unwrap().point_at(0.5);
            assert!(
                (0.0..640.0).contains(&x) && (0.0..480.0).contains(&y),
                "{x} {y}"
            );
            return rope.track();
        }
    }
    panic!("the rope was not seen");
}

#[test]
fn a_loop_outlives_the_chain_and_does_not_take_the_next_ones_rope_for_its_own() {
    let bench = Bench::new();
    let mut reader = reader(&bench);
    let nothing = reader.latest().unwrap().only_rope(PATIENCE);
    assert!(matches!(nothing, Seen::Absent(Absent::NothingYet)));
    let arguments = ["--fps", "100", "--duration", "60"];

    let chain = bench.start(&arguments);
    let track = wait_for_rope(&mut reader);
    chain.signal_chain(Signal::TERM);
    assert!(chain.end().status.success());
    // Waiting messages are taken. From then on, the rope keeps its position and gets older with
    // each read.
    reader.latest().unwrap();
    let frame = reader.latest().unwrap();
    assert!(!frame.is_new());
    assert!(matches!(frame.rope(track, Duration::ZERO), Seen::Stale(_)));

    let chain = bench.start(&arguments);
    let again = wait_for_rope(&mut reader);
    assert_eq!((track.run(), again.run()), (1, 2));
    let frame = reader.frame();
    assert!(matches!(
        frame.rope(track, PATIENCE),
        Seen::Absent(Absent::OtherRun)
    ));
    assert!(matches!(frame.rope(again, PATIENCE), Seen::Fresh(_)));

    // The same for a stage that is killed.
    chain.signal_stage(2, Signal::KILL);
    assert!(!chain.end().status.success());
    let chain = bench.start(&arguments);
    while reader.frame().run() == 2 {
        assert!(reader.wait(Instant::now() + PATIENCE).unwrap().is_new());
    }
    assert_eq!(wait_for_rope(&mut reader).run(), 3);
    chain.signal_chain(Signal::TERM);
    assert!(chain.end().status.success());
    drop(reader);
    bench.assert_nothing_is_left();
}

#[test]
fn the_examples_loop_follows_the_rope() {
    let bench = Bench::new();
    let reader = reader(&bench);
    let chain = bench.start(&["--fps", "100", "--duration", "60", "--filter"]);
    let mut robot = Vec::new();
    control_loop::follow(reader, 50, &mut robot).unwrap();
    chain.signal_chain(Signal::TERM);
    assert!(chain.end().status.success());
    let said = String::from_utf8(robot).unwrap();
    let moves = said
        .lines()
        .filter(|line| line.starts_with("move "))
        .count();
    assert!(moves > 0 && said.contains("± "), "{said}");
    bench.assert_nothing_is_left();
}

#[test]
fn a_rope_is_predicted_from_its_image_to_now() {
    let bench = Bench::new();
    let mut reader = reader(&bench);
    let chain = bench.start(&["--fps", "100", "--duration", "60", "--filter"]);
    let end = Instant::now() + PATIENCE;
    let mut predicted = false;
    while !predicted && Instant::now() < end {
        let frame = reader.wait(end).unwrap();
        if let Seen::Fresh(rope) = frame.only_rope(PATIENCE)
            && let Ok(ahead) = rope.predict(now_ns())
        {
            let (then, now) = (rope.shape().unwrap(), ahead.shape());
            let moved = [0, 1].map(|axis| now.point_at(0.5)[axis] - then.point_at(0.5)[axis]);
            // The drawn rope moves at a few hundred pixels a second, and the image is a few
            // milliseconds old.
            assert!(moved[0].hypot(moved[1]) < 100.0, "{moved:?}");
            assert!(now.covariance_at(0.5)[0] > then.covariance_at(0.5)[0]);
            assert!(then.covariance().is_exact());
            predicted = true;
        }
    }
    assert!(predicted);
    chain.signal_chain(Signal::TERM);
    assert!(chain.end().status.success());
}

/// A control loop in a separate process: this test itself, run by the test below. It prints a line
/// for each frame.
#[test]
fn a_loop_of_its_own() {
    if std::env::var_os("LARIAT_TEST_LOOP").is_none() {
        return;
    }
    let mut reader = Reader::open("default").unwrap();
    loop {
        if reader.wait(Instant::now() + PATIENCE).unwrap().is_new() {
            println!("frame");
        }
    }
}

struct Loop {
    process: Child,
    said: BufReader<ChildStdout>,
}

impl Loop {
    fn start(bench: &Bench) -> Self {
        let mut process = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "a_loop_of_its_own", "--nocapture"])
            .env("LARIAT_TEST_LOOP", "1")
            .env("LARIAT_DOMAIN", &bench.domain)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let said = BufReader::new(process.stdout.take().unwrap());
        Self { process, said }
    }

    /// Waits for this many more frames.
    fn wait_for_frames(&mut self, count: usize) {
        let lines = self.said.by_ref().lines().map(|line| line.unwrap());
        let frames = lines.filter(|line| line.ends_with("frame"));
        assert_eq!(frames.take(count).count(), count, "it ended");
    }

    fn signal(&self, signal: Signal) {
        send(self.process.id() as i32, signal);
    }

    fn kill(mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
        wait_until_gone(self.process.id() as i32);
    }
}

#[test]
fn of_sixteen_loops_one_is_stopped_and_one_killed_and_nobody_else_notices() {
    let bench = Bench::new();
    let mut loops: Vec<Loop> = (0..16).map(|_| Loop::start(&bench)).collect();
    let chain = bench.start(&["--fps", "100", "--duration", "60", "--out", "out"]);
    for each in &mut loops {
        each.wait_for_frames(5);
    }
    let (mut stopped, killed) = (loops.pop().unwrap(), loops.pop().unwrap());
    stopped.signal(Signal::STOP);
    killed.kill();
    for each in &mut loops {
        // More messages than the buffer of any reader holds: if the chain waited for the stopped
        // reader, these messages would not come.
        each.wait_for_frames(30);
    }
    stopped.signal(Signal::CONT);
    stopped.wait_for_frames(5);
    for each in loops.into_iter().chain([stopped]) {
        each.kill();
    }
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

/// The same test as tests/c/layout.c in C.
#[test]
fn every_field_of_a_message_is_read_in_its_place() {
    let bench = Bench::new();
    let mut reader = reader(&bench);
    let domain = Domain::named(&bench.domain).unwrap();
    let writer = Writer::<Descriptors>::create(
        &domain,
        &Rig::default(),
        &DESCRIPTORS,
        &Delivery::NewestWins,
    )
    .unwrap();
    let mut slot = writer.slot().unwrap();
    *slot = *message_of_offsets::message();
    slot.send().unwrap();
    let frame = reader.latest().unwrap();
    let message = frame.message().unwrap();
    macro_rules! integers {
        ($type:ty, $from:expr, $at:expr; $($field:ident),+) => {
            $(assert_eq!($from.$field as usize, $at + offset_of!($type, $field), stringify!($field));)+
        };
    }
    macro_rules! floats {
        ($from:expr, $at:expr; $($field:ident),+) => {
            $(let at = $at + offset_of!(Descriptor, $field);
            assert_eq!($from.$field, at as f64 + 0.5, stringify!($field));)+
        };
    }
    macro_rules! arrays {
        ($from:expr, $at:expr; $($field:ident),+) => {
            $(for (i, value) in $from.$field.as_flattened().iter().enumerate() {
                let at = $at + offset_of!(Descriptor, $field) + 8 * i;
                assert_eq!(*value, at as f64 + 0.5, "{} {i}", stringify!($field));
            })+
        };
    }
    integers!(Trace, message.trace, 0; sequence, captured, extracted, fitted, bridged, exposed_ns, captured_ns,
        extract_started_ns, extracted_ns, fit_started_ns, fitted_ns);
    integers!(Descriptors, message, 0; width, height, count, unit);
    for (i, rope) in message.curves.iter().enumerate() {
        let at = offset_of!(Descriptors, curves) + i * size_of::<Descriptor>();
        integers!(Descriptor, rope, at; track, status, basis, degree, count, samples, closed, border, age_ns, hidden,
            filtered, fit);
        assert_eq!(
            f64::from(rope.confidence),
            (at + offset_of!(Descriptor, confidence)) as f64 + 0.5
        );
        floats!(rope, at; rms, max, residual_variance, condition, length, width);
        arrays!(rope, at; control_points, covariances, velocities);
        for (j, (weight, knot)) in rope.weights.iter().zip(rope.knots).enumerate() {
            assert_eq!(
                *weight,
                (at + offset_of!(Descriptor, weights) + 8 * j) as f64 + 0.5
            );
            assert_eq!(
                knot,
                (at + offset_of!(Descriptor, knots) + 8 * j) as f64 + 0.5
            );
        }
    }
    for (i, points) in message.centerlines.iter().enumerate() {
        let at = offset_of!(Descriptors, centerlines) + i * size_of::<CenterlinePoints>();
        integers!(CenterlinePoints, points, at; count, closed);
        for (j, word) in points.hidden.iter().enumerate() {
            let at = at + offset_of!(CenterlinePoints, hidden) + 4 * j;
            assert_eq!(*word as usize, at, "hidden {j}");
        }
        for (first, numbers) in [
            (
                offset_of!(CenterlinePoints, points),
                points.points.as_flattened(),
            ),
            (offset_of!(CenterlinePoints, widths), &points.widths[..]),
        ] {
            for (j, number) in numbers.iter().enumerate() {
                assert_eq!(*number, (at + first + 4 * j) as f32 + 0.5, "{first} {j}");
            }
        }
    }
    // These numbers are a message, but not a rope.
    let mut ropes = frame.ropes(PATIENCE);
    assert!(ropes.all(|seen| matches!(seen, Seen::Absent(Absent::Unreadable))));
}

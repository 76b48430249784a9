//! The chain on the simulated rope: a controller closes the loop through it.

use std::time::{Duration, Instant};

use lariat_wire::{
    COMMANDS, Command, DESCRIPTORS3, Delivery, Domain, Reader, Receiver, Rig, TRUTH3, Writer,
    now_ns,
};
use rustix::process::Signal;

use crate::rig::Bench;

const CHAIN: [&str; 6] = ["--source", "simulated", "--fps", "60", "--out", "out"];

#[test]
fn a_controller_moves_the_rope_by_what_it_sees() {
    let bench = Bench::new();
    let mut chain = bench.start(&CHAIN);
    chain.wait_for_frames();
    let rig = Rig::default();
    let mut reader =
        Reader::open_in(Domain::named(&bench.domain).unwrap(), &rig).expect("a reader");
    let domain = Domain::named(&bench.domain).unwrap();
    let writer = Writer::<Command>::create(&domain, &rig, &COMMANDS, &Delivery::NewestWins);
    let writer = writer.expect("the one controller");
    let began = Instant::now();
    let mut seen: Vec<[f64; 2]> = Vec::new();
    let mut count = 0;
    // Both grippers move up until the middle of the rope is 15 px higher.
    let is_there = |seen: &[[f64; 2]]| {
        let rise = seen.first().zip(seen.last());
        rise.is_some_and(|(first, last)| first[1] - last[1] > 15.0)
    };
    while !is_there(&seen) {
        assert!(began.elapsed() < Duration::from_secs(30), "{seen:?}");
        let frame = reader
            .wait(Instant::now() + Duration::from_secs(1))
            .unwrap();
        let Some(message) = frame.message().filter(|_| frame.is_new()) else {
            continue;
        };
        let Some(curve) = message.curves().first() else {
            continue;
        };
        let control = curve.control_points();
        seen.push(control[control.len() / 2]);
        count += 1;
        let mut slot = writer.slot().unwrap();
        *slot = Command {
            count,
            sent_ns: now_ns(),
            exposed_ns: message.trace.exposed_ns,
            grippers: 2,
            velocities: [[0.0, -60.0, 0.0, 0.0, 0.0, 0.0]; 2],
            ..Command::default()
        };
        slot.send().unwrap();
    }
    let list = bench.run(&["topic", "list"]);
    let list = String::from_utf8(list.stdout).unwrap();
    let of_commands = list.split("commands").nth(1).expect("it is listed");
    let me = format!("process {}", std::process::id());
    assert!(of_commands.contains(&me), "{list}");
    assert!(of_commands.contains("read by capture"), "{list}");
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    bench.assert_every_frame_is_accounted_for("out");
    drop((reader, writer, domain));
    bench.assert_nothing_is_left();
}

#[test]
fn the_visible_rope_is_seen_where_it_is() {
    let bench = Bench::new();
    let frames = ["--frames", "60", "--lossless", "--seed", "3"];
    let ended = bench.run(&[&["run"], &CHAIN[..], &frames].concat());
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success(), "{said}");
    let summary = bench.summary("out");
    assert_eq!(summary["frames"]["received"], 60);
    bench.assert_every_frame_is_accounted_for("out");
    let mean = summary["error_px"]["centerline"]["mean"].as_f64();
    assert!(mean.is_some_and(|mean| mean < 1.0), "{summary:#}");
    bench.assert_nothing_is_left();
}

/// Finds the rope by its color, without the grippers' jaws.
const BLUE: &str =
    "[extract]\nmask = [{ hue_deg = [190, 250], saturation = [0.3, 1], value = [0.1, 1] }]\n";

/// Mean distance of the points from a line.
fn beside(points: &[[f32; 3]], line: &[[f32; 3]]) -> f32 {
    let far = |p: &[f32; 3], q: &[f32; 3]| {
        let square = |k: usize| (p[k] - q[k]) * (p[k] - q[k]);
        (square(0) + square(1) + square(2)).sqrt()
    };
    let nearest = |p| line.iter().map(|q| far(p, q)).fold(f32::MAX, f32::min);
    points.iter().map(nearest).sum::<f32>() / points.len() as f32
}

#[test]
fn a_lifted_rope_is_seen_in_space_where_it_is_and_lifted_further_by_command() {
    let bench = Bench::new();
    std::fs::write(bench.path("lariat.toml"), BLUE).unwrap();
    let mut chain = bench.start(&["--source", "simulated", "--depth", "simulated"]);
    chain.wait_for_frames();
    let (domain, rig) = (Domain::named(&bench.domain).unwrap(), Rig::default());
    let truth = Receiver::create(&domain, &rig, &TRUTH3, None).unwrap();
    let seen = Receiver::create(&domain, &rig, &DESCRIPTORS3, None).unwrap();
    let writer = Writer::<Command>::create(&domain, &rig, &COMMANDS, &Delivery::NewestWins);
    let writer = writer.expect("the one controller");
    let began = Instant::now();
    let mut lines: Vec<(u64, Vec<[f32; 3]>)> = Vec::new();
    let (mut first_mm, mut compared) = (None, 0);
    loop {
        assert!(began.elapsed() < Duration::from_secs(40), "{first_mm:?}");
        truth
            .sleep(Some(Instant::now() + Duration::from_millis(50)), None)
            .unwrap();
        while let Some(message) = truth.next().unwrap() {
            let points = message.curves()[0].points().to_vec();
            lines.push((message.trace.captured, points));
        }
        while let Some(message) = seen.next().unwrap() {
            let line = lines.iter().find(|(of, _)| *of == message.trace.captured);
            let (Some((_, line)), [rope]) = (line, message.curves()) else {
                continue;
            };
            // Each point is within the accuracy of a depth camera at three quarters of a meter.
            let off_mm = beside(rope.points(), line);
            assert!(off_mm < 2.5, "{off_mm}");
            compared += 1;
        }
        let Some((_, newest)) = lines.last() else {
            continue;
        };
        let middle_mm = newest[newest.len() / 2][2];
        if middle_mm - *first_mm.get_or_insert(middle_mm) > 10.0 && compared > 10 {
            break;
        }
        let mut slot = writer.slot().unwrap();
        *slot = Command {
            count: lines.len() as u64,
            sent_ns: now_ns(),
            grippers: 2,
            velocities: [[0.0, 0.0, 20.0, 0.0, 0.0, 0.0]; 2],
            ..Command::default()
        };
        slot.send().unwrap();
    }
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    drop((truth, seen, writer, domain));
    bench.assert_nothing_is_left();
}

#[test]
fn only_the_simulated_rope_has_simulated_cameras() {
    let bench = Bench::new();
    let ended = bench.run(&["run", "--source", "rendered", "--depth", "simulated"]);
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(!ended.status.success());
    assert!(said.contains("--source simulated"), "{said}");
    bench.assert_nothing_is_left();
}

#[test]
fn a_rope_that_cannot_be_simulated_is_refused_before_anything_runs() {
    let bench = Bench::new();
    std::fs::write(bench.path("lariat.toml"), "[simulation]\ngrippers = 3\n").unwrap();
    let ended = bench.run(&[&["run"], &CHAIN[..]].concat());
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(said.contains("choose a whole number from 1 to 2"), "{said}");
    bench.assert_nothing_is_left();
}

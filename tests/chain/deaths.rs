//! Death of a process, by a signal that it can catch and by one that it cannot.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Sender};
use std::thread;
use std::time::{Duration, Instant};

use lariat_wire::{Domain, Receiver, Rig};
use rustix::fs::{CWD, Mode, mkfifoat};
use rustix::pipe::fcntl_setpipe_size;
use rustix::process::Signal;

use crate::rig::{Bench, send, wait_until_gone};

const STAGES: [&str; 4] = ["capture", "extract", "fit", "sink"];

fn a_stage_dies(place: usize, signal: Signal, how: &str) {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--duration", "60", "--out", "out"]);
    let ids = chain.ids;
    chain.wait_for_frames();
    chain.signal_stage(place, signal);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(1), "{}", ended.stderr);
    let sentence = format!("lariat: {} {how}; the chain was stopped", STAGES[place]);
    assert!(ended.stderr.contains(&sentence), "{}", ended.stderr);
    ids.into_iter().for_each(wait_until_gone);
    // A killed sink cannot report; its report shows every other death.
    if STAGES[place] != "sink" || signal == Signal::TERM {
        assert!(
            ended.stdout.contains("exposed → received"),
            "{}",
            ended.stdout
        );
        bench.assert_every_frame_is_accounted_for("out");
    }
    bench.assert_nothing_is_left();
}

#[test]
fn a_killed_capture_stops_the_chain_which_says_so() {
    a_stage_dies(0, Signal::KILL, "was killed by signal 9 (SIGKILL)");
}

#[test]
fn a_killed_extract_stops_the_chain_which_says_so() {
    a_stage_dies(1, Signal::KILL, "was killed by signal 9 (SIGKILL)");
}

#[test]
fn a_killed_fit_stops_the_chain_which_says_so() {
    a_stage_dies(2, Signal::KILL, "was killed by signal 9 (SIGKILL)");
}

#[test]
fn a_killed_sink_stops_the_chain_which_says_so() {
    a_stage_dies(3, Signal::KILL, "was killed by signal 9 (SIGKILL)");
}

#[test]
fn a_stage_that_is_told_to_end_ends_the_chain() {
    for place in 0..4 {
        a_stage_dies(place, Signal::TERM, "ended before its time");
    }
}

#[test]
fn a_signal_to_the_chain_ends_it_in_order_with_its_report() {
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        let bench = Bench::new();
        let mut chain = bench.start(&["--fps", "100", "--duration", "60", "--out", "out"]);
        chain.wait_for_frames();
        chain.signal_chain(signal);
        let ended = chain.end();
        assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
        assert!(
            ended.stdout.contains("exposed → received"),
            "{}",
            ended.stdout
        );
        bench.assert_every_frame_is_accounted_for("out");
        bench.assert_nothing_is_left();
    }
}

#[test]
fn two_signals_at_once_are_one() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--duration", "60", "--out", "out"]);
    chain.wait_for_frames();
    // Send two signals, as `timeout -s INT` does, which signals the process and then its group.
    // TERM is delivered first, so that the two do not merge.
    chain.signal_chain(Signal::TERM);
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn a_chain_that_is_told_to_end_before_it_is_up_ends_in_order() {
    for more in [&[][..], &["--fuse"]] {
        let bench = Bench::new();
        let mut process = bench
            .command(&[&["run", "-v", "--control-points", "6"], more].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary runs");
        let mut stderr = BufReader::new(process.stderr.take().expect("piped"));
        let mut first = String::new();
        stderr.read_line(&mut first).expect("readable");
        // The first stage that starts prints this before the chain is ready.
        assert!(first.contains("sink: "), "{first}");
        send(process.id() as i32, Signal::INT);
        let mut rest = String::new();
        stderr.read_to_string(&mut rest).expect("readable");
        let status = process.wait().expect("waited for");
        assert_eq!(status.code(), Some(0), "{rest}");
        bench.assert_nothing_is_left();
    }
}

#[test]
fn stages_that_somebody_stopped_end_in_order() {
    let bench = Bench::new();
    for stage in 0..4 {
        let mut chain = bench.start(&["--fps", "100", "--out", "out", "--force"]);
        let ids = chain.ids;
        chain.wait_for_frames();
        chain.signal_stage(stage, Signal::STOP);
        chain.signal_chain(Signal::TERM);
        let ended = chain.end();
        assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
        assert!(ended.stdout.contains("exposed → received"));
        bench.assert_every_frame_is_accounted_for("out");
        ids.into_iter().for_each(wait_until_gone);
        bench.assert_nothing_is_left();
    }
}

/// The timeline is written to a pipe that nobody reads.
#[test]
fn a_stage_that_does_not_end_is_killed_and_named() {
    let bench = Bench::new();
    let pipe = bench.path("timeline.json");
    mkfifoat(CWD, &pipe, Mode::RUSR | Mode::WUSR).expect("a pipe");
    let open = File::options().read(true).write(true).open(&pipe);
    let open = open.expect("a pipe");
    fcntl_setpipe_size(&open, 4096).expect("a size");
    // The timeline is much larger than the pipe's buffer.
    let frames = ["--fps", "200", "--frames", "200"];
    let chain = bench.start(&[&frames[..], &["--trace", "timeline.json"]].concat());
    let ids = chain.ids;
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(1), "{}", ended.stderr);
    let sentence = "lariat: sink did not end within 3 s of being told to, and was killed";
    assert_eq!(
        ended.stderr.matches(sentence).count(),
        1,
        "{}",
        ended.stderr
    );
    assert!(
        !ended.stderr.contains("the chain was stopped"),
        "{}",
        ended.stderr
    );
    ids.into_iter().for_each(wait_until_gone);
    bench.assert_nothing_is_left();
}

#[test]
fn a_killed_chain_takes_its_stages_along() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--duration", "60"]);
    let ids = chain.ids;
    chain.wait_for_frames();
    chain.signal_chain(Signal::KILL);
    chain.end();
    ids.into_iter().for_each(wait_until_gone);
    bench.assert_nothing_is_left();
}

#[test]
fn a_lossless_chain_ends_too_when_a_stage_is_killed() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--lossless", "--fps", "max", "--duration", "60"]);
    chain.wait_for_frames();
    chain.signal_stage(1, Signal::KILL);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(1), "{}", ended.stderr);
    assert!(
        ended.stderr.contains("extract was killed"),
        "{}",
        ended.stderr
    );
    bench.assert_nothing_is_left();
}

/// Runs a reader of a lossless chain. It pauses until the chain is told to end, and then reads
/// until nothing is left after the end. Returns the number of messages, and the numbers of the
/// first and the last one.
///
/// `opened` is notified when the reader is open.
fn read_late(domain: &str, opened: &Sender<()>, is_over: &AtomicBool) -> (u64, u64, u64) {
    let domain = Domain::named(domain).expect("a domain");
    let reader = Receiver::descriptors(&domain, &Rig::default()).expect("a reader");
    let until = Instant::now() + Duration::from_millis(1500);
    opened.send(()).expect("someone waits");
    while Instant::now() < until {
        // The reader opens its end of the channel, but takes no message.
        reader.before_poll().expect("a channel");
        thread::sleep(Duration::from_millis(10));
    }
    let (mut came, mut first, mut last) = (0, 0, 0);
    loop {
        // This order matters: messages sent before the end are still available after it.
        let was_over = is_over.load(Ordering::Acquire);
        match reader.next().expect("a channel") {
            Some(message) => {
                last = message.trace.fitted;
                first = if came == 0 { last } else { first };
                came += 1;
            }
            None if was_over => return (came, first, last),
            None => thread::sleep(Duration::from_millis(2)),
        }
    }
}

#[test]
fn a_lossless_chain_that_is_told_to_end_delivers_all_to_a_reader_that_was_slow() {
    for round in 0..4 {
        let bench = Bench::new();
        let arguments = [
            "--lossless",
            "--fps",
            "300",
            "--duration",
            "60",
            "--out",
            "out",
        ];
        let mut chain = bench.start(&arguments);
        chain.wait_for_frames();
        let domain = bench.domain.clone();
        let is_over = Arc::new(AtomicBool::new(false));
        let (opened, is_open) = mpsc::channel();
        let reader = thread::spawn({
            let is_over = is_over.clone();
            move || read_late(&domain, &opened, &is_over)
        });
        is_open.recv().expect("the reader opens");
        // All buffers are full by now, and each stage waits for the next.
        thread::sleep(Duration::from_millis(800));
        chain.signal_chain(Signal::TERM);
        let ended = chain.end();
        is_over.store(true, Ordering::Release);
        assert_eq!(
            ended.status.code(),
            Some(0),
            "round {round}: {}",
            ended.stderr
        );
        let (came, first, last) = reader.join().expect("it reads");
        let sent = bench.summary("out")["frames"]["received"].as_u64();
        assert_eq!(Some(last), sent, "round {round}");
        assert_eq!(came, 1 + last - first, "round {round}");
        bench.assert_nothing_is_left();
    }
}

#[test]
fn a_lossless_chain_says_what_a_reader_missed_that_stood_still_to_the_end() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--lossless", "--fps", "300", "--duration", "60"]);
    chain.wait_for_frames();
    let domain = Domain::named(&bench.domain).expect("a domain");
    let reader = Receiver::descriptors(&domain, &Rig::default()).expect("a reader");
    let until = Instant::now() + Duration::from_millis(800);
    while Instant::now() < until {
        // The reader opens its end of the channel, but takes no message.
        reader.before_poll().expect("a channel");
        thread::sleep(Duration::from_millis(10));
    }
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(1), "{}", ended.stderr);
    let sentence = "did not reach a reader that stood still while this stage ended";
    assert!(ended.stderr.contains(sentence), "{}", ended.stderr);
    drop((reader, domain));
    bench.assert_nothing_is_left();
}

#[test]
fn stages_by_hand_are_as_good_citizens() {
    use std::process::Stdio;
    let bench = Bench::new();
    let start = |stage: &'static str| {
        let said = std::fs::File::create(bench.path(stage)).unwrap();
        let process = bench
            .command(&[stage])
            .stdout(Stdio::null())
            .stderr(said)
            .spawn();
        (stage, process.unwrap())
    };
    let mut stages = ["sink", "fit", "extract"].map(start);
    let killed = bench
        .command(&["capture", "--fps", "50"])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // The rig works once a descriptor comes.
    let domain = lariat_wire::Domain::named(&bench.domain).unwrap();
    let reader = lariat_wire::Receiver::descriptors(&domain, &lariat_wire::Rig::default()).unwrap();
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(30);
    assert!(reader.wait(deadline).unwrap().is_some());
    // The sink may start more slowly than the stages that it listens to.
    for (stage, process) in &stages {
        let entry = format!("lariat-roster/default.{stage}.{}", process.id());
        let entry = std::path::Path::new("/tmp")
            .join(format!("lariat-{}", bench.domain))
            .join(entry);
        while !entry.exists() {
            assert!(std::time::Instant::now() < deadline, "{stage} is not up");
            thread::sleep(Duration::from_millis(1));
        }
    }
    drop((reader, domain));
    let mut killed = killed;
    crate::rig::send(killed.id() as i32, Signal::KILL);
    killed.wait().unwrap();
    for (stage, process) in &mut stages {
        // A signal that comes before the handler is installed ends the process like any other.
        crate::rig::wait_until_told_by_signals(process.id());
        crate::rig::send(process.id() as i32, Signal::TERM);
        let ended = process.wait().unwrap();
        let said = std::fs::read_to_string(bench.path(stage)).unwrap();
        assert!(ended.success(), "{stage}: {ended}, {said}");
    }
    bench.assert_nothing_is_left();
}

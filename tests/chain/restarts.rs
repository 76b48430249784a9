//! Stages that restart in place, and settings that change, while the rest of a chain continues.

use std::fs;
use std::io::Read;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixDatagram, UnixStream};
use std::process::Output;
use std::thread;
use std::time::{Duration, Instant};

use lariat_wire::{Domain, Reader, Rig, Trace};
use rustix::process::Signal;

use crate::rig::{Bench, Running, program, send, wait_until_gone};

const STAGES: [&str; 4] = ["capture", "extract", "fit", "sink"];
const PATIENCE: Duration = Duration::from_secs(60);

/// Polls until something is found.
fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(begin.elapsed() < PATIENCE, "{what} did not come");
        thread::sleep(Duration::from_millis(5));
    }
}

/// Opens a reader, as a control loop does, on the bench's rig.
fn reader(bench: &Bench) -> Reader {
    let domain = Domain::named(&bench.domain).unwrap();
    Reader::open_in(domain, &Rig::default()).unwrap()
}

/// Returns the number and the first point of the only rope in the next frame that shows one, after
/// `fitted` frames.
fn rope_after(reader: &mut Reader, fitted: u64) -> (u32, [f32; 2], Trace) {
    wait_for("a rope", || {
        let frame = reader.latest().unwrap();
        assert!(frame.run() <= 1, "a restarted stage is not a new run");
        let message = frame.message()?;
        let is_new = message.trace.fitted > fitted;
        let curve = message.curves().first().filter(|_| is_new)?;
        (curve.age_ns == 0).then(|| {
            let first = message.centerlines[0].points()[0];
            (curve.track, first, message.trace)
        })
    })
}

/// Checks that a recomputation reports equal results. Its output is wrapped, so the lines are
/// joined.
fn assert_same_to_the_bit(check: &Output) {
    let text = String::from_utf8_lossy(&check.stdout);
    let words: Vec<_> = text.split_whitespace().collect();
    assert!(
        words.join(" ").contains("are the same to the bit"),
        "{check:?}"
    );
}

fn start(bench: &Bench, more: &[&str]) -> Running {
    let always = ["--restart", "on-failure", "--out", "out"];
    bench.start(&[&always, more].concat())
}

/// Returns the process of a stage in the bench's domain, if it differs from `before`.
fn another(bench: &Bench, stage: &str, before: i32) -> Option<i32> {
    let folder = format!("/tmp/lariat-{}/lariat-roster", bench.domain);
    let names = fs::read_dir(folder).ok()?.flatten();
    let mut ids = names.filter_map(|entry| {
        let name = entry.file_name().into_string().ok()?;
        let id = name.strip_prefix(&format!("default.{stage}."))?;
        id.parse::<i32>().ok().filter(|id| *id != before)
    });
    ids.next()
}

#[test]
fn a_stage_that_is_killed_is_restarted_and_all_others_go_on() {
    let bench = Bench::new();
    let mut chain = start(&bench, &["--fps", "100"]);
    chain.wait_for_frames();
    let mut reader = reader(&bench);
    let (track, mut before, mut trace) = rope_after(&mut reader, 0);
    for (place, stage) in STAGES.into_iter().enumerate() {
        chain.signal_stage(place, Signal::KILL);
        let id = wait_for(stage, || another(&bench, stage, chain.ids[place]));
        wait_until_gone(chain.ids[place]);
        let restarts = u8::from(stage != "sink");
        let (now_track, now, now_trace) = wait_for("the rope", || {
            let (track, now, trace) = rope_after(&mut reader, trace.fitted);
            let is_new = trace
                .restarts()
                .get(place)
                .is_none_or(|&count| count == restarts);
            is_new.then_some((track, now, trace))
        });
        assert_eq!(now_track, track, "{stage}: the rope keeps its number");
        let moved = (now[0] - before[0]).hypot(now[1] - before[1]);
        assert!(
            moved < 100.0,
            "{stage}: and begins where it began: {before:?} {now:?}"
        );
        assert!(now_trace.captured > trace.captured && now_trace.sequence > trace.sequence);
        assert!(now_trace.extracted > trace.extracted && now_trace.fitted > trace.fitted);
        (before, trace) = (now, now_trace);
        assert_ne!(id, chain.ids[place]);
    }
    assert_eq!(trace.restarts(), [1, 1, 1]);
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    for stage in STAGES {
        let sentence = format!("{stage} was killed by signal 9 (SIGKILL); it is restarted");
        assert_eq!(
            ended.stderr.matches(&sentence).count(),
            1,
            "{}",
            ended.stderr
        );
    }
    bench.assert_every_frame_is_accounted_for("out");
    drop(reader);
    bench.assert_nothing_is_left();
}

#[test]
fn a_stage_that_stands_still_while_frames_wait_is_killed_and_restarted() {
    let bench = Bench::new();
    fs::write(bench.path("lariat.toml"), "[run]\nhang_s = 1\n").unwrap();
    let mut chain = start(&bench, &["--fps", "100"]);
    chain.wait_for_frames();
    for place in [0, 2] {
        send(chain.ids[place], Signal::STOP);
        wait_for("another", || {
            another(&bench, STAGES[place], chain.ids[place])
        });
    }
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    for stage in ["capture", "fit"] {
        let sentence = format!("{stage} has stood still for 1 s while work waits for it");
        assert_eq!(
            ended.stderr.matches(&sentence).count(),
            1,
            "{}",
            ended.stderr
        );
    }
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn a_stage_that_falls_too_often_ends_the_chain() {
    let bench = Bench::new();
    fs::write(bench.path("lariat.toml"), "[run]\nmax_restarts = 1\n").unwrap();
    let mut chain = start(&bench, &["--fps", "100"]);
    chain.wait_for_frames();
    chain.signal_stage(2, Signal::KILL);
    let id = wait_for("fit", || another(&bench, "fit", chain.ids[2]));
    send(id, Signal::KILL);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(1), "{}", ended.stderr);
    let sentence = "1 parts were restarted within 60 s (max_restarts): no more";
    assert_eq!(
        ended.stderr.matches(sentence).count(),
        1,
        "{}",
        ended.stderr
    );
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn a_chain_that_is_told_to_end_before_a_stage_is_back_ends_in_order() {
    let bench = Bench::new();
    let mut chain = start(&bench, &["--fps", "100"]);
    chain.wait_for_frames();
    let mut fit = chain.ids[2];
    // The next pause is 0.8 s, and the one after it 1.6 s.
    for _ in 0..4 {
        send(fit, Signal::KILL);
        fit = wait_for("fit", || another(&bench, "fit", fit));
    }
    for id in [fit, chain.ids[3]] {
        send(id, Signal::KILL);
        wait_until_gone(id);
    }
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn a_recorder_that_is_killed_is_restarted_and_what_it_wrote_stays() {
    let bench = Bench::new();
    let mut chain = start(&bench, &["--fps", "100", "--record", "run.mcap"]);
    chain.wait_for_frames();
    let id = wait_for("the recorder", || another(&bench, "record", 0));
    wait_for("something to keep", || {
        let info = bench.run(&["info", "run.mcap"]);
        info.status.success().then_some(())
    });
    send(id, Signal::KILL);
    wait_for("another", || another(&bench, "record", id));
    chain.wait_for_frames();
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    let sentence = "recorder was killed by signal 9 (SIGKILL); it is restarted";
    assert_eq!(
        ended.stderr.matches(sentence).count(),
        1,
        "{}",
        ended.stderr
    );
    for file in ["run.mcap", "run-2.mcap"] {
        let info = bench.run(&["info", file, "--json"]);
        assert!(info.status.success(), "{file}: {info:?}");
    }
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn files_go_on_where_a_killed_capture_stopped() {
    let bench = Bench::new();
    let films = bench.run(&[
        "run",
        "--lossless",
        "--frames",
        "60",
        "--fps",
        "100",
        "--record",
        "film.mcap",
    ]);
    assert!(films.status.success());
    let mut chain = bench.start(&[
        "film.mcap",
        "--restart",
        "on-failure",
        "--lossless",
        "--fps",
        "20",
        "--out",
        "out",
    ]);
    chain.wait_for_frames();
    chain.signal_stage(0, Signal::KILL);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    let frames = &bench.summary("out")["frames"];
    // A frame may have been counted but not sent when the stage was killed; it is reported as lost.
    assert_eq!(frames["published"], 60, "{frames}");
    assert!(frames["received"].as_u64().unwrap() >= 58, "{frames}");
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn settings_change_between_two_frames_and_each_message_says_by_which_it_was_made() {
    let bench = Bench::new();
    let mut chain = start(
        &bench,
        &["--lossless", "--record", "run.mcap", "--fps", "50"],
    );
    chain.wait_for_frames();
    let set = |changes: &[&str]| bench.run(&[&["set"], changes].concat());
    let said = set(&["fit.control_points=7", "extract.min_confidence=0.25"]);
    let text = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(said.status.success(), "{said:?}");
    assert!(
        text.starts_with("settings 1: extract.min_confidence = 0.25 fit."),
        "{text}"
    );
    let wait_for_version = |version| {
        let mut reader = reader(&bench);
        wait_for("the version", || {
            let frame = reader.latest().unwrap();
            let message = frame.message()?;
            (message.trace.settings == version).then(|| {
                let curve = message.curves()[0];
                (curve.degree, message.centerlines[0].points().len())
            })
        })
    };
    // A lossless chain waits for its readers, so this one exists only while it reads.
    let (degree, _) = wait_for_version(1);
    assert_eq!(degree, 6);
    assert!(set(&["fit.control_points=5"]).status.success());
    assert_eq!(wait_for_version(2).0, 4);
    // An invalid change leaves everything as it is, and says why.
    for (change, code, why) in [
        ("fit.control_points=100", 2, "control_points"),
        ("fit.order=6", 2, "write fit.control_points=7"),
        ("fit.degre=9", 2, "did you mean fit.degree?"),
        (
            "run.rig=other",
            1,
            "run.rig cannot change while the chain runs",
        ),
        ("extract.network=none.weights", 1, "none.weights"),
    ] {
        let refused = set(&[change]);
        assert_eq!(refused.status.code(), Some(code), "{refused:?}");
        let text = String::from_utf8_lossy(&refused.stderr);
        assert!(text.contains(why), "{change}: {text}");
    }
    let holds = String::from_utf8(set(&[]).stdout).unwrap();
    assert!(holds.starts_with("# lariat settings 2\n"), "{holds}");
    assert!(
        holds.contains("control_points = 5\n") && holds.contains("min_confidence = 0.25\n"),
        "{holds}"
    );
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    // The recording contains every version, and recomputing with them gives the same results.
    let check = bench.run(&["replay", "run.mcap", "--check"]);
    assert!(check.status.success(), "{check:?}");
    assert_same_to_the_bit(&check);
    bench.assert_nothing_is_left();
}

#[test]
fn a_settings_file_that_is_edited_holds_at_once_if_it_is_watched() {
    let bench = Bench::new();
    let file = bench.path("lariat.toml");
    fs::write(&file, "[fit]\ncontrol_points = 6\n").unwrap();
    let mut chain = start(&bench, &["--watch", "--fps", "100"]);
    chain.wait_for_frames();
    let mut reader = reader(&bench);
    let mut degree_is = |degree: u32| {
        wait_for("the degree", || {
            let frame = reader.latest().unwrap();
            let curve = frame.message()?.curves().first()?;
            (curve.degree == degree).then_some(())
        });
    };
    degree_is(5);
    fs::write(&file, "[fit]\ncontrol_points = \"many\"\n").unwrap();
    fs::write(&file, "[fit]\ncontrol_points = 8\n[capture]\nseed = 90\n").unwrap();
    degree_is(7);
    wait_for("capture", || another(&bench, "capture", chain.ids[0]));
    drop(reader);
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    assert!(
        ended.stderr.contains("restarted: capture"),
        "{}",
        ended.stderr
    );
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn a_service_manager_hears_that_the_chain_is_up_at_work_and_at_its_end() {
    let bench = Bench::new();
    let path = bench.path("manager");
    let manager = UnixDatagram::bind(&path).unwrap();
    manager.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut command = bench.command(&["run", "--daemon", "--fps", "50"]);
    command
        .env("NOTIFY_SOCKET", &path)
        .env("WATCHDOG_USEC", "2000000");
    let chain = bench.start_command(command);
    let next = || {
        let mut bytes = [0; 256];
        let length = manager.recv(&mut bytes).expect("the chain says nothing");
        String::from_utf8_lossy(&bytes[..length]).into_owned()
    };
    let wait_for_word = |word: &str| {
        let mut heard = Vec::new();
        while !heard
            .last()
            .is_some_and(|last: &String| last.starts_with(word))
        {
            heard.push(next());
        }
        heard
    };
    assert_eq!(next(), "READY=1");
    wait_for_word("WATCHDOG=1");
    let heard = wait_for_word("STATUS=");
    let status = heard.last().unwrap();
    assert!(status.contains(" frames/s, 1 rope"), "{status}");
    chain.signal_chain(Signal::TERM);
    wait_for_word("STOPPING=1");
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    // No live status line is shown.
    assert!(!ended.stdout.contains("received, "), "{}", ended.stdout);
    bench.assert_nothing_is_left();
}

#[test]
fn a_stage_is_restarted_when_that_is_asked_for() {
    let bench = Bench::new();
    let recorded = ["--lossless", "--record", "run.mcap"];
    let mut chain = bench.start(&[&["--fps", "50", "--out", "out"], &recorded[..]].concat());
    chain.wait_for_frames();
    for (place, stage) in STAGES.into_iter().enumerate() {
        let said = bench.run(&["restart", stage]);
        assert!(said.status.success(), "{said:?}");
        wait_for(stage, || another(&bench, stage, chain.ids[place]));
    }
    let unknown = bench.run(&["restart", "fitt"]);
    assert_eq!(unknown.status.code(), Some(2));
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
    // The recomputation continues after each restart as the chain did.
    let check = bench.run(&["replay", "run.mcap", "--check"]);
    assert_same_to_the_bit(&check);
    let nobody = bench.run(&["set", "fit.control_points=4"]);
    assert_eq!(nobody.status.code(), Some(1));
    let text = String::from_utf8_lossy(&nobody.stderr);
    assert!(text.contains("no chain runs on rig default"), "{text}");
}

/// Starts a chain from a copy of the binary, so that the copy can be replaced.
fn start_copy(bench: &Bench) -> Running {
    fs::copy(program(), bench.path("copy")).unwrap();
    let arguments = ["run", "--restart", "on-failure", "--fps", "100"];
    bench.start_command(bench.command_of(bench.path("copy"), &arguments))
}

#[test]
fn stages_are_restarted_from_the_file_that_runs_though_another_took_its_place() {
    let bench = Bench::new();
    let mut chain = start_copy(&bench);
    chain.wait_for_frames();
    // The name is given to another file, as dpkg and cargo do.
    fs::write(bench.path("new"), "not a program").unwrap();
    fs::rename(bench.path("new"), bench.path("copy")).unwrap();
    chain.signal_stage(2, Signal::KILL);
    let fit = wait_for("fit", || another(&bench, "fit", chain.ids[2]));
    let name = fs::read_to_string(format!("/proc/{fit}/comm")).unwrap();
    assert_eq!(name, "lariat\n");
    fs::remove_file(bench.path("copy")).unwrap();
    assert!(bench.run(&["restart", "extract"]).status.success());
    wait_for("extract", || another(&bench, "extract", chain.ids[1]));
    let mut reader = reader(&bench);
    let (.., seen) = rope_after(&mut reader, 0);
    rope_after(&mut reader, seen.fitted);
    drop(reader);
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    let sentence = "the executable was replaced or removed";
    assert_eq!(
        ended.stderr.matches(sentence).count(),
        1,
        "{}",
        ended.stderr
    );
    bench.assert_nothing_is_left();
}

#[test]
fn a_stage_that_cannot_be_executed_is_tried_again_until_it_can() {
    let bench = Bench::new();
    let mut chain = start_copy(&bench);
    chain.wait_for_frames();
    let permit = |mode| {
        fs::set_permissions(bench.path("copy"), fs::Permissions::from_mode(mode)).unwrap();
    };
    permit(0o600);
    chain.signal_stage(2, Signal::KILL);
    chain.wait_for_message("fit could not be started: Permission denied");
    permit(0o700);
    wait_for("fit", || another(&bench, "fit", chain.ids[2]));
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    bench.assert_nothing_is_left();
}

#[test]
fn settings_that_a_stage_does_not_start_with_are_taken_back_and_the_answer_says_why() {
    let bench = Bench::new();
    let mut chain = start(&bench, &["--fps", "50"]);
    chain.wait_for_frames();
    for (change, why) in [
        ("capture.source=\"none.png\"", "none.png"),
        ("capture.source=\"/dev/null\"", "/dev/null"),
    ] {
        let refused = bench.run(&["set", change]);
        assert_eq!(refused.status.code(), Some(1), "{refused:?}");
        let text = String::from_utf8_lossy(&refused.stderr);
        let says = |part| text.contains(part);
        assert!(
            says("capture cannot start with this change: ") && says(why),
            "{text}"
        );
        assert!(says("; the previous settings stay in force"), "{text}");
    }
    let holds = String::from_utf8(bench.run(&["set"]).stdout).unwrap();
    assert!(
        !holds.contains("none.png") && !holds.contains("/dev/null"),
        "{holds}"
    );
    // Frames come as before, and a change that capture can start with takes effect.
    let mut reader = reader(&bench);
    let (.., seen) = rope_after(&mut reader, 0);
    rope_after(&mut reader, seen.fitted);
    drop(reader);
    let taken = bench.run(&["set", "capture.fps=60"]);
    assert!(taken.status.success(), "{taken:?}");
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn clients_that_say_nothing_hold_up_neither_the_chain_nor_others() {
    let bench = Bench::new();
    let mut chain = start(&bench, &["--fps", "50"]);
    chain.wait_for_frames();
    let socket = format!("/tmp/lariat-{}/lariat-roster/default.control", bench.domain);
    let silent: Vec<_> = (0..20)
        .map(|_| UnixStream::connect(&socket).unwrap())
        .collect();
    let said = bench.run(&["set", "fit.control_points=7"]);
    assert!(said.status.success(), "{said:?}");
    for mut client in silent {
        let mut answer = String::new();
        client.read_to_string(&mut answer).unwrap();
        assert_eq!(answer, "refused\nthe request did not end\n");
    }
    chain.signal_chain(Signal::TERM);
    let ended = chain.end();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.stderr);
    bench.assert_nothing_is_left();
}

//! Cores and priorities of the stages, and their cost when idle.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::Signal;
use rustix::thread::{CpuSet, sched_getaffinity};

use crate::rig::{Bench, send, wait_until_told_by_signals};

const STAGES: [&str; 4] = ["capture", "extract", "fit", "sink"];

/// Cores that the tests may use.
fn cores() -> Vec<usize> {
    let set = sched_getaffinity(None).expect("the kernel says which");
    (0..CpuSet::MAX_CPU)
        .filter(|&core| set.is_set(core))
        .collect()
}

/// Returns a line of `/proc/ID/status`.
fn status_of(process: &str, name: &str) -> String {
    let status = fs::read_to_string(format!("/proc/{process}/status")).expect("it lives");
    let line = status.lines().find_map(|line| line.strip_prefix(name));
    line.expect("a line of that name").trim().to_owned()
}

/// Policy and realtime priority of each thread of a process: policy 0 is the normal one, 1 is FIFO.
fn scheduling(id: i32) -> Vec<(u32, u32)> {
    let threads = fs::read_dir(format!("/proc/{id}/task")).expect("it lives");
    let of_thread = |thread: fs::DirEntry| {
        let stat = fs::read_to_string(thread.path().join("stat")).expect("it lives");
        // The name, in parentheses, may contain spaces; the third field is the first one after it.
        let fields: Vec<&str> = stat[stat.rfind(')').expect("a name") + 2..]
            .split(' ')
            .collect();
        let number = |field: usize| fields[field - 3].parse().expect("a number");
        (number(41), number(40))
    };
    threads.flatten().map(of_thread).collect()
}

fn sleeps(id: u32) -> u64 {
    let count = status_of(&id.to_string(), "voluntary_ctxt_switches:");
    count.parse().expect("a number")
}

#[test]
fn stages_run_on_the_cores_that_they_were_given() {
    let bench = Bench::new();
    let cores = cores();
    let given: Vec<usize> = (0..4).map(|place| cores[place % cores.len()]).collect();
    let text: Vec<String> = given.iter().map(usize::to_string).collect();
    let chain = bench.start(&["--duration", "60", "--cpus", &text.join(",")]);
    for (id, core) in chain.ids.iter().zip(&text) {
        assert_eq!(&status_of(&id.to_string(), "Cpus_allowed_list:"), core);
    }
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn a_core_that_is_not_there_is_said_before_anything_starts() {
    let bench = Bench::new();
    for arguments in [
        &["run", "--cpus", "1023,0,0,0"][..],
        &["fit", "--cpus", "0,0,1023,0"],
    ] {
        let output = bench.run(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success());
        assert!(said.contains("cannot run on core 1023"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    bench.assert_nothing_is_left();
}

#[test]
fn realtime_is_had_or_its_lack_is_said_in_one_sentence() {
    let bench = Bench::new();
    let file = bench.path("lariat.toml");
    fs::write(file, "[run]\nrealtime = true\npriority = 7\n").expect("written");
    let mut chain = bench.start(&["--fps", "100", "--duration", "60"]);
    chain.wait_for_frames();
    let found = chain.ids.map(scheduling);
    let limits = chain
        .ids
        .map(|id| fs::read_to_string(format!("/proc/{id}/limits")).expect("it lives"));
    let cores = chain
        .ids
        .map(|id| status_of(&id.to_string(), "Cpus_allowed_list:"));
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let (introduction, lacking) = (&ended.introduction, "may not have FIFO scheduling");
    if introduction.contains(lacking) {
        assert_eq!(introduction.matches("may not have").count(), 1);
        assert!(found.iter().flatten().all(|thread| *thread == (0, 0)));
        // Without priority over other programs, a single core for all stages would be harmful.
        let own = status_of("self", "Cpus_allowed_list:");
        assert!(cores.iter().all(|stage| *stage == own), "{cores:?}");
    } else {
        for (priority, threads) in (7..).zip(&found) {
            // The thread that listens to the chain keeps the normal policy.
            let (stage, listens) = threads.split_first().expect("a thread");
            assert_eq!(*stage, (1, priority));
            assert!(
                listens.iter().all(|thread| *thread == (0, 0)),
                "{listens:?}"
            );
        }
        assert!(cores.iter().all(|stage| *stage == cores[0]), "{cores:?}");
        // The kernel ends a thread that runs without a pause.
        for of_stage in &limits {
            let bound = of_stage
                .lines()
                .find_map(|line| line.strip_prefix("Max realtime timeout"));
            let soft = bound.and_then(|line| line.split_whitespace().next());
            assert_ne!(soft, Some("unlimited"), "{of_stage}");
        }
        assert!(cores[0].parse::<usize>().is_ok(), "{cores:?}");
    }
}

#[test]
fn threads_that_decode_pictures_stay_common_ones() {
    let bench = Bench::new();
    let pictures = bench.path("pictures");
    fs::create_dir(&pictures).expect("a folder");
    for number in 0..40 {
        image::GrayImage::new(640, 480)
            .save(pictures.join(format!("{number}.png")))
            .expect("written");
    }
    let chain = bench.start(&["--source", "pictures", "--fps", "10", "--realtime"]);
    let threads = scheduling(chain.ids[0]);
    chain.signal_chain(Signal::INT);
    chain.end();
    // The stage's own thread, the decoder's, and the one that listens to the chain.
    assert_eq!(threads.len(), 3, "{threads:?}");
    let common = threads.iter().filter(|thread| **thread == (0, 0));
    assert!(common.count() >= 2, "{threads:?}");
}

/// Copies the binary to where any user may run it, and returns a command that runs it without
/// privileges.
fn as_nobody(bench: &Bench, arguments: &[&str]) -> Command {
    let binary = bench.path("lariat");
    fs::copy(env!("CARGO_BIN_EXE_lariat"), &binary).expect("copied");
    let open = fs::Permissions::from_mode(0o755);
    fs::set_permissions(bench.folder.path(), open).expect("mine");
    let mut command = Command::new(binary);
    command
        .args(arguments)
        .env("LARIAT_DOMAIN", &bench.domain)
        .current_dir(bench.folder.path())
        .stdin(Stdio::null());
    if rustix::process::geteuid().is_root() {
        command.uid(65534).gid(65534);
    }
    command
}

#[test]
fn a_user_without_rights_gets_one_sentence_and_the_chain() {
    let bench = Bench::new();
    let output = as_nobody(&bench, &["run", "--realtime", "--frames", "5"])
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("5 frames received"));
    // The limits of this user may allow everything.
    assert!(said.matches("may not have").count() <= 1, "{said}");
    bench.assert_nothing_is_left();
}

#[test]
fn a_stage_of_realtime_priority_rests_however_much_there_is_to_do() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--scheduling", "fifo", "--fps", "max", "--duration", "60"]);
    chain.wait_for_frames();
    let capture = chain.ids[0] as u32;
    let deadline = Instant::now() + Duration::from_secs(30);
    let before = sleeps(capture);
    while sleeps(capture) < before + 3 {
        assert!(Instant::now() < deadline, "capture never sleeps");
        std::thread::sleep(Duration::from_millis(10));
    }
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
}

#[test]
fn readers_that_look_before_they_sleep_lose_nothing() {
    let bench = Bench::new();
    let arguments = [
        "run",
        "--wake",
        "spin",
        "--lossless",
        "--fps",
        "max",
        "--frames",
        "200",
    ];
    let output = bench.run(&[&arguments[..], &["--out", "out"]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_eq!(bench.summary("out")["frames"]["received"], 200);
    bench.assert_nothing_is_left();
}

#[test]
fn without_frames_no_stage_is_ever_woken() {
    let bench = Bench::new();
    let mut stages = STAGES[1..].iter().map(|stage| {
        let mut command = bench.command(&[stage]);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().expect("the binary runs")
    });
    let mut stages = [(); 3].map(|()| stages.next().expect("three stages"));
    for stage in &stages {
        wait_until_told_by_signals(stage.id());
    }
    let counts = |stages: &[std::process::Child; 3]| {
        [0, 1, 2].map(|place: usize| sleeps(stages[place].id()))
    };
    // Wait until everything is set up and the live line has reported that nothing comes.
    let deadline = Instant::now() + Duration::from_secs(60);
    let mut before = counts(&stages);
    loop {
        std::thread::sleep(Duration::from_millis(2500));
        let now = counts(&stages);
        if now == before {
            break;
        }
        assert!(Instant::now() < deadline, "woken: {before:?} → {now:?}");
        before = now;
    }
    for stage in &mut stages {
        send(stage.id() as i32, Signal::TERM);
        assert!(stage.wait().expect("waited for").success());
    }
    bench.assert_nothing_is_left();
}

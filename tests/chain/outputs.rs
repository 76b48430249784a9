//! Output files: one rule for all commands.

use std::fs;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::{Output, Stdio};

use rustix::fs::{CWD, FileType, Mode, mknodat};

use crate::rig::Bench;

/// Every command that makes one file, without the file's name. Its picture, recording, calibration
/// and points exist.
const COMMANDS: [&[&str]; 6] = [
    &["export", "a.mcap", "--format", "csv", "--out"],
    &["export", "a.mcap", "--format", "jsonl", "--out"],
    &["export", "a.mcap", "--format", "y4m", "--out"],
    &[
        "calibrate",
        "plane",
        "--size",
        "640x480",
        "--points-file",
        "points.txt",
        "--calibration",
        "lens.yaml",
        "--out",
    ],
    &["pick", "rope.png", "--out"],
    &["snapshot", "--source", "rope.png", "--"],
];

fn bench() -> Bench {
    let bench = Bench::new();
    let recorded = bench.run(&[
        "run",
        "--fps",
        "max",
        "--frames",
        "3",
        "--lossless",
        "--record",
        "a.mcap",
    ]);
    assert!(recorded.status.success(), "{}", said(&recorded));
    let drawn = bench.run(&["snapshot", "rope.png", "--source", "rendered"]);
    assert!(drawn.status.success(), "{}", said(&drawn));
    fs::write(
        bench.path("points.txt"),
        "60 50 0 0\n590 45 297 0\n600 430 297 210\n40 440 0 210\n",
    )
    .expect("written");
    fs::write(
        bench.path("lens.yaml"),
        "image_width: 640\nimage_height: 480\nK: [600, 0, 320, 0, 600, 240, 0, 0, 1]\nD: [0, 0, 0, 0]\n",
    )
    .expect("written");
    bench
}

fn run(bench: &Bench, command: &[&str], more: &[&str]) -> Output {
    // Flags come before the words after `--`.
    let (flags, last) = command.split_at(command.len() - 1);
    match last {
        ["--"] => {
            let (names, switches): (Vec<&str>, Vec<&str>) =
                more.iter().partition(|word| !word.starts_with("--"));
            bench.run(&[flags, &switches, &["--"], &names].concat())
        }
        _ => bench.run(&[command, more].concat()),
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A name that the command accepts.
fn named(command: &[&str], stem: &str) -> String {
    let ending = match command[0] {
        "pick" | "snapshot" => "png",
        "calibrate" => "toml",
        _ => command[3],
    };
    format!("{stem}-{}.{ending}", command[0])
}

#[test]
fn a_file_that_is_there_is_kept_by_every_command_unless_force_is_said() {
    let bench = bench();
    for command in COMMANDS {
        let name = named(command, "there");
        let file = bench.path(&name);
        fs::write(&file, "old").expect("written");
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).expect("its own");
        let refused = run(&bench, command, &[&name]);
        assert_eq!(refused.status.code(), Some(1), "{command:?}");
        let sentence = format!(
            "there is a file {name} already: name another one, or overwrite it with --force"
        );
        assert!(said(&refused).contains(&sentence), "{}", said(&refused));
        assert_eq!(fs::read(&file).expect("there"), b"old");
        let forced = run(&bench, command, &[&name, "--force"]);
        assert!(forced.status.success(), "{command:?}: {}", said(&forced));
        assert!(fs::metadata(&file).expect("there").len() > 3);
        assert_eq!(fs::metadata(&file).expect("there").mode() & 0o777, 0o640);
    }
}

#[test]
fn a_pipe_is_written_into_a_link_is_followed_and_a_dash_is_standard_output() {
    let bench = bench();
    for (number, command) in COMMANDS.into_iter().enumerate() {
        let name = named(command, "whole");
        let written = run(&bench, command, &[&name]);
        assert!(written.status.success(), "{command:?}: {}", said(&written));
        let whole = fs::read(bench.path(&name)).expect("there");

        let dash = run(&bench, command, &["-"]);
        assert!(dash.status.success(), "{command:?}: {}", said(&dash));
        assert!(
            dash.stdout == whole,
            "{command:?}: more or less than the file"
        );

        let pipe = bench.path(&format!("pipe{number}"));
        mknodat(CWD, &pipe, FileType::Fifo, Mode::RWXU, 0).expect("a pipe");
        let reader = {
            let pipe = pipe.clone();
            std::thread::spawn(move || fs::read(pipe).expect("readable"))
        };
        let piped = run(&bench, command, &[&format!("pipe{number}")]);
        assert!(piped.status.success(), "{command:?}: {}", said(&piped));
        assert!(reader.join().expect("no panic") == whole, "{command:?}");
        let kind = fs::symlink_metadata(&pipe).expect("there").file_type();
        assert!(kind.is_fifo(), "{command:?}: the pipe was replaced");

        let link = named(command, "link");
        symlink(named(command, "target"), bench.path(&link)).expect("a link");
        let linked = run(&bench, command, &[&link]);
        assert!(linked.status.success(), "{command:?}: {}", said(&linked));
        let kind = fs::symlink_metadata(bench.path(&link))
            .expect("there")
            .file_type();
        assert!(kind.is_symlink(), "{command:?}: the link was replaced");
        assert!(fs::read(bench.path(&named(command, "target"))).expect("there") == whole);
    }
    // Write through a link, so that a bug in this rule replaces only the link.
    symlink("/dev/full", bench.path("full.csv")).expect("a link");
    let full = run(&bench, COMMANDS[0], &["full.csv"]);
    assert_eq!(full.status.code(), Some(1));
    assert!(
        said(&full).contains("cannot write full.csv: No space left"),
        "{}",
        said(&full)
    );
    assert!(
        fs::symlink_metadata(bench.path("full.csv"))
            .expect("there")
            .is_symlink()
    );
}

#[test]
fn what_a_command_reads_it_never_overwrites_whatever_the_name() {
    let bench = bench();
    fs::hard_link(bench.path("a.mcap"), bench.path("b.mcap")).expect("linked");
    symlink("rope.png", bench.path("link.png")).expect("a link");
    fs::create_dir(bench.path("masks")).expect("made");
    let mask = ["pick", "rope.png", "--out", "masks/rope.png"];
    assert!(bench.run(&mask).status.success());
    fs::write(bench.path("own.toml"), "[run]\nframes = 3\n").expect("written");
    let overwriting: [(&str, &[&str]); 10] = [
        (
            "a.mcap",
            &["export", "a.mcap", "--format", "csv", "--out", "./a.mcap"],
        ),
        (
            "a.mcap",
            &["export", "a.mcap", "--format", "jsonl", "--out", "b.mcap"],
        ),
        (
            "a.mcap",
            &["run", "--source", "a.mcap", "--record", "a.mcap"],
        ),
        (
            "a.mcap",
            &["run", "--source", "a.mcap", "--trace", "b.mcap"],
        ),
        (
            "rope.png",
            &["snapshot", "link.png", "--source", "rope.png"],
        ),
        ("rope.png", &["pick", "rope.png", "--out", "link.png"]),
        ("rope.png", &["trace", "rope.png", "--overlay", "."]),
        (
            "masks/rope.png",
            &[
                "trace",
                "rope.png",
                "--masks",
                "masks",
                "--overlay",
                "masks",
            ],
        ),
        (
            "own.toml",
            &["run", "--config", "own.toml", "--trace", "own.toml"],
        ),
        (
            "lens.yaml",
            &[
                "calibrate",
                "plane",
                "--points-file",
                "points.txt",
                "--calibration",
                "lens.yaml",
                "--out",
                "lens.yaml",
            ],
        ),
    ];
    for (file, command) in overwriting {
        let before = fs::read(bench.path(file)).expect("there");
        let refused = bench.run(&[command, &["--force"]].concat());
        assert_eq!(
            refused.status.code(),
            Some(1),
            "{command:?}: {}",
            said(&refused)
        );
        assert!(
            said(&refused).contains("is what is read here"),
            "{}",
            said(&refused)
        );
        assert!(
            fs::read(bench.path(file)).expect("there") == before,
            "{command:?}"
        );
    }
    bench.assert_nothing_is_left();
}

#[test]
fn what_will_not_be_writable_at_the_end_is_said_before_the_first_frame() {
    let bench = Bench::new();
    fs::write(bench.path("file"), "in the way").expect("written");
    fs::create_dir(bench.path("old")).expect("made");
    fs::write(bench.path("old/summary.json"), "{}").expect("written");
    let hopeless: [(&[&str], &str); 6] = [
        (
            &["--out", "file"],
            "cannot write to the folder file: it is a file",
        ),
        (
            &["--out", "file/report"],
            "cannot write to the folder file/report",
        ),
        (
            &["--out", "old"],
            "there is a summary.json in the folder old already",
        ),
        (&["--trace", "no/such.json"], "there is no folder no"),
        (&["--trace", "old"], "it is a folder"),
        (&["--record", "no/such.mcap"], "there is no folder no"),
    ];
    for (flags, why) in hopeless {
        let refused = bench.run(&[&["run", "--frames", "3"], flags].concat());
        assert_eq!(refused.status.code(), Some(1), "{flags:?}");
        assert!(said(&refused).contains(why), "{}", said(&refused));
        assert_eq!(said(&refused).lines().count(), 1, "{}", said(&refused));
        assert!(refused.stdout.is_empty());
    }
    // A folder that was created in vain is removed again.
    let failed = bench.run(&["run", "--source", "/dev/video4711", "--out", "new"]);
    assert!(!failed.status.success());
    assert!(!Path::new(&bench.path("new")).exists());
    assert_eq!(
        fs::read(bench.path("old/summary.json")).expect("there"),
        b"{}"
    );
    let again = bench.run(&["run", "--frames", "3", "--out", "old", "--force"]);
    assert!(again.status.success(), "{}", said(&again));
    assert!(
        fs::metadata(bench.path("old/summary.json"))
            .expect("there")
            .len()
            > 2
    );
}

#[test]
fn an_old_recording_outlives_a_new_one_that_gets_nothing() {
    let bench = bench();
    let before = fs::read(bench.path("a.mcap")).expect("there");
    let absent = ["run", "--source", "/dev/video4711", "--force", "--record"];
    for source in ["/dev/video4711", "no/such.y4m"] {
        let failed = bench.run(&["run", "--source", source, "--record", "a.mcap", "--force"]);
        assert!(!failed.status.success());
        assert!(
            fs::read(bench.path("a.mcap")).expect("there") == before,
            "{}",
            said(&failed)
        );
    }
    let waited = bench.run(&[
        "record",
        "--out",
        "a.mcap",
        "--force",
        "--duration",
        "1ms",
        "--frames",
        "0",
    ]);
    assert!(
        fs::read(bench.path("a.mcap")).expect("there") == before,
        "{}",
        said(&waited)
    );
    // An empty recording does not block the next one, either.
    assert!(
        !bench
            .run(&[&absent[..], &["new.mcap"]].concat())
            .status
            .success()
    );
    assert!(!bench.path("new.mcap").exists());
    let names = fs::read_dir(bench.folder.path()).expect("there").flatten();
    let hidden = names.filter(|file| file.file_name().to_string_lossy().starts_with('.'));
    assert_eq!(hidden.count(), 0);
    bench.assert_nothing_is_left();
}

#[test]
fn a_recording_and_a_timeline_go_to_standard_output_and_what_else_is_said_beside_them() {
    let bench = Bench::new();
    let run = ["run", "--fps", "max", "--lossless", "--frames", "20"];
    let recorded = bench.run(&[&run[..], &["--record", "-"]].concat());
    assert!(recorded.status.success(), "{}", said(&recorded));
    fs::write(bench.path("piped.mcap"), &recorded.stdout).expect("written");
    let info = bench.run(&["info", "piped.mcap", "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).expect("JSON");
    assert_eq!(info["frames"], 20, "{info}");

    let traced = bench.run(&[&run[..], &["--trace", "-"]].concat());
    let json: serde_json::Value = serde_json::from_slice(&traced.stdout).expect("JSON alone");
    assert!(json["traceEvents"].is_array());
    assert!(said(&traced).contains("received"), "{}", said(&traced));
    let both = bench.run(&[&run[..], &["--trace", "-", "--record", "-"]].concat());
    assert_eq!(both.status.code(), Some(2));
}

/// A pipe that nobody reads.
fn unread() -> std::io::PipeWriter {
    std::io::pipe().expect("a pipe").1
}

/// Runs a command that cannot print there, and must fail. Returns its error message.
fn failure(bench: &Bench, command: &[&str], stdout: impl Into<Stdio>) -> String {
    let ended = bench.command(command).stdout(stdout).output();
    let ended = ended.expect("the binary runs");
    let said = said(&ended);
    assert_eq!(ended.status.code(), Some(1), "{command:?}: {said}");
    said
}

/// Commands that print, each with its arguments.
const PRINTING: [&[&str]; 9] = [
    &["info", "a.mcap"],
    &["export", "a.mcap", "--format", "csv", "--out", "-"],
    &["replay", "a.mcap", "--check"],
    &["replay", "a.mcap", "--compare"],
    &["trace", "rope.png"],
    &["pick", "rope.png", "--force"],
    &["config", "show"],
    &["doctor"],
    &["run", "--fps", "max", "--frames", "3"],
];

#[test]
fn a_command_whose_output_nobody_reads_ends_in_order() {
    let bench = bench();
    for command in PRINTING {
        let said = failure(&bench, command, unread());
        assert!(!said.contains("panic"), "{command:?}: {said}");
        // Run a command that cannot report errors anywhere.
        let mut command = bench.command(command);
        command.stdout(Stdio::null()).stderr(unread());
        assert_eq!(
            command.status().expect("the binary runs").code(),
            Some(0),
            "{command:?}"
        );
    }
    // Files are written nevertheless.
    let plane = [
        "calibrate",
        "plane",
        "--size",
        "640x480",
        "--points-file",
        "points.txt",
        "--out",
        "plane.toml",
    ];
    let overlays = ["trace", "rope.png", "rope.png", "--overlay", "drawn"];
    for (command, file) in [(&plane[..], "plane.toml"), (&overlays, "drawn/rope-2.png")] {
        failure(&bench, command, unread());
        assert!(bench.path(file).exists(), "{command:?}");
    }
    bench.assert_nothing_is_left();
}

#[test]
fn output_that_cannot_be_written_is_said_and_is_no_success() {
    let bench = bench();
    for command in PRINTING {
        let full = fs::File::options()
            .write(true)
            .open("/dev/full")
            .expect("there");
        let more: &[_] = match command[0] {
            "run" => &["--out", "out"],
            _ => &[],
        };
        let said = failure(&bench, &[command, more].concat(), full);
        assert!(said.contains("No space left"), "{command:?}: {said}");
    }
    // Everything that could be written exists.
    assert!(bench.path("out/summary.json").exists());
    bench.assert_nothing_is_left();
}

#[test]
fn a_chain_whose_output_nobody_reads_any_more_ends_with_every_frame_accounted_for() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--out", "out"]);
    chain.wait_for_frames();
    drop(chain.process.stdout.take());
    let ended = chain.process.wait().expect("waited for");
    assert_eq!(ended.code(), Some(1), "its report was lost");
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

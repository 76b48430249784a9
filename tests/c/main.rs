//! Programs in C and C++ with the library, its header and its package files, as a user installs
//! them. They are built by the compiler alone, by pkg-config and by CMake, and run next to the real
//! chain. Without a C compiler nothing is tested; `.ci/run` makes sure that there is one.

#[path = "../chain/rig.rs"]
#[allow(dead_code, reason = "these tests need less of it than the chain's")]
mod rig;

#[path = "../../examples/message_of_offsets.rs"]
mod message_of_offsets;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use lariat_wire::{
    DESCRIPTORS, DESCRIPTORS3, Delivery, Descriptors, Descriptors3, Domain, Place, Rig, Writer,
    now_ns,
};
use rig::Bench;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];

/// Returns whether a program is installed. If not, tests that need it are skipped, which is
/// reported.
fn has(program: &str) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok();
    if !there {
        eprintln!("{program} is not installed: what needs it is not tested");
    }
    there
}

/// The library as a user installs it.
struct Installed {
    bench: Bench,
    prefix: PathBuf,
}

impl Installed {
    /// Installs it; `None` without a C compiler.
    fn new() -> Option<Self> {
        if !has("cc") {
            return None;
        }
        let bench = Bench::new();
        let prefix = bench.path("prefix");
        // Cargo puts the tests' dependencies next to the test itself.
        let this = std::env::current_exe().expect("a test has a file");
        let built = this.parent().expect("a file has a folder");
        let script = Path::new(ROOT).join("crates/c/install.sh");
        let installed = Self { bench, prefix };
        installed.succeeds(
            Command::new(script)
                .arg("--prefix")
                .arg(&installed.prefix)
                .arg("--from")
                .arg(built),
        );
        Some(installed)
    }

    /// Runs a command in the test's folder and domain, with the installed library on its paths.
    fn succeeds(&self, command: &mut Command) -> String {
        let Output {
            status,
            stdout,
            stderr,
        } = command
            .current_dir(self.bench.folder.path())
            .env("LARIAT_DOMAIN", &self.bench.domain)
            .env("LD_LIBRARY_PATH", self.prefix.join("lib"))
            .env("PKG_CONFIG_PATH", self.prefix.join("lib/pkgconfig"))
            .output()
            .expect("it runs");
        let text = [stdout, stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        assert!(status.success(), "{command:?}: {}{}", text[0], text[1]);
        text.concat()
    }

    /// Builds a program with the compiler alone.
    fn compile(&self, compiler: &str, source: &str, program: &str) -> PathBuf {
        let to = self.bench.path(program);
        let standard = if source.ends_with(".cpp") {
            "-std=c++17"
        } else {
            "-std=c11"
        };
        self.succeeds(
            Command::new(compiler)
                .args(WARNINGS)
                .arg(standard)
                .arg(Path::new(ROOT).join(source))
                .arg("-I")
                .arg(self.prefix.join("include"))
                .arg("-L")
                .arg(self.prefix.join("lib"))
                .args(["-llariat", "-lm", "-o"])
                .arg(&to),
        );
        to
    }

    /// Compiler flags from pkg-config.
    fn flags(&self, options: &[&str]) -> Vec<String> {
        let mut command = Command::new("pkg-config");
        let said = self.succeeds(command.args(options).args(["--cflags", "--libs", "lariat"]));
        said.split_whitespace().map(String::from).collect()
    }

    /// Runs a program next to a chain that draws a rope, until the program has read 20 frames and
    /// steered.
    fn follows(&self, program: impl AsRef<OsStr>) -> String {
        let chain = self
            .bench
            .start(&["--fps", "100", "--duration", "60", "--filter"]);
        let said = self.succeeds(Command::new(program).args(["default", "20"]));
        chain.signal_chain(rustix::process::Signal::TERM);
        assert!(chain.end().status.success());
        assert!(said.contains("move "), "{said}");
        said
    }
}

#[test]
fn a_loop_in_c_follows_the_rope_with_the_compiler_alone() {
    let Some(installed) = Installed::new() else {
        return;
    };
    let program = installed.compile("cc", "examples/c/follow.c", "follow");
    let said = installed.follows(program);
    // The drawn rope never leaves the image, so its middle is inside.
    let moves = said.lines().filter_map(|line| line.strip_prefix("move "));
    for text in moves {
        let velocity: Vec<f64> = text
            .split_whitespace()
            .filter_map(|word| word.parse().ok())
            .collect();
        assert!(
            matches!(velocity[..], [x, y] if x.abs() <= 320.0 && y.abs() <= 240.0),
            "{text}"
        );
    }
    installed.bench.assert_nothing_is_left();
}

#[test]
fn a_loop_with_a_poll_of_its_own_keeps_its_beat() {
    let Some(installed) = Installed::new() else {
        return;
    };
    let program = installed.compile("cc", "examples/c/poll.c", "poll");
    installed.follows(program);
    installed.bench.assert_nothing_is_left();
}

#[test]
fn pkg_config_finds_the_library_for_c_and_for_c_plus_plus() {
    let Some(installed) = Installed::new() else {
        return;
    };
    if !has("pkg-config") || !has("c++") {
        return;
    }
    let flags = installed.flags(&[]);
    let to = installed.bench.path("follow");
    installed.succeeds(
        Command::new("c++")
            .args(WARNINGS)
            .arg("-std=c++17")
            .arg(Path::new(ROOT).join("examples/c/follow.cpp"))
            .args(flags)
            .arg("-o")
            .arg(&to),
    );
    installed.follows(to);
}

#[test]
fn the_static_library_needs_nothing_beside_the_program() {
    let Some(installed) = Installed::new() else {
        return;
    };
    if !has("pkg-config") {
        return;
    }
    // Without the shared library, the linker uses the static one.
    for file in ["liblariat.so", "liblariat.so.1"] {
        std::fs::remove_file(installed.prefix.join("lib").join(file)).unwrap();
    }
    let flags = installed.flags(&["--static"]);
    let to = installed.bench.path("states");
    let source = Path::new(ROOT).join("tests/c/states.c");
    installed.succeeds(
        Command::new("cc")
            .arg(source)
            .args(flags)
            .arg("-lm")
            .arg("-o")
            .arg(&to),
    );
    assert_eq!(installed.succeeds(&mut Command::new(to)).trim(), "0 wrong");
}

#[test]
fn cmake_finds_the_package_in_its_version() {
    let Some(installed) = Installed::new() else {
        return;
    };
    if !has("cmake") || !has("c++") {
        return;
    }
    let prefix = installed.prefix.display();
    let source = Path::new(ROOT).join("examples/c");
    installed.succeeds(
        Command::new("cmake")
            .args(["-S", &source.display().to_string(), "-B", "build"])
            .arg(format!("-DCMAKE_PREFIX_PATH={prefix}")),
    );
    installed.succeeds(Command::new("cmake").args(["--build", "build"]));
    installed.follows(installed.bench.path("build/follow_cpp"));
    // A version that is not installed is not found.
    std::fs::write(
        installed.bench.path("CMakeLists.txt"),
        "cmake_minimum_required(VERSION 3.16)\nproject(other C)\nfind_package(lariat 99 REQUIRED)\n",
    )
    .unwrap();
    let refused = Command::new("cmake")
        .args(["-S", ".", "-B", "other"])
        .arg(format!("-DCMAKE_PREFIX_PATH={prefix}"))
        .current_dir(installed.bench.folder.path())
        .output()
        .unwrap();
    assert!(!refused.status.success());
}

#[test]
fn every_field_of_a_message_is_read_in_its_place() {
    let Some(installed) = Installed::new() else {
        return;
    };
    let program = installed.compile("cc", "tests/c/layout.c", "layout");
    let domain = Domain::named(&installed.bench.domain).unwrap();
    let rig: Rig = "layout".parse().unwrap();
    let writer =
        Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins).unwrap();
    let ended = AtomicBool::new(false);
    let said = std::thread::scope(|scope| {
        let reading = scope.spawn(|| {
            let said = installed.succeeds(&mut Command::new(program));
            ended.store(true, Ordering::Relaxed);
            said
        });
        let message = message_of_offsets::message();
        while !ended.load(Ordering::Relaxed) && !reading.is_finished() {
            let mut slot = writer.slot().unwrap();
            *slot = *message;
            slot.send().unwrap();
            std::thread::park_timeout(Duration::from_millis(5));
        }
        reading.join().expect("no panic")
    });
    assert_eq!(said.trim(), "0 wrong");
}

/// Two ropes, one with a known position in 3-D.
fn ropes_in_space(sequence: u64) -> (Box<Descriptors>, Box<Descriptors3>) {
    let mut image = Box::new(Descriptors::EMPTY);
    let mut space = Box::new(Descriptors3::EMPTY);
    (image.width, image.height) = (640, 480);
    image.trace.sequence = sequence;
    image.trace.exposed_ns = now_ns();
    image.trace.captured_ns = image.trace.exposed_ns;
    image.trace.fitted_ns = image.trace.exposed_ns;
    image.trace.fitted = sequence;
    space.trace = image.trace;
    (image.count, space.count) = (2, 2);
    for (i, (flat, in_space)) in image
        .curves
        .iter_mut()
        .zip(&mut space.curves)
        .take(2)
        .enumerate()
    {
        (flat.track, in_space.track) = (i as u32 + 4, i as u32 + 4);
        flat.confidence = 1.0;
        (flat.degree, flat.count, flat.samples) = (1, 2, 120);
        flat.control_points[1] = [100.0, 0.0];
        (in_space.degree, in_space.count, in_space.samples) = (1, 2, 120);
        in_space.place = Place::Thin as u32;
    }
    let known = &mut space.curves[0];
    known.place = Place::Known as u32;
    known.length = 120.0;
    known.control_points[..2].copy_from_slice(&[[0.0, -10.0, 500.0], [100.0, -10.0, 400.0]]);
    known.covariances[1][5] = 7.0;
    (image, space)
}

#[test]
fn a_rope_in_space_is_read_where_it_is() {
    let Some(installed) = Installed::new() else {
        return;
    };
    let program = installed.compile("cc", "tests/c/space.c", "space");
    let domain = Domain::named(&installed.bench.domain).unwrap();
    let rig: Rig = "space".parse().unwrap();
    let delivery = Delivery::NewestWins;
    let image = Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &delivery).unwrap();
    let space = Writer::<Descriptors3>::create(&domain, &rig, &DESCRIPTORS3, &delivery).unwrap();
    let said = std::thread::scope(|scope| {
        let reading = scope.spawn(|| installed.succeeds(&mut Command::new(program)));
        for sequence in 1.. {
            if reading.is_finished() {
                break;
            }
            let (flat, in_space) = ropes_in_space(sequence);
            let mut slot = space.slot().unwrap();
            *slot = *in_space;
            slot.send().unwrap();
            let mut slot = image.slot().unwrap();
            *slot = *flat;
            slot.send().unwrap();
            std::thread::park_timeout(Duration::from_millis(5));
        }
        reading.join().expect("no panic")
    });
    assert_eq!(said.trim(), "0 wrong");
}

#[test]
fn what_is_asked_of_nothing_is_an_error_and_no_number() {
    let Some(installed) = Installed::new() else {
        return;
    };
    let program = installed.compile("cc", "tests/c/states.c", "states");
    assert_eq!(
        installed.succeeds(&mut Command::new(program)).trim(),
        "0 wrong"
    );
    installed.bench.assert_nothing_is_left();
}

#[test]
fn a_camera_in_c_is_a_source_of_the_chain() {
    let Some(installed) = Installed::new() else {
        return;
    };
    let camera = installed.compile("cc", "examples/c/camera.c", "camera");
    let arguments = ["--source", "external", "--lossless", "--frames", "20"];
    let chain = installed
        .bench
        .start(&[&arguments[..], &["--out", "out"]].concat());
    installed.succeeds(Command::new(camera).args(["default", "20"]));
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let frames = &installed.bench.summary("out")["frames"];
    assert_eq!(
        (&frames["received"], &frames["with_curve"]),
        (&20.into(), &20.into()),
        "{frames}"
    );
    installed.bench.assert_nothing_is_left();
}

#[test]
fn valgrind_finds_nothing() {
    let Some(installed) = Installed::new() else {
        return;
    };
    if !has("valgrind") {
        return;
    }
    let states = installed.compile("cc", "tests/c/states.c", "states");
    let follow = installed.compile("cc", "examples/c/follow.c", "follow");
    let poll = installed.compile("cc", "examples/c/poll.c", "poll");
    let script = Path::new(ROOT).join("tests/c/valgrind.sh");
    installed.succeeds(Command::new(&script).arg(states));
    let camera = installed.compile("cc", "examples/c/camera.c", "camera");
    installed.succeeds(Command::new(&script).arg(camera).args(["other", "5"]));
    let chain = installed
        .bench
        .start(&["--fps", "30", "--duration", "120", "--filter"]);
    for program in [follow, poll] {
        installed.succeeds(Command::new(&script).arg(program).args(["default", "20"]));
    }
    chain.signal_chain(rustix::process::Signal::TERM);
    assert!(chain.end().status.success());
}

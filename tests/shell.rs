//! Files for packages: completions that their shells understand, a manual page for each command,
//! and a version that identifies the build.

#[allow(dead_code, reason = "written for the chain's own tests")]
#[path = "chain/rig.rs"]
mod rig;

use rig::Bench;
use std::fs;
use std::process::{Command, Output};

fn text(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout.clone()).expect("text")
}

/// Runs a program, if it is installed.
fn ask(program: &str, words: &[&str], bench: &Bench) -> Option<Output> {
    let mut command = Command::new(program);
    command.args(words).current_dir(bench.folder.path());
    command.output().ok()
}

/// Commands listed in the help.
fn commands(bench: &Bench) -> Vec<String> {
    let help = text(&bench.run(&["-h"]));
    let list = help.lines().skip_while(|line| !line.starts_with("Run "));
    let list = list.take_while(|line| !line.is_empty());
    // A group's title, names separated by commas, and a few words.
    let names = list.flat_map(|line| line[9..37].trim_end().split(", "));
    names.map(str::to_owned).collect()
}

#[test]
fn the_long_version_says_commit_and_vectors_and_the_short_one_is_a_line() {
    let bench = Bench::new();
    let short = text(&bench.run(&["-V"]));
    assert_eq!(short, concat!("lariat ", env!("CARGO_PKG_VERSION"), "\n"));
    let long = text(&bench.run(&["--version"]));
    let lines: Vec<_> = long.lines().collect();
    let [first, commit, simd] = lines[..] else {
        panic!("{long}");
    };
    assert_eq!(first, short.trim_end());
    let commit = commit.strip_prefix("commit: ").expect(commit);
    let is_hash = commit.len() >= 12 && commit.chars().all(|c| c.is_ascii_hexdigit());
    assert!(is_hash || commit == "unknown", "{commit}");
    let simd = simd.strip_prefix("SIMD:   ").expect(simd);
    assert!(
        ["AVX-512", "AVX2", "SSE2", "NEON", "none"].contains(&simd),
        "{simd}"
    );
}

#[test]
fn every_shell_understands_its_completions_and_every_command_is_in_them() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish"] {
        let script = text(&bench.run(&["completions", shell]));
        for command in commands(&bench) {
            assert!(
                script.contains(&command),
                "{shell} does not complete {command}"
            );
        }
        fs::write(bench.path(shell), script).expect("written");
        // `-n`: parse only, without executing.
        if let Some(output) = ask(shell, &["-n", shell], &bench) {
            assert!(
                output.status.success() && output.stderr.is_empty(),
                "{output:?}"
            );
        }
    }
}

#[test]
fn bash_completes_commands_flags_and_values() {
    let bench = Bench::new();
    let script = text(&bench.run(&["completions", "bash"]));
    fs::write(bench.path("bash"), script).expect("written");
    for (typed, expected) in [
        ("lariat rep", "replay"),
        ("lariat run --loss", "--lossless"),
        ("lariat completions z", "zsh"),
        ("lariat config ch", "check"),
    ] {
        let line = format!(
            "source ./bash; COMP_WORDS=({typed}); COMP_CWORD=$((${{#COMP_WORDS[@]}}-1)); \
             _lariat lariat \"${{COMP_WORDS[COMP_CWORD]}}\" \"${{COMP_WORDS[COMP_CWORD-1]}}\"; echo \"${{COMPREPLY[@]}}\""
        );
        let Some(output) = ask("bash", &["-c", &line], &bench) else {
            return;
        };
        assert_eq!(text(&output).trim(), expected, "{typed}");
    }
}

#[test]
fn every_command_has_a_manual_page_that_troff_reads_without_a_word() {
    let bench = Bench::new();
    text(&bench.run(&["man", "pages"]));
    let below = [
        "config-init",
        "topic-echo",
        "calibrate-plane",
        "service-install",
    ];
    let names = commands(&bench);
    assert!(names.len() > 18, "{names:?}");
    for name in names.iter().map(String::as_str).chain(below) {
        let file = format!("pages/lariat-{name}.1");
        let page = fs::read_to_string(bench.path(&file)).expect(&file);
        assert!(page.contains(".SH NAME"), "{page}");
        if let Some(output) = ask(
            "groff",
            &["-Kutf8", "-man", "-Tutf8", "-ww", "-z", &file],
            &bench,
        ) {
            assert!(
                output.status.success() && output.stderr.is_empty(),
                "{output:?}"
            );
        }
    }
    let first = fs::read_to_string(bench.path("pages/lariat.1")).expect("a page");
    assert!(first.contains(env!("CARGO_PKG_VERSION")), "{first}");
    assert!(!first.contains("SIMD"), "a page is of no machine: {first}");
    assert!(!bench.path("pages/lariat-man.1").exists(), "hidden");
    let again = bench.run(&["man", "pages"]);
    assert!(!again.status.success(), "pages that are there are kept");
}

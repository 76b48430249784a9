//! Two users on one machine: each has a separate domain, and neither blocks the other.
//!
//! Only root can act as two users; otherwise these tests report that they were skipped.

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, SystemTime};

use rustix::process::{Signal, geteuid};

use crate::rig::Bench;

/// Two users that no other test uses, if this process may become other users.
fn users() -> Option<[u32; 2]> {
    if !geteuid().is_root() {
        eprintln!("left out: only root can run lariat as two users");
        return None;
    }
    // Below 65,536, which is the limit in containers.
    let first = 40_000 + std::process::id() % 5_000;
    Some([first, first + 10_000])
}

/// A bench for a user, in the default domain of that user.
fn bench_of(user: u32) -> Bench {
    let mut bench = Bench::new();
    bench.domain = user.to_string();
    let everyone = fs::Permissions::from_mode(0o777);
    fs::set_permissions(bench.folder.path(), everyone).expect("its own folder");
    // Other users may not have access to cargo's folder.
    fs::copy(env!("CARGO_BIN_EXE_lariat"), bench.path("lariat")).expect("copied");
    bench
}

fn command_of(bench: &Bench, arguments: &[&str]) -> Command {
    let user = bench.domain.parse().expect("a user's number");
    let mut command = bench.command_of(bench.path("lariat"), arguments);
    command.env_remove("LARIAT_DOMAIN").uid(user).gid(user);
    command
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn two_users_run_the_same_rig_at_once_and_neither_sees_the_other() {
    let Some(users) = users() else { return };
    let benches = users.map(bench_of);
    let mut chains = benches
        .each_ref()
        .map(|bench| bench.start_command(command_of(bench, &["run", "--source", "rendered"])));
    for chain in &mut chains {
        chain.wait_for_frames();
    }
    // Shells with and without XDG_RUNTIME_DIR belong to the same user.
    for (bench, chain) in benches.iter().zip(&chains) {
        for runtime in [None, Some("/run/user/1")] {
            let mut command = command_of(bench, &["topic", "list", "--json"]);
            command.env_remove("XDG_RUNTIME_DIR");
            command.envs(runtime.map(|folder| ("XDG_RUNTIME_DIR", folder)));
            let output = command.output().expect("the binary runs");
            let listed = String::from_utf8_lossy(&output.stdout).into_owned();
            let capture = chain.ids[0].to_string();
            assert!(listed.contains(&capture), "{listed} {}", text(&output));
        }
    }
    for chain in &chains {
        chain.signal_chain(Signal::INT);
    }
    for (chain, bench) in chains.into_iter().zip(&benches) {
        let ended = chain.end();
        assert!(ended.status.success(), "{}", ended.stderr);
        bench.assert_nothing_is_left();
    }
}

#[test]
fn a_file_that_another_user_put_into_a_domain_is_named_and_removed_by_root() {
    let Some([user, other]) = users() else { return };
    let bench = bench_of(user + 2_500);
    let run = || {
        let mut command = command_of(&bench, &["run", "--source", "rendered", "--frames", "3"]);
        command.output().expect("the binary runs")
    };
    // The transport's own file, made beforehand, blocked everybody who joined.
    let name = format!(
        "lariat_{}_9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt",
        bench.domain
    );
    let file = Path::new("/dev/shm").join(name);
    fs::write(&file, [0; 16]).expect("root may");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o666)).expect("root may");
    chown(&file, Some(other), Some(other)).expect("root may");
    let refused = run();
    assert_eq!(refused.status.code(), Some(1), "{}", text(&refused));
    let said = text(&refused);
    let whose = format!("belongs to user {other}");
    for word in [&whose[..], "sudo lariat doctor --clean"] {
        assert!(said.contains(word), "{word}: {said}");
    }
    let root = Bench::new();
    let cleaned = root.run(&["doctor", "--clean"]);
    assert!(!file.exists(), "{}", text(&cleaned));
    let ran = run();
    assert!(ran.status.success(), "{}", text(&ran));
    bench.assert_nothing_is_left();
}

#[test]
fn nothing_of_a_running_chain_is_open_to_other_users() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--source", "rendered"]);
    chain.wait_for_frames();
    let prefix = format!("lariat_{}_", bench.domain);
    let shared = fs::read_dir("/dev/shm").expect("shared memory").flatten();
    let own: Vec<_> = shared
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix))
        .collect();
    assert!(own.len() > 10);
    for entry in own {
        let mode = entry.metadata().expect("there").mode();
        assert_eq!(mode & 0o077, 0, "{entry:?}");
    }
    let folder = fs::metadata(format!("/tmp/lariat-{}", bench.domain)).expect("there");
    assert_eq!(folder.mode() & 0o077, 0);
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}

#[test]
fn settings_that_another_user_put_into_the_folder_are_not_read_unless_they_are_named() {
    let Some([user, other]) = users() else { return };
    let bench = bench_of(user + 1_250);
    let settings = bench.path("lariat.toml");
    fs::write(&settings, "[fit]\nno_such_setting = 1\n").expect("root may");
    chown(&settings, Some(other), Some(other)).expect("root may");
    let run = |more: &[&str]| {
        let arguments = [&["run", "--source", "rendered", "--frames", "3"], more].concat();
        command_of(&bench, &arguments)
            .output()
            .expect("the binary runs")
    };
    let ran = run(&[]);
    let said = text(&ran);
    assert!(ran.status.success(), "{said}");
    let words = said.split_whitespace().collect::<Vec<_>>().join(" ");
    let sentence = format!("lariat.toml in this folder belongs to user {other}, and is not read");
    assert!(words.contains(&sentence), "{words}");
    let named = run(&["--config", "lariat.toml"]);
    assert_eq!(named.status.code(), Some(2), "{}", text(&named));
    bench.assert_nothing_is_left();
}

#[test]
fn the_domain_of_another_user_is_refused_with_whose_it_is_and_what_to_do() {
    let Some([user, _]) = users() else { return };
    let roots = Bench::new();
    let ran = roots.run(&["run", "--source", "rendered", "--frames", "3"]);
    assert!(ran.status.success(), "{}", text(&ran));

    let bench = bench_of(user + 5_000);
    let run = || {
        let mut command = command_of(&bench, &["run", "--source", "rendered", "--frames", "3"]);
        command.env("LARIAT_DOMAIN", &roots.domain);
        command.output().expect("the binary runs")
    };
    let refused = run();
    assert!(!refused.status.success());
    let said = text(&refused);
    let folder = format!("/tmp/lariat-{}", roots.domain);
    for word in [&folder[..], "belongs to root", "lariat doctor --clean"] {
        assert!(said.contains(word), "{word}: {said}");
    }

    // A domain that nobody uses any more is removed by the command in the message.
    let minute_ago = SystemTime::now() - Duration::from_secs(60);
    for entry in fs::read_dir(&folder).expect("there").flatten() {
        let file = fs::File::open(entry.path()).expect("root's");
        file.set_modified(minute_ago).expect("root's");
    }
    let file = fs::File::open(&folder).expect("root's");
    file.set_modified(minute_ago).expect("root's");
    let cleaned = roots
        .command(&["doctor", "--clean"])
        .env("LARIAT_DOMAIN", format!("{}x", roots.domain))
        .output()
        .expect("the binary runs");
    assert!(cleaned.status.success(), "{}", text(&cleaned));
    let ran = run();
    assert!(ran.status.success(), "{}", text(&ran));

    // Root cannot enter a user's domain either, because root's files would block that user.
    let mut command = roots.command(&["topic", "list"]);
    command.env("LARIAT_DOMAIN", &bench.domain);
    let refused = command.output().expect("the binary runs");
    assert!(!refused.status.success());
    let said = text(&refused);
    assert!(
        said.contains(&format!("the domain of user {}", bench.domain)),
        "{said}"
    );
    let _ = fs::remove_dir_all(format!("/tmp/lariat-{}x", roots.domain));
}

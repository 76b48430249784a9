//! A process that is killed while it joins or leaves a rig blocks no other process, and nothing of
//! it remains. Short form of `tests/kills/kills.py`, which kills at each system call.

use std::fs::{self, File, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use lariat_wire::*;

/// Far more than a process may wait; anything longer is a hang.
const HANGS: Duration = Duration::from_secs(20);
/// Environment variable with the domain of the reader that is killed.
const VICTIM: &str = "LARIAT_TEST_VICTIM";
const HASH: &str = "0354a209029e7d094a819e2d4030ea331e6caaf0";

fn name(what: &str) -> String {
    format!("{what}{}", std::process::id())
}

fn root(domain: &str) -> PathBuf {
    Path::new("/tmp").join(format!("lariat-{domain}"))
}

/// The files of a domain, in `/dev/shm` and in its folder.
fn files(domain: &str) -> Vec<PathBuf> {
    fn below(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                below(&entry.path(), found);
            } else {
                found.push(entry.path());
            }
        }
    }
    let mut found = Vec::new();
    below(&root(domain), &mut found);
    let prefix = format!("lariat_{domain}_");
    let shared = fs::read_dir("/dev/shm").expect("Linux has it").flatten();
    let shared = shared.filter(|file| file.file_name().to_string_lossy().starts_with(&prefix));
    found.extend(shared.map(|file| file.path()));
    found
}

/// Joins and leaves a domain; an error if it hangs.
fn visit(domain: &str) -> Result<(), String> {
    let domain = domain.to_owned();
    let (send, receive) = mpsc::channel();
    thread::spawn(move || {
        let visited = Domain::named(&domain).and_then(|domain| {
            Receiver::descriptors(&domain, &Rig::default())?;
            domain.channels()
        });
        let _ = send.send(visited.map(drop).map_err(|cause| cause.to_string()));
    });
    receive
        .recv_timeout(HANGS)
        .unwrap_or(Err("it hangs".into()))
}

fn leave_with(path: &Path, text: &str, mode: u32) {
    fs::create_dir_all(path.parent().expect("a folder")).expect("it is ours");
    fs::write(path, text).expect("it is ours");
    fs::set_permissions(path, Permissions::from_mode(mode)).expect("it is ours");
}

#[test]
fn what_the_dead_left_half_made_is_removed_beside_the_living() {
    let name = name("f");
    let domain = Domain::named(&name).unwrap();
    let _reader = Receiver::descriptors(&domain, &Rig::default()).unwrap();
    let living = files(&name);
    let prefix = format!("lariat_{name}_");
    let (shared, root) = (Path::new("/dev/shm"), root(&name));
    let nodes = root.join("nodes");
    // Shared memory without a size, one with a size but not yet filled, and a complete one of a
    // port.
    leave_with(&shared.join(format!("{prefix}{HASH}_1.dynamic")), "", 0o200);
    leave_with(
        &shared.join(format!("{prefix}{HASH}_2_3.connection")),
        "x",
        0o200,
    );
    leave_with(
        &shared.join(format!("{prefix}{HASH}_4.event_mgmt")),
        "x",
        0o600,
    );
    leave_with(&root.join(format!("{prefix}4.event")), "", 0o600);
    // A half-written file of a service, and a complete one that belongs to no node.
    leave_with(
        &root.join(format!("services/{prefix}{HASH}.service")),
        "",
        0o600,
    );
    // A node about to start, one that has just ended, and one in between.
    leave_with(&nodes.join(format!("5/{prefix}node.details")), "x", 0o600);
    leave_with(
        &nodes.join(format!("{prefix}6.node_monitor_context")),
        "",
        0o200,
    );
    leave_with(&nodes.join(format!("{prefix}7.node_monitor")), "", 0o600);
    leave_with(&nodes.join(format!("7/{prefix}8.port_tag")), "", 0o400);
    let before = files(&name).len() - living.len();
    assert_eq!(before, 9);
    visit(&name).unwrap();
    let mut after = files(&name);
    after.retain(|path| !living.contains(path));
    assert_eq!(after, Vec::<PathBuf>::new());
    assert!(!nodes.join("5").exists() && !nodes.join("7").exists());
}

#[test]
fn shared_memory_that_never_got_a_size_holds_up_nobody() {
    let name = name("z");
    let domain = Domain::named(&name).unwrap();
    let counter = format!(
        "/dev/shm/lariat_{name}_9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt"
    );
    File::create(&counter).expect("it is ours");
    visit(&name).unwrap();
    assert!(!Path::new(&counter).exists());
    drop(domain);
}

#[test]
fn the_last_one_out_leaves_no_file_whatever_the_dead_left() {
    let name = name("l");
    let domain = Domain::named(&name).unwrap();
    let stray = format!("/dev/shm/lariat_{name}_{HASH}_9.data");
    leave_with(Path::new(&stray), "x", 0o600);
    drop(domain);
    assert_eq!(files(&name), Vec::<PathBuf>::new());
}

#[test]
fn who_stands_still_in_the_door_is_named() {
    let name = name("s");
    let domain = Domain::named(&name).unwrap();
    let door = File::open(root(&name)).unwrap();
    door.lock().unwrap();
    let refused = Domain::named(&name).unwrap_err().to_string();
    let me = format!("process {} (", std::process::id());
    assert!(refused.starts_with(&me), "{refused}");
    drop(door);
    visit(&name).unwrap();
    drop(domain);
}

#[test]
fn a_reader_that_is_killed_at_any_moment_leaves_the_rig_as_it_was() {
    let name = name("k");
    // A fixed generator, so that each run kills at the same moments.
    let mut seed = 1_u64;
    let mut alive = 0;
    for round in 0..60 {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1);
        let mut victim = victim_of(&name).spawn().unwrap();
        thread::sleep(Duration::from_micros(2_000 + (seed >> 33) % 12_000));
        victim.kill().unwrap();
        alive += usize::from(!victim.wait().unwrap().success());
        visit(&name).unwrap_or_else(|cause| panic!("round {round}: {cause}"));
        assert_eq!(files(&name), Vec::<PathBuf>::new(), "round {round}");
    }
    assert!(alive > 0, "none lived when it was to be killed");
}

#[test]
fn settings_of_the_transport_in_the_current_folder_change_nothing() {
    let name = name("c");
    let here = std::env::temp_dir().join(format!("lariat-settings-{}", std::process::id()));
    fs::create_dir_all(here.join("config")).unwrap();
    let settings = "[global.node]\ndirectory = \"elsewhere\"\n";
    fs::write(here.join("config/iceoryx2.toml"), settings).unwrap();
    let visited = victim_of(&name).current_dir(&here).status().unwrap();
    assert!(visited.success());
    assert!(root(&name).join("nodes").exists());
    assert!(!root(&name).join("elsewhere").exists());
    fs::remove_dir_all(here).unwrap();
}

/// Runs this program as a process that joins and leaves the domain repeatedly.
fn victim_of(domain: &str) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(["--exact", "kills::victim", "--include-ignored"])
        .env(VICTIM, domain)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}

#[test]
#[ignore = "it is started by the tests before"]
fn victim() {
    let name = std::env::var(VICTIM).expect("it was started by a test");
    let until = Instant::now() + Duration::from_secs(1);
    while Instant::now() < until {
        visit(&name).unwrap();
    }
}

//! What a process that is killed at the wrong moment leaves, and what iceoryx2 0.10 makes of it: `cargo run --release` here.
//!
//! Each state is that between two neighbouring system calls, made by hand so that it is there every time; `strace -e
//! inject=ftruncate:signal=KILL:when=1` makes the first one of any program on iceoryx2. Everything is in a domain of its own.

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use iceoryx2::node::NodeCreationFailure;
use iceoryx2::prelude::*;

/// Ten times the `creation_timeout` that the library promises.
const PATIENCE: Duration = Duration::from_secs(5);

fn config(name: &str) -> Config {
    let mut config = Config::default();
    config.global.prefix = FileName::new(format!("half_{name}_").as_bytes()).unwrap();
    let root = format!("/tmp/half-made-{name}");
    config
        .global
        .set_root_path(&Path::new(root.as_bytes()).unwrap());
    config
}

/// What becomes of something that ought to end, one way or the other.
fn outcome(work: impl FnOnce() -> String + Send + 'static) -> String {
    let (send, receive) = mpsc::channel();
    thread::spawn(move || send.send(work()));
    let in_time = receive.recv_timeout(PATIENCE);
    in_time.unwrap_or_else(|_| format!("has not returned after {PATIENCE:?}"))
}

fn node(config: &Config) -> Result<Node<ipc::Service>, NodeCreationFailure> {
    NodeBuilder::new().config(config).create()
}

fn event(node: &Node<ipc::Service>) -> String {
    let service = node.service_builder(&"a".try_into().unwrap()).event();
    format!("{:?}", service.open_or_create().map(|_| "opened"))
}

/// Killed between `shm_open` and `ftruncate`: the loop in `dynamic_storage/posix_shared_memory.rs`, `open_impl`, has no limit where
/// `MappingSizeIsZero` is matched.
fn memory_without_a_size() {
    let config = config("size");
    drop(node(&config).unwrap());
    for entry in fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry
            .file_name()
            .to_string_lossy()
            .starts_with("half_size_")
        {
            fs::File::create(entry.path()).unwrap();
        }
    }
    let made = outcome(move || format!("{:?}", node(&config).map(|_| "made")));
    println!("node, its counter's shared memory without a size: {made}");
}

/// Killed between the creation of a service's file and its last `fchmod`: no later process can open or make the service, and nothing
/// in the library removes it.
fn service_half_written() {
    let config = config("file");
    let node = node(&config).unwrap();
    let service = node.service_builder(&"a".try_into().unwrap()).event();
    let service = service.create().unwrap();
    let folder = PathBuf::from("/tmp/half-made-file/services");
    let file = fs::read_dir(&folder).unwrap().flatten().next().unwrap();
    drop(service);
    fs::write(file.path(), "").unwrap();
    fs::set_permissions(file.path(), Permissions::from_mode(0o600)).unwrap();
    println!("service, its file half written: {}", event(&node));
    let cleaned = node.try_cleanup_dead_nodes();
    println!("  and after {cleaned:?}: {}", event(&node));
}

/// Killed while it leaves, after `node.details` was removed and before its monitor's files were: `remove_stale_resources_impl` looks for the
/// node in the domain of the global configuration then, and says that it was cleaned up.
fn node_half_removed() {
    let config = config("node");
    let node = node(&config).unwrap();
    let nodes = PathBuf::from("/tmp/half-made-node/nodes");
    for (ending, text, mode) in [
        ("", &[][..], 0o600),
        ("_owner_lock", &[][..], 0o600),
        ("_context", &[0; 16][..], 0o400),
    ] {
        let path = nodes.join(format!("half_node_7.node_monitor{ending}"));
        fs::write(&path, text).unwrap();
        fs::set_permissions(&path, Permissions::from_mode(mode)).unwrap();
    }
    let cleaned = node.try_cleanup_dead_nodes();
    let left = nodes.join("half_node_7.node_monitor").exists();
    println!("node half removed: {cleaned:?}, and its files are there: {left}");
}

fn main() {
    set_log_level(LogLevel::Fatal);
    service_half_written();
    node_half_removed();
    memory_without_a_size();
    for entry in fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with("half_") {
            let _ = fs::remove_file(entry.path());
        }
    }
    for name in ["size", "file", "node"] {
        let _ = fs::remove_dir_all(format!("/tmp/half-made-{name}"));
    }
    // One thread still waits.
    std::process::exit(0);
}

//! What dead processes left in a domain, half made, whole or half removed, is removed while others live in it; and all of it when
//! nobody does.
//!
//! Whoever calls this is passing the [`door`](crate::door): no other process makes or removes anything meanwhile. The transport's own
//! clean-up takes what a process left that was killed in the middle of its life. It is not safe against kills at
//! other moments: each state that a death between two system calls leaves is told here by what the transport reads it from.
//!
//! | left | known by | otherwise |
//! |---|---|---|
//! | shared memory half made | no size, or not yet readable | whoever opens it waits without end |
//! | a service's file half written | its permissions | `HangsInCreation` |
//! | a node half made or half removed | no lock is held on its file, or its files are not all there | it is no node to the transport, and its ports stay |
//! | a service without nodes | no living node has its tag | `IsMarkedForDestruction` |
//! | a port's memory and socket | no living node has its tag | they stay |

use std::collections::BTreeSet;
use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use iceoryx2::node::{DeadNodeView, NodeDetails, NodeState, NodeView};
use iceoryx2::prelude::*;

use crate::domain::root_of;
use crate::door::Passing;
use crate::leftovers::mapped_files;
use crate::memory::SHM;
use crate::roster;

/// What a file's owner may do with shared memory that is whole.
const READABLE: u32 = 0o400;
/// The file of a service, a node or a tag can be written until it is whole.
const HALF_WRITTEN: u32 = 0o600;
/// What a node's monitor has beside its own file.
const OWNER_LOCK: &str = "_owner_lock";
const CONTEXT: &str = "_context";

/// Finishes what the dead began.
pub(crate) fn finish(config: &Config, passing: &Passing) {
    remove_half_made(config, passing);
    let domain = Paths::new(config);
    remove_dead_nodes(config, &domain);
    let nodes = living_nodes(config);
    let tags = domain.tags(&nodes);
    let services = remove_left_services(&domain, &tags);
    remove_left_ports(&domain, &tags, &services);
    roster::sweep(config);
}

/// Removes what a process was about to make when it was killed: nobody can open it, and who tries may wait without end.
pub(crate) fn remove_half_made(config: &Config, _passing: &Passing) {
    let domain = Paths::new(config);
    for path in domain.shared() {
        let is_half_made = fs::symlink_metadata(&path)
            .is_ok_and(|data| data.len() == 0 || data.mode() & READABLE == 0);
        if is_half_made {
            let _ = fs::remove_file(path);
        }
    }
    remove_half_written(&domain.services);
}

/// Removes the files that are still to be written. What they were to tell of has not been made yet.
fn remove_half_written(folder: &Path) {
    for path in files(folder) {
        let is_half_written = fs::symlink_metadata(&path)
            .is_ok_and(|data| data.is_file() && data.mode() & 0o777 == HALF_WRITTEN);
        if is_half_written {
            let _ = fs::remove_file(path);
        }
    }
}

/// Removes every file of a domain in which nobody lives.
pub(crate) fn remove_all(config: &Config, _passing: &Passing) {
    let domain = Paths::new(config);
    let shared = domain.shared();
    if !shared.is_empty() {
        // Its folder may have been removed under a chain that runs.
        let mapped = mapped_files();
        let is_mapped = |path: &Path| mapped.iter().any(|file| Path::new(file) == path);
        for path in shared.into_iter().filter(|path| !is_mapped(path)) {
            let _ = fs::remove_file(path);
        }
    }
    remove_below(&domain.root);
}

/// Whether a node lives here, of whatever program on the transport.
pub(crate) fn has_living_nodes(config: &Config) -> bool {
    !living_nodes(config).is_empty()
}

fn remove_below(folder: &Path) {
    for path in files(folder) {
        if path.symlink_metadata().is_ok_and(|data| data.is_dir()) {
            remove_below(&path);
            // One that is locked stays, and is empty.
        } else {
            let _ = fs::remove_file(path);
        }
    }
    if folder
        .parent()
        .is_some_and(|above| above.ends_with("nodes"))
    {
        let _ = fs::remove_dir(folder);
    }
}

/// The numbers of the nodes whose processes live.
fn living_nodes(config: &Config) -> BTreeSet<u128> {
    let mut living = BTreeSet::new();
    let _ = Node::<ipc::Service>::list(config, |node| {
        if matches!(node, NodeState::Alive(_) | NodeState::Inaccessible(_)) {
            living.insert(node.node_id().value());
        }
        CallbackProgression::Continue
    });
    living
}

/// Has the transport remove what dead nodes left, after each was made to look as if it had died in the middle of its life.
fn remove_dead_nodes(config: &Config, domain: &Paths) {
    let living = living_nodes(config);
    let found = domain.nodes();
    if found.is_subset(&living) {
        return;
    }
    for dead in found.difference(&living) {
        remove_half_written(&domain.nodes.join(dead.to_string()));
        // What cannot be written now is tried again by the next.
        let _ = domain.complete_monitor(*dead);
    }
    let mut dead = Vec::new();
    let _ = Node::<ipc::Service>::list(config, |node| {
        if let NodeState::Dead(node) = node {
            dead.push(*node.id());
        }
        CallbackProgression::Continue
    });
    for id in dead {
        // The transport reads a node's settings from a file that may be gone already, and would look in another domain.
        let details = NodeDetails::__internal_new(&None, config);
        let _ = DeadNodeView::<ipc::Service>::__internal_try_remove_stale_resources(id, details);
    }
}

/// Removes the services that no living node has open, and returns the numbers of those that stay.
fn remove_left_services(domain: &Paths, tags: &BTreeSet<String>) -> BTreeSet<u128> {
    let mut stay = BTreeSet::new();
    for path in files(&domain.services) {
        let Some(service) = domain.stem(&path) else {
            continue;
        };
        let id = fs::read_to_string(&path)
            .ok()
            .and_then(|text| service_id(&text));
        if tags.contains(service) {
            stay.extend(id);
        } else {
            let _ = fs::remove_file(path);
        }
    }
    stay
}

/// Removes shared memory and sockets whose ports and services are no living node's.
fn remove_left_ports(domain: &Paths, tags: &BTreeSet<String>, services: &BTreeSet<u128>) {
    let is_left = |stem: &str| {
        let ids: Option<Vec<u128>> = stem.split('_').map(|word| word.parse().ok()).collect();
        ids.is_some_and(|ids| {
            let mut ids = ids.into_iter();
            !ids.any(|id| services.contains(&id) || tags.contains(&id.to_string()))
        })
    };
    for path in domain.shared() {
        // Before the numbers stands the kind's own word.
        let stem = domain.stem(&path).and_then(|stem| stem.split_once('_'));
        if stem.is_some_and(|(_, stem)| is_left(stem)) {
            let _ = fs::remove_file(path);
        }
    }
    for path in files(&domain.root) {
        let is_file = path.symlink_metadata().is_ok_and(|data| !data.is_dir());
        if is_file && domain.stem(&path).is_some_and(is_left) {
            let _ = fs::remove_file(path);
        }
    }
}

/// A domain's files in shared memory.
pub(crate) fn shared_memory(config: &Config) -> Vec<PathBuf> {
    Paths::new(config).shared()
}

/// Removes the file in which the transport counts nodes while it creates one. The transport creates it with mode 0666, and any user who
/// changes it keeps all processes from joining the domain. It is not needed: a node's number contains the process's id and the time,
/// and the lock lets one process at a time create a node.
pub(crate) fn remove_counter(config: &Config, _passing: &Passing) {
    let ending = config.global.node.global_mgmt_suffix.to_string();
    for path in shared_memory(config) {
        if path.to_string_lossy().ends_with(&ending) {
            let _ = fs::remove_file(path);
        }
    }
}

/// A service's number, as the text of its file has it in two halves.
fn service_id(text: &str) -> Option<u128> {
    let half = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.trim_start_matches([' ', '=']).parse::<u64>().ok()
    };
    let (low, high) = (half("payload_value")?, half("unique_value")?);
    Some(u128::from(high) << 64 | u128::from(low))
}

/// Where a domain's files are.
struct Paths {
    root: PathBuf,
    nodes: PathBuf,
    services: PathBuf,
    prefix: String,
    monitor: String,
}

impl Paths {
    fn new(config: &Config) -> Self {
        let global = &config.global;
        let root = root_of(config);
        Self {
            nodes: root.join(global.node.directory.to_string()),
            services: root.join(global.service.directory.to_string()),
            prefix: global.prefix.to_string(),
            monitor: global.node.monitor_suffix.to_string(),
            root,
        }
    }

    fn shared(&self) -> Vec<PathBuf> {
        let mut all = files(Path::new(SHM));
        all.retain(|path| {
            path.file_name()
                .is_some_and(|name| name.to_string_lossy().starts_with(&self.prefix))
        });
        all
    }

    /// A file's name between the domain's prefix and its ending.
    fn stem<'a>(&self, path: &'a Path) -> Option<&'a str> {
        let name = path.file_name()?.to_str()?.strip_prefix(&self.prefix)?;
        name.split('.').next()
    }

    /// The nodes that anything is left of: a folder, or files of their monitors.
    fn nodes(&self) -> BTreeSet<u128> {
        let number = |path: PathBuf| {
            let name = path.file_name()?.to_str()?;
            name.parse().ok().or_else(|| self.stem(&path)?.parse().ok())
        };
        files(&self.nodes).into_iter().filter_map(number).collect()
    }

    /// The names of the services and ports that these nodes have, or are about to make.
    fn tags(&self, nodes: &BTreeSet<u128>) -> BTreeSet<String> {
        let folders = nodes.iter().map(|node| self.nodes.join(node.to_string()));
        let all = folders.flat_map(|folder| files(&folder));
        all.filter_map(|path| self.stem(&path).map(str::to_owned))
            .collect()
    }

    /// Makes the files that tell the transport that a node is dead.
    fn complete_monitor(&self, node: u128) -> io::Result<()> {
        let file = |ending: &str| {
            let name = format!("{}{node}{}{ending}", self.prefix, self.monitor);
            self.nodes.join(name)
        };
        for path in [file(""), file(OWNER_LOCK)] {
            if !path.exists() {
                File::create(&path)?;
            }
            fs::set_permissions(&path, Permissions::from_mode(0o600))?;
        }
        // The number of a process: that of none.
        let context = file(CONTEXT);
        let _ = fs::remove_file(&context);
        File::create(&context)?.write_all(&0u128.to_ne_bytes())?;
        fs::set_permissions(&context, Permissions::from_mode(READABLE))
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).collect()
}

//! Removes what dead processes left in a domain, in whatever state, while other processes live in
//! it. If no process lives in it, everything is removed.
//!
//! Callers hold the pass of the [`door`](crate::door), so no other process creates or removes
//! anything meanwhile. The transport's own cleanup handles a process that was killed in normal
//! operation, but is not safe against kills at other moments. Every state that a death between two
//! system calls leaves is recognized here from the data that the transport itself reads.
//!
//! | left behind | recognized by | consequence if not removed |
//! |---|---|---|
//! | half-created shared memory | no size, or not yet readable | opening it blocks forever |
//! | half-written file of a service | its permissions | `HangsInCreation` |
//! | half-created or half-removed node | no lock on its file, or files are missing | the transport
//! does not see a node, and its ports stay |
//! | service without nodes | no living node has its tag | `IsMarkedForDestruction` |
//! | memory and socket of a port | no living node has its tag | they stay |

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

/// Permission of the owner on complete shared memory.
const READABLE: u32 = 0o400;
/// Permissions of a service, node or tag file until it is complete.
const HALF_WRITTEN: u32 = 0o600;
/// Suffixes of the files that a node's monitor has in addition to its main file.
const OWNER_LOCK: &str = "_owner_lock";
const CONTEXT: &str = "_context";

/// Completes what dead processes began.
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

/// Removes objects that a process was creating when it was killed. They cannot be opened, and
/// trying may block forever.
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

/// Removes files that are not complete yet. The objects that they describe have not been created.
fn remove_half_written(folder: &Path) {
    for path in files(folder) {
        let is_half_written = fs::symlink_metadata(&path)
            .is_ok_and(|data| data.is_file() && data.mode() & 0o777 == HALF_WRITTEN);
        if is_half_written {
            let _ = fs::remove_file(path);
        }
    }
}

/// Removes every file of a domain without living processes.
pub(crate) fn remove_all(config: &Config, _passing: &Passing) {
    let domain = Paths::new(config);
    let shared = domain.shared();
    if !shared.is_empty() {
        // The domain's folder may have been removed under a running chain.
        let mapped = mapped_files();
        let is_mapped = |path: &Path| mapped.iter().any(|file| Path::new(file) == path);
        for path in shared.into_iter().filter(|path| !is_mapped(path)) {
            let _ = fs::remove_file(path);
        }
    }
    remove_below(&domain.root);
}

/// Returns whether a node of any program on the transport lives here.
pub(crate) fn has_living_nodes(config: &Config) -> bool {
    !living_nodes(config).is_empty()
}

fn remove_below(folder: &Path) {
    for path in files(folder) {
        if path.symlink_metadata().is_ok_and(|data| data.is_dir()) {
            remove_below(&path);
            // A locked folder is emptied, but not removed.
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

/// IDs of the nodes whose processes live.
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

/// Makes each dead node look as if it had died in normal operation, then lets the transport remove
/// what the node left.
fn remove_dead_nodes(config: &Config, domain: &Paths) {
    let living = living_nodes(config);
    let found = domain.nodes();
    if found.is_subset(&living) {
        return;
    }
    for dead in found.difference(&living) {
        remove_half_written(&domain.nodes.join(dead.to_string()));
        // If it cannot be written now, the next process tries again.
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
        // The transport reads a node's settings from a file that may already be gone, and would
        // then use another domain.
        let details = NodeDetails::__internal_new(&None, config);
        let _ = DeadNodeView::<ipc::Service>::__internal_try_remove_stale_resources(id, details);
    }
}

/// Removes the services that no living node has open. Returns the IDs of the others.
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

/// Removes shared memory and sockets whose ports and services belong to no living node.
fn remove_left_ports(domain: &Paths, tags: &BTreeSet<String>, services: &BTreeSet<u128>) {
    let is_left = |stem: &str| {
        let ids: Option<Vec<u128>> = stem.split('_').map(|word| word.parse().ok()).collect();
        ids.is_some_and(|ids| {
            let mut ids = ids.into_iter();
            !ids.any(|id| services.contains(&id) || tags.contains(&id.to_string()))
        })
    };
    for path in domain.shared() {
        // A word for the kind precedes the numbers.
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

/// Removes the file in which the transport counts nodes while it creates one. It has mode 0666, and
/// any user can change it and thereby keep all processes from joining the domain. It is not needed:
/// a node's ID contains the process ID and the time, and the lock allows only one process at a time
/// to create a node.
pub(crate) fn remove_counter(config: &Config, _passing: &Passing) {
    let ending = config.global.node.global_mgmt_suffix.to_string();
    for path in shared_memory(config) {
        if path.to_string_lossy().ends_with(&ending) {
            let _ = fs::remove_file(path);
        }
    }
}

/// A service's ID, which its file contains in two halves.
fn service_id(text: &str) -> Option<u128> {
    let half = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.trim_start_matches([' ', '=']).parse::<u64>().ok()
    };
    let (low, high) = (half("payload_value")?, half("unique_value")?);
    Some(u128::from(high) << 64 | u128::from(low))
}

/// Paths of a domain's files.
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

    /// A file's name between the domain's prefix and its extension.
    fn stem<'a>(&self, path: &'a Path) -> Option<&'a str> {
        let name = path.file_name()?.to_str()?.strip_prefix(&self.prefix)?;
        name.split('.').next()
    }

    /// The nodes that have anything left: a folder, or files of their monitors.
    fn nodes(&self) -> BTreeSet<u128> {
        let number = |path: PathBuf| {
            let name = path.file_name()?.to_str()?;
            name.parse().ok().or_else(|| self.stem(&path)?.parse().ok())
        };
        files(&self.nodes).into_iter().filter_map(number).collect()
    }

    /// Names of the services and ports that these nodes have, or are about to create.
    fn tags(&self, nodes: &BTreeSet<u128>) -> BTreeSet<String> {
        let folders = nodes.iter().map(|node| self.nodes.join(node.to_string()));
        let all = folders.flat_map(|folder| files(&folder));
        all.filter_map(|path| self.stem(&path).map(str::to_owned))
            .collect()
    }

    /// Creates the files that tell the transport that a node is dead.
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
        // A process ID that no process has.
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

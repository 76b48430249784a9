//! Finds and removes what killed processes left in shared memory, in every domain of the machine,
//! without joining any.
//!
//! Only root can inspect domains of other users. One domain belongs to nobody: in older releases
//! all users shared the transport's own folder, `/tmp/iceoryx2`, where the first user locked out
//! the others.
//!
//! A domain's files are left over if all of these hold:
//!
//! - Its folder with the transport's locks exists here. In a container that shares only the host's
//!   `/dev/shm`, the folder is missing and nothing can be determined.
//! - None of the locks is held.
//! - No process has its shared memory mapped, as far as this user can see.
//! - No file is so new that its process may be about to take a lock.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, DirEntry, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::node::NodeState;
use iceoryx2::prelude::*;

use crate::domain::{config_of, root_of};
use crate::door::Passing;
use crate::memory::SHM;
use crate::{door, owner, roster, tidy};

/// Age below which a file is too new to be left over: a process takes its locks within milliseconds
/// of creating its first file.
const SETTLED_AFTER: Duration = Duration::from_secs(2);

/// All files that a domain's killed processes left behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leftover {
    /// Name of the domain. `None` is the place that older releases shared with other programs on
    /// iceoryx2; in that place, lariat's folder also counts as left over if no files remain.
    pub domain: Option<String>,
    /// Common prefix of its files in shared memory.
    pub prefix: String,
    /// Number of files.
    pub files: usize,
    /// Total size of the files in bytes.
    pub bytes: u64,
}

/// The domains that have files in `/dev/shm` and no living process. Files left next to living
/// processes are removed by the next process that joins or leaves, and by [`remove_leftovers`].
pub fn leftovers() -> Vec<Leftover> {
    let mut found = BTreeMap::<Option<String>, Leftover>::new();
    let mut is_new = Vec::new();
    for (domain, entry) in shared_files() {
        let data = entry.metadata().ok();
        if data.as_ref().is_some_and(|data| !is_settled(data)) {
            is_new.push(domain.clone());
        }
        let leftover = found.entry(domain.clone()).or_insert_with(|| Leftover {
            prefix: format!("{SHM}/{}", prefix_of(domain.as_deref())),
            domain,
            files: 0,
            bytes: 0,
        });
        leftover.files += 1;
        leftover.bytes += data.map_or(0, |data| data.len());
    }
    found.retain(|domain, _| !is_new.contains(domain));
    if is_shared_place_left() {
        found.entry(None).or_insert_with(|| Leftover {
            prefix: format!("{SHM}/{}", prefix_of(None)),
            domain: None,
            files: 0,
            bytes: 0,
        });
    }
    if found.is_empty() {
        return Vec::new();
    }
    let mapped = mapped_files();
    let is_left = |left: &Leftover| {
        let folder = config(left.domain.as_deref()).map(|config| root_of(&config));
        if !folder.is_some_and(|folder| folder.is_dir()) {
            return false;
        }
        let is_mapped = mapped.iter().any(|file| file.starts_with(&left.prefix));
        !is_mapped && !lives(left.domain.as_deref())
    };
    found.into_values().filter(is_left).collect()
}

/// Files of other users' processes in `/dev/shm`: for each user ID, the number of files and bytes.
/// Only those users and root can tell whether the processes are alive.
pub fn shared_by_others() -> BTreeMap<u32, (usize, u64)> {
    let mut others = BTreeMap::new();
    let me = owner::this_user();
    let files = shared_files().filter_map(|(_, entry)| entry.metadata().ok());
    for file in files.filter(|file| file.uid() != me && me != 0) {
        let (files, bytes) = others.entry(file.uid()).or_insert((0, 0));
        *files += 1;
        *bytes += file.len();
    }
    others
}

/// Returns whether the place that all users once shared contains lariat's own folder, as far as
/// this user can see.
fn is_shared_place_left() -> bool {
    let roster = root_of(&Config::default()).join(roster::FOLDER);
    fs::symlink_metadata(roster).is_ok_and(|data| data.is_dir() && is_settled(&data))
}

/// Removes everything that belongs to no living process: all of each domain that is [left
/// over](leftovers), the folders of empty domains, and files of dead processes next to living ones.
/// Returns the leftovers that were found, and the files that could not be removed, each with its
/// cause.
pub fn remove_leftovers() -> (Vec<Leftover>, Vec<(PathBuf, io::Error)>) {
    let left = leftovers();
    let mut kept = Vec::new();
    remove_intruders(&mut kept);
    for of in &left {
        let before = kept.len();
        let root = config(of.domain.as_deref()).map(|config| root_of(&config));
        // This keeps others from joining in the meantime.
        let passing = root.filter(|_| of.domain.is_some());
        let _passing = match passing.map(|root| Passing::into(&root)) {
            Some(Err(cause)) => {
                kept.push(((&of.prefix).into(), io::Error::other(cause)));
                continue;
            }
            passing => passing,
        };
        for (domain, entry) in shared_files() {
            if domain == of.domain {
                remove(&entry.path(), &mut kept);
            }
        }
        // If files could not be removed, the folder stays, so that the next call recognizes them as
        // left over.
        if let Some(config) = config(of.domain.as_deref())
            && kept.len() == before
        {
            roster::sweep(&config);
            let name = prefix_of(of.domain.as_deref());
            remove_tree(&root_of(&config), &name, &mut kept);
        }
    }
    for folder in domain_folders() {
        remove_if_empty_of_life(&folder);
    }
    let domains = shared_files().map(|(domain, _)| domain);
    let domains: BTreeSet<_> = domains.collect();
    for domain in &domains {
        sweep_dead(domain.as_deref());
    }
    (left, kept)
}

/// Removes files that a user created in the shared memory of another user's domain.
fn remove_intruders(kept: &mut Vec<(PathBuf, io::Error)>) {
    let me = owner::this_user();
    for (domain, entry) in shared_files() {
        let owner = domain.as_deref().and_then(owner_of);
        let (Some(owner), Ok(data)) = (owner, entry.metadata()) else {
            continue;
        };
        if data.uid() != owner && (me == owner || me == 0) {
            remove(&entry.path(), kept);
        }
    }
}

/// Owner of a domain: the user whose ID is its name, or the owner of its folder.
fn owner_of(domain: &str) -> Option<u32> {
    let folder = || {
        let root = root_of(&config_of(domain).ok()?);
        fs::symlink_metadata(root).ok().map(|data| data.uid())
    };
    domain.parse().ok().or_else(folder)
}

/// The domains that have a folder.
fn domain_folders() -> Vec<String> {
    let root = root_of(&Config::default());
    let beside = fs::read_dir(root.parent().unwrap_or(Path::new("/tmp")));
    let entries = beside.into_iter().flatten().flatten();
    let folders = entries.filter(|entry| entry.metadata().is_ok_and(|data| data.is_dir()));
    let names = folders.map(|folder| folder.file_name().to_string_lossy().into_owned());
    names
        .filter_map(|name| Some(name.strip_prefix("lariat-")?.to_owned()))
        .filter(|name| config_of(name).is_ok())
        .collect()
}

/// Removes the folder of an empty domain. Otherwise no user other than its owner could use a domain
/// of this name.
fn remove_if_empty_of_life(domain: &str) {
    let Ok(config) = config_of(domain) else {
        return;
    };
    let root = root_of(&config);
    let Some(passing) = Passing::at_once(&root) else {
        return;
    };
    let prefix = prefix_of(Some(domain));
    let entries = fs::read_dir(&root).into_iter().flatten().flatten();
    let entries: Vec<DirEntry> = entries.collect();
    if !entries.iter().all(|entry| is_a_domains(entry, &prefix)) {
        return;
    }
    let mut all = entries
        .iter()
        .filter_map(|entry| entry.metadata().ok())
        .chain(fs::metadata(&root).ok());
    let has_memory = || shared_files().any(|(other, _)| other.as_deref() == Some(domain));
    if all.all(|data| is_settled(&data))
        && !has_memory()
        && passing.is_alone(&root)
        && !tidy::has_living_nodes(&config)
    {
        roster::sweep(&config);
        remove_tree(&root, &prefix, &mut Vec::new());
    }
}

/// Returns whether lariat or the transport put this entry into a domain's folder. An unrelated
/// folder whose name looks like a domain's keeps its contents, even empty folders.
fn is_a_domains(entry: &DirEntry, prefix: &str) -> bool {
    let name = entry.file_name();
    let name = name.to_string_lossy();
    matches!(&*name, door::LIVING | roster::FOLDER | "nodes" | "services")
        || name.starts_with(prefix)
}

/// Removes files of dead processes next to living ones.
fn sweep_dead(domain: Option<&str>) {
    let Some(config) = config(domain) else {
        return;
    };
    if domain.is_some() {
        let root = root_of(&config);
        // A process that is joining or leaving does this, too.
        if let Some(passing) = Passing::at_once(&root)
            && (!passing.is_alone(&root) || tidy::has_living_nodes(&config))
        {
            tidy::finish(&config, &passing);
        }
        return;
    }
    // Other programs on the transport do not use lariat's locks, so rely on the transport's own
    // records.
    let _ = Node::<ipc::Service>::list(&config, |node| {
        if let NodeState::Dead(node) = node {
            // Another process may be removing it, or this one may lack the permission.
            let _ = node.try_remove_stale_resources();
        }
        CallbackProgression::Continue
    });
}

fn remove(path: &Path, kept: &mut Vec<(PathBuf, io::Error)>) {
    match fs::remove_file(path) {
        Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
            kept.push((path.to_owned(), cause));
        }
        _ => {}
    }
}

/// Removes the files under a folder whose names begin with `prefix`, and the folders that are then
/// empty.
fn remove_tree(folder: &Path, prefix: &str, kept: &mut Vec<(PathBuf, io::Error)>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_ours = entry.file_name().to_string_lossy().starts_with(prefix);
        match entry.file_type() {
            Ok(kind) if kind.is_dir() => remove_tree(&entry.path(), prefix, kept),
            // Links and everything else are left alone.
            Ok(kind) if is_ours && kind.is_file() => remove(&entry.path(), kept),
            _ => {}
        }
    }
    // Fails if something else is in it.
    let _ = fs::remove_dir(folder);
}

/// The files in shared memory that belong to a domain.
fn shared_files() -> impl Iterator<Item = (Option<String>, DirEntry)> {
    let entries = fs::read_dir(SHM).into_iter().flatten().flatten();
    entries.filter_map(|entry| {
        let name = entry.file_name();
        let domain = domain_of(name.to_str()?)?.map(str::to_owned);
        Some((domain, entry))
    })
}

/// The domain of a file in `/dev/shm`; `Some(None)` is the place that all users once shared. The
/// transport's own name parts follow the prefix; the first one has 40 hexadecimal digits.
fn domain_of(name: &str) -> Option<Option<&str>> {
    let is_hash = |word: &str| word.len() == 40 && word.bytes().all(|c| c.is_ascii_hexdigit());
    let begins_so = |rest: &str| rest.split(['_', '.']).next().is_some_and(is_hash);
    if name.strip_prefix(&prefix_of(None)).is_some_and(begins_so) {
        return Some(None);
    }
    let rest = name.strip_prefix("lariat_")?;
    rest.match_indices('_')
        .find(|(at, _)| begins_so(&rest[at + 1..]))
        .map(|(at, _)| &rest[..at])
        .filter(|domain| !domain.is_empty())
        .map(Some)
}

/// Prefix of the names of a domain's files.
fn prefix_of(domain: Option<&str>) -> String {
    match domain {
        Some(name) => format!("lariat_{name}_"),
        None => Config::default().global.prefix.to_string(),
    }
}

fn config(domain: Option<&str>) -> Option<Config> {
    match domain {
        Some(name) => config_of(name).ok(),
        None => Some(Config::default()),
    }
}

fn is_settled(data: &Metadata) -> bool {
    let age = data.modified().ok().and_then(|at| at.elapsed().ok());
    age.is_some_and(|age| age >= SETTLED_AFTER)
}

/// The files in shared memory that any process has mapped, as far as this user can see.
pub(crate) fn mapped_files() -> Vec<String> {
    let mut files = Vec::new();
    for entry in fs::read_dir("/proc").into_iter().flatten().flatten() {
        let Ok(maps) = fs::read_to_string(entry.path().join("maps")) else {
            continue;
        };
        let paths = maps
            .lines()
            .filter_map(|line| line.find(SHM).map(|at| line[at..].to_owned()));
        files.extend(paths);
    }
    files.sort();
    files.dedup();
    files
}

/// Returns whether a process of this domain lives, or may live.
fn lives(domain: Option<&str>) -> bool {
    config(domain).is_none_or(|config| {
        let root = root_of(&config);
        let is_entered = || match Passing::at_once(&root) {
            Some(passing) => !passing.is_alone(&root),
            // A process is joining or leaving.
            None => root.exists(),
        };
        domain.is_some() && is_entered() || tidy::has_living_nodes(&config)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_tells_its_domain() {
        let hash = "0354a209029e7d094a819e2d4030ea331e6caaf0";
        let domain = |name: String| domain_of(&name).map(|domain| domain.map(str::to_owned));
        let found = domain(format!("lariat_left_arm_{hash}_12.data"));
        assert_eq!(found, Some(Some("left_arm".into())));
        let found = domain(format!("lariat_t1-2_{hash}_node.0_10_0.global_mgmt"));
        assert_eq!(found, Some(Some("t1-2".into())));
        assert_eq!(domain(format!("iox2_{hash}_1.data")), Some(None));
        for other in [
            format!("lariat_{hash}"),
            "iox2_settings".into(),
            "lariat_a_b".into(),
        ] {
            assert_eq!(domain(other.clone()), None, "{other}");
        }
    }

    #[test]
    fn a_folder_that_is_only_called_as_a_domain_s_keeps_its_empty_folders() {
        let name = format!("k{}", std::process::id());
        let (own, emptied) = (
            format!("/tmp/lariat-{name}"),
            format!("/tmp/lariat-{name}-0"),
        );
        fs::create_dir_all(format!("{own}/pictures")).expect("a folder");
        fs::create_dir_all(format!("{emptied}/nodes")).expect("a folder");
        for folder in [&own, &emptied] {
            let set = |path: &str| {
                let file = fs::File::open(path).expect("it is there");
                let long_ago = std::time::SystemTime::now() - 2 * SETTLED_AFTER;
                file.set_modified(long_ago).expect("its owner may");
            };
            let below = if folder == &own { "pictures" } else { "nodes" };
            set(&format!("{folder}/{below}"));
            set(folder);
        }
        remove_if_empty_of_life(&name);
        remove_if_empty_of_life(&format!("{name}-0"));
        assert!(Path::new(&own).join("pictures").exists());
        assert!(!Path::new(&emptied).exists());
        fs::remove_dir_all(own).expect("nobody else removed it");
    }

    #[test]
    fn this_process_s_own_memory_is_not_left_over() {
        let name = format!("m{}", std::process::id());
        let domain = crate::Domain::named(&name).expect("a domain");
        let rig = "left".parse().expect("a name");
        let reader = crate::Receiver::descriptors(&domain, &rig).expect("a reader");
        let prefix = format!("{SHM}/{}", prefix_of(Some(&name)));
        assert!(mapped_files().iter().any(|file| file.starts_with(&prefix)));
        assert!(lives(Some(&name)));
        drop((reader, domain));
        assert!(!lives(Some(&name)));
        assert!(mapped_files().iter().all(|file| !file.starts_with(&prefix)));
        let _ = fs::remove_dir_all(format!("/tmp/lariat-{name}"));
    }
}

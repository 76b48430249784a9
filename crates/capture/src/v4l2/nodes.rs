//! The video nodes of this machine: which exist, which belong together, and who has access to them
//! or uses them.
//!
//! The facts come from `/sys`, `/dev/v4l`, `/proc` and `/etc/group`. This module opens no device.

use std::fs;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};

/// Returns whether a path names a camera: any character device, or the name of a video node, even
/// if that does not exist now.
pub fn names_a_camera(path: &Path) -> bool {
    let is_device = fs::metadata(path).is_ok_and(|meta| meta.file_type().is_char_device());
    let has_a_nodes_name = ["/dev/video", "/dev/v4l/"]
        .iter()
        .any(|beginning| path.to_string_lossy().starts_with(beginning));
    is_device || has_a_nodes_name
}

/// A video node as the kernel lists it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Node {
    pub(super) path: PathBuf,
    /// The hardware's path in `/sys`, which all nodes of one camera share.
    pub(super) hardware: Option<PathBuf>,
}

/// Lists all video nodes by number.
pub(super) fn all() -> Vec<Node> {
    let mut numbers: Vec<u32> = entries(Path::new("/dev"))
        .filter_map(|path| number_of(&path))
        .collect();
    numbers.sort_unstable();
    let node = |number| {
        let path = PathBuf::from(format!("/dev/video{number}"));
        let hardware = hardware_of(&path);
        Node { path, hardware }
    };
    numbers.into_iter().map(node).collect()
}

/// Lists the other video nodes of the same hardware.
pub(super) fn siblings(path: &Path) -> Vec<PathBuf> {
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let Some(hardware) = hardware_of(&path) else {
        return Vec::new();
    };
    let others = all().into_iter().filter(|node| node.path != path);
    others
        .filter(|node| node.hardware.as_ref() == Some(&hardware))
        .map(|node| node.path)
        .collect()
}

/// Lists the names under `/dev/v4l/by-id` and `/dev/v4l/by-path` of this node. They stay the same
/// when its number changes.
pub(super) fn lasting_names(path: &Path) -> Vec<PathBuf> {
    let mut names: Vec<_> = ["/dev/v4l/by-id", "/dev/v4l/by-path"]
        .into_iter()
        .flat_map(|folder| entries(Path::new(folder)))
        .filter(|name| fs::canonicalize(name).is_ok_and(|leads_to| leads_to == path))
        .collect();
    names.sort();
    names
}

fn hardware_of(node: &Path) -> Option<PathBuf> {
    let name = node.file_name()?;
    fs::canonicalize(
        Path::new("/sys/class/video4linux")
            .join(name)
            .join("device"),
    )
    .ok()
}

fn number_of(path: &Path) -> Option<u32> {
    let name = path.file_name()?.to_str()?;
    let is_device = fs::metadata(path).is_ok_and(|meta| meta.file_type().is_char_device());
    name.strip_prefix("video")?
        .parse()
        .ok()
        .filter(|_| is_device)
}

/// Yields the paths in a folder, or none if it cannot be read.
fn entries(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    entries.filter_map(|entry| Some(entry.ok()?.path()))
}

/// Lists the programs that have this node open, as words of a sentence. `None` if none is visible.
/// Programs of other users are not visible.
pub(super) fn holders(path: &Path) -> Option<String> {
    let node = fs::canonicalize(path).ok()?;
    let own = std::process::id();
    let has_open = |pid: &u32| {
        let descriptors = entries(&PathBuf::from(format!("/proc/{pid}/fd")));
        *pid != own
            && descriptors
                .map(fs::read_link)
                .any(|target| target.is_ok_and(|target| target == node))
    };
    let pids = entries(Path::new("/proc"))
        .filter_map(|path| path.file_name()?.to_str()?.parse().ok())
        .filter(has_open);
    let words: Vec<_> = pids
        .map(|pid| {
            let name = fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
            format!("{} (process {pid})", name.trim())
        })
        .collect();
    (!words.is_empty()).then(|| words.join(" and "))
}

/// Says how this user can get permission to open a node: who has it, and what to type.
pub(super) fn permission_remedy(path: &Path) -> String {
    let Ok(meta) = fs::metadata(path) else {
        return "ask this machine's administrator".to_owned();
    };
    let text = |path| fs::read_to_string(path).unwrap_or_default();
    let uid = rustix::process::geteuid().as_raw();
    let session: Vec<u32> = rustix::process::getgroups()
        .unwrap_or_default()
        .iter()
        .map(|gid| gid.as_raw())
        .collect();
    let user = name_of_id(&text("/etc/passwd"), uid);
    remedy(
        meta.mode(),
        meta.gid(),
        &text("/etc/group"),
        user.as_deref(),
        &session,
    )
}

/// The sentence for a node with this mode and group. `session`: groups of the running process.
fn remedy(mode: u32, gid: u32, etc_group: &str, user: Option<&str>, session: &[u32]) -> String {
    let group_reads_and_writes = mode & 0o060 == 0o060;
    let Some(group) = name_of_id(etc_group, gid).filter(|_| group_reads_and_writes) else {
        return format!(
            "its mode is {:03o}, so that only its owner may; a udev rule with GROUP=\"video\", MODE=\"0660\" gives it to \
             the group video",
            mode & 0o777
        );
    };
    let enrolled = user.is_some_and(|user| is_member(etc_group, gid, user));
    if session.contains(&gid) {
        format!(
            "it belongs to the group {group}, and you are in it, so something else keeps it shut (a container?)"
        )
    } else if enrolled {
        format!(
            "it belongs to the group {group}, which you joined after you logged in: log out and in again"
        )
    } else {
        format!(
            "it belongs to the group {group}, and you are not in it: `sudo usermod -aG {group} $USER`, then log out and \
             in again"
        )
    }
}

/// Looks up the name of this number in a text like `/etc/group` or `/etc/passwd`.
fn name_of_id(table: &str, id: u32) -> Option<String> {
    let id = id.to_string();
    let line = table
        .lines()
        .find(|line| line.split(':').nth(2) == Some(&id))?;
    line.split(':').next().map(str::to_owned)
}

fn is_member(etc_group: &str, gid: u32, user: &str) -> bool {
    let gid = gid.to_string();
    etc_group
        .lines()
        .map(|line| line.split(':').collect::<Vec<_>>())
        .filter(|fields| fields.get(2) == Some(&gid.as_str()))
        .any(|fields| {
            fields
                .get(3)
                .is_some_and(|members| members.split(',').any(|member| member.trim() == user))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUPS: &str = "root:x:0:\nvideo:x:44:ada,grace\nusers:x:100:\n";

    #[test]
    fn who_is_not_in_the_group_is_told_how_to_join_it() {
        let text = remedy(0o20660, 44, GROUPS, Some("linus"), &[100]);
        assert!(text.contains("the group video"), "{text}");
        assert!(text.contains("sudo usermod -aG video $USER"), "{text}");
    }

    #[test]
    fn who_joined_the_group_since_is_told_to_log_in_again() {
        let text = remedy(0o20660, 44, GROUPS, Some("grace"), &[100]);
        assert!(text.contains("log out and in again"), "{text}");
        assert!(!text.contains("usermod"), "{text}");
    }

    #[test]
    fn joining_a_group_is_not_advised_where_it_would_not_help() {
        for (mode, gid) in [(0o20600, 44), (0o20640, 44), (0o20660, 4711)] {
            let text = remedy(mode, gid, GROUPS, Some("linus"), &[100]);
            assert!(!text.contains("usermod"), "{text}");
            assert!(text.contains("udev"), "{text}");
        }
        let text = remedy(0o20660, 44, GROUPS, Some("ada"), &[44]);
        assert!(!text.contains("usermod"), "{text}");
    }
}

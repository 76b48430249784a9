//! The roster: which processes run on the rigs of a domain, and with which settings.
//!
//! Each process has a file in a folder next to the domain's own, and holds a lock on it. The kernel
//! releases the lock however the process ends. An unlocked file thus belongs to a dead process, and
//! whoever finds it removes it.
//!
//! Recorders, `top` and `doctor` read the roster; no stage depends on it.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process;

use crate::WireError;
use crate::domain::{Domain, Rig, config_here, root_of};
use iceoryx2::config::Config;

/// Every entry starts with this text, so that other files are left alone.
const HEAD: &str = "lariat ";
pub(crate) const FOLDER: &str = "lariat-roster";
/// Maximum size of an entry. Settings take a few kilobytes.
const LONGEST_ENTRY: u64 = 1 << 20;
/// Suffix of an entry that is being written. The file is renamed when the entry is complete.
const UNFINISHED: &str = "new";

/// A process that runs on a rig.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Member {
    /// Name of the rig.
    pub rig: String,
    /// Role of the process: `capture`, `extract`, `fit`, `sink`, `record`.
    pub stage: String,
    /// Process ID.
    pub pid: u32,
    /// Release of lariat.
    pub version: String,
    /// Folder in which it was started; relative paths in its settings start there.
    pub folder: PathBuf,
    /// Settings, as the text of a `lariat.toml`.
    pub settings: String,
}

/// A process's entry. It exists until this value is dropped or the process ends.
#[derive(Debug)]
pub struct Announcement {
    path: PathBuf,
    _lock: File,
}

impl Announcement {
    /// Announces that this process now uses other settings.
    ///
    /// # Errors
    /// The entry cannot be written; the previous one remains.
    pub fn renew(&mut self, settings: &str) -> io::Result<()> {
        self._lock = write_entry(&self.path, settings)?;
        Ok(())
    }
}

impl Drop for Announcement {
    fn drop(&mut self) {
        // A failure does no harm: without the lock, the entry counts as dead.
        let _ = fs::remove_file(&self.path);
    }
}

impl Domain {
    /// Announces that this process is `stage` on `rig`, with these settings.
    ///
    /// # Errors
    /// The entry cannot be written. Nothing else depends on the entry.
    pub fn announce(&self, rig: &Rig, stage: &str, settings: &str) -> io::Result<Announcement> {
        announce(&folder_of(self.config()), rig, stage, settings)
    }
}

/// The processes on the rigs of the domain, by rig and stage. The domain is that of
/// `LARIAT_DOMAIN`, or the user's own. This call does not join it.
///
/// # Errors
/// `LARIAT_DOMAIN` is not a valid name.
pub fn members() -> Result<Vec<Member>, WireError> {
    Ok(read_folder(&folder_of(&config_here()?)))
}

/// Path of the socket that controls a rig's chain, in the domain that `LARIAT_DOMAIN` names or in
/// the user's own. Every process that may join the domain may control the chain.
///
/// # Errors
/// `LARIAT_DOMAIN` is not a valid name.
pub fn control_socket(rig: &Rig) -> Result<PathBuf, WireError> {
    Ok(folder_of(&config_here()?).join(format!("{rig}.control")))
}

/// Removes the entries of dead processes.
pub(crate) fn sweep(config: &Config) {
    read_folder(&folder_of(config));
}

fn folder_of(config: &Config) -> PathBuf {
    root_of(config).join(FOLDER)
}

fn announce(folder: &Path, rig: &Rig, stage: &str, settings: &str) -> io::Result<Announcement> {
    fs::create_dir_all(folder)?;
    let path = folder.join(format!("{rig}.{stage}.{}", process::id()));
    let lock = write_entry(&path, settings)?;
    Ok(Announcement { path, _lock: lock })
}

/// Writes an entry atomically and returns it locked.
fn write_entry(path: &Path, settings: &str) -> io::Result<File> {
    let mut unfinished = path.as_os_str().to_owned();
    unfinished.push(format!(".{UNFINISHED}"));
    let mut file = File::create(&unfinished)?;
    file.lock()?;
    let started_in = std::env::current_dir().unwrap_or_default();
    write!(
        file,
        "{HEAD}{}\n{}\n{settings}",
        env!("CARGO_PKG_VERSION"),
        started_in.display()
    )?;
    fs::rename(&unfinished, path)?;
    Ok(file)
}

fn read_folder(folder: &Path) -> Vec<Member> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut members: Vec<_> = entries.filter_map(|entry| read(&entry.path())).collect();
    members.sort();
    members
}

/// Returns the entry in a file if its process is alive.
fn read(path: &Path) -> Option<Member> {
    let name = path.file_name()?.to_str()?;
    let mut words = name.split('.');
    let (rig, stage, pid) = (words.next()?, words.next()?, words.next()?.parse().ok()?);
    let is_unfinished = words.next().is_some();
    let file = File::open(path).ok()?;
    match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) if is_unfinished => return None,
        Err(TryLockError::WouldBlock) => {}
        Err(TryLockError::Error(_)) => return None,
        Ok(()) if is_unfinished && fs::metadata(path).is_ok_and(is_young) => return None,
        Ok(()) => {
            let _ = fs::remove_file(path);
            return None;
        }
    }
    let text = io::read_to_string(file.take(LONGEST_ENTRY)).ok()?;
    let (head, rest) = text.split_once('\n')?;
    let (folder, settings) = rest.split_once('\n')?;
    Some(Member {
        rig: rig.to_owned(),
        stage: stage.to_owned(),
        pid,
        version: head.strip_prefix(HEAD)?.to_owned(),
        folder: folder.into(),
        settings: settings.to_owned(),
    })
}

/// Returns whether a file is so recent that its process may still be about to lock it.
fn is_young(file: fs::Metadata) -> bool {
    let age = file.modified().ok().and_then(|at| at.elapsed().ok());
    age.is_none_or(|age| age.as_secs() < 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = format!("lariat-roster-{name}-{}", process::id());
        std::env::temp_dir().join(folder)
    }

    #[test]
    fn who_lives_is_listed_with_what_it_said() {
        let folder = folder("lives");
        let rig: Rig = "left-arm".parse().unwrap();
        let mut fit = announce(&folder, &rig, "fit", "").unwrap();
        fit.renew("[fit]\norder = 8\n").unwrap();
        let extract = announce(&folder, &rig, "extract", "").unwrap();
        let members = read_folder(&folder);
        let stages: Vec<&str> = members.iter().map(|m| m.stage.as_str()).collect();
        assert_eq!(stages, ["extract", "fit"]);
        assert_eq!(members[1].settings, "[fit]\norder = 8\n");
        assert_eq!(
            (members[1].pid, members[1].rig.as_str()),
            (process::id(), "left-arm")
        );
        assert_eq!(members[1].folder, std::env::current_dir().unwrap());
        drop(fit);
        assert_eq!(read_folder(&folder).len(), 1);
        drop(extract);
        fs::remove_dir(&folder).expect("nothing is left in it");
    }

    #[test]
    fn an_entry_that_makes_no_sense_is_no_member() {
        let folder = folder("sense");
        fs::create_dir_all(&folder).unwrap();
        let whole = "lariat 0.1.0\n/home\n[fit]\norder = 8\n";
        let path = folder.join("default.fit.123");
        let entry = File::create(&path).unwrap();
        entry.lock().unwrap();
        for length in 0..=whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            // Complete from the end of the second line on, except for the settings.
            let says_enough = length >= "lariat 0.1.0\n/home\n".len();
            assert_eq!(read_folder(&folder).len(), usize::from(says_enough));
        }
        for bytes in [&b"\xff\xfe\n\n"[..], b"other 0.1.0\n/\n", b"\n\n\n"] {
            fs::write(&path, bytes).unwrap();
            assert_eq!(read_folder(&folder), []);
        }
        // A sparse file of 1 TiB.
        entry.set_len(1 << 40).unwrap();
        assert_eq!(read_folder(&folder), []);
        drop(entry);
        assert_eq!(read_folder(&folder), []);
        fs::remove_dir(&folder).expect("nothing is left in it");
    }

    #[test]
    fn what_the_dead_left_is_removed() {
        let folder = folder("dead");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("default.fit.123"), "lariat 0.1.0\n/\n").unwrap();
        assert_eq!(read_folder(&folder), []);
        fs::remove_dir(&folder).expect("nothing is left in it");
        assert_eq!(read_folder(&folder), []);
    }
}

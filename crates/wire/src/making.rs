//! Services are made and opened by one process of lariat at a time.
//!
//! A process that is killed while it makes a service leaves it half made: nobody can open it, and nobody can make it again,
//! because the transport takes it for one that is just being made. But each process of lariat holds a lock on the domain's folder
//! meanwhile, which the kernel takes back however a process ends. So whoever holds it knows that what hangs was left by a
//! dead one, and removes it.

use std::fs::{self, File};
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use iceoryx2::prelude::*;

use crate::Domain;
use crate::domain::root_of;

/// How long a service that another process is just making or removing is waited for.
const IN_FLUX: Duration = Duration::from_secs(4);
/// A service's file may be read by others when it is whole; until then it has these permissions.
const HALF_MADE: u32 = 0o600;

/// What keeps a service from being opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Hindrance {
    /// Nothing that passes.
    Lasting,
    /// Another process is between two steps.
    Passing,
    /// It has not been whole for as long as the transport waits for one.
    HalfMade,
}

/// Makes or opens a service, again and again while what hinders it passes.
pub(crate) fn make<T, E>(
    domain: &Domain,
    mut attempt: impl FnMut() -> Result<T, E>,
    hindrance: impl Fn(&E) -> Hindrance,
) -> Result<T, E> {
    // Without it (the folder is another user's) nothing is removed.
    let alone = Alone::in_domain(domain.config());
    let deadline = Instant::now() + IN_FLUX;
    loop {
        let cause = match attempt() {
            Ok(service) => return Ok(service),
            Err(cause) => cause,
        };
        match hindrance(&cause) {
            Hindrance::Lasting => return Err(cause),
            _ if Instant::now() >= deadline => return Err(cause),
            Hindrance::HalfMade => {
                if let Some(alone) = &alone {
                    alone.remove_half_made();
                }
            }
            // There is nothing to be woken by.
            Hindrance::Passing => std::thread::yield_now(),
        }
    }
}

/// The lock on a domain's folder.
struct Alone {
    _lock: File,
    services: PathBuf,
    prefix: String,
    settled_after: Duration,
}

impl Alone {
    fn in_domain(config: &Config) -> Option<Self> {
        let global = &config.global;
        let root = root_of(config);
        let folder = File::open(&root).ok()?;
        folder.lock().ok()?;
        Some(Self {
            _lock: folder,
            services: root.join(global.service.directory.to_string()),
            prefix: global.prefix.to_string(),
            settled_after: global.creation_timeout,
        })
    }

    /// Other programs on the transport know nothing of the lock: what one of them is making is younger.
    fn remove_half_made(&self) {
        let entries = fs::read_dir(&self.services).into_iter().flatten().flatten();
        for entry in entries {
            let is_ours = entry
                .file_name()
                .to_string_lossy()
                .starts_with(&self.prefix);
            let is_left = entry.metadata().is_ok_and(|data| {
                let age = data.modified().ok().and_then(|at| at.elapsed().ok());
                data.is_file()
                    && data.permissions().mode() & 0o777 == HALF_MADE
                    && age.is_some_and(|age| age >= self.settled_after)
            });
            if is_ours && is_left {
                // Who comes second finds it gone.
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Receiver;
    use std::path::Path;
    use std::time::SystemTime;

    fn services(domain: &Domain) -> PathBuf {
        let global = &domain.config().global;
        root_of(domain.config()).join(global.service.directory.to_string())
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect()
    }

    #[test]
    fn a_channel_that_was_left_half_made_is_made_anew() {
        let name = format!("h{}", std::process::id());
        let domain = Domain::named(&name).expect("a domain");
        let rig = "left".parse().expect("a name");
        let reader = Receiver::descriptors(&domain, &rig).expect("a reader");
        let folder = services(&domain);
        let made = files(&folder);
        drop(reader);
        assert!(files(&folder).is_empty());
        // As a kill leaves them: the channel's own file, and that of its bell.
        assert_eq!(made.len(), 2);
        for path in &made {
            let file = File::create(path).expect("a file");
            let half_made = fs::Permissions::from_mode(HALF_MADE);
            file.set_permissions(half_made).expect("it is ours");
            let before = SystemTime::now() - Duration::from_secs(2);
            file.set_modified(before).expect("it is ours");
        }
        let reader = Receiver::descriptors(&domain, &rig);
        assert!(reader.is_ok(), "{reader:?}");
        drop((reader, domain));
        let _ = fs::remove_dir_all(format!("/tmp/lariat-{name}"));
    }
}

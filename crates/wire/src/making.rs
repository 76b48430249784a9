//! Creates and opens services. Only one process of lariat does so at a time: the one that holds the
//! pass of the [`door`](crate::door).

use std::time::{Duration, Instant};

use crate::door::Held;
use crate::{Domain, WireError, tidy};

/// Time for which opening a service is retried while another program on the transport creates or
/// removes it. Such a program ignores lariat's lock.
const IN_FLUX: Duration = Duration::from_secs(1);

/// Creates or opens a service, and retries as long as the failure is transient.
pub(crate) fn make<T, E>(
    domain: &Domain,
    mut attempt: impl FnMut() -> Result<T, E>,
    passes: impl Fn(&E) -> bool,
) -> Result<Result<Held<T>, E>, WireError> {
    let passing = domain.door.pass()?;
    // Opening a service that was left half created may block forever.
    tidy::remove_half_made(domain.config(), &passing);
    let deadline = Instant::now() + IN_FLUX;
    loop {
        match attempt() {
            Ok(service) => return Ok(Ok(domain.door.keep(service))),
            Err(cause) if !passes(&cause) || Instant::now() >= deadline => return Ok(Err(cause)),
            // No event reports the change, so this loop cannot wait for one.
            Err(_) => tidy::finish(domain.config(), &passing),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Receiver;
    use crate::domain::root_of;
    use std::fs::{self, File};
    use std::os::unix::fs::PermissionsExt;
    use std::path::{Path, PathBuf};

    fn services(domain: &Domain) -> PathBuf {
        let global = &domain.config().global;
        root_of(domain.config()).join(global.service.directory.to_string())
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect()
    }

    #[test]
    fn a_channel_that_was_left_half_made_is_made_again() {
        let name = format!("h{}", std::process::id());
        let domain = Domain::named(&name).expect("a domain");
        let rig = "left".parse().expect("a name");
        let reader = Receiver::descriptors(&domain, &rig).expect("a reader");
        let folder = services(&domain);
        let made = files(&folder);
        drop(reader);
        assert!(files(&folder).is_empty());
        // The state after a kill: the channel's own file and that of its event service.
        assert_eq!(made.len(), 2);
        for path in &made {
            let file = File::create(path).expect("a file");
            let half_made = fs::Permissions::from_mode(0o600);
            file.set_permissions(half_made).expect("it is ours");
        }
        let reader = Receiver::descriptors(&domain, &rig);
        assert!(reader.is_ok(), "{reader:?}");
        drop((reader, domain));
        let _ = fs::remove_dir_all(format!("/tmp/lariat-{name}"));
    }
}

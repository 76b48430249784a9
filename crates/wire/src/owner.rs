//! Ownership of a domain. Its folder and its shared memory are accessible to their owner only. A
//! process of another user can neither take part nor see which processes are in it.

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use crate::WireError;

/// ID of the user that this process runs as.
pub(crate) fn this_user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// Name of a user, or the user ID if `/etc/passwd` lacks it.
pub fn user_name(uid: u32) -> String {
    name_in(&fs::read_to_string("/etc/passwd").unwrap_or_default(), uid)
}

fn name_in(passwd: &str, uid: u32) -> String {
    let number = uid.to_string();
    let mut users = passwd
        .lines()
        .map(|line| line.split(':').collect::<Vec<_>>());
    let user = users.find(|fields| fields.get(2) == Some(&number.as_str()));
    user.map_or_else(|| format!("user {number}"), |fields| fields[0].to_owned())
}

/// Checks that the domain belongs to this user, or does not exist yet.
pub(crate) fn require_own(name: &str, folder: &Path) -> Result<(), WireError> {
    let me = this_user();
    // A numeric name is the domain of the user with this ID, even if that user has never run
    // anything.
    let by_name = name.parse().ok().filter(|_| is_number(name));
    let by_folder = fs::symlink_metadata(folder).ok().map(|data| data.uid());
    match (by_name, by_folder) {
        (Some(owner), _) if owner != me => Err(WireError::DomainOfUser {
            name: name.to_owned(),
            owner: user_name(owner),
        }),
        (_, Some(owner)) if owner != me => Err(WireError::Owner {
            folder: folder.display().to_string(),
            owner: user_name(owner),
        }),
        _ => require_closed(folder),
    }
}

/// Checks that all files of the domain's shared memory belong to this user.
pub(crate) fn require_own_memory(files: &[PathBuf]) -> Result<(), WireError> {
    let me = this_user();
    for file in files {
        // A file that was removed in the meantime is harmless.
        let owner = fs::symlink_metadata(file).map_or(me, |data| data.uid());
        if owner != me {
            return Err(WireError::Intruder {
                file: file.display().to_string(),
                owner: user_name(owner),
            });
        }
    }
    Ok(())
}

/// Checks that the path is a folder, and that no other user can write to it.
fn require_closed(folder: &Path) -> Result<(), WireError> {
    let unusable = |cause: &str| WireError::Folder {
        folder: folder.display().to_string(),
        cause: cause.into(),
    };
    let Ok(data) = fs::symlink_metadata(folder) else {
        // The entering process will create the folder.
        return Ok(());
    };
    if !data.is_dir() {
        return Err(unusable("it is a link or a file"));
    }
    if data.mode() & 0o022 != 0 {
        return Err(unusable("others may write into it"));
    }
    if data.mode() & 0o077 != 0 {
        // A folder of an older release: prevent others from taking its locks.
        let closed = fs::set_permissions(folder, fs::Permissions::from_mode(0o700));
        closed.map_err(|cause| unusable(&cause.to_string()))?;
    }
    Ok(())
}

fn is_number(name: &str) -> bool {
    name.bytes().all(|c| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_user_is_named_or_numbered() {
        let passwd = "root:x:0:0:root:/root:/bin/sh\nann:x:1000:1000::/home/ann:/bin/sh\n";
        assert_eq!(name_in(passwd, 1000), "ann");
        assert_eq!(name_in(passwd, 77), "user 77");
    }

    #[test]
    fn the_domain_of_another_user_is_refused_by_its_name_and_by_its_folder() {
        let me = this_user();
        let nowhere = Path::new("/tmp/lariat-nobody-was-here");
        assert!(require_own(&me.to_string(), nowhere).is_ok());
        assert!(require_own("mine", nowhere).is_ok());
        let other = require_own(&(me + 1).to_string(), nowhere);
        assert!(matches!(other, Err(WireError::DomainOfUser { .. })));
        // The kernel owns it, so it belongs to another user whoever runs this test, or to nobody in
        // a user namespace.
        let owner = fs::metadata("/proc/sys").expect("there").uid();
        let other = require_own("mine", Path::new("/proc/sys"));
        assert_eq!(matches!(other, Err(WireError::Owner { .. })), owner != me);
    }

    #[test]
    fn a_folder_that_others_may_change_is_no_domain() {
        let here = std::env::temp_dir().join(format!("lariat-owner-{}", std::process::id()));
        let (folder, link) = (here.join("folder"), here.join("link"));
        fs::create_dir_all(&folder).expect("it is ours");
        std::os::unix::fs::symlink(&folder, &link).expect("it is ours");
        let mode = |mode| fs::set_permissions(&folder, fs::Permissions::from_mode(mode));
        mode(0o777).expect("it is ours");
        let refused = require_own("mine", &folder).map_err(|cause| cause.to_string());
        assert!(refused.is_err_and(|cause| cause.contains("others may write into it")));
        mode(0o750).expect("it is ours");
        assert!(require_own("mine", &folder).is_ok());
        let data = fs::metadata(&folder).expect("it is there");
        assert_eq!(data.mode() & 0o777, 0o700);
        let refused = require_own("mine", &link).map_err(|cause| cause.to_string());
        assert!(refused.is_err_and(|cause| cause.contains("it is a link")));
        let _ = fs::remove_dir_all(here);
    }
}

//! Locations of the unit and the settings: for the machine, for a user, or for a package.

use std::env;
use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use lariat_chain::exit::wrong_use;
use lariat_wire::Rig;

use super::unit;

/// First user number of a person, for logind (`SYS_UID_MAX` of Debian and Fedora, plus one).
const FIRST_PERSON: u32 = 1000;

pub(super) struct Place {
    /// File that `install` writes the unit to.
    pub(super) unit: PathBuf,
    /// File of a unit that a package has installed.
    pub(super) of_package: Option<PathBuf>,
    /// Folder of the settings, with a file for each rig.
    settings: PathBuf,
    /// Program that the unit starts.
    pub(super) program: PathBuf,
}

impl Place {
    pub(super) fn of_machine() -> Result<Self> {
        Ok(Self {
            unit: Path::new("/etc/systemd/system").join(unit::NAME),
            of_package: Some(Path::new("/usr/lib/systemd/system").join(unit::NAME)),
            settings: "/etc/lariat".into(),
            program: own_program()?,
        })
    }

    pub(super) fn of_user() -> Result<Self> {
        let set = |name| env::var_os(name).filter(|value| !value.is_empty());
        let config = set("XDG_CONFIG_HOME").map(PathBuf::from);
        let config = config.or_else(|| Some(PathBuf::from(set("HOME")?).join(".config")));
        let Some(config) = config else {
            bail!("neither XDG_CONFIG_HOME nor HOME is set: there is no folder for a user's units");
        };
        Ok(Self {
            unit: config.join("systemd/user").join(unit::NAME),
            of_package: None,
            settings: config.join("lariat"),
            program: own_program()?,
        })
    }

    pub(super) fn of_package(root: &Path) -> Self {
        Self {
            unit: root.join("usr/lib/systemd/system").join(unit::NAME),
            of_package: None,
            settings: root.join("etc/lariat"),
            program: "/usr/bin/lariat".into(),
        }
    }

    pub(super) fn settings(&self, rig: &Rig) -> PathBuf {
        self.settings.join(format!("{rig}.toml"))
    }

    /// Other rigs that systemd starts with this unit.
    pub(super) fn enabled(&self, but: &Rig) -> Vec<String> {
        let folders = self.unit.parent().map(fs::read_dir);
        let wants = folders.into_iter().flatten().flatten().flatten();
        let wants =
            wants.filter(|entry| entry.path().extension().is_some_and(|end| end == "wants"));
        let links = wants.filter_map(|entry| fs::read_dir(entry.path()).ok());
        let mut rigs: Vec<_> = links
            .flatten()
            .flatten()
            .filter_map(|link| Some(unit::rig_of(link.file_name().to_str()?)?.to_owned()))
            .filter(|rig| rig != but.as_str())
            .collect();
        rigs.sort();
        rigs.dedup();
        rigs
    }
}

fn own_program() -> Result<PathBuf> {
    env::current_exe().context("the path of this program is not known")
}

/// Checks that the user exists and can start this program. Returns advice on that user's service.
pub(super) fn require_user_can_run(user: &str, program: &Path) -> Result<String> {
    let output = Command::new("id").args(["-u", "--", user]).output();
    let output = output.context("`id` cannot be started")?;
    let uid = String::from_utf8_lossy(&output.stdout)
        .trim()
        .parse::<u32>();
    let (true, Ok(uid)) = (output.status.success(), uid) else {
        wrong_use!(
            "there is no user {user}: make it (sudo useradd --system {user}), or name the one of your control loop (--as USER)"
        );
    };
    let closed = program.ancestors().find(|path| {
        fs::metadata(path).is_ok_and(|found| {
            let mode = found.permissions().mode();
            let needed = if found.uid() == uid { 0o100 } else { 0o001 };
            uid != 0 && mode & needed == 0
        })
    });
    if let Some(closed) = closed {
        wrong_use!(
            "{user} cannot start {}, as {} is closed to others: sudo install {0} /usr/local/bin, and install the service with \
             /usr/local/bin/lariat",
            program.display(),
            closed.display()
        );
    }
    // logind's RemoveIPC= removes the shared memory of people, but not of system users.
    Ok(match uid < FIRST_PERSON {
        true => String::new(),
        false => format!(
            "once, so that the chain's memory stays when {user} logs out: sudo loginctl enable-linger {user}\n"
        ),
    })
}

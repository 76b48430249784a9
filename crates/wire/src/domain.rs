//! The place of a machine's channels, and the names of its camera chains.
//!
//! Processes see each other if they are in the same domain. The environment variable
//! `LARIAT_DOMAIN` names it (1 to 16 of a–z, 0–9, `-`, `_`). Without that variable, a process joins
//! the user's own domain, named after the user ID. A domain has the prefix `lariat_<name>_` in
//! `/dev/shm` and the folder `/tmp/lariat-<name>`.
//!
//! `XDG_RUNTIME_DIR` is not used: two shells of a user, one with the variable and one without it,
//! would be in different domains. It is also emptied under a running chain when its user logs out.
//!
//! The transport makes its files accessible to their owner only, so a domain belongs to one user.
//! Anyone else who joins it, root included, is refused before anything is created there (`owner`).
//! `docs/domains.md` explains how several users work together. Every test runs in its own domain.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use iceoryx2::prelude::*;

use crate::door::{Door, Held};
use crate::{WireError, memory, owner, tidy};

/// Name of one camera chain, so that several can run side by side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rig(String);

impl Rig {
    /// Name of the rig.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Default for Rig {
    fn default() -> Self {
        Self("default".into())
    }
}

impl fmt::Display for Rig {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FromStr for Rig {
    type Err = WireError;

    fn from_str(name: &str) -> Result<Self, WireError> {
        if is_plain(name, 32) {
            Ok(Self(name.into()))
        } else {
            Err(WireError::RigName(name.into()))
        }
    }
}

fn is_plain(name: &str, longest: usize) -> bool {
    let plain = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'-' || c == b'_';
    (1..=longest).contains(&name.len()) && name.bytes().all(plain)
}

/// Membership of this process in a domain. A process opens one before anything else and drops it
/// last.
///
/// Processes see each other's channels if they are in the same domain: their user's own, or the one
/// that the environment variable `LARIAT_DOMAIN` names. A domain belongs to one user, because the
/// transport makes its files accessible to their owner only. Opening a domain also removes what
/// killed processes left behind in it.
#[derive(Debug)]
pub struct Domain {
    pub(crate) node: Held<Node<ipc::Service>>,
    pub(crate) door: Arc<Door>,
}

impl Domain {
    /// Joins the domain that `LARIAT_DOMAIN` names, or the user's own.
    ///
    /// # Errors
    /// The domain belongs to another user, shared memory is missing, or a process that is joining
    /// or leaving is stuck.
    pub fn open() -> Result<Self, WireError> {
        Self::named(&name_here()?)
    }

    /// Joins a domain by name, regardless of the environment. A user's own domain is named after
    /// the user ID.
    ///
    /// # Errors
    /// The domain belongs to another user, shared memory is missing, or a process that is joining
    /// or leaving is stuck.
    pub fn named(name: &str) -> Result<Self, WireError> {
        set_log_level_from_env_or(LogLevel::Fatal);
        let config = config_of(name)?;
        owner::require_own(name, &root_of(&config))?;
        memory::require_shared_memory()?;
        owner::require_own_memory(&tidy::shared_memory(&config))?;
        let (door, passing) = Door::enter(&config)?;
        tidy::remove_counter(&config, &passing);
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>();
        tidy::remove_counter(&config, &passing);
        let node = node.map_err(|cause| match cause {
            iceoryx2::node::NodeCreationFailure::InsufficientPermissions => WireError::Permission {
                channel: "the domain".into(),
            },
            cause => WireError::transport("joining the domain", cause),
        })?;
        Ok(Self {
            node: door.keep(node),
            door,
        })
    }

    /// Removes the shared memory and files that killed processes left behind in this domain.
    pub fn sweep(&self) {
        // Otherwise the next process that joins or leaves does this.
        if let Some(passing) = self.door.leave() {
            tidy::finish(self.config(), &passing);
        }
    }

    /// Calls a function with the transport's own node while no other process creates or removes
    /// anything. For measurements below the level of channels.
    #[doc(hidden)]
    pub fn making<T>(&self, make: impl FnOnce(&Node<ipc::Service>) -> T) -> Result<T, WireError> {
        let _passing = self.door.pass()?;
        Ok(make(&self.node))
    }

    pub(crate) fn config(&self) -> &Config {
        self.node.config()
    }
}

/// A leaving process also removes what killed processes left behind.
impl Drop for Domain {
    fn drop(&mut self) {
        self.sweep();
    }
}

/// The transport's settings for a domain: its own prefix in `/dev/shm` and its own folder.
pub(crate) fn config_of(name: &str) -> Result<Config, WireError> {
    let unusable = || WireError::DomainName(name.into());
    if !is_plain(name, 16) {
        return Err(unusable());
    }
    // Not the global configuration, which a `config/iceoryx2.toml` in the current folder would
    // change.
    let mut config = Config::default();
    let prefix = FileName::new(format!("lariat_{name}_").as_bytes()).map_err(|_| unusable())?;
    let root = Path::new(format!("/tmp/lariat-{name}").as_bytes()).map_err(|_| unusable())?;
    config.global.prefix = prefix;
    config.global.set_root_path(&root);
    // `tidy` cleans up under the lock instead.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    Ok(config)
}

/// The transport's settings for the domain that `LARIAT_DOMAIN` names, or for the user's own.
pub(crate) fn config_here() -> Result<Config, WireError> {
    config_of(&name_here()?)
}

/// Name of the domain in `LARIAT_DOMAIN`, or the user ID. Nothing else of the environment is used,
/// so that a login shell, a service and a cron job of one user share a domain. `XDG_RUNTIME_DIR` is
/// not set in all of them, and is emptied under a running chain when its user logs out.
fn name_here() -> Result<String, WireError> {
    match std::env::var_os("LARIAT_DOMAIN") {
        None => Ok(owner::this_user().to_string()),
        Some(name) => name
            .into_string()
            .map_err(|name| WireError::DomainName(name.to_string_lossy().into_owned())),
    }
}

/// The folder with a domain's locks.
pub(crate) fn root_of(config: &Config) -> PathBuf {
    PathBuf::from(config.global.root_path().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rig_has_a_plain_name() {
        assert_eq!("left-arm_2".parse::<Rig>().unwrap().as_str(), "left-arm_2");
        for name in ["", "Left", "a/b", "a b", &"x".repeat(33)] {
            assert!(
                matches!(name.parse::<Rig>(), Err(WireError::RigName(_))),
                "{name}"
            );
        }
    }
}

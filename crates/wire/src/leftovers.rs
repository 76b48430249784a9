//! What killed processes left in shared memory, in every domain of the machine, without joining any.

use std::collections::BTreeMap;
use std::fs;

use iceoryx2::node::NodeState;
use iceoryx2::prelude::*;

use crate::domain::config_of;
use crate::memory::SHM;

/// The files that a domain's processes left in `/dev/shm` when they were killed, all of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leftover {
    /// The domain's name.
    pub domain: String,
    /// What the names of its files begin with.
    pub prefix: String,
    /// How many there are.
    pub files: usize,
    /// Their size in bytes.
    pub bytes: u64,
}

/// The named domains that have files in `/dev/shm` and no living process. (What is left beside living ones, and in the
/// machine's own domain, the next process to join or leave removes.)
pub fn leftovers() -> Vec<Leftover> {
    let mut found = BTreeMap::<String, Leftover>::new();
    for entry in fs::read_dir(SHM).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(domain) = name.to_str().and_then(domain_of) else {
            continue;
        };
        let leftover = found.entry(domain.to_owned()).or_insert_with(|| Leftover {
            domain: domain.to_owned(),
            prefix: format!("{SHM}/lariat_{domain}_"),
            files: 0,
            bytes: 0,
        });
        leftover.files += 1;
        leftover.bytes += entry.metadata().map_or(0, |data| data.len());
    }
    found
        .into_values()
        .filter(|leftover| !lives(&leftover.domain))
        .collect()
}

/// The domain of a file in `/dev/shm`: after the prefix come the transport's own words, the first of them 40 hexadecimal
/// digits.
fn domain_of(name: &str) -> Option<&str> {
    let rest = name.strip_prefix("lariat_")?;
    let is_hash = |word: &str| word.len() == 40 && word.bytes().all(|c| c.is_ascii_hexdigit());
    rest.match_indices('_')
        .find(|(at, _)| rest[at + 1..].split(['_', '.']).next().is_some_and(is_hash))
        .map(|(at, _)| &rest[..at])
        .filter(|domain| !domain.is_empty())
}

/// Whether a process of this domain lives, or may live.
fn lives(domain: &str) -> bool {
    let Ok(config) = config_of(domain) else {
        return true;
    };
    let mut lives = false;
    let listed = Node::<ipc::Service>::list(&config, |node| match node {
        NodeState::Dead(_) => CallbackProgression::Continue,
        _ => {
            lives = true;
            CallbackProgression::Stop
        }
    });
    lives || listed.is_err()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_tells_its_domain() {
        let hash = "0354a209029e7d094a819e2d4030ea331e6caaf0";
        let domain = |name: String| domain_of(&name).map(str::to_owned);
        let found = domain(format!("lariat_left_arm_{hash}_12.data"));
        assert_eq!(found.as_deref(), Some("left_arm"));
        let found = domain(format!("lariat_t1-2_{hash}_node.0_10_0.global_mgmt"));
        assert_eq!(found.as_deref(), Some("t1-2"));
        for other in [
            format!("iox2_{hash}_1.data"),
            format!("lariat_{hash}"),
            "lariat_a_b".into(),
        ] {
            assert_eq!(domain(other.clone()), None, "{other}");
        }
    }
}

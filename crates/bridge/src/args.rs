//! The command line, and the check that a key is used.

use std::fmt;
use std::io;
use std::net::{SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use anyhow::Result;
use clap::{ArgGroup, Parser, ValueEnum};
use lariat_chain::exit::wrong_use;
use lariat_chain::settings::duration;
use lariat_wire::Rig;

use crate::key::Key;

/// Carry a rig to another machine: its descriptors over the network, with their ages
#[derive(Debug, Parser)]
#[command(name = "lariat bridge", version, after_help = EXAMPLES)]
#[command(group(ArgGroup::new("place").required(true).args(["listen", "connect", "make_key"])))]
pub(crate) struct Args {
    /// On the camera's machine: address to listen on
    #[arg(long, value_name = "udp/ADDRESS:PORT")]
    pub(crate) listen: Option<Place>,
    /// On the other machine: address of the camera's machine
    #[arg(long, value_name = "udp/HOST:PORT")]
    pub(crate) connect: Option<Place>,
    /// Name of the rig, the same on both sides
    #[arg(long, value_name = "NAME", default_value = "default")]
    pub(crate) rig: Rig,
    /// With --connect: also carry these channels, after the descriptors
    #[arg(
        long,
        value_name = "CHANNELS",
        value_enum,
        value_delimiter = ',',
        conflicts_with = "listen"
    )]
    pub(crate) also: Vec<Also>,
    /// With --connect: also carry this many frames per second, as JPEG, on the port after --connect's
    #[arg(long, value_name = "RATE", value_parser = rate, conflicts_with = "listen")]
    pub(crate) frames: Option<f64>,
    /// With --listen: drop commands that are older than this
    #[arg(long, value_name = "TIME", default_value = "100ms", value_parser = duration::parse)]
    pub(crate) command_age: Duration,
    /// Run with realtime priority, on the core of a realtime chain's stages
    #[arg(long)]
    pub(crate) realtime: bool,
    /// File with the key that both sides share
    #[arg(long, value_name = "FILE", conflicts_with = "insecure")]
    key: Option<PathBuf>,
    /// Use no key: anyone on the network, and every user of this machine, can read the rig, forge it, and move the simulated robot
    #[arg(long)]
    insecure: bool,
    /// Write a new key into this file
    #[arg(long, value_name = "FILE")]
    pub(crate) make_key: Option<PathBuf>,
}

/// Channels that can be carried in addition to descriptors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Also {
    /// Centerlines as extract found them
    Centerlines,
    /// The true centerlines of rendered frames
    Truth,
    /// Masks that another process makes, on the port behind --connect's
    Masks,
}

const EXAMPLES: &str = "Examples:
  lariat bridge --make-key cell.key                                             once, then copied to the other machine
  lariat bridge --listen udp/0.0.0.0:7447 --rig cell --key cell.key             on the camera's machine
  lariat bridge --connect udp/camera.local:7447 --rig cell --key cell.key       on the other";

impl Args {
    /// Interval between requested frames in ms; 0 if none are requested.
    pub(crate) fn frames_ms(&self) -> u16 {
        self.frames.map_or(0, |rate| (1000.0 / rate).round() as u16)
    }

    /// Returns the key, or [`Key::NONE`] with `--insecure`. The loopback interface needs a key as
    /// well, because every user of the machine can send there.
    ///
    /// # Errors
    /// Fails if the key cannot be read, or if neither a key nor `--insecure` is given.
    pub(crate) fn key(&self) -> Result<Key> {
        match &self.key {
            Some(path) => Key::read(path),
            None if self.insecure => Ok(Key::NONE),
            None => wrong_use!(
                "without a key, everyone on the network and every user of this machine could read the rig and forge it: make a \
                 key with `lariat bridge --make-key FILE`, copy it to the other side, and give both --key FILE; or say \
                 --insecure"
            ),
        }
    }
}

/// Parses a rate in frames per second.
fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok();
    let rate = rate.filter(|rate| (0.1..=60.0).contains(rate));
    rate.ok_or_else(|| "choose a rate from 0.1 to 60".into())
}

/// Address to listen on or to connect to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Place {
    host: String,
    port: u16,
}

impl Place {
    /// Returns the address for frames, on the next port; `None` if this port is the last.
    pub(crate) fn of_frames(&self) -> Option<Self> {
        let port = self.port.checked_add(1)?;
        Some(Self {
            port,
            ..self.clone()
        })
    }

    /// Resolves the host. Returns at least one address.
    ///
    /// # Errors
    /// Fails if the name is unknown.
    pub(crate) fn addresses(&self) -> io::Result<Vec<SocketAddr>> {
        let host = self.host.trim_start_matches('[').trim_end_matches(']');
        let found: Vec<_> = (host, self.port).to_socket_addrs()?.collect();
        if found.is_empty() {
            return Err(io::Error::new(
                io::ErrorKind::NotFound,
                "the name has no address",
            ));
        }
        Ok(found)
    }
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let said = text
            .strip_prefix("udp/")
            .and_then(|place| place.rsplit_once(':'));
        let port = said
            .and_then(|(_, port)| port.parse().ok())
            .filter(|port| *port > 0);
        match (said, port) {
            (Some((host, _)), Some(port)) if !host.is_empty() && host.chars().all(is_of_host) => {
                Ok(Self {
                    host: host.to_owned(),
                    port,
                })
            }
            _ => Err("write udp/, an address or a name, and a port: udp/192.168.1.20:7447".into()),
        }
    }
}

/// Returns whether a character may occur in a host name, or in an address with its interface.
fn is_of_host(c: char) -> bool {
    c.is_ascii_alphanumeric() || "-._:%[]".contains(c)
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "udp/{}:{}", self.host, self.port)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_an_address_and_a_port() {
        for text in ["udp/0.0.0.0:7447", "udp/[::1]:1", "udp/camera.local:65535"] {
            let place: Place = text.parse().expect(text);
            assert_eq!(place.to_string(), text);
        }
        for text in [
            "",
            "udp/",
            "tcp/127.0.0.1:7447",
            "127.0.0.1:7447",
            "udp/127.0.0.1",
            "udp/:7447",
            "udp/a:0",
            "udp/a:65536",
            "udp/a:7447#iface=eth0",
            "udp/a?rel=1:7",
        ] {
            assert!(
                text.parse::<Place>()
                    .is_err_and(|cause| cause.contains("udp/192")),
                "{text}"
            );
        }
    }

    #[test]
    fn a_bridge_needs_a_key_or_a_word() {
        let args = |words: &str| {
            Args::try_parse_from(["bridge"].into_iter().chain(words.split(' '))).expect("words")
        };
        for place in [
            "--listen udp/127.0.0.1:7447",
            "--connect udp/[::1]:7447",
            "--connect udp/10.0.0.1:7447",
        ] {
            let refusal = args(place).key().err().expect("no key is given");
            assert!(refusal.to_string().contains("--make-key"), "{refusal}");
            let insecure = args(&format!("{place} --insecure"));
            assert!(insecure.key().is_ok());
            assert!(args(&format!("{place} --key /nowhere")).key().is_err());
        }
    }

    #[test]
    fn one_side_is_asked_for() {
        for words in [
            &["bridge"][..],
            &["bridge", "--listen", "udp/a:1", "--connect", "udp/a:1"],
            &["bridge", "--listen", "udp/a:1", "--also", "truth"],
        ] {
            assert!(Args::try_parse_from(words).is_err());
        }
    }
}

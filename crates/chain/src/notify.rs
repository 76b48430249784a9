//! Notifies the service manager in systemd's protocol, which other managers use as well. Datagrams
//! of lines `NAME=value` go to the socket that the environment names (`sd_notify(3)`,
//! `sd_watchdog_enabled(3)`).
//!
//! Without a manager nothing is sent. A manager that does not read delays a message by at most a
//! second. The first message that does not reach it is logged, and the chain continues.

use std::env;
use std::ffi::OsStr;
use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::Duration;

/// Time for which a message waits for room in the manager's queue.
const PATIENCE: Duration = Duration::from_secs(1);

/// The manager that started this process, if there is one and it wants notifications.
#[derive(Debug)]
pub struct Notify {
    manager: Option<(UnixDatagram, SocketAddr)>,
    watchdog: Option<Duration>,
    has_failed: bool,
}

impl Notify {
    /// Reads `NOTIFY_SOCKET`, `WATCHDOG_USEC` and `WATCHDOG_PID`. An invalid address is logged, and
    /// nothing is sent.
    ///
    /// The variables stay set. Code that starts other processes must remove them from their
    /// environment, because the manager listens to only one process.
    pub fn from_env() -> Self {
        let number = |name| env::var(name).ok().and_then(|text| text.parse().ok());
        let pid = number("WATCHDOG_PID");
        let is_ours = pid.is_none_or(|pid| pid == u64::from(std::process::id()));
        let limit_us = number("WATCHDOG_USEC").filter(|&us| us > 0 && is_ours);
        let address = env::var_os("NOTIFY_SOCKET").filter(|address| !address.is_empty());
        Self::to(address.as_deref(), limit_us.map(Duration::from_micros))
    }

    /// `address` is a path, or an abstract name after an `@`. `limit` is the time that the manager
    /// waits for a sign of life.
    fn to(address: Option<&OsStr>, limit: Option<Duration>) -> Self {
        let manager = address.and_then(|address| {
            connected(address)
                .inspect_err(|cause| {
                    let address = address.display();
                    tracing::warn!("NOTIFY_SOCKET={address} cannot be used: {cause}");
                })
                .ok()
        });
        Self {
            watchdog: limit.filter(|_| manager.is_some()).map(|limit| limit / 2),
            manager,
            has_failed: false,
        }
    }

    /// Returns true if there is a manager.
    pub fn is_heard(&self) -> bool {
        self.manager.is_some()
    }

    /// Reports that the chain is running and its rig can be read.
    pub fn ready(&mut self) {
        self.tell("READY=1");
    }

    /// Reports the state in one line for `systemctl status`.
    pub fn status(&mut self, line: &str) {
        // A line break would start another message.
        self.tell(&format!("STATUS={}", line.replace('\n', " ")));
    }

    /// Reports that the chain is alive and at work.
    pub fn watchdog(&mut self) {
        self.tell("WATCHDOG=1");
    }

    /// Reports that the chain is stopping in order.
    pub fn stopping(&mut self) {
        self.tell("STOPPING=1");
    }

    /// Returns the interval at which to call [`watchdog`](Self::watchdog): half of the manager's
    /// limit. Returns `None` without a watchdog.
    pub fn watchdog_period(&self) -> Option<Duration> {
        self.watchdog
    }

    fn tell(&mut self, message: &str) {
        let Some((socket, address)) = &self.manager else {
            return;
        };
        if let Err(cause) = socket.send_to_addr(message.as_bytes(), address)
            && !std::mem::replace(&mut self.has_failed, true)
        {
            tracing::warn!("the service manager does not hear {message}: {cause}");
        }
    }
}

fn connected(address: &OsStr) -> io::Result<(UnixDatagram, SocketAddr)> {
    let address = match address.as_bytes() {
        [b'@', name @ ..] => SocketAddr::from_abstract_name(name)?,
        [b'/', ..] => SocketAddr::from_pathname(address)?,
        _ => {
            return Err(io::Error::other(
                "it is neither a whole path nor a name behind an @",
            ));
        }
    };
    let socket = UnixDatagram::unbound()?;
    socket.set_write_timeout(Some(PATIENCE))?;
    Ok((socket, address))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns what a manager receives from `say`.
    fn heard(socket: &UnixDatagram, mut notify: Notify, say: fn(&mut Notify)) -> Vec<String> {
        say(&mut notify);
        socket.set_nonblocking(true).expect("a socket");
        let mut bytes = [0; 256];
        let mut next = || {
            let length = socket.recv(&mut bytes).ok()?;
            String::from_utf8(bytes[..length].to_vec()).ok()
        };
        std::iter::from_fn(&mut next).collect()
    }

    fn say_all(notify: &mut Notify) {
        notify.ready();
        notify.status("30 frames/s\nREADY=0, 1 rope");
        notify.watchdog();
        notify.stopping();
    }

    const ALL: [&str; 4] = [
        "READY=1",
        "STATUS=30 frames/s READY=0, 1 rope",
        "WATCHDOG=1",
        "STOPPING=1",
    ];

    #[test]
    fn a_manager_at_a_path_hears_all_in_order() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("notify");
        let socket = UnixDatagram::bind(&path).expect("a socket");
        let notify = Notify::to(Some(path.as_os_str()), None);
        assert_eq!(heard(&socket, notify, say_all), ALL);
    }

    #[test]
    fn a_manager_behind_an_abstract_name_hears_all_in_order() {
        let name = format!("lariat-notify-{}", std::process::id());
        let address = SocketAddr::from_abstract_name(&name).expect("a name");
        let socket = UnixDatagram::bind_addr(&address).expect("a socket");
        let notify = Notify::to(Some(OsStr::new(&format!("@{name}"))), None);
        assert_eq!(heard(&socket, notify, say_all), ALL);
    }

    #[test]
    fn the_watchdog_is_fed_twice_within_the_managers_limit_if_there_is_a_manager() {
        let limit = Some(Duration::from_secs(10));
        let somebody = Notify::to(Some(OsStr::new("@nobody-listens-here")), limit);
        assert_eq!(somebody.watchdog_period(), Some(Duration::from_secs(5)));
        assert_eq!(Notify::to(None, limit).watchdog_period(), None);
    }

    #[test]
    fn without_a_manager_or_with_one_that_is_gone_the_chain_goes_on() {
        for address in [
            None,
            Some("@nobody-listens-here"),
            Some("/none/at/all"),
            Some("vsock:1:2"),
        ] {
            let mut notify = Notify::to(address.map(OsStr::new), None);
            say_all(&mut notify);
        }
    }

    #[test]
    fn a_manager_that_reads_nothing_holds_nobody_up_for_ever() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("notify");
        let _socket = UnixDatagram::bind(&path).expect("a socket");
        let mut notify = Notify::to(Some(path.as_os_str()), None);
        // The queue has room for a few messages. The first one that does not fit is dropped.
        while !notify.has_failed {
            notify.watchdog();
        }
    }
}

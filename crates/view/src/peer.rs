//! Finds the user at the other end of a connection from this machine. TCP does not reveal the user,
//! but the kernel's tables of sockets do, and anyone may read them (`proc_pid_net(5)`; the kernel's
//! `Documentation/networking/proc_net_tcp.rst`).

use std::net::{IpAddr, SocketAddr, TcpStream};

use lariat_chain::bounded;
use rustix::process::geteuid;

const TABLES: [&str; 2] = ["/proc/self/net/tcp", "/proc/self/net/tcp6"];
/// Maximum size of a table in bytes: half a million sockets.
const LONGEST: u64 = 64 << 20;
/// Number of attempts. A table that changes while it is read may lack an entry.
const LOOKS: usize = 3;

/// The two ends of a connection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peer {
    theirs: SocketAddr,
    ours: SocketAddr,
}

impl Peer {
    /// Returns the ends of a connection; `None` if it is gone.
    pub(crate) fn of(stream: &TcpStream) -> Option<Self> {
        Some(Self {
            theirs: stream.peer_addr().ok()?,
            ours: stream.local_addr().ok()?,
        })
    }

    /// Returns whether a process of this process's user holds the other end. False if that is
    /// unknown.
    pub(crate) fn is_of_this_user(&self) -> bool {
        let owner = || {
            let texts = TABLES
                .iter()
                .filter_map(|path| bounded::read(path.as_ref(), LONGEST).ok());
            texts
                .filter_map(|bytes| String::from_utf8(bytes).ok())
                .find_map(|text| self.owner_in(&text))
        };
        (0..LOOKS).find_map(|_| owner()) == Some(geteuid().as_raw())
    }

    /// Returns the ID of the user at the other end, if the table lists that end and a process holds
    /// it. The table lists a closed connection as root's.
    fn owner_in(&self, table: &str) -> Option<u32> {
        table.lines().skip(1).find_map(|line| {
            let fields: Vec<&str> = line.split_whitespace().take(10).collect();
            let [_, local, remote, _, _, _, _, owner, _, inode] = fields[..] else {
                return None;
            };
            let is_theirs = address(local)? == canonical(self.theirs)
                && address(remote)? == canonical(self.ours);
            (is_theirs && inode != "0").then(|| owner.parse().ok())?
        })
    }
}

/// Parses an address of the tables: the words of the IP in this machine's byte order, and the port.
fn address(text: &str) -> Option<(IpAddr, u16)> {
    let (ip, port) = text.split_once(':')?;
    let port = u16::from_str_radix(port, 16).ok()?;
    let word = |place: usize| {
        let word = u32::from_str_radix(ip.get(8 * place..8 * place + 8)?, 16).ok()?;
        Some(word.to_ne_bytes())
    };
    let ip = match ip.len() {
        8 => IpAddr::from(word(0)?),
        32 => {
            let words = [word(0)?, word(1)?, word(2)?, word(3)?];
            IpAddr::from(<[u8; 16]>::try_from(words.as_flattened()).ok()?)
        }
        _ => return None,
    };
    Some((ip.to_canonical(), port))
}

fn canonical(address: SocketAddr) -> (IpAddr, u16) {
    (address.ip().to_canonical(), address.port())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::{Shutdown, TcpListener};

    #[test]
    fn our_own_connection_is_ours_by_either_protocol_and_a_closed_one_is_nobodys() {
        for here in ["127.0.0.1:0", "[::1]:0"] {
            // The machine may lack IPv6.
            let Ok(listener) = TcpListener::bind(here) else {
                continue;
            };
            let client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
            let (server, _) = listener.accept().unwrap();
            let peer = Peer::of(&server).unwrap();
            assert!(peer.is_of_this_user(), "{here}");
            // A client that has finished sending still waits for its answer.
            client.shutdown(Shutdown::Write).unwrap();
            assert!(peer.is_of_this_user(), "{here}");
            drop(client);
            assert!(!peer.is_of_this_user(), "{here}");
        }
    }

    #[cfg(target_endian = "little")]
    #[test]
    fn the_owner_of_their_end_is_told_and_neither_ours_nor_one_that_is_closed() {
        let head = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n";
        let peer = |theirs: &str| Peer {
            theirs: theirs.parse().unwrap(),
            ours: "127.0.0.1:8765".parse().unwrap(),
        };
        let line = |local: &str, remote: &str, owner: u32, inode: u32| {
            format!(
                "   0: {local} {remote} 01 00000000:00000000 00:00000000 00000000  {owner}        0 {inode} 1 0 20 4 30 10 -1\n"
            )
        };
        let (ours, theirs) = ("0100007F:223D", "0100007F:C350");
        let both = line(ours, theirs, 5, 10) + &line(theirs, ours, 1000, 11);
        let here = peer("127.0.0.1:50000");
        assert_eq!(here.owner_in(&(head.to_owned() + &both)), Some(1000));
        assert_eq!(
            peer("127.0.0.1:50001").owner_in(&(head.to_owned() + &both)),
            None
        );
        let closed = head.to_owned() + &line(theirs, ours, 0, 0);
        assert_eq!(here.owner_in(&closed), None);
        // An IPv6 socket that speaks IPv4.
        let mapped = line(
            "0000000000000000FFFF00000100007F:C350",
            "0000000000000000FFFF00000100007F:223D",
            1001,
            12,
        );
        assert_eq!(here.owner_in(&(head.to_owned() + &mapped)), Some(1001));
        for broken in [
            "",
            "a b",
            "   0: 0100007F 0100007F:223D 01 0 0 0 1 0 1",
            "é: é:é é:é 0 0 0 0 0 0 0",
        ] {
            assert_eq!(here.owner_in(&format!("{head}{broken}\n")), None);
        }
    }
}

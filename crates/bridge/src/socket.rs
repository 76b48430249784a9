//! A UDP socket that never waits. A datagram that finds no room is lost, and the other side counts
//! it like a loss on the network.

use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::os::fd::{AsFd, BorrowedFd};

use lariat_wire::now_ns;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt;

use crate::args::Place;

/// Largest UDP datagram that both IPv4 and IPv6 can carry, in bytes.
pub(crate) const LARGEST_DATAGRAM: usize = 65_507;

/// Size of the receive buffer in bytes, including the kernel's overhead: a few hundred datagrams.
const ROOM: usize = 1 << 20;

/// Priority in queues that distinguish priorities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rank {
    /// Descriptors, questions, answers, commands.
    First,
    /// Pictures.
    Last,
}

impl Rank {
    /// Returns the differentiated services code point: six bits of a packet's header (RFC 2474).
    /// Linux's own queues and Wi-Fi (RFC 8325) both honor these two. VOICE-ADMIT (RFC 5865) goes
    /// before everything else in either, and AF11 after everything else.
    fn class(self) -> u8 {
        match self {
            Self::First => 44,
            Self::Last => 10,
        }
    }
}

/// A bound socket.
#[derive(Debug)]
pub(crate) struct Socket(UdpSocket);

impl Socket {
    /// Listens on an address.
    ///
    /// # Errors
    /// Fails if the name is unknown, or the address cannot be listened on.
    pub(crate) fn listen(place: &Place, rank: Rank) -> io::Result<Self> {
        Self::with(UdpSocket::bind(&place.addresses()?[..])?, rank)
    }

    /// Creates a socket that can reach an address.
    ///
    /// # Errors
    /// Fails if the system cannot create a socket.
    pub(crate) fn toward(address: SocketAddr, rank: Rank) -> io::Result<Self> {
        let any = match address {
            SocketAddr::V4(_) => SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0)),
            SocketAddr::V6(_) => SocketAddr::from((Ipv6Addr::UNSPECIFIED, 0)),
        };
        Self::with(UdpSocket::bind(any)?, rank)
    }

    fn with(socket: UdpSocket, rank: Rank) -> io::Result<Self> {
        socket.set_nonblocking(true)?;
        // A process that gets no core for a while still finds what arrived. The system may grant
        // less.
        let _ = sockopt::set_socket_recv_buffer_size(&socket, ROOM);
        let class = rank.class() << 2;
        // Networks that ignore the class send packets in order. An IPv6 socket may carry IPv4 too.
        let _ = sockopt::set_ip_tos(&socket, class);
        let _ = sockopt::set_ipv6_tclass(&socket, class.into());
        Ok(Self(socket))
    }

    /// Sends a datagram, or loses it: the buffer may be full, the link down, the route unknown, or
    /// nobody listening.
    pub(crate) fn send(&self, datagram: &[u8], to: SocketAddr) {
        let _ = self.0.send_to(datagram, to);
    }

    /// Sends a datagram to each address.
    pub(crate) fn send_all(&self, datagram: &[u8], to: &[SocketAddr]) {
        to.iter().for_each(|to| self.send(datagram, *to));
    }

    /// Returns the next waiting datagram and its sender; `None` if none is waiting. `buffer` holds
    /// [`LARGEST_DATAGRAM`] bytes.
    pub(crate) fn next<'b>(&self, buffer: &'b mut [u8]) -> Option<(&'b mut [u8], SocketAddr)> {
        loop {
            match self.0.recv_from(buffer) {
                Ok((length, from)) => return Some((&mut buffer[..length], from)),
                Err(cause) if cause.kind() == io::ErrorKind::Interrupted => {}
                // Nothing is waiting. (Only connected sockets learn of a port where nobody
                // listens.)
                Err(_) => return None,
            }
        }
    }
}

/// The descriptor becomes readable when a datagram is waiting.
impl AsFd for Socket {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Sleeps until one of the descriptors is readable, or until the time `due_ns` of [`now_ns`].
pub(crate) fn sleep<const N: usize>(descriptors: [BorrowedFd; N], due_ns: u64) {
    let left_ns = due_ns.saturating_sub(now_ns());
    let left = Timespec {
        tv_sec: (left_ns / 1_000_000_000) as i64,
        tv_nsec: (left_ns % 1_000_000_000) as _,
    };
    let mut descriptors =
        descriptors.map(|descriptor| PollFd::from_borrowed_fd(descriptor, PollFlags::IN));
    // The result does not matter: the caller checks what arrived.
    let _ = poll(&mut descriptors, Some(&left));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nobody_listens_to_is_lost_and_the_socket_goes_on() {
        for host in ["127.0.0.1", "::1"] {
            let Ok(one) = UdpSocket::bind((host, 0)) else {
                // This machine lacks IPv6.
                continue;
            };
            let one = Socket::with(one, Rank::First).expect("a socket");
            let at = one.0.local_addr().expect("bound");
            let other = Socket::toward(at, Rank::Last).expect("a socket");
            let there = SocketAddr::new(at.ip(), other.0.local_addr().expect("bound").port());
            let nobody = {
                let gone = UdpSocket::bind((at.ip(), 0)).expect("a port");
                gone.local_addr().expect("bound")
            };
            let mut buffer = vec![0; LARGEST_DATAGRAM];
            for _ in 0..3 {
                one.send(b"lost", nobody);
                one.send(&vec![0; 1 << 16], there);
                one.send(b"heard", there);
                let stop = UdpSocket::bind("127.0.0.1:0").expect("a port");
                sleep([other.as_fd(), stop.as_fd()], now_ns() + 20_000_000_000);
                let (heard, from) = other.next(&mut buffer).expect("it came");
                assert!(heard == b"heard" && from == at, "{from}");
                assert!(other.next(&mut buffer).is_none() && one.next(&mut buffer).is_none());
            }
        }
    }
}

//! A UDP socket that never waits: what there is no room for is lost, as on the way, and counted as that by the other side.

use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::os::fd::{AsFd, BorrowedFd};

use lariat_wire::now_ns;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt;

use crate::args::Place;

/// The largest datagram that UDP has, over IPv6 and IPv4.
pub(crate) const LARGEST_DATAGRAM: usize = 65_507;

/// Bytes that wait to be read at most, with what the kernel keeps beside them: some hundred datagrams.
const ROOM: usize = 1 << 20;

/// What goes first where a queue knows more than one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rank {
    /// Descriptors, questions, answers, commands.
    First,
    /// Pictures.
    Last,
}

impl Rank {
    /// The six bits of a packet's head by which it is told (RFC 2474), of those that Linux' own queues and Wi-Fi (RFC 8325) both know how to
    /// take: VOICE-ADMIT (RFC 5865) is before all else in either, AF11 behind all else.
    fn class(self) -> u8 {
        match self {
            Self::First => 44,
            Self::Last => 10,
        }
    }
}

/// A socket, bound.
#[derive(Debug)]
pub(crate) struct Socket(UdpSocket);

impl Socket {
    /// Listens at a place.
    ///
    /// # Errors
    /// The name is not known, or it cannot be listened there.
    pub(crate) fn listen(place: &Place, rank: Rank) -> io::Result<Self> {
        Self::with(UdpSocket::bind(&place.addresses()?[..])?, rank)
    }

    /// A socket from which an address can be reached.
    ///
    /// # Errors
    /// The system has none.
    pub(crate) fn toward(address: SocketAddr, rank: Rank) -> io::Result<Self> {
        let any = match address {
            SocketAddr::V4(_) => SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0)),
            SocketAddr::V6(_) => SocketAddr::from((Ipv6Addr::UNSPECIFIED, 0)),
        };
        Self::with(UdpSocket::bind(any)?, rank)
    }

    fn with(socket: UdpSocket, rank: Rank) -> io::Result<Self> {
        socket.set_nonblocking(true)?;
        // A process that gets no core for a while finds what came meanwhile: as much as the system gives anybody, up to this.
        let _ = sockopt::set_socket_recv_buffer_size(&socket, ROOM);
        let class = rank.class() << 2;
        // Where it is not heeded, all goes in its turn. A socket of IPv6 may carry IPv4 too.
        let _ = sockopt::set_ip_tos(&socket, class);
        let _ = sockopt::set_ipv6_tclass(&socket, class.into());
        Ok(Self(socket))
    }

    /// Sends a datagram, or loses it: a full buffer, a link that is down, a way that is not known, a port where nobody listens.
    pub(crate) fn send(&self, datagram: &[u8], to: SocketAddr) {
        let _ = self.0.send_to(datagram, to);
    }

    /// Sends a datagram to each of these.
    pub(crate) fn send_all(&self, datagram: &[u8], to: &[SocketAddr]) {
        to.iter().for_each(|to| self.send(datagram, *to));
    }

    /// The next datagram that waits, into `buffer`, which is of [`LARGEST_DATAGRAM`] bytes; and who sent it.
    pub(crate) fn next<'b>(&self, buffer: &'b mut [u8]) -> Option<(&'b mut [u8], SocketAddr)> {
        loop {
            match self.0.recv_from(buffer) {
                Ok((length, from)) => return Some((&mut buffer[..length], from)),
                Err(cause) if cause.kind() == io::ErrorKind::Interrupted => {}
                // None waits. (A port where nobody listens is told to connected sockets alone.)
                Err(_) => return None,
            }
        }
    }
}

/// Becomes readable when a datagram waits.
impl AsFd for Socket {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Sleeps until one of these is readable, or a moment of [`now_ns`] has come.
pub(crate) fn sleep<const N: usize>(descriptors: [BorrowedFd; N], due_ns: u64) {
    let left_ns = due_ns.saturating_sub(now_ns());
    let left = Timespec {
        tv_sec: (left_ns / 1_000_000_000) as i64,
        tv_nsec: (left_ns % 1_000_000_000) as _,
    };
    let mut descriptors =
        descriptors.map(|descriptor| PollFd::from_borrowed_fd(descriptor, PollFlags::IN));
    // The result does not matter: who looks sees what came.
    let _ = poll(&mut descriptors, Some(&left));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nobody_listens_to_is_lost_and_the_socket_goes_on() {
        for host in ["127.0.0.1", "::1"] {
            let Ok(one) = UdpSocket::bind((host, 0)) else {
                // There is no IPv6.
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

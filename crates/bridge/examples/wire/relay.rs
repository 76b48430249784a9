//! A relay of UDP datagrams. It delays, loses and thereby reorders them at random, from a seed.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// Delay, jitter and loss of datagrams, either way.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Weather {
    /// Minimum delay.
    pub(crate) delay: Duration,
    /// Maximum additional delay, different for each datagram, so that later ones overtake earlier
    /// ones.
    pub(crate) jitter: Duration,
    /// Datagrams lost per thousand.
    pub(crate) lost_of_1000: u64,
}

/// A datagram in transit: when it is due, its number, its client, whether it goes up, and its
/// bytes.
type UnderWay = Reverse<(Instant, u64, SocketAddr, bool, Vec<u8>)>;

/// A relay. It relays for each client that sends to its address, with a socket for each.
pub(crate) struct Relay {
    listens: UdpSocket,
    to: SocketAddr,
    weather: Weather,
    random: u64,
    count: u64,
    clients: HashMap<SocketAddr, UdpSocket>,
    under_way: BinaryHeap<UnderWay>,
}

impl Relay {
    /// Fails if the address cannot be listened on.
    pub(crate) fn new(
        listens: SocketAddr,
        to: SocketAddr,
        weather: Weather,
        seed: u64,
    ) -> io::Result<Self> {
        let listens = UdpSocket::bind(listens)?;
        listens.set_nonblocking(true)?;
        Ok(Self {
            listens,
            to,
            weather,
            random: seed,
            count: 0,
            clients: HashMap::new(),
            under_way: BinaryHeap::new(),
        })
    }

    /// Relays for as long as `wanted` returns true, which it checks every 50 ms.
    ///
    /// # Errors
    /// Fails if a socket fails.
    pub(crate) fn run(&mut self, wanted: impl Fn() -> bool) -> io::Result<()> {
        let mut buffer = vec![0; 65536];
        while wanted() {
            self.sleep();
            while let Ok((length, from)) = self.listens.recv_from(&mut buffer) {
                if !self.clients.contains_key(&from) {
                    let up = UdpSocket::bind("0.0.0.0:0")?;
                    up.connect(self.to)?;
                    up.set_nonblocking(true)?;
                    self.clients.insert(from, up);
                }
                self.take(from, true, &buffer[..length]);
            }
            let clients: Vec<SocketAddr> = self.clients.keys().copied().collect();
            for client in clients {
                while let Ok(length) = self.clients[&client].recv(&mut buffer) {
                    self.take(client, false, &buffer[..length]);
                }
            }
            let now = Instant::now();
            while self
                .under_way
                .peek()
                .is_some_and(|Reverse((due, ..))| *due <= now)
            {
                let Some(Reverse((_, _, client, is_up, bytes))) = self.under_way.pop() else {
                    break;
                };
                // If the peer is not there, the datagram is lost.
                let _ = match is_up {
                    true => self.clients[&client].send(&bytes),
                    false => self.listens.send_to(&bytes, client),
                };
            }
        }
        Ok(())
    }

    fn take(&mut self, client: SocketAddr, is_up: bool, bytes: &[u8]) {
        let lost = self.next() % 1000 < self.weather.lost_of_1000;
        let jitter_ns = self.weather.jitter.as_nanos() as u64;
        let more = Duration::from_nanos(self.next() % (jitter_ns + 1));
        if !lost {
            self.count += 1;
            let due = Instant::now() + self.weather.delay + more;
            self.under_way
                .push(Reverse((due, self.count, client, is_up, bytes.to_vec())));
        }
    }

    fn next(&mut self) -> u64 {
        self.random = self
            .random
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        self.random >> 20
    }

    /// Sleeps until a datagram comes or is due.
    fn sleep(&self) {
        let mut sockets = vec![PollFd::from_borrowed_fd(
            self.listens.as_fd(),
            PollFlags::IN,
        )];
        sockets.extend(
            self.clients
                .values()
                .map(|client| PollFd::from_borrowed_fd(client.as_fd(), PollFlags::IN)),
        );
        let due = self
            .under_way
            .peek()
            .map(|Reverse((due, ..))| due.saturating_duration_since(Instant::now()));
        let left = due.unwrap_or(Duration::MAX).min(Duration::from_millis(50));
        let left = Timespec {
            tv_sec: 0,
            tv_nsec: left.subsec_nanos() as _,
        };
        let _ = poll(&mut sockets, Some(&left));
    }
}

//! Handles what far sides send. The thread that receives a question or a command also answers or
//! executes it. Each µs of delay before an answer adds 1 µs of doubt about the clock.

use std::net::SocketAddr;
use std::os::fd::AsFd;

use lariat_chain::stop::Stop;
use lariat_wire::now_ns;

use super::robot::{Done, Gives, Robot};
use super::{LARGEST_DATAGRAM, Near, ask};
use crate::datagram::{Datagram, Incoming, Kind, Refused};
use crate::say;
use crate::socket::{Socket, sleep};

/// Interval at which the thread checks whether the controller still controls the robot.
const LOOK_NS: u64 = 250_000_000;

/// Handles datagrams until told to stop. Returns counts of the commands by outcome.
pub(super) fn run(
    near: &Near,
    socket: &Socket,
    incoming: Incoming,
    robot: Robot,
    stop: &Stop,
) -> Done {
    let gives = Gives::open();
    if let Err(cause) = &gives {
        say(&format!("no commands are taken: {cause}"));
    }
    let mut hearing = Hearing {
        near,
        socket,
        incoming,
        robot,
        gives: gives.ok(),
        answer: Vec::new(),
    };
    let mut buffer = vec![0; LARGEST_DATAGRAM];
    let mut look_ns = 0;
    while !stop.asked() {
        if let Some((bytes, from)) = socket.next(&mut buffer) {
            hearing.take(now_ns(), bytes, from);
        } else {
            sleep([socket.as_fd(), stop.as_fd()], look_ns);
        }
        if now_ns() >= look_ns {
            look_ns = now_ns() + LOOK_NS;
            if let Some(gives) = &mut hearing.gives
                && !hearing.robot.is_held(now_ns())
            {
                gives.let_go();
            }
        }
    }
    hearing.robot.done()
}

struct Hearing<'n> {
    near: &'n Near,
    socket: &'n Socket,
    incoming: Incoming,
    robot: Robot,
    gives: Option<Gives>,
    answer: Vec<u8>,
}

impl Hearing<'_> {
    fn take(&mut self, at_ns: u64, bytes: &mut [u8], from: SocketAddr) {
        let datagram = match self.incoming.read(bytes) {
            Ok(datagram) => datagram,
            Err(cause) => return self.near.refuse(cause),
        };
        match datagram.kind {
            Kind::Ask => {
                let (asked, is_first) = {
                    let mut peers = self.near.peers();
                    let was_asked = peers.also(at_ns).is_some();
                    let asked = ask(&mut peers, &datagram, from, at_ns);
                    (asked, !was_asked && peers.also(at_ns).is_some())
                };
                let Some((question, told)) = asked else {
                    return;
                };
                self.near.answer(&question, told, at_ns, &mut self.answer);
                self.socket.send(&self.answer, from);
                if is_first {
                    // Writing fails only if the counter is full, and then the descriptor is
                    // readable anyway.
                    let _ = rustix::io::write(&self.near.first, &1_u64.to_ne_bytes());
                }
            }
            Kind::Command => {
                if let Some(gives) = &mut self.gives {
                    let Datagram {
                        process,
                        count,
                        says,
                        ..
                    } = datagram;
                    self.robot.obey(gives, process, count, says);
                }
            }
            _ => self.near.refuse(Refused::Foreign),
        }
    }
}

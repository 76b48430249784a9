//! Sends the commands of a controller on this machine to the robot, each at once, with its
//! timestamps on the robot's clock.

use std::os::fd::AsFd;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use lariat_chain::stop::Stop;
use lariat_wire::{COMMANDS, Command, Domain, Rig, now_ns};

use super::Upward;
use crate::channel::{Read, Woken};
use crate::datagram::{Kind, Outgoing};
use crate::pack::pack;
use crate::say;

/// Interval at which the channel is checked for a controller.
const CHECK: Duration = Duration::from_millis(250);

/// Sends commands until told to stop. Returns their number.
pub(super) fn run(rig: &Rig, outgoing: &Outgoing, upward: &Mutex<Upward>, stop: &Stop) -> u64 {
    let domain = match Domain::open() {
        Ok(domain) => domain,
        Err(cause) => {
            say(&format!("no commands are sent: {cause}"));
            return 0;
        }
    };
    let mut commands = Read::new(&COMMANDS, Woken::Yes);
    let mut datagram = Vec::new();
    while !stop.asked() {
        commands.follow(&domain, rig, true);
        let due = Instant::now() + CHECK;
        while !stop.asked() && Instant::now() < due {
            let slept = commands
                .receiver()
                .is_some_and(|reader| reader.sleep(Some(due), Some(stop.as_fd())).is_ok());
            if !slept {
                stop.sleep_until(now_ns() + CHECK.as_nanos() as u64);
            }
            // The newest wins here too: commands before it are outdated.
            let mut newest = None;
            while let Some(command) = commands.next() {
                newest = Some(*command);
            }
            if let Some(command) = newest {
                send(&command, outgoing, upward, &mut datagram);
            }
        }
    }
    outgoing.sent(Kind::Command)
}

/// Sends a command, if the other side is there.
fn send(command: &Command, outgoing: &Outgoing, upward: &Mutex<Upward>, datagram: &mut Vec<u8>) {
    let ((socket, near), process, offset) = {
        let upward = upward.lock().unwrap_or_else(PoisonError::into_inner);
        let (Some(socket), Some((process, offset))) = (&upward.socket, upward.near) else {
            return;
        };
        (socket.clone(), process, offset)
    };
    let there = |ns: u64| if ns > 0 { offset.there(ns) } else { 0 };
    let told = Command {
        sent_ns: there(command.sent_ns),
        exposed_ns: there(command.exposed_ns),
        ..*command
    };
    outgoing.write(Kind::Command, datagram, |to| {
        to.extend(process.to_le_bytes());
        pack(&told, to);
    });
    socket.send(datagram, near);
}

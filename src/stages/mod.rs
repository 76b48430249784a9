//! The four stages as processes: thin shells that receive, call a library, and send.

#[cfg(test)]
mod allocation;
pub(crate) mod capture;
pub(crate) mod extract;
pub(crate) mod fit;
mod masks;
pub(crate) mod sink;
pub(crate) mod status;

use std::os::fd::AsFd;

use lariat_wire::{Delivery, Domain, Message, Payload, Reader, Rig, WireError, now_ns};

use crate::settings::Settings;
use crate::stop::Stop;
use status::Status;

/// What every stage has: its place on the wire, the signal that ends it, the line to the chain that started it.
pub(crate) struct Station {
    pub(crate) domain: Domain,
    pub(crate) rig: Rig,
    pub(crate) delivery: Delivery,
    pub(crate) stop: Stop,
    pub(crate) status: Status,
}

impl Station {
    pub(crate) fn open(settings: &Settings) -> anyhow::Result<Self> {
        let stop = Stop::on_signals()?;
        let status = Status::of_the_chain()?;
        let delivery = if settings.run.lossless {
            Delivery::Lossless { stop: stop.flag() }
        } else {
            Delivery::NewestWins
        };
        Ok(Self {
            domain: Domain::open()?,
            rig: settings.run.rig.parse()?,
            delivery,
            stop,
            status,
        })
    }
}

/// Watches the counter of the stage before for gaps.
///
/// A backlog is worked off in order. But a gap says that the backlog overflowed: what still waits is old then, and the
/// newest message is worth more than the rest.
#[derive(Default)]
pub(crate) struct Backlog {
    last: Option<u64>,
}

impl Backlog {
    /// Takes the counter of a message just received; `true` if messages before it were lost.
    pub(crate) fn overflowed(&mut self, count: u64) -> bool {
        let gap = self.last.is_some_and(|last| count > last + 1);
        self.last = Some(count);
        gap
    }
}

/// Receives the next message of a stage, sleeping until there is one; `None` when the stage is to end and nothing waits.
///
/// Returns the message with the moment it was in hand.
pub(crate) fn receive<P: Payload + ?Sized>(
    reader: &Reader<P>,
    backlog: &mut Backlog,
    count: impl Fn(&Message<P>) -> u64,
    stop: &Stop,
) -> Result<Option<(Message<P>, u64)>, WireError> {
    loop {
        // Asked before looking: what was sent before the signal is still received.
        let last_look = stop.asked();
        if let Some(mut message) = reader.next()? {
            if backlog.overflowed(count(&message)) {
                message = reader.newest_after(message)?;
                backlog.last = Some(count(&message));
            }
            return Ok(Some((message, now_ns())));
        }
        if last_look {
            return Ok(None);
        }
        reader.sleep(None, Some(stop.as_fd()))?;
    }
}

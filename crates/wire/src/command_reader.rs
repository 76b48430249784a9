#![allow(unsafe_code)] // A reader may go to another thread, which the transport's own counters do not know.
//! The simulated robot's end of its rig's commands.

use std::fmt;

use crate::{COMMANDS, Command, Delivery, Domain, Receiver, Rig, WireError};

/// Reads the commands of a rig, one after the other. It may be there before the controller, and outlives it.
pub struct CommandReader {
    // Before the domain that it lives in.
    receiver: Receiver<Command>,
    _domain: Domain,
}

// SAFETY: as of `Reader`. What keeps it from being `Send` are counted references without atomics inside the transport's
// subscriber, which its samples share: no sample leaves `next`, and the subscriber is a field of this one reader.
unsafe impl Send for CommandReader {}

impl fmt::Debug for CommandReader {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("CommandReader")
            .field("receiver", &self.receiver)
            .finish_non_exhaustive()
    }
}

impl CommandReader {
    /// Becomes a reader of a rig's commands. It is never woken: it looks when it needs them.
    ///
    /// # Errors
    /// No shared memory, a controller of another release or of another user, or too many readers.
    pub fn open(domain: Domain, rig: &Rig) -> Result<Self, WireError> {
        let delivery = Some(&Delivery::NewestWins);
        Ok(Self {
            receiver: Receiver::create_unwoken(&domain, rig, &COMMANDS, delivery)?,
            _domain: domain,
        })
    }

    /// The oldest command that waits, without blocking; `None` if there is none.
    ///
    /// # Errors
    /// The transport's.
    pub fn next(&self) -> Result<Option<Command>, WireError> {
        Ok(self.receiver.next()?.map(|message| *message))
    }
}

#![allow(unsafe_code)] // Readers move between threads despite their non-atomic counters.
//! The simulated robot's end of its rig's commands.

use std::fmt;

use crate::{COMMANDS, Command, Delivery, Domain, Receiver, Rig, WireError};

/// Reads the commands of a rig in order. It may be opened before the controller, and outlives it.
pub struct CommandReader {
    // Drops before the domain that contains it.
    receiver: Receiver<Command>,
    _domain: Domain,
}

// SAFETY: as for `Reader`, only reference counts without atomics are not `Send`: those in the
// transport's subscriber, which its samples share. No sample leaves `next`, and the subscriber is a
// field of this reader.
unsafe impl Send for CommandReader {}

impl fmt::Debug for CommandReader {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("CommandReader")
            .field("receiver", &self.receiver)
            .finish_non_exhaustive()
    }
}

impl CommandReader {
    /// Opens a reader of a rig's commands. The reader is never woken: call [`next`](Self::next)
    /// when the robot needs commands.
    ///
    /// # Errors
    /// Shared memory is missing, the controller is of another release or another user, or the rig
    /// has too many readers.
    pub fn open(domain: Domain, rig: &Rig) -> Result<Self, WireError> {
        let delivery = Some(&Delivery::NewestWins);
        Ok(Self {
            receiver: Receiver::create_unwoken(&domain, rig, &COMMANDS, delivery)?,
            _domain: domain,
        })
    }

    /// Returns the oldest waiting command without blocking; `None` if nothing waits.
    ///
    /// # Errors
    /// The transport failed.
    pub fn next(&self) -> Result<Option<Command>, WireError> {
        Ok(self.receiver.next()?.map(|message| *message))
    }
}

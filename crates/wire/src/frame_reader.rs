#![allow(unsafe_code)] // Readers move between threads despite their non-atomic counters.
//! Reads a rig's frames for a user's program: a mask network, a display or a recorder.

use std::fmt;
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::{Domain, FRAMES, Message, Receiver, Rig, WireError};

/// Reads the frames of a rig, as the chain's own extract does. It reads the newest frame and may
/// skip some. In a `--lossless` chain, it reads every frame, and the chain waits for it.
///
/// It may be opened before the chain runs, and outlives it. At most four readers, including
/// extract, share a rig's frames. A reader belongs to one thread at a time.
pub struct FrameReader {
    // Fields drop in order: the message before its channel, the channel before the domain.
    held: Option<Message<[u8]>>,
    receiver: Receiver<[u8]>,
    _domain: Domain,
    has_each: bool,
}

// SAFETY: as for `Reader`, everything that shares a non-atomic count is a field of this struct and
// only borrowed from it.
unsafe impl Send for FrameReader {}

impl fmt::Debug for FrameReader {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("FrameReader")
            .field("receiver", &self.receiver)
            .finish_non_exhaustive()
    }
}

impl FrameReader {
    /// Opens a reader of a rig's frames. The rig is `"default"`, or the one that the chain was
    /// started with (`--rig NAME`).
    ///
    /// # Errors
    /// The name is invalid, shared memory is missing, the chain is of another release or another
    /// user, or the rig has four readers already.
    pub fn open(rig: &str) -> Result<Self, WireError> {
        Self::open_in(Domain::open()?, &rig.parse()?, None)
    }

    /// Opens a reader in a given domain. `lossless` says whether the chain is started with
    /// `--lossless`. `None` follows the running chain; without one, it means not lossless.
    ///
    /// # Errors
    /// As for [`open`](Self::open), or the chain is open with the other setting of `lossless`.
    pub fn open_in(domain: Domain, rig: &Rig, lossless: Option<bool>) -> Result<Self, WireError> {
        let delivery = FRAMES.delivery(&domain, rig, lossless, &Arc::default())?;
        let receiver = Receiver::create(&domain, rig, &FRAMES, Some(&delivery))?;
        Ok(Self {
            held: None,
            has_each: receiver.is_lossless(),
            receiver,
            _domain: domain,
        })
    }

    /// Returns the next frame without waiting; `None` if nothing new has arrived. The frame stays
    /// in shared memory until the next call.
    ///
    /// # Errors
    /// The transport failed.
    pub fn try_next(&mut self) -> Result<Option<&Message<[u8]>>, WireError> {
        self.held = None;
        self.held = if self.has_each {
            self.receiver.next()?
        } else {
            self.receiver.latest()?
        };
        Ok(self.held.as_ref())
    }

    /// Waits for the next frame until the deadline, or without limit; `None` if nothing arrived.
    ///
    /// # Errors
    /// The transport failed.
    pub fn wait(&mut self, deadline: Option<Instant>) -> Result<Option<&Message<[u8]>>, WireError> {
        while self.try_next()?.is_none()
            && deadline.is_none_or(|deadline| Instant::now() < deadline)
        {
            self.receiver.sleep(deadline, None)?;
        }
        Ok(self.held.as_ref())
    }

    /// Prepares for a `poll` on [this reader's descriptor](AsFd::as_fd), as
    /// [`Reader::before_poll`](crate::Reader::before_poll) does.
    ///
    /// # Errors
    /// The transport failed.
    pub fn before_poll(&mut self) -> Result<Option<Duration>, WireError> {
        self.receiver.before_poll()
    }

    /// Returns whether this reader receives every frame, because the writer waits for slow readers.
    pub fn is_lossless(&self) -> bool {
        self.has_each
    }
}

/// The descriptor is readable when a frame has arrived.
impl AsFd for FrameReader {
    fn as_fd(&self) -> BorrowedFd<'_> {
        let bell = self.receiver.descriptor();
        bell.expect("a frame reader's receiver is made with an ear, always")
    }
}

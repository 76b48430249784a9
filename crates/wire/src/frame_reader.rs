#![allow(unsafe_code)] // A reader may go to another thread, which the transport's own counters do not know.
//! A rig's frames for a program of the user's: a mask network, a display, a recorder of its own.

use std::fmt;
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::{Domain, FRAMES, Message, Receiver, Rig, WireError};

/// Reads the frames of a rig, as the chain's own extract does: the newest, where frames may be left out, and each one of a
/// `--lossless` chain, which waits for it.
///
/// It may be opened before the chain runs, and outlives it. Four readers, extract among them, share a rig's frames. It belongs
/// to one thread at a time.
pub struct FrameReader {
    // The message first, then its channel, then the domain: each lives in the next.
    held: Option<Message<[u8]>>,
    receiver: Receiver<[u8]>,
    _domain: Domain,
    has_each: bool,
}

// SAFETY: as for `Reader`: what share a count without atomics are fields of this one struct, lent out by a borrow of it only.
unsafe impl Send for FrameReader {}

impl fmt::Debug for FrameReader {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("FrameReader")
            .field("receiver", &self.receiver)
            .finish_non_exhaustive()
    }
}

impl FrameReader {
    /// Opens a reader of a rig's frames: `"default"`, or what the chain was started with (`--rig NAME`).
    ///
    /// # Errors
    /// No such name, no shared memory, a chain of another release or of another user, or four readers already.
    pub fn open(rig: &str) -> Result<Self, WireError> {
        Self::open_in(Domain::open()?, &rig.parse()?, None)
    }

    /// The same, in a domain of one's own choice. `lossless`: whether the chain is started with `--lossless`; `None`: as the
    /// chain is that runs, without where none does.
    ///
    /// # Errors
    /// As [`open`](Self::open); and the chain is the other of the two.
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

    /// The next frame, without waiting; `None` if none came since the last. It stays in shared memory until the next look.
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

    /// The next frame, waited for until the deadline, or for as long as it takes; `None` if none came.
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

    /// Makes ready for a `poll` on [this reader's descriptor](AsFd::as_fd), as
    /// [`Reader::before_poll`](crate::Reader::before_poll) does.
    ///
    /// # Errors
    /// The transport failed.
    pub fn before_poll(&mut self) -> Result<Option<Duration>, WireError> {
        self.receiver.before_poll()
    }

    /// Whether it has every frame, because their writer waits for it.
    pub fn is_lossless(&self) -> bool {
        self.has_each
    }
}

/// Becomes readable when a frame came.
impl AsFd for FrameReader {
    fn as_fd(&self) -> BorrowedFd<'_> {
        let bell = self.receiver.descriptor();
        bell.expect("a frame reader's receiver is made with an ear, always")
    }
}

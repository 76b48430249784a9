//! What zenoh's threads heard, handed to the thread that has the channels: those belong to one thread, zenoh's callbacks to any.

use std::collections::VecDeque;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::{Mutex, PoisonError};

use lariat_wire::now_ns;
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll};
use rustix::io::{read, write};

/// So many wait; then the oldest makes room, and is lost.
const MOST: usize = 256;

/// A datagram, and when it came.
#[derive(Debug, Default)]
pub(crate) struct Arrived {
    pub(crate) at_ns: u64,
    pub(crate) bytes: Vec<u8>,
}

/// Datagrams that wait.
pub(crate) struct Inbox {
    queue: Mutex<Queue>,
    bell: OwnedFd,
}

#[derive(Default)]
struct Queue {
    waiting: VecDeque<Arrived>,
    /// Buffers that are used again.
    spare: Vec<Vec<u8>>,
}

impl Inbox {
    /// # Errors
    /// The system has no descriptor left.
    pub(crate) fn new() -> rustix::io::Result<Self> {
        let bell = eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC)?;
        Ok(Self {
            queue: Mutex::default(),
            bell,
        })
    }

    fn queue(&self) -> std::sync::MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts a datagram behind those that wait.
    pub(crate) fn put<'b>(&self, at_ns: u64, parts: impl Iterator<Item = &'b [u8]>) {
        let mut queue = self.queue();
        let mut bytes = queue.spare.pop().unwrap_or_default();
        bytes.clear();
        parts.for_each(|part| bytes.extend_from_slice(part));
        if queue.waiting.len() == MOST {
            queue.waiting.pop_front();
        }
        let was_empty = queue.waiting.is_empty();
        queue.waiting.push_back(Arrived { at_ns, bytes });
        drop(queue);
        if was_empty {
            // It fails only if it has been rung often enough already.
            let _ = write(&self.bell, &1_u64.to_ne_bytes());
        }
    }

    /// The oldest that waits; the one before is done with.
    pub(crate) fn next(&self, done: &mut Arrived) -> bool {
        let mut queue = self.queue();
        let Some(arrived) = queue.waiting.pop_front() else {
            return false;
        };
        let before = std::mem::replace(done, arrived);
        if queue.spare.len() < MOST {
            queue.spare.push(before.bytes);
        }
        true
    }

    /// Sleeps until a datagram may wait, `also` is readable, or a moment of [`now_ns`] has come.
    pub(crate) fn sleep(&self, due_ns: u64, also: BorrowedFd) {
        let left_ns = due_ns.saturating_sub(now_ns());
        let left = Timespec {
            tv_sec: (left_ns / 1_000_000_000) as i64,
            tv_nsec: (left_ns % 1_000_000_000) as _,
        };
        let mut descriptors = [
            PollFd::new(&self.bell, PollFlags::IN),
            PollFd::from_borrowed_fd(also.as_fd(), PollFlags::IN),
        ];
        // The result does not matter: who looks sees what came.
        let _ = poll(&mut descriptors, Some(&left));
        let _ = read(&self.bell, &mut [0_u8; 8]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_comes_out_in_order_and_the_oldest_makes_room() {
        let inbox = Inbox::new().expect("a descriptor");
        let mut arrived = Arrived::default();
        assert!(!inbox.next(&mut arrived));
        for i in 0..MOST as u64 + 10 {
            inbox.put(i, [&b"a"[..], &[i as u8]].into_iter());
        }
        for i in 10..MOST as u64 + 10 {
            assert!(inbox.next(&mut arrived));
            assert_eq!(
                (arrived.at_ns, &arrived.bytes[..]),
                (i, &[b'a', i as u8][..])
            );
        }
        assert!(!inbox.next(&mut arrived));
    }
}

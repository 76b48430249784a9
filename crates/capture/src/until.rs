//! Limits a source's wait: for its own event, but no longer than the caller wants.

use std::cell::Cell;
use std::os::fd::BorrowedFd;

use lariat_message::now_ns;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// The conditions that end a wait for the next frame.
#[derive(Debug)]
pub struct Until<'a> {
    deadline_ns: Option<u64>,
    interrupt: Option<BorrowedFd<'a>>,
    waited_ns: Cell<u64>,
}

/// How a wait ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Woken {
    /// The event occurred; contains the flags that `poll` returned.
    Ready(PollFlags),
    /// The source's own moment has come.
    Moment,
    /// The caller wants an answer now.
    Interrupted,
}

impl<'a> Until<'a> {
    /// Waits without limit.
    pub fn forever() -> Self {
        Self {
            deadline_ns: None,
            interrupt: None,
            waited_ns: Cell::new(0),
        }
    }

    /// Waits until `deadline_ns` on the clock of [`now_ns`], if given, or until `interrupt` is
    /// readable.
    pub fn new(deadline_ns: Option<u64>, interrupt: BorrowedFd<'a>) -> Self {
        Self {
            deadline_ns,
            interrupt: Some(interrupt),
            ..Self::forever()
        }
    }

    /// The longest single wait, which shows whether the thread has slept.
    pub fn waited_ns(&self) -> u64 {
        self.waited_ns.get()
    }

    /// Waits for an event, for a moment on the clock of [`now_ns`], or for both. If neither is
    /// given, it waits only for the interruption. An event that is ready is reported without
    /// sleeping, and an interruption before everything else.
    pub fn wait(&self, event: Option<(BorrowedFd, PollFlags)>, moment_ns: Option<u64>) -> Woken {
        let mut began_ns = now_ns();
        loop {
            let earliest_ns = match (moment_ns, self.deadline_ns) {
                (Some(moment), Some(deadline)) => Some(moment.min(deadline)),
                (one, other) => one.or(other),
            };
            let left_ns = earliest_ns.map(|ns| ns.saturating_sub(began_ns));
            let (interrupted, ready) = self.poll(event, left_ns);
            let ended_ns = now_ns();
            let waited_ns = ended_ns.saturating_sub(began_ns);
            self.waited_ns.set(self.waited_ns.get().max(waited_ns));
            began_ns = ended_ns;
            let is_past = |ns: Option<u64>| ns.is_some_and(|ns| ended_ns >= ns);
            if interrupted || is_past(self.deadline_ns) {
                return Woken::Interrupted;
            } else if !ready.is_empty() {
                return Woken::Ready(ready);
            } else if is_past(moment_ns) {
                return Woken::Moment;
            }
        }
    }

    /// Sleeps once; a signal may end that early. Returns whether it was interrupted, and the flags
    /// of the event's descriptor.
    fn poll(
        &self,
        event: Option<(BorrowedFd, PollFlags)>,
        left_ns: Option<u64>,
    ) -> (bool, PollFlags) {
        let left = left_ns.map(|ns| Timespec {
            tv_sec: (ns / 1_000_000_000) as i64,
            tv_nsec: (ns % 1_000_000_000) as _,
        });
        // The return value of `poll` does not matter: the descriptors and the clock say what
        // happened.
        match (self.interrupt, event) {
            (None, None) => {
                let _ = poll(&mut [], left.as_ref());
                (false, PollFlags::empty())
            }
            (None, Some((fd, flags))) => {
                let mut fds = [PollFd::from_borrowed_fd(fd, flags)];
                let _ = poll(&mut fds, left.as_ref());
                (false, fds[0].revents())
            }
            (Some(interrupt), None) => {
                let mut fds = [PollFd::from_borrowed_fd(interrupt, PollFlags::IN)];
                let _ = poll(&mut fds, left.as_ref());
                (!fds[0].revents().is_empty(), PollFlags::empty())
            }
            (Some(interrupt), Some((fd, flags))) => {
                let mut fds = [
                    PollFd::from_borrowed_fd(interrupt, PollFlags::IN),
                    PollFd::from_borrowed_fd(fd, flags),
                ];
                let _ = poll(&mut fds, left.as_ref());
                (!fds[0].revents().is_empty(), fds[1].revents())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::os::fd::AsFd;
    use std::os::unix::net::UnixStream;

    use super::*;

    #[test]
    fn an_interruption_ends_a_wait_before_anything_else_does() {
        let (mut event_in, event) = UnixStream::pair().unwrap();
        let (mut stop_in, stop) = UnixStream::pair().unwrap();
        let until = Until::new(None, stop.as_fd());
        let event = Some((event.as_fd(), PollFlags::IN));
        event_in.write_all(&[1]).unwrap();
        assert_eq!(until.wait(event, Some(0)), Woken::Ready(PollFlags::IN));
        stop_in.write_all(&[1]).unwrap();
        assert_eq!(until.wait(event, Some(0)), Woken::Interrupted);
        assert_eq!(until.wait(None, None), Woken::Interrupted);
    }

    #[test]
    fn a_wait_ends_at_the_callers_deadline_and_at_the_sources_own_moment() {
        let (_stop_in, stop) = UnixStream::pair().unwrap();
        let soon_ns = || now_ns() + 2_000_000;
        let until = Until::new(Some(soon_ns()), stop.as_fd());
        assert_eq!(until.wait(None, None), Woken::Interrupted);
        assert!(until.waited_ns() > 0);
        let until = Until::new(None, stop.as_fd());
        assert_eq!(until.wait(None, Some(soon_ns())), Woken::Moment);
        assert_eq!(Until::forever().wait(None, Some(soon_ns())), Woken::Moment);
    }
}

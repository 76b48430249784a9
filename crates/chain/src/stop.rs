#![allow(unsafe_code)] // This file registers signal handlers.
//! SIGINT, SIGTERM and SIGHUP as a flag to read and a descriptor to wait for.

use std::io::Write;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use anyhow::Context;
use lariat_wire::now_ns;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

/// A signal this soon after the first one is the same request. `timeout -s INT` signals the process
/// and then its group, and Ctrl-C on a terminal may arrive together with a parent's SIGINT. Nobody
/// presses Ctrl-C twice within a tenth of a second.
const SAME_NS: u64 = 100_000_000;

/// A request to stop: of this process by a signal, or of one of its threads by a [`Stopper`].
pub struct Stop {
    asked: Arc<AtomicBool>,
    /// Readable from the first signal on, because it is never emptied.
    pipe: UnixStream,
}

impl Stop {
    /// Listens to signals: Ctrl-C, SIGTERM, and SIGHUP of a closed terminal unless it was ignored,
    /// for example by `nohup`. A second Ctrl-C, at least 0.1 s after the first signal, ends the
    /// process at once.
    pub fn on_signals() -> anyhow::Result<Self> {
        let asked = Arc::new(AtomicBool::new(false));
        let first_ns = Arc::new(AtomicU64::new(0));
        let (pipe, write) = UnixStream::pair().context("no pipe for signals could be made")?;
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let hang_up = (!is_ignored(SIGHUP, &status)).then_some(SIGHUP);
        for signal in [SIGINT, SIGTERM].into_iter().chain(hang_up) {
            let register = || -> std::io::Result<()> {
                let (asked, first_ns) = (asked.clone(), first_ns.clone());
                let handle = move || {
                    asked.store(true, Ordering::Relaxed);
                    if is_another(&first_ns, now_ns()) && signal == SIGINT {
                        signal_hook::low_level::exit(130);
                    }
                };
                // SAFETY: The handler only stores to atomics and calls `clock_gettime` and `_exit`.
                // All of this is allowed (signal-safety(7)).
                unsafe { signal_hook::low_level::register(signal, handle)? };
                signal_hook::low_level::pipe::register(signal, write.try_clone()?)?;
                Ok(())
            };
            register().context("signals could not be listened to")?;
        }
        Ok(Self { asked, pipe })
    }

    /// Creates a request that ignores signals, and the [`Stopper`] that triggers it.
    pub fn by_another() -> anyhow::Result<(Self, Stopper)> {
        let asked = Arc::new(AtomicBool::new(false));
        let (pipe, write) =
            UnixStream::pair().context("no pipe for the end of a stage could be made")?;
        let stopper = Stopper {
            asked: asked.clone(),
            write,
        };
        Ok((Self { asked, pipe }, stopper))
    }

    /// Returns true if a stop was requested.
    pub fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// Returns the flag itself, for a lossless writer.
    pub fn flag(&self) -> Arc<AtomicBool> {
        self.asked.clone()
    }

    /// Sleeps until a time of [`now_ns`]. Returns `false` if a stop is requested first.
    pub fn sleep_until(&self, due_ns: u64) -> bool {
        while !self.asked() {
            let left_ns = due_ns.saturating_sub(now_ns());
            if left_ns == 0 {
                return true;
            }
            let left = Timespec {
                tv_sec: (left_ns / 1_000_000_000) as i64,
                tv_nsec: (left_ns % 1_000_000_000) as _,
            };
            // Ignore the result: the flag and the clock show what happened.
            let _ = poll(&mut [PollFd::new(&self.pipe, PollFlags::IN)], Some(&left));
        }
        false
    }
}

/// Requests a stop from its [`Stop`].
#[derive(Debug)]
pub struct Stopper {
    asked: Arc<AtomicBool>,
    write: UnixStream,
}

impl Stopper {
    /// Requests the stop.
    pub fn stop(&mut self) {
        self.asked.store(true, Ordering::Relaxed);
        // A thread that has already ended need not be woken.
        let _ = self.write.write_all(&[0]);
    }
}

impl AsFd for Stop {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.pipe.as_fd()
    }
}

/// Returns true for a signal that comes long enough after the first one. Notes the time of the
/// first.
fn is_another(first_ns: &AtomicU64, now_ns: u64) -> bool {
    let noted = first_ns.compare_exchange(0, now_ns, Ordering::Relaxed, Ordering::Relaxed);
    noted.is_err_and(|first_ns| now_ns.saturating_sub(first_ns) >= SAME_NS)
}

/// Returns true if a process ignores a signal, according to the kernel's `status` file.
fn is_ignored(signal: i32, status: &str) -> bool {
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    ignored.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_signal_at_once_is_the_same_and_a_later_one_is_another() {
        let first_ns = AtomicU64::new(0);
        let times = [5, 5, SAME_NS, 4 + SAME_NS, 5 + SAME_NS, 6 + SAME_NS];
        let are_others = times.map(|now_ns| is_another(&first_ns, now_ns));
        assert_eq!(are_others, [false, false, false, false, true, true]);
    }

    #[test]
    fn a_signal_that_is_ignored_is_told_from_the_others() {
        let status = "Name:\tlariat\nSigBlk:\t0000000000000001\nSigIgn:\t0000000000001001\n";
        assert!(is_ignored(SIGHUP, status));
        assert!(!is_ignored(SIGTERM, status));
        assert!(!is_ignored(SIGHUP, ""));
    }
}

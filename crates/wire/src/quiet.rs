#![allow(unsafe_code)] // Only libc offers a thread's signal mask.
//! Holds back signals while the transport waits.
//!
//! A lossless writer waits for free space inside the transport's `send`, which sleeps between two
//! checks. In iceoryx2 0.10, a signal during such a sleep makes the whole `send` fail. The message
//! then has reached some readers and is lost to the others. A chain that is stopping would also
//! lose everything that it still has to deliver. Signals are therefore blocked during the sleep and
//! delivered at each of its checks.

use std::cell::Cell;
use std::mem::MaybeUninit;
use std::ptr;

use libc::sigset_t;

thread_local! {
    /// The signal mask before it was changed.
    static BEFORE: Cell<Option<sigset_t>> = const { Cell::new(None) };
}

/// Runs `work` while signals reach this thread only in [`let_through`].
pub(crate) fn quietly<T>(work: impl FnOnce() -> T) -> T {
    /// Restores the mask even if `work` panics.
    struct Restored(sigset_t);
    impl Drop for Restored {
        fn drop(&mut self) {
            BEFORE.set(None);
            set_mask(&self.0);
        }
    }
    let restored = Restored(set_mask(&every()));
    BEFORE.set(Some(restored.0));
    work()
}

/// Delivers the signals that were held back, if they are blocked.
pub(crate) fn let_through() {
    if let Some(before) = BEFORE.get() {
        set_mask(&before);
        set_mask(&every());
    }
}

fn every() -> sigset_t {
    let mut set = MaybeUninit::uninit();
    // SAFETY: `sigfillset` initializes the set.
    unsafe {
        libc::sigfillset(set.as_mut_ptr());
        set.assume_init()
    }
}

fn set_mask(set: &sigset_t) -> sigset_t {
    let mut before = MaybeUninit::zeroed();
    // SAFETY: both are signal sets; all zeros is a valid one.
    unsafe {
        libc::pthread_sigmask(libc::SIG_SETMASK, ptr::from_ref(set), before.as_mut_ptr());
        before.assume_init()
    }
}

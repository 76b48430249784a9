#![allow(unsafe_code)] // A thread's signal mask is libc's alone.
//! Signals, kept from a wait of the transport's.
//!
//! A lossless writer waits for room inside the transport's `send`, which sleeps there between two looks. In iceoryx2 0.10 a signal
//! that comes in such a sleep fails the whole sending: the message has gone to some readers and is lost to the others, and what
//! a chain that is told to end has yet to deliver is lost with it. So signals are held back while it sleeps, and come
//! through at each of its looks.

use std::cell::Cell;
use std::mem::MaybeUninit;
use std::ptr;

use libc::sigset_t;

thread_local! {
    /// The mask that was there before.
    static BEFORE: Cell<Option<sigset_t>> = const { Cell::new(None) };
}

/// Does something meanwhile of which no signal reaches this thread, but at [`let_through`].
pub(crate) fn quietly<T>(work: impl FnOnce() -> T) -> T {
    /// Also if the work panics.
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

/// Lets the signals come that were held back, if they are.
pub(crate) fn let_through() {
    if let Some(before) = BEFORE.get() {
        set_mask(&before);
        set_mask(&every());
    }
}

fn every() -> sigset_t {
    let mut set = MaybeUninit::uninit();
    // SAFETY: it is initialized there.
    unsafe {
        libc::sigfillset(set.as_mut_ptr());
        set.assume_init()
    }
}

fn set_mask(set: &sigset_t) -> sigset_t {
    let mut before = MaybeUninit::zeroed();
    // SAFETY: both are sets of signals; of zeros alone is one, too.
    unsafe {
        libc::pthread_sigmask(libc::SIG_SETMASK, ptr::from_ref(set), before.as_mut_ptr());
        before.assume_init()
    }
}

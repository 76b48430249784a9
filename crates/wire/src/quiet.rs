#![allow(unsafe_code)] // A thread's signal mask is libc's alone.
//! Signals, kept from a wait of the transport's.
//!
//! A lossless writer waits for room inside the transport's `send`, which sleeps there between two looks. In iceoryx2 0.10 a signal
//! that comes in such a sleep fails the whole sending: the message has gone to some readers and is lost to the others, and what
//! a chain that is told to end has yet to deliver is lost with it. So signals are held back while it sleeps, and come
//! through at each of its looks.

use std::cell::Cell;
use std::ffi::c_int;
use std::ptr;

/// As large as glibc and musl have it.
#[derive(Clone, Copy)]
#[repr(C, align(8))]
struct SignalSet([u64; 16]);

const EVERY: SignalSet = SignalSet([u64::MAX; 16]);
/// To replace the whole mask, on each processor that Rust's `linux` is made for but MIPS.
const SET_MASK: c_int = 2;

unsafe extern "C" {
    fn pthread_sigmask(how: c_int, set: *const SignalSet, before: *mut SignalSet) -> c_int;
}

thread_local! {
    /// The mask that was there before.
    static BEFORE: Cell<Option<SignalSet>> = const { Cell::new(None) };
}

/// Does something meanwhile of which no signal reaches this thread, but at [`let_through`].
pub(crate) fn quietly<T>(work: impl FnOnce() -> T) -> T {
    /// Also if the work panics.
    struct Restored(SignalSet);
    impl Drop for Restored {
        fn drop(&mut self) {
            BEFORE.set(None);
            set_mask(&self.0);
        }
    }
    let restored = Restored(set_mask(&EVERY));
    BEFORE.set(Some(restored.0));
    work()
}

/// Lets the signals come that were held back, if they are.
pub(crate) fn let_through() {
    if let Some(before) = BEFORE.get() {
        set_mask(&before);
        set_mask(&EVERY);
    }
}

fn set_mask(set: &SignalSet) -> SignalSet {
    let mut before = SignalSet([0; 16]);
    // SAFETY: both are sets of signals as libc has them. libc itself leaves out the signals that it needs.
    unsafe { pthread_sigmask(SET_MASK, ptr::from_ref(set), ptr::from_mut(&mut before)) };
    before
}

#![allow(unsafe_code)] // Memory that belongs to another is handed over to whoever fills it: a thread, or the kernel.
//! Memory that a source is lent ahead of need, to be filled by a thread or by a driver while the last frame is on its way.

use std::ops::{Deref, DerefMut};
use std::ptr::NonNull;

/// Which of the slots that are lent at a time. Only a slot that was let go of has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlotKey(usize);

impl SlotKey {
    /// The number that the slot was lent under.
    pub fn index(self) -> usize {
        self.0
    }
}

/// A slot of memory in a source's hands. Whoever has it alone reads and writes it; it holds what was last written there.
#[derive(Debug)]
pub struct LentSlot {
    index: usize,
    memory: NonNull<[u8]>,
}

// SAFETY: by the promise of `new` nobody else touches the memory, which has no tie to a thread.
unsafe impl Send for LentSlot {}

impl LentSlot {
    /// Lends `memory` under a number.
    ///
    /// # Safety
    /// Until the source gives the slot back with a frame ([`Frame::slot`](crate::Frame::slot)), or is dropped, the
    /// memory stays valid and at its place, and nobody else reads or writes it. Every byte of it is initialized.
    pub unsafe fn new(index: usize, memory: NonNull<[u8]>) -> Self {
        Self { index, memory }
    }

    /// Lets go of the memory: the key that goes back with the frame in it.
    pub fn give_back(self) -> SlotKey {
        SlotKey(self.index)
    }
}

impl Deref for LentSlot {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        // SAFETY: valid, initialized and nobody else's, by the promise of `new`.
        unsafe { self.memory.as_ref() }
    }
}

impl DerefMut for LentSlot {
    fn deref_mut(&mut self) -> &mut [u8] {
        // SAFETY: as above; and it is borrowed as `self` is.
        unsafe { self.memory.as_mut() }
    }
}

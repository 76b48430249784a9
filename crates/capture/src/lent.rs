#![allow(unsafe_code)] // Hands over memory to whoever fills it: a thread, or the kernel.
//! Memory lent to a source ahead of need. A thread or a driver fills it while the previous frame is
//! being sent.

use std::ops::{Deref, DerefMut};
use std::ptr::NonNull;

/// Identifies a lent slot. Only a slot that was given back has a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlotKey(usize);

impl SlotKey {
    /// Number under which the slot was lent.
    pub fn index(self) -> usize {
        self.0
    }
}

/// A slot of memory that a source has borrowed. Only its holder reads and writes it. It contains
/// what was last written there.
#[derive(Debug)]
pub struct LentSlot {
    index: usize,
    memory: NonNull<[u8]>,
}

// SAFETY: by the contract of `new`, nobody else touches the memory. It is not tied to a thread.
unsafe impl Send for LentSlot {}

impl LentSlot {
    /// Lends `memory` under a number.
    ///
    /// # Safety
    /// The memory must stay valid and in place, and nobody else may read or write it. This
    /// requirement ends when the source gives the slot back with a frame
    /// ([`Frame::slot`](crate::Frame::slot)) or is dropped. Every byte of the memory must be
    /// initialized.
    pub unsafe fn new(index: usize, memory: NonNull<[u8]>) -> Self {
        Self { index, memory }
    }

    /// Gives up the memory. The returned key goes back with the frame that is in the slot.
    pub fn give_back(self) -> SlotKey {
        SlotKey(self.index)
    }
}

impl Deref for LentSlot {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        // SAFETY: valid, initialized and exclusive, by the contract of `new`.
        unsafe { self.memory.as_ref() }
    }
}

impl DerefMut for LentSlot {
    fn deref_mut(&mut self) -> &mut [u8] {
        // SAFETY: as above, and the borrow is that of `self`.
        unsafe { self.memory.as_mut() }
    }
}

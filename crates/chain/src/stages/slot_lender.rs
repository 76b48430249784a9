#![allow(unsafe_code)] // A source's thread or driver fills slots of shared memory.
//! A source and the slots of shared memory for its frames. If the source fills slots itself, they
//! are lent in advance. Otherwise a slot is taken when a frame is ready.

use std::ptr::NonNull;

use anyhow::Context;
use lariat_capture::{Frame, FrameSource, LentSlot, SlotKey};
use lariat_wire::{Slot, WireError, Writer};

use super::Station;

/// Creates the writer of a source's frames. It has one slot more than those lent to the source.
pub(super) fn writer(
    station: &Station,
    source: &dyn FrameSource,
) -> Result<Writer<[u8]>, WireError> {
    let Station {
        domain,
        rig,
        delivery,
        ..
    } = station;
    let (largest, wanted) = (source.largest_frame_bytes(), source.slots_wanted());
    Writer::frames_ahead(domain, rig, delivery, largest, wanted + 1)
}

/// A source and the slots lent to it.
pub(super) struct SlotLender<'w> {
    /// Dropped first, so that the source releases the slots.
    pub(super) source: Box<dyn FrameSource>,
    /// Slots that the source holds, by their number. `None` for a slot that was returned and not
    /// yet replaced.
    lent: Vec<Option<Slot<'w, [u8]>>>,
    writer: &'w Writer<[u8]>,
}

impl<'w> SlotLender<'w> {
    /// Lends the source as many slots as it wants. `writer` must have been made for this source.
    pub(super) fn new(
        source: Box<dyn FrameSource>,
        writer: &'w Writer<[u8]>,
    ) -> Result<Self, WireError> {
        let mut lent = Vec::new();
        lent.resize_with(source.slots_wanted(), || None);
        let mut lender = Self {
            source,
            lent,
            writer,
        };
        lender.lend()?;
        Ok(lender)
    }

    /// Replaces the slots that were returned. Call this only after the returned slots were sent,
    /// because the writer lends no more slots than there are.
    pub(super) fn lend(&mut self) -> Result<(), WireError> {
        for index in 0..self.lent.len() {
            if self.lent[index].is_none() {
                let slot = self.writer.frame_slot(self.source.largest_frame_bytes())?;
                self.lend_one(index, slot);
            }
        }
        Ok(())
    }

    fn lend_one(&mut self, index: usize, mut slot: Slot<'w, [u8]>) {
        let memory = NonNull::from(&mut *slot);
        self.lent[index] = Some(slot);
        // SAFETY: The memory belongs to the writer and does not move, and the borrow of the writer
        // outlives the source. Nobody else uses the memory until the slot is sent or dropped. This
        // struct only keeps the slot until the source has returned it or is gone; the source is the
        // first field that is dropped. The memory always contains initialized bytes.
        self.source.lend(unsafe { LentSlot::new(index, memory) });
    }

    /// Returns the slot of the frame that is ready: the slot that the source filled, or a new slot
    /// into which the frame is written now.
    pub(super) fn slot_of(&mut self, frame: &Frame) -> anyhow::Result<Slot<'w, [u8]>> {
        match frame.slot {
            Some(key) => self.take_back(key),
            None => {
                let mut slot = self.writer.frame_slot(frame.bytes())?;
                self.source.write(&mut slot);
                Ok(slot)
            }
        }
    }

    fn take_back(&mut self, key: SlotKey) -> anyhow::Result<Slot<'w, [u8]>> {
        let lent = self.lent.get_mut(key.index()).and_then(Option::take);
        lent.context("the source gave back a slot that it was not lent: this is a defect of lariat, please report it")
    }
}

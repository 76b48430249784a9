#![allow(unsafe_code)] // Slots of shared memory are lent to a source, whose thread or driver fills them.
//! A source and the slots of shared memory that its frames are written into: lent ahead of need if it fills them by
//! itself, else when a frame is ready.

use std::ptr::NonNull;

use anyhow::Context;
use lariat_capture::{Frame, FrameSource, LentSlot, SlotKey};
use lariat_wire::{Slot, WireError, Writer};

use super::Station;

/// The writer of a source's frames: with a slot to spare beside those that the source is lent.
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

/// A source with what it is lent.
pub(super) struct SlotLender<'w> {
    /// Dropped first: it lets go of the slots.
    pub(super) source: Box<dyn FrameSource>,
    /// Those in the source's hands, each under its number; none where one was given back and not yet replaced.
    lent: Vec<Option<Slot<'w, [u8]>>>,
    writer: &'w Writer<[u8]>,
}

impl<'w> SlotLender<'w> {
    /// Lends the source what it wants. `writer`: made for this source.
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

    /// Replaces the slots that were given back. Only when those are sent: the writer borrows no more than there are.
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
        // SAFETY: the memory is the writer's, who is borrowed for longer than the source lives, and stays where it is. It
        // is nobody else's until the slot is sent or dropped: here it is only kept, until the source has given it back or
        // is gone itself, as the first field that is dropped. It held bytes before, whichever.
        self.source.lend(unsafe { LentSlot::new(index, memory) });
    }

    /// The slot that holds the frame just made ready: the source's own, or one that it is written into now.
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

#![allow(unsafe_code)] // Lends memory to a driver, and keeps it from everybody else meanwhile.
//! A streaming camera: which buffers the driver holds, and the contents of those that it returns.
//!
//! With [`Memory::Lent`] the driver writes into slots lent to the source. A slot is reused many
//! times at the same address. It is then queued under the same number, so that the kernel finds the
//! pages that it has pinned.

use std::ptr::NonNull;

use rustix::io::{Errno, Result};

use super::driver::{Driver, Filled, Mapping, Memory};
use crate::lent::LentSlot;

/// Number of buffers in Video4Linux2 (`VIDEO_MAX_FRAME`), one for each slot that may be lent.
const MOST_BUFFERS: usize = 32;
/// Number of the driver's own buffers: one is filled, one is read, and two are for delays of this
/// process.
const MAPPED_BUFFERS: usize = 4;
/// Minimum number of buffers. With fewer, the driver could not fill one while a frame is read.
const LEAST_BUFFERS: usize = 2;

/// A driver that streams. Dropping it stops the driver and releases all memory.
#[derive(Debug)]
pub(super) struct Stream<D: Driver> {
    /// `None` once it has been taken out.
    driver: Option<D>,
    buffers: Buffers,
    /// True if the driver has allocated buffers, which must be freed.
    has_buffers: bool,
    /// Calls that failed once and then succeeded.
    mended: Mended,
}

/// The number of calls that needed a second attempt since the last query, and the latest such call.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mended {
    pub(super) count: u64,
    pub(super) last: Option<(&'static str, Errno)>,
}

#[derive(Debug)]
enum Buffers {
    Mapped(Vec<Mapping>),
    Lent(Vec<Place>),
}

/// A buffer number, under which the driver holds or held a slot.
#[derive(Debug, Default)]
struct Place {
    address: usize,
    /// The slot, while the driver holds it.
    slot: Option<LentSlot>,
    /// When it was last used, as a count of queued buffers.
    used: u64,
}

/// Why a driver does not stream, and the driver itself.
pub(super) struct NotStarted<D> {
    pub(super) call: &'static str,
    pub(super) errno: Errno,
    /// `None` if it had to be closed.
    pub(super) driver: Option<D>,
}

impl<D: Driver> Stream<D> {
    /// Starts a driver. With [`Memory::Lent`], it gets memory from `slots`.
    pub(super) fn start(
        driver: D,
        memory: Memory,
        slots: &mut Vec<LentSlot>,
    ) -> std::result::Result<Self, NotStarted<D>> {
        let mut stream = Self {
            driver: Some(driver),
            buffers: match memory {
                Memory::Mapped => Buffers::Mapped(Vec::new()),
                Memory::Lent => Buffers::Lent(Vec::new()),
            },
            has_buffers: false,
            mended: Mended::default(),
        };
        match stream.prepare(slots) {
            Ok(()) => Ok(stream),
            Err((call, errno)) => Err(NotStarted {
                call,
                errno,
                driver: stream.stop(slots),
            }),
        }
    }

    fn prepare(
        &mut self,
        slots: &mut Vec<LentSlot>,
    ) -> std::result::Result<(), (&'static str, Errno)> {
        let memory = self.memory();
        let wanted = match memory {
            Memory::Mapped => MAPPED_BUFFERS,
            Memory::Lent => MOST_BUFFERS,
        };
        let count = self.twice("VIDIOC_REQBUFS", |driver| driver.request(memory, wanted))?;
        self.has_buffers = true;
        if count < LEAST_BUFFERS {
            return Err(("VIDIOC_REQBUFS", Errno::NOBUFS));
        }
        match memory {
            Memory::Mapped => {
                for index in 0..count {
                    let mapping = self.twice("VIDIOC_QUERYBUF", |driver| driver.map(index))?;
                    let Buffers::Mapped(mappings) = &mut self.buffers else {
                        unreachable!("its memory is mapped");
                    };
                    mappings.push(mapping);
                    self.queue_mapped(index)?;
                }
            }
            Memory::Lent => {
                let places = std::iter::repeat_with(Place::default).take(count);
                self.buffers = Buffers::Lent(places.collect());
                for _ in 0..slots.len().min(count) {
                    if let Some(slot) = slots.pop() {
                        self.lend(slot).map_err(|(slot, cause)| {
                            slots.push(slot);
                            cause
                        })?;
                    }
                }
            }
        }
        self.twice("VIDIOC_STREAMON", |driver| driver.stream(true))
    }

    /// Owner of the frames' memory.
    pub(super) fn memory(&self) -> Memory {
        match self.buffers {
            Buffers::Mapped(_) => Memory::Mapped,
            Buffers::Lent(_) => Memory::Lent,
        }
    }

    /// The driver.
    pub(super) fn driver(&self) -> Option<&D> {
        self.driver.as_ref()
    }

    /// Number of buffers.
    pub(super) fn count(&self) -> usize {
        match &self.buffers {
            Buffers::Mapped(mappings) => mappings.len(),
            Buffers::Lent(places) => places.len(),
        }
    }

    /// Returns the calls that needed a second attempt since the last query.
    pub(super) fn take_mended(&mut self) -> Mended {
        std::mem::take(&mut self.mended)
    }

    /// Dequeues the frame that was filled first; `AGAIN` if none is filled.
    pub(super) fn dequeue(&mut self) -> Result<Filled> {
        let driver = self.driver.as_ref().ok_or(Errno::NODEV)?;
        driver.dequeue(self.memory())
    }

    /// The bytes of a dequeued frame in the driver's mapped memory.
    pub(super) fn mapped(&self, filled: &Filled) -> &[u8] {
        let Buffers::Mapped(mappings) = &self.buffers else {
            return &[];
        };
        let bytes = mappings.get(filled.index).map_or(&[][..], Mapping::bytes);
        let begin = filled.offset.min(bytes.len());
        &bytes[begin..bytes.len().min(begin + filled.bytes)]
    }

    /// Takes the slot that contains a dequeued frame. The frame is moved to the slot's start.
    pub(super) fn take_slot(&mut self, filled: &Filled) -> Option<LentSlot> {
        let Buffers::Lent(places) = &mut self.buffers else {
            return None;
        };
        let mut slot = places.get_mut(filled.index)?.slot.take()?;
        if filled.offset > 0 {
            let end = (filled.offset + filled.bytes).min(slot.len());
            slot.copy_within(filled.offset.min(end)..end, 0);
        }
        Some(slot)
    }

    /// Queues the buffer of a dequeued frame again.
    pub(super) fn requeue(
        &mut self,
        filled: &Filled,
    ) -> std::result::Result<(), (&'static str, Errno)> {
        match &mut self.buffers {
            Buffers::Mapped(_) => self.queue_mapped(filled.index),
            Buffers::Lent(places) => {
                let slot = places
                    .get_mut(filled.index)
                    .and_then(|place| place.slot.take());
                match slot {
                    // If the driver refuses it, the stream is stopped and slots are lent again.
                    Some(slot) => self.keep(filled.index, slot),
                    None => Ok(()),
                }
            }
        }
    }

    fn queue_mapped(&mut self, index: usize) -> std::result::Result<(), (&'static str, Errno)> {
        self.twice("VIDIOC_QBUF", |driver| {
            // SAFETY: it lends no memory.
            unsafe { driver.queue(index, None) }
        })
    }

    /// Lends a slot to the driver. Returns the slot if the driver refuses it.
    pub(super) fn lend(
        &mut self,
        slot: LentSlot,
    ) -> std::result::Result<(), (LentSlot, (&'static str, Errno))> {
        let Buffers::Lent(places) = &self.buffers else {
            return Err((slot, ("VIDIOC_QBUF", Errno::INVAL)));
        };
        let Some(index) = place_of(places, slot.as_ptr().addr()) else {
            return Err((slot, ("VIDIOC_QBUF", Errno::NOBUFS)));
        };
        self.queue_lent(index, slot)
    }

    fn keep(
        &mut self,
        index: usize,
        slot: LentSlot,
    ) -> std::result::Result<(), (&'static str, Errno)> {
        self.queue_lent(index, slot).map_err(|(slot, cause)| {
            // The driver does not hold the slot, but it is kept where `stop` finds it.
            self.put(index, slot);
            cause
        })
    }

    fn queue_lent(
        &mut self,
        index: usize,
        mut slot: LentSlot,
    ) -> std::result::Result<(), (LentSlot, (&'static str, Errno))> {
        let memory = NonNull::from(&mut *slot);
        let queued = self.twice("VIDIOC_QBUF", |driver| {
            // SAFETY: the slot is exclusive. If the driver accepts it, it is stored untouched until
            // the buffer is dequeued or `release` has stopped or dropped the driver.
            unsafe { driver.queue(index, Some(memory)) }
        });
        match queued {
            Ok(()) => {
                self.put(index, slot);
                Ok(())
            }
            Err(cause) => Err((slot, cause)),
        }
    }

    fn put(&mut self, index: usize, slot: LentSlot) {
        if let Buffers::Lent(places) = &mut self.buffers {
            let used = 1 + places.iter().map(|place| place.used).max().unwrap_or(0);
            places[index] = Place {
                address: slot.as_ptr().addr(),
                slot: Some(slot),
                used,
            };
        }
    }

    /// Makes a call, and repeats it once if it fails, because some failures of drivers are
    /// temporary. Does not repeat it if the device is gone or busy.
    fn twice<T>(
        &mut self,
        call: &'static str,
        make: impl Fn(&D) -> Result<T>,
    ) -> std::result::Result<T, (&'static str, Errno)> {
        let driver = self.driver.as_ref().ok_or((call, Errno::NODEV))?;
        let first = match make(driver) {
            Ok(done) => return Ok(done),
            Err(errno @ (Errno::NODEV | Errno::BUSY)) => return Err((call, errno)),
            Err(errno) => errno,
        };
        let done = make(driver).map_err(|errno| (call, errno))?;
        self.mended = Mended {
            count: self.mended.count + 1,
            last: Some((call, first)),
        };
        Ok(done)
    }

    /// Stops the driver and returns its slots to `slots`. `None` if it had to be closed for that.
    pub(super) fn stop(mut self, slots: &mut Vec<LentSlot>) -> Option<D> {
        let driver = self.release();
        if let Buffers::Lent(places) = &mut self.buffers {
            slots.extend(places.iter_mut().filter_map(|place| place.slot.take()));
        }
        driver
    }

    /// Makes the driver release all memory.
    fn release(&mut self) -> Option<D> {
        let driver = self.driver.take()?;
        let memory = self.memory();
        if !self.has_buffers {
            return Some(driver);
        }
        // Buffers cannot be freed while they are mapped.
        if let Buffers::Mapped(mappings) = &mut self.buffers {
            mappings.clear();
        }
        let stopped = driver.stream(false);
        // Some drivers fail this call once, like any other. Whatever is left is freed with the
        // descriptor.
        let freed = driver
            .request(memory, 0)
            .or_else(|_| driver.request(memory, 0));
        // A driver that cannot be stopped is closed, which stops it.
        (stopped.is_ok() && freed.is_ok()).then_some(driver)
    }
}

impl<D: Driver> Drop for Stream<D> {
    fn drop(&mut self) {
        self.release();
    }
}

/// The number under which to queue memory at this address: its previous number, otherwise one never
/// used, otherwise the least recently used. `None` if the driver holds them all.
fn place_of(places: &[Place], address: usize) -> Option<usize> {
    let free = || {
        places
            .iter()
            .enumerate()
            .filter(|(_, place)| place.slot.is_none())
    };
    free()
        .find(|(_, place)| place.address == address)
        .or_else(|| free().min_by_key(|(_, place)| place.used))
        .map(|(index, _)| index)
}

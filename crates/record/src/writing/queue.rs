//! The queue between the thread that reads channels and the one that writes: a bounded channel of
//! pooled buffers.
//!
//! The total size of the buffers is bounded. Each buffer is filled by the reader, written, and
//! returned. Once the pool has grown to the size needed, messages need no allocation. A slow disk
//! causes dropped messages, but memory stays bounded. Part of the queue is reserved for small
//! messages, so that images cannot fill it and displace the ropes' shapes.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use crossbeam::channel::{Receiver, RecvTimeoutError, Sender, TrySendError, bounded};

use super::topic::Topic;

/// Buffers larger than this are for images.
const SMALL_BYTES: usize = 128 << 10;
/// Initial size of a small buffer: enough for most messages of one rope.
const FIRST_BYTES: usize = 4 << 10;
/// Maximum number of waiting messages. The main bound is in bytes. A slot takes 64 bytes, allocated
/// at the start.
const MOST_MESSAGES: usize = 8192;

/// A message on its way to the file.
#[derive(Debug)]
pub(crate) struct Parcel {
    pub(crate) topic: Topic,
    pub(crate) sequence: u32,
    pub(crate) log_ns: u64,
    pub(crate) cdr: Vec<u8>,
    /// True if the buffer belongs to the pool.
    pub(crate) is_pooled: bool,
}

/// Requests other than writing messages.
#[derive(Debug)]
pub(crate) enum Order {
    /// Add a file to the recording.
    Attach {
        name: String,
        media_type: &'static str,
        log_ns: u64,
        bytes: Vec<u8>,
    },
    /// Add metadata to the recording.
    About(BTreeMap<String, String>),
    /// Write the messages kept in memory into this file.
    Flush(PathBuf),
}

/// An item in the queue.
#[derive(Debug)]
pub(crate) enum Item {
    Message(Parcel),
    /// A request, which is rare.
    Order(Box<Order>),
}

/// The other end is gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Gone;

/// The reader's end.
#[derive(Debug)]
pub(crate) struct Intake {
    items: Sender<Item>,
    returned: Receiver<Vec<u8>>,
    freed: Arc<[AtomicUsize; 2]>,
    /// Free buffers, by their [`Size`].
    free: [Vec<Vec<u8>>; 2],
    /// Capacities of all buffers, free or in use, by their size.
    held_bytes: [usize; 2],
    most_bytes: usize,
    most_large_bytes: usize,
}

/// The writer's end.
#[derive(Debug)]
pub(crate) struct Outlet {
    items: Receiver<Item>,
    back: Sender<Vec<u8>>,
    /// Bytes of buffers that could not be returned, by their size.
    freed: Arc<[AtomicUsize; 2]>,
}

/// Class of a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Size {
    Small,
    Large,
}

impl Size {
    fn of(bytes: usize) -> Self {
        if bytes > SMALL_BYTES {
            Self::Large
        } else {
            Self::Small
        }
    }
}

/// Creates a queue whose buffers take at most `most_bytes`, of which `kept_for_small` are reserved
/// for small ones.
pub(crate) fn queue(most_bytes: usize, kept_for_small: usize) -> (Intake, Outlet) {
    let (items, to_write) = bounded(MOST_MESSAGES);
    let (back, returned) = bounded(MOST_MESSAGES);
    let freed = Arc::<[AtomicUsize; 2]>::default();
    let intake = Intake {
        items,
        returned,
        freed: freed.clone(),
        free: [Vec::with_capacity(MOST_MESSAGES), Vec::with_capacity(64)],
        held_bytes: [0; 2],
        most_bytes,
        most_large_bytes: most_bytes.saturating_sub(kept_for_small),
    };
    let outlet = Outlet {
        items: to_write,
        back,
        freed,
    };
    (intake, outlet)
}

impl Intake {
    /// Returns an empty buffer for this many bytes; `None` if the queue is full.
    pub(crate) fn buffer(&mut self, bytes: usize) -> Option<Vec<u8>> {
        self.take_back();
        let size = Size::of(bytes);
        let place = size as usize;
        let mut buffer = self.free[place].pop().unwrap_or_default();
        let before = buffer.capacity();
        let wanted = bytes.max(FIRST_BYTES);
        if before < wanted {
            let more = wanted - before;
            let others = self.held_bytes.iter().sum::<usize>();
            // A single image is accepted even if it exceeds the bound.
            let fits = match size {
                Size::Large => {
                    self.held_bytes[place] == before
                        || (self.held_bytes[place] + more <= self.most_large_bytes
                            && others + more <= self.most_bytes)
                }
                Size::Small => others + more <= self.most_bytes,
            };
            if !fits {
                // Frees the buffer, as the next request may need its memory.
                self.held_bytes[place] -= before;
                return None;
            }
            buffer.reserve_exact(wanted);
            self.held_bytes[place] += buffer.capacity() - before;
        }
        Some(buffer)
    }

    /// Returns a buffer, and waits for one if necessary.
    pub(crate) fn buffer_waited_for(&mut self, bytes: usize) -> Result<Vec<u8>, Gone> {
        loop {
            if let Some(buffer) = self.buffer(bytes) {
                return Ok(buffer);
            }
            // Frees unused buffers, which may be of the wrong size.
            for (held, free) in self.held_bytes.iter_mut().zip(&mut self.free) {
                *held -= free
                    .drain(..)
                    .map(|buffer| buffer.capacity())
                    .sum::<usize>();
            }
            if let Some(buffer) = self.buffer(bytes) {
                return Ok(buffer);
            }
            let buffer = self.returned.recv().map_err(|_| Gone)?;
            self.keep(buffer);
        }
    }

    /// Fills a buffer, which may grow.
    pub(crate) fn fill(&mut self, buffer: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
        let before = buffer.capacity();
        write(buffer);
        let after = buffer.capacity();
        self.held_bytes[Size::of(before) as usize] -= before;
        self.held_bytes[Size::of(after) as usize] += after;
    }

    /// Returns an unsent buffer to the pool.
    pub(crate) fn keep(&mut self, mut buffer: Vec<u8>) {
        buffer.clear();
        self.free[Size::of(buffer.capacity()) as usize].push(buffer);
    }

    /// Sends a message. Returns `Ok(false)` if there are too many messages in the queue.
    pub(crate) fn send(&mut self, parcel: Parcel) -> Result<bool, Gone> {
        match self.items.try_send(Item::Message(parcel)) {
            Ok(()) => Ok(true),
            Err(TrySendError::Full(Item::Message(parcel))) => {
                self.keep(parcel.cdr);
                Ok(false)
            }
            Err(_) => Err(Gone),
        }
    }

    /// Sends an item, and waits for room if necessary.
    pub(crate) fn send_waiting(&mut self, item: Item) -> Result<(), Gone> {
        self.items.send(item).map_err(|_| Gone)
    }

    fn take_back(&mut self) {
        while let Ok(buffer) = self.returned.try_recv() {
            self.keep(buffer);
        }
        for (held, freed) in self.held_bytes.iter_mut().zip(self.freed.iter()) {
            *held -= freed.swap(0, Ordering::Relaxed);
        }
    }
}

impl Outlet {
    /// Returns the next item, and waits for it until the deadline.
    pub(crate) fn next(&self, deadline: Option<Instant>) -> Result<Item, RecvTimeoutError> {
        match deadline {
            Some(deadline) => self.items.recv_deadline(deadline),
            None => self
                .items
                .recv()
                .map_err(|_| RecvTimeoutError::Disconnected),
        }
    }

    /// Returns whether any item is waiting.
    pub(crate) fn has_more(&self) -> bool {
        !self.items.is_empty()
    }

    /// Returns a buffer to the reader.
    pub(crate) fn give_back(&self, buffer: Vec<u8>) {
        // The channel is full if the reader does not take buffers back.
        if let Err(TrySendError::Full(buffer)) = self.back.try_send(buffer) {
            let bytes = buffer.capacity();
            self.freed[Size::of(bytes) as usize].fetch_add(bytes, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parcel(cdr: Vec<u8>) -> Parcel {
        Parcel {
            topic: Topic::Image,
            sequence: 0,
            log_ns: 0,
            cdr,
            is_pooled: true,
        }
    }

    fn written(outlet: &Outlet) -> Vec<u8> {
        match outlet.next(None) {
            Ok(Item::Message(parcel)) => parcel.cdr,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_there_is_of_buffers_stays_within_its_bound() {
        let (mut intake, outlet) = queue(10 << 20, 2 << 20);
        // Eight images fit next to the part reserved for small messages, and small messages still
        // fit after that.
        for _ in 0..8 {
            let buffer = intake.buffer(1 << 20).unwrap();
            assert!(intake.send(parcel(buffer)).unwrap());
        }
        assert!(intake.buffer(1 << 20).is_none());
        for _ in 0..(2 << 20) / FIRST_BYTES {
            let buffer = intake.buffer(100).unwrap();
            assert!(intake.send(parcel(buffer)).unwrap());
        }
        assert!(intake.buffer(100).is_none());
        // Written messages free their memory.
        outlet.give_back(written(&outlet));
        assert!(intake.buffer(100).is_none());
        assert!(intake.buffer(1 << 20).is_some());
    }

    #[test]
    fn once_warm_a_buffer_is_the_one_before() {
        let (mut intake, outlet) = queue(10 << 20, 0);
        let mut buffer = intake.buffer(1 << 20).unwrap();
        let address = buffer.as_ptr();
        for _ in 0..3 {
            assert!(intake.send(parcel(buffer)).unwrap());
            outlet.give_back(written(&outlet));
            buffer = intake.buffer(1 << 20).unwrap();
            assert_eq!(buffer.as_ptr(), address);
        }
    }

    #[test]
    fn an_image_larger_than_the_queue_goes_alone() {
        let (mut intake, outlet) = queue(1 << 20, 0);
        let buffer = intake.buffer(3 << 20).unwrap();
        assert!(intake.buffer(3 << 20).is_none());
        outlet.give_back(buffer);
        assert!(intake.buffer(3 << 20).is_some());
    }

    #[test]
    fn a_buffer_is_waited_for_until_one_comes_back_or_the_writer_is_gone() {
        let (mut intake, outlet) = queue(1 << 20, 0);
        let small = intake.buffer_waited_for(100).unwrap();
        intake.keep(small);
        let buffer = intake.buffer_waited_for(1 << 20).unwrap();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                outlet.give_back(buffer);
                // The writer then goes away.
            });
            let again = intake.buffer_waited_for(1 << 20).unwrap();
            assert!(again.capacity() >= 1 << 20);
            assert_eq!(intake.buffer_waited_for(1 << 20), Err(Gone));
        });
    }

    #[test]
    fn a_buffer_that_grows_is_counted() {
        let (mut intake, _outlet) = queue(1 << 20, 0);
        let mut buffer = intake.buffer(100).unwrap();
        intake.fill(&mut buffer, |buffer| buffer.resize(1 << 20, 0));
        assert!(intake.buffer(100).is_none());
        intake.keep(buffer);
        assert!(intake.buffer(1 << 20).is_some());
    }

    #[test]
    fn buffers_that_find_no_way_back_make_room_all_the_same() {
        let (mut intake, outlet) = queue(1 << 30, 0);
        // A ring may free this many at once while the reader sleeps.
        let buffers: Vec<_> = (0..MOST_MESSAGES + 100)
            .map(|_| intake.buffer(100).unwrap())
            .collect();
        buffers
            .into_iter()
            .for_each(|buffer| outlet.give_back(buffer));
        intake.take_back();
        assert_eq!(intake.free[0].len(), MOST_MESSAGES);
        assert_eq!(intake.held_bytes[0], MOST_MESSAGES * FIRST_BYTES);
    }
}

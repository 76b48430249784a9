//! Keeps the last seconds in memory. They are written on request and remain in memory.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Duration;

use super::error::WriteError;
use super::pictures::Images;
use super::place::Existing;
use super::queue::{Item, Order, Outlet, Parcel};
use super::recorder::{Ending, RingOptions};
use super::thread::{self, Developer};
use super::writer::{Head, Writer, Written};

/// Report of a recording made from the ring.
#[derive(Debug)]
pub struct Flushed {
    /// File of the recording.
    pub path: PathBuf,
    /// Time from the first to the last message of the recording.
    pub time: Duration,
    /// Contents of the recording.
    pub written: Written,
    /// Reason why it is incomplete, if it is.
    pub fault: Option<WriteError>,
}

/// Messages of the last seconds, in order of arrival.
#[derive(Debug)]
struct Ring {
    parcels: VecDeque<Parcel>,
    /// Total size of the messages' buffers.
    bytes: usize,
    longest_ns: u64,
    most_bytes: usize,
}

impl Ring {
    fn new(longest: Duration, most_bytes: usize) -> Self {
        Self {
            parcels: VecDeque::new(),
            bytes: 0,
            longest_ns: longest.as_nanos() as u64,
            most_bytes,
        }
    }

    fn push(&mut self, parcel: Parcel) {
        self.bytes += parcel.cdr.capacity();
        self.parcels.push_back(parcel);
    }

    /// Returns whether the oldest message must be dropped.
    fn overflows(&self) -> bool {
        let (Some(oldest), Some(newest)) = (self.parcels.front(), self.parcels.back()) else {
            return false;
        };
        // Messages of a frame come one after the other, so a message may be older than the previous
        // one. The subtraction must not overflow then.
        let age_ns = newest.log_ns.saturating_sub(oldest.log_ns);
        (age_ns > self.longest_ns || self.bytes > self.most_bytes) && self.parcels.len() > 1
    }

    fn pop(&mut self) -> Option<Parcel> {
        let oldest = self.parcels.pop_front()?;
        self.bytes -= oldest.cdr.capacity();
        Some(oldest)
    }
}

/// A recording being written from a ring, while further messages arrive.
struct Flush {
    writer: Writer,
    path: PathBuf,
    /// Index of the next message to write, in the ring.
    next: usize,
    /// End of the messages that had arrived when the recording was requested.
    end: usize,
    first_ns: u64,
    last_ns: u64,
}

/// Keeps messages until the queue's other end is gone.
pub(crate) fn keep(options: RingOptions, head: Head, outlet: Outlet, images: Images) -> Ending {
    let mut keeper = Keeper {
        ring: Ring::new(options.time, options.bytes),
        developer: Developer::new(images),
        head,
        files: Vec::new(),
        flush: None,
        options,
        outlet,
    };
    let mut is_open = true;
    while is_open || keeper.flush.is_some() {
        // Incoming messages have priority over writing a file, so that the disk does not delay
        // them.
        if keeper.flush.is_none() || keeper.outlet.has_more() {
            match keeper.outlet.next(None) {
                Ok(Item::Message(parcel)) => keeper.take(parcel),
                Ok(Item::Order(order)) => keeper.obey(*order),
                Err(_) => is_open = false,
            }
        }
        keeper.write_next();
    }
    Ending {
        written: Written::default(),
        fault: None,
    }
}

struct Keeper {
    ring: Ring,
    developer: Developer,
    head: Head,
    /// Attachments for every file.
    files: Vec<(String, &'static str, u64, Vec<u8>)>,
    flush: Option<Flush>,
    options: RingOptions,
    outlet: Outlet,
}

impl Keeper {
    fn take(&mut self, mut parcel: Parcel) {
        if let Some((topic, picture)) = self.developer.develop(parcel.topic, &parcel.cdr) {
            let raw = std::mem::replace(&mut parcel.cdr, picture.to_vec());
            parcel.topic = topic;
            parcel.is_pooled = false;
            self.outlet.give_back(raw);
        }
        self.ring.push(parcel);
        while self.ring.overflows() {
            // Writes the oldest message before it is dropped, if it is part of the file.
            while self.flush.as_ref().is_some_and(|flush| flush.next == 0) {
                self.write_next();
            }
            if let Some(flush) = &mut self.flush {
                flush.next -= 1;
                flush.end -= 1;
            }
            match self.ring.pop() {
                Some(oldest) if oldest.is_pooled => self.outlet.give_back(oldest.cdr),
                _ => {}
            }
        }
    }

    fn obey(&mut self, order: Order) {
        match order {
            Order::Attach {
                name,
                media_type,
                log_ns,
                bytes,
            } => {
                self.files.retain(|(other, ..)| *other != name);
                self.files.push((name, media_type, log_ns, bytes));
            }
            Order::About(about) => self.head.about.extend(about),
            Order::Flush(path) => self.begin(path),
        }
    }

    /// Begins a file. A file in progress is completed first.
    fn begin(&mut self, path: PathBuf) {
        while self.flush.is_some() {
            self.write_next();
        }
        match self.open(&path) {
            Ok(writer) => {
                let first = self.ring.parcels.front();
                let first_ns = first.map_or(0, |parcel| parcel.log_ns);
                self.flush = Some(Flush {
                    writer,
                    path,
                    next: 0,
                    end: self.ring.parcels.len(),
                    first_ns,
                    last_ns: first_ns,
                });
            }
            Err(fault) => (self.options.report)(Flushed {
                path,
                time: Duration::ZERO,
                written: Written::default(),
                fault: Some(fault),
            }),
        }
    }

    fn open(&self, path: &std::path::Path) -> Result<Writer, WriteError> {
        let compression = self.options.compression;
        let mut writer = Writer::create(path, Existing::Keep, &self.head, compression)?;
        for (name, media_type, log_ns, bytes) in &self.files {
            writer.attach(name, media_type, *log_ns, bytes)?;
        }
        Ok(writer)
    }

    /// Writes the next message of the file in progress, and closes it after the last.
    fn write_next(&mut self) {
        let Some(flush) = &mut self.flush else { return };
        let parcel = (flush.next < flush.end).then(|| &self.ring.parcels[flush.next]);
        let fault = match parcel {
            Some(parcel) => {
                flush.next += 1;
                flush.last_ns = flush.last_ns.max(parcel.log_ns);
                let Parcel {
                    topic,
                    sequence,
                    log_ns,
                    cdr,
                    ..
                } = parcel;
                match flush.writer.write(*topic, *sequence, *log_ns, cdr) {
                    Ok(()) => return,
                    Err(fault) => Some(fault),
                }
            }
            None => None,
        };
        let Some(flush) = self.flush.take() else {
            return;
        };
        let Ending { written, fault } = thread::end(flush.writer, fault);
        (self.options.report)(Flushed {
            path: flush.path,
            time: Duration::from_nanos(flush.last_ns - flush.first_ns),
            written,
            fault,
        });
    }
}

#[cfg(test)]
mod tests;

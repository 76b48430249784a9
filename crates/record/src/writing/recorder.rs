//! Records what a rig says: messages in, at the reader's pace; a thread of its own writes them.
//!
//! A message is copied once, out of shared memory into the bytes that go to the file. The reader never waits for the disk
//! (unless it is asked to): what finds no room is dropped, and counted.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::thread::JoinHandle;
use std::time::Duration;

use lariat_message::{Centerlines, Descriptors, Descriptors3, FrameHeader};

use super::clock::Clock;
use super::error::WriteError;
use super::pictures::Images;
use super::queue::{Gone, Intake, Item, Order, Parcel, queue};
use super::ring::{self, Flushed};
use super::thread;
use super::topic::Topic;
use super::writer::{Head, Writer, Written};
use crate::{Losses, Record, encode_control_points, encode_image, encode_ropes};

/// How messages are recorded.
#[derive(Debug, Clone)]
pub struct Options {
    /// How frames' pixels are.
    pub images: Images,
    /// Memory for messages that wait for the disk.
    pub queue_bytes: usize,
    /// Whether the reader waits for the disk, rather than that a message is dropped.
    pub waits: bool,
    /// From the clock of the traces to log times.
    pub clock: Clock,
}

/// What is kept in memory, until it is asked for.
pub struct RingOptions {
    /// The last so long.
    pub time: Duration,
    /// And no more than this.
    pub bytes: usize,
    /// How the recordings are written.
    pub compression: super::writer::Compression,
    /// Is told of each recording that was written, or was not.
    pub report: Box<dyn Fn(Flushed) + Send>,
}

/// Messages that are not in the recording: the recorder did not get them in time, or had no room for them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Drops {
    /// Frames whose images are not in it.
    pub frames: u64,
    /// Centerlines.
    pub centerlines: u64,
    /// Descriptors that came. (Those that did not come are lost on the link before.)
    pub descriptors: u64,
    /// True centerlines.
    pub truth: u64,
    /// Masks.
    pub masks: u64,
    /// Depth images.
    pub depths: u64,
    /// Descriptors in space.
    pub descriptors3: u64,
}

impl Drops {
    /// All of them.
    pub fn total(&self) -> u64 {
        let images = self.frames + self.masks + self.depths;
        images + self.centerlines + self.descriptors + self.descriptors3 + self.truth
    }
}

/// The recording has ended before its time. [`Recorder::finish`] says why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the recording has ended before its time")]
pub struct Ended;

impl From<Gone> for Ended {
    fn from(_: Gone) -> Self {
        Self
    }
}

/// How a recording ended.
#[derive(Debug)]
pub struct Ending {
    /// What is in it.
    pub written: Written,
    /// Why it ended before its time, if it did.
    pub fault: Option<WriteError>,
}

/// A recording under way: the reader's end.
#[derive(Debug)]
pub struct Recorder {
    intake: Intake,
    thread: JoinHandle<Ending>,
    rig: String,
    options: Options,
    drops: Drops,
    /// The last count that was seen of frames, masks, centerlines and truth.
    counts: [Option<u64>; 4],
}

/// What has a counter of its own.
#[derive(Debug, Clone, Copy)]
enum Counted {
    Frames,
    Masks,
    Centerlines,
    Truth,
}

impl Recorder {
    /// Records into a file.
    ///
    /// # Errors
    /// There can be no other thread.
    pub fn to_file(writer: Writer, head: &Head, options: Options) -> std::io::Result<Self> {
        let (intake, outlet) = queue(options.queue_bytes, options.queue_bytes / 8);
        let images = options.images;
        let thread = std::thread::Builder::new()
            .name("writer".into())
            .spawn(move || thread::to_file(writer, outlet, images))?;
        Ok(Self::new(intake, thread, head, options))
    }

    /// Keeps the last seconds in memory, and writes them when it is asked to.
    ///
    /// # Errors
    /// There can be no other thread.
    pub fn to_ring(ring: RingOptions, head: &Head, options: Options) -> std::io::Result<Self> {
        let all_bytes = options.queue_bytes + ring.bytes;
        let (intake, outlet) = queue(all_bytes, options.queue_bytes / 8);
        let (images, head_of_files) = (options.images, head.clone());
        let thread = std::thread::Builder::new()
            .name("ring".into())
            .spawn(move || ring::keep(ring, head_of_files, outlet, images))?;
        Ok(Self::new(intake, thread, head, options))
    }

    fn new(intake: Intake, thread: JoinHandle<Ending>, head: &Head, options: Options) -> Self {
        Self {
            intake,
            thread,
            rig: head.rig.clone(),
            options,
            drops: Drops::default(),
            counts: [None; 4],
        }
    }

    /// What is not in the recording so far.
    pub fn drops(&self) -> Drops {
        self.drops
    }

    /// The next message of each channel is its first: what is missing before it was dropped.
    pub fn begins_with_the_rig(&mut self) {
        self.counts = [Some(0); 4];
    }

    /// Records a frame. What follows the image in `bytes` is left out.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn frame(&mut self, header: &FrameHeader, bytes: &[u8]) -> Result<(), Ended> {
        self.drops.frames += self.missed(Counted::Frames, header.trace.captured);
        let whole = self.image([Topic::Frames, Topic::Image], header, bytes)?;
        self.drops.frames += u64::from(!whole);
        Ok(())
    }

    /// Records a mask that was made elsewhere.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn mask(&mut self, header: &FrameHeader, bytes: &[u8]) -> Result<(), Ended> {
        // Who makes masks may leave frames out.
        self.missed(Counted::Masks, header.trace.captured);
        let whole = self.image([Topic::Masks, Topic::MaskImage], header, bytes)?;
        self.drops.masks += u64::from(!whole);
        Ok(())
    }

    /// Records a depth image.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn depth(&mut self, header: &FrameHeader, bytes: &[u8]) -> Result<(), Ended> {
        let whole = self.image([Topic::Depth, Topic::DepthImage], header, bytes)?;
        self.drops.depths += u64::from(!whole);
        Ok(())
    }

    /// Records what fit made of it.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn descriptors3(&mut self, shapes: &Descriptors3) -> Result<(), Ended> {
        let at = (shapes.trace.sequence, shapes.trace.fitted_ns);
        let recorded = self.small(Topic::Descriptors3, at, |cdr| shapes.encode(cdr))?;
        self.drops.descriptors3 += u64::from(!recorded);
        Ok(())
    }

    /// Records what extract saw, and how it is drawn.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn centerlines(&mut self, seen: &Centerlines) -> Result<(), Ended> {
        self.drops.centerlines += self.missed(Counted::Centerlines, seen.trace.extracted);
        let at = (seen.trace.sequence, seen.trace.extracted_ns);
        let recorded = self.small(Topic::Centerlines, at, |cdr| seen.encode(cdr))?;
        self.drops.centerlines += u64::from(!recorded);
        let stamp_ns = self.options.clock.wall_ns(seen.trace.exposed_ns);
        self.small(Topic::Ropes, at, |cdr| {
            encode_ropes(seen, stamp_ns, cdr);
        })?;
        Ok(())
    }

    /// Records what fit made of it, and how it is drawn. `pixel`: where in the image a point of it is seen.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn descriptors(
        &mut self,
        shapes: &Descriptors,
        pixel: impl Fn([f64; 2]) -> Option<[f64; 2]>,
    ) -> Result<(), Ended> {
        let at = (shapes.trace.sequence, shapes.trace.fitted_ns);
        let recorded = self.small(Topic::Descriptors, at, |cdr| shapes.encode(cdr))?;
        self.drops.descriptors += u64::from(!recorded);
        let stamp_ns = self.options.clock.wall_ns(shapes.trace.exposed_ns);
        self.small(Topic::ControlPoints, at, |cdr| {
            encode_control_points(shapes, pixel, stamp_ns, cdr);
        })?;
        Ok(())
    }

    /// Records the true centerlines of a rendered frame.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn truth(&mut self, truth: &Centerlines) -> Result<(), Ended> {
        self.drops.truth += self.missed(Counted::Truth, truth.trace.captured);
        let at = (truth.trace.sequence, truth.trace.captured_ns);
        let recorded = self.small(Topic::Truth, at, |cdr| truth.encode(cdr))?;
        self.drops.truth += u64::from(!recorded);
        Ok(())
    }

    /// Records what was lost so far: what the links lost, and what was dropped here. Waits for room for it.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn losses(&mut self, links: &Losses) -> Result<(), Ended> {
        let losses = Losses {
            dropped_frames: self.drops.frames,
            dropped_centerlines: self.drops.centerlines,
            dropped_descriptors: self.drops.descriptors,
            dropped_truth: self.drops.truth,
            dropped_masks: self.drops.masks,
            dropped_depths: self.drops.depths,
            dropped_descriptors3: self.drops.descriptors3,
            ..*links
        };
        let mut cdr = self.intake.buffer_waited_for(0)?;
        self.intake.fill(&mut cdr, |cdr| losses.encode(cdr));
        let parcel = self.parcel(Topic::Losses, (0, losses.at_ns), cdr);
        Ok(self.intake.send_waiting(Item::Message(parcel))?)
    }

    /// Puts a file into the recording. In a ring, into all that are written from now on, in the place of one of the same
    /// name.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn attach(
        &mut self,
        name: &str,
        media_type: &'static str,
        at_ns: u64,
        bytes: Vec<u8>,
    ) -> Result<(), Ended> {
        self.order(Order::Attach {
            name: name.to_owned(),
            media_type,
            log_ns: self.options.clock.wall_ns(at_ns),
            bytes,
        })
    }

    /// Says more of the recording.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn about(&mut self, about: BTreeMap<String, String>) -> Result<(), Ended> {
        self.order(Order::About(about))
    }

    /// Writes what the ring holds into a file. Where there is no ring, nothing happens.
    ///
    /// # Errors
    /// The recording has ended.
    pub fn flush_to(&mut self, path: PathBuf) -> Result<(), Ended> {
        self.order(Order::Flush(path))
    }

    /// Ends the recording when all that waits is written.
    pub fn finish(self) -> Ending {
        // The thread ends when nothing can come any more.
        drop(self.intake);
        self.thread.join().unwrap_or_else(|_| Ending {
            written: Written::default(),
            fault: Some(WriteError::Fallen),
        })
    }

    fn order(&mut self, order: Order) -> Result<(), Ended> {
        Ok(self.intake.send_waiting(Item::Order(Box::new(order)))?)
    }

    /// How many messages are missing before this one.
    fn missed(&mut self, what: Counted, count: u64) -> u64 {
        let last = self.counts[what as usize].replace(count);
        // A stage that was restarted counts from 1 again.
        last.map_or(0, |last| count.saturating_sub(last.saturating_add(1)))
    }

    /// Records a frame's head and, if it has them, its pixels; `false` if there was no room for one of them.
    fn image(
        &mut self,
        [head, pixels]: [Topic; 2],
        header: &FrameHeader,
        bytes: &[u8],
    ) -> Result<bool, Ended> {
        let at = (header.trace.sequence, header.trace.captured_ns);
        if self.options.images == Images::None || header.is_blank() {
            return self.small(head, at, |cdr| header.encode(cdr));
        }
        // What beside the pixels is in an image's message is its rig's name and a few numbers.
        let most = header.image_bytes().unwrap_or(0).min(bytes.len()) + self.rig.len() + 128;
        let image = self.buffer(most)?;
        // That there was a frame is recorded even if its image is not; but no image without its head.
        let recorded = self.small(head, at, |cdr| header.encode(cdr))?;
        let Some(mut cdr) = image else {
            return Ok(false);
        };
        let stamp_ns = self.options.clock.wall_ns(header.trace.exposed_ns);
        let rig = &self.rig;
        // Not in a format that this version does not know.
        let mut is_image = false;
        if recorded {
            self.intake.fill(&mut cdr, |cdr| {
                is_image = encode_image(header, bytes, stamp_ns, rig, cdr);
            });
        }
        if !is_image {
            self.intake.keep(cdr);
            return Ok(false);
        }
        let parcel = self.parcel(pixels, at, cdr);
        self.send(parcel)
    }

    /// Records a message of some kilobytes; `false` if there was no room.
    fn small(
        &mut self,
        topic: Topic,
        at: (u64, u64),
        encode: impl FnOnce(&mut Vec<u8>),
    ) -> Result<bool, Ended> {
        let Some(mut cdr) = self.buffer(0)? else {
            return Ok(false);
        };
        self.intake.fill(&mut cdr, encode);
        let parcel = self.parcel(topic, at, cdr);
        self.send(parcel)
    }

    fn buffer(&mut self, bytes: usize) -> Result<Option<Vec<u8>>, Ended> {
        if self.options.waits {
            return Ok(Some(self.intake.buffer_waited_for(bytes)?));
        }
        Ok(self.intake.buffer(bytes))
    }

    fn send(&mut self, parcel: Parcel) -> Result<bool, Ended> {
        if self.options.waits {
            self.intake.send_waiting(Item::Message(parcel))?;
            return Ok(true);
        }
        Ok(self.intake.send(parcel)?)
    }

    fn parcel(&self, topic: Topic, (sequence, at_ns): (u64, u64), cdr: Vec<u8>) -> Parcel {
        Parcel {
            topic,
            // Of 32 bits there; the whole number is in the message.
            sequence: sequence as u32,
            log_ns: self.options.clock.wall_ns(at_ns),
            cdr,
            is_pooled: true,
        }
    }
}

#[cfg(test)]
mod allocation;
#[cfg(test)]
mod tests;

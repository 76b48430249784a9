//! Records a rig's messages. The reader passes messages at its own pace, and a separate thread
//! writes them.
//!
//! A message is copied once, from shared memory into the bytes for the file. The reader never waits
//! for the disk unless requested. Messages without room are dropped and counted.

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
    /// Encoding of the frames' pixels.
    pub images: Images,
    /// Memory for messages that wait for the disk.
    pub queue_bytes: usize,
    /// True if the reader waits for the disk instead of dropping messages.
    pub waits: bool,
    /// Converts the traces' clock to log times.
    pub clock: Clock,
}

/// Options of a recording that is kept in memory until requested.
pub struct RingOptions {
    /// Time span to keep.
    pub time: Duration,
    /// Maximum memory.
    pub bytes: usize,
    /// Compression of the recordings.
    pub compression: super::writer::Compression,
    /// Called for each recording after it was written, or after writing it failed.
    pub report: Box<dyn Fn(Flushed) + Send>,
}

/// Messages missing from the recording, because the recorder missed them or had no room for them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Drops {
    /// Frames whose images are missing.
    pub frames: u64,
    /// Centerlines.
    pub centerlines: u64,
    /// Descriptors that arrived. (Descriptors that did not arrive count as losses of the link
    /// before the recorder.)
    pub descriptors: u64,
    /// True centerlines.
    pub truth: u64,
    /// Masks.
    pub masks: u64,
    /// Depth images.
    pub depths: u64,
    /// 3-D descriptors.
    pub descriptors3: u64,
}

impl Drops {
    /// Total number of missing messages.
    pub fn total(&self) -> u64 {
        let images = self.frames + self.masks + self.depths;
        images + self.centerlines + self.descriptors + self.descriptors3 + self.truth
    }
}

/// The recording has ended early. [`Recorder::finish`] returns the reason.
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
    /// Contents of the recording.
    pub written: Written,
    /// Reason for an early end, if any.
    pub fault: Option<WriteError>,
}

/// The reader's end of a recording in progress.
#[derive(Debug)]
pub struct Recorder {
    intake: Intake,
    thread: JoinHandle<Ending>,
    rig: String,
    options: Options,
    drops: Drops,
    /// Last counts of frames, masks, centerlines and truth.
    counts: [Option<u64>; 4],
}

/// Messages that have a counter.
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
    /// Fails if no thread can be started.
    pub fn to_file(writer: Writer, head: &Head, options: Options) -> std::io::Result<Self> {
        let (intake, outlet) = queue(options.queue_bytes, options.queue_bytes / 8);
        let images = options.images;
        let thread = std::thread::Builder::new()
            .name("writer".into())
            .spawn(move || thread::to_file(writer, outlet, images))?;
        Ok(Self::new(intake, thread, head, options))
    }

    /// Keeps the last seconds in memory, and writes them on request.
    ///
    /// # Errors
    /// Fails if no thread can be started.
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

    /// Messages missing from the recording so far.
    pub fn drops(&self) -> Drops {
        self.drops
    }

    /// States that the rig starts now. If the first message received on a channel is not the
    /// channel's first, the earlier ones count as dropped.
    pub fn begins_with_the_rig(&mut self) {
        self.counts = [Some(0); 4];
    }

    /// Records a frame. Bytes after the image are left out.
    ///
    /// # Errors
    /// Fails if the recording has ended.
    pub fn frame(&mut self, header: &FrameHeader, bytes: &[u8]) -> Result<(), Ended> {
        self.drops.frames += self.missed(Counted::Frames, header.trace.captured);
        let whole = self.image([Topic::Frames, Topic::Image], header, bytes)?;
        self.drops.frames += u64::from(!whole);
        Ok(())
    }

    /// Records a mask made by another program.
    ///
    /// # Errors
    /// Fails if the recording has ended.
    pub fn mask(&mut self, header: &FrameHeader, bytes: &[u8]) -> Result<(), Ended> {
        // Programs that make masks may skip frames.
        self.missed(Counted::Masks, header.trace.captured);
        let whole = self.image([Topic::Masks, Topic::MaskImage], header, bytes)?;
        self.drops.masks += u64::from(!whole);
        Ok(())
    }

    /// Records a depth image.
    ///
    /// # Errors
    /// Fails if the recording has ended.
    pub fn depth(&mut self, header: &FrameHeader, bytes: &[u8]) -> Result<(), Ended> {
        let whole = self.image([Topic::Depth, Topic::DepthImage], header, bytes)?;
        self.drops.depths += u64::from(!whole);
        Ok(())
    }

    /// Records 3-D descriptors from fit.
    ///
    /// # Errors
    /// Fails if the recording has ended.
    pub fn descriptors3(&mut self, shapes: &Descriptors3) -> Result<(), Ended> {
        let at = (shapes.trace.sequence, shapes.trace.fitted_ns);
        let recorded = self.small(Topic::Descriptors3, at, |cdr| shapes.encode(cdr))?;
        self.drops.descriptors3 += u64::from(!recorded);
        Ok(())
    }

    /// Records centerlines from extract, and their annotations.
    ///
    /// # Errors
    /// Fails if the recording has ended.
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

    /// Records descriptors from fit, and their annotations. `pixel` maps a point of the descriptors
    /// to the image.
    ///
    /// # Errors
    /// Fails if the recording has ended.
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
    /// Fails if the recording has ended.
    pub fn truth(&mut self, truth: &Centerlines) -> Result<(), Ended> {
        self.drops.truth += self.missed(Counted::Truth, truth.trace.captured);
        let at = (truth.trace.sequence, truth.trace.captured_ns);
        let recorded = self.small(Topic::Truth, at, |cdr| truth.encode(cdr))?;
        self.drops.truth += u64::from(!recorded);
        Ok(())
    }

    /// Records the losses so far: on the links, and in this recorder. Waits for room.
    ///
    /// # Errors
    /// Fails if the recording has ended.
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

    /// Adds a file to the recording. In a ring, it is added to all recordings written from now on,
    /// and replaces one of the same name.
    ///
    /// # Errors
    /// Fails if the recording has ended.
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

    /// Adds metadata.
    ///
    /// # Errors
    /// Fails if the recording has ended.
    pub fn about(&mut self, about: BTreeMap<String, String>) -> Result<(), Ended> {
        self.order(Order::About(about))
    }

    /// Writes the contents of the ring into a file. Does nothing without a ring.
    ///
    /// # Errors
    /// Fails if the recording has ended.
    pub fn flush_to(&mut self, path: PathBuf) -> Result<(), Ended> {
        self.order(Order::Flush(path))
    }

    /// Ends the recording once all waiting messages are written.
    pub fn finish(self) -> Ending {
        // The thread ends once the queue is closed.
        drop(self.intake);
        self.thread.join().unwrap_or_else(|_| Ending {
            written: Written::default(),
            fault: Some(WriteError::Fallen),
        })
    }

    fn order(&mut self, order: Order) -> Result<(), Ended> {
        Ok(self.intake.send_waiting(Item::Order(Box::new(order)))?)
    }

    /// Returns the number of messages missing before this one.
    fn missed(&mut self, what: Counted, count: u64) -> u64 {
        let last = self.counts[what as usize].replace(count);
        // A restarted stage counts from 1 again.
        last.map_or(0, |last| count.saturating_sub(last.saturating_add(1)))
    }

    /// Records a frame's header and, if the frame has pixels, the pixels. Returns `false` if there
    /// was no room for the header or the pixels.
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
        // Besides the pixels, an image message contains its rig's name and a few numbers.
        let most = header.image_bytes().unwrap_or(0).min(bytes.len()) + self.rig.len() + 128;
        let image = self.buffer(most)?;
        // A frame's header is recorded even without its image, but an image is not recorded without
        // its header.
        let recorded = self.small(head, at, |cdr| header.encode(cdr))?;
        let Some(mut cdr) = image else {
            return Ok(false);
        };
        let stamp_ns = self.options.clock.wall_ns(header.trace.exposed_ns);
        let rig = &self.rig;
        // False for a format that this version does not know.
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

    /// Records a message of a few kilobytes; `false` if there was no room.
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
            // MCAP's sequence has 32 bits. The complete number is in the message.
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

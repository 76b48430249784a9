//! An open recording.

use std::io;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use super::about::About;
use super::census;
use super::chunk::Unpacker;
use super::cursor::{Messages, Source};
use super::error::RecordingError;
use super::index::Indexed;
use super::layout::{HEAD_BYTES, attachment};
use super::opening::{self, Opened};
use super::scan::{times_among, times_of};

/// A recording: an MCAP file that lariat made, or another one with images, or a folder of several
/// files as ROS 2 makes it.
///
/// The file may contain any bytes. Lengths are not trusted until the bytes are read, so memory is
/// limited to a few times the file's size, and 1 GiB for a chunk.
pub struct Recording {
    /// The files in their order. There is at least one.
    files: Vec<Source>,
    /// All topics with images from which the frames' topic was chosen.
    candidates: Vec<String>,
    about: About,
    cut_off: Option<String>,
}

/// A position in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Number of a frame in the recording, counted from 1.
    Frame(u64),
    /// Time since the first message.
    After(Duration),
}

/// A part of a recording: the frames from one position up to but excluding another, and all results
/// of these frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Span {
    /// The beginning if `None`.
    pub from: Option<Place>,
    /// The end if `None`.
    pub to: Option<Place>,
}

/// A topic of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicSummary {
    /// Name of the topic.
    pub name: String,
    /// Name of its schema; empty if there is none.
    pub schema: String,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of the messages, unpacked.
    pub bytes: u64,
    /// Upper bound of the largest message's size, in bytes.
    pub largest: u64,
}

impl Recording {
    /// Opens a file or a folder.
    ///
    /// # Errors
    /// Fails if it cannot be read, is not a recording, or contains nothing that lariat reads.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Self::open_topic(path, None)
    }

    /// Opens a file or a folder. `topic` selects the topic whose images are the frames, if several
    /// topics have images.
    ///
    /// # Errors
    /// Fails as [`open`](Self::open) does, or if there is no such topic.
    pub fn open_topic(path: &Path, topic: Option<&str>) -> Result<Self, RecordingError> {
        let (files, notes) = opening::open(path, topic)?;
        let mut recording = Self::of_files(files);
        recording.cut_off = (!notes.is_empty()).then(|| notes.join("; "));
        Ok(recording)
    }

    /// Opens a recording in memory.
    ///
    /// # Errors
    /// Fails as [`open`](Self::open) does.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, RecordingError> {
        Ok(Self::of_files(vec![Opened::new(Arc::new(bytes), None)?]))
    }

    /// Combines files. Metadata comes from the first one.
    fn of_files(mut files: Vec<Opened>) -> Self {
        let mut candidates: Vec<String> = (files.iter())
            .flat_map(|file| file.source.topics.candidates.iter().cloned())
            .collect();
        candidates.sort();
        candidates.dedup();
        let about = std::mem::take(&mut files[0].about);
        let cut_off = files[0].cut_off.take();
        Self {
            files: files.into_iter().map(|file| file.source).collect(),
            candidates,
            about,
            cut_off,
        }
    }

    /// Metadata of the recording.
    pub fn about(&self) -> &About {
        &self.about
    }

    /// Message about what is missing at the end, if the recording was not closed.
    pub fn cut_off(&self) -> Option<&str> {
        self.cut_off.as_deref()
    }

    /// Total size of the files, in bytes.
    pub fn size(&self) -> u64 {
        self.files.iter().map(|file| file.storage.size()).sum()
    }

    /// The topic whose images are the frames.
    pub fn images(&self) -> Option<&str> {
        (self.files.iter()).find_map(|file| file.topics.images.as_deref())
    }

    /// All topics with images; the frames' topic is one of them. There are several if several
    /// cameras were recorded.
    pub fn cameras(&self) -> &[String] {
        &self.candidates
    }

    /// Returns whether the frames are lariat's own, with their traces.
    pub fn has_traces(&self) -> bool {
        self.files.iter().any(|file| file.topics.has_headers)
    }

    /// Log times of the first and the last message, in nanoseconds of Unix time.
    pub fn times_ns(&self) -> (u64, u64) {
        let parts = || self.files.iter().flat_map(|file| &file.index.parts);
        let first = parts().map(|part| part.start_ns).min();
        let last = parts().map(|part| part.end_ns).max();
        (first.unwrap_or(0), last.unwrap_or(0))
    }

    /// Returns the attachment of this name.
    ///
    /// # Errors
    /// Fails if the attachment is damaged.
    pub fn attachment(&self, name: &str) -> Result<Option<Vec<u8>>, RecordingError> {
        // The last attachment of a name is the valid one.
        let mut placed = self.files.iter().rev().flat_map(|file| {
            let placed = file.index.attachments.iter().rev();
            placed.map(move |placed| (&file.storage, placed))
        });
        let Some((storage, placed)) = placed.find(|(_, placed)| placed.name == name) else {
            return Ok(None);
        };
        let offset = placed.offset;
        let damaged = RecordingError::Damaged {
            offset,
            why: "an attachment is not what was written",
        };
        let (Some(at), Some(bytes)) = (
            offset.checked_add(HEAD_BYTES),
            placed.length.checked_sub(HEAD_BYTES),
        ) else {
            return Err(damaged);
        };
        let mut buffer = Vec::new();
        storage.read_into(at, bytes, &mut buffer)?;
        match attachment(&buffer) {
            Some((of, bytes)) if of == name => Ok(Some(bytes.to_vec())),
            _ => Err(damaged),
        }
    }

    /// Names of the attachments.
    pub fn attachments(&self) -> impl Iterator<Item = &str> {
        let placed = self.files.iter().flat_map(|file| &file.index.attachments);
        placed.map(|placed| &placed.name[..])
    }

    /// Counts the messages on each topic, sorted by name.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub fn topics(&self) -> Result<Vec<TopicSummary>, RecordingError> {
        let mut topics: Vec<TopicSummary> = Vec::new();
        for Source { storage, index, .. } in &self.files {
            let mut unpacker = Unpacker::new(storage.clone());
            let counts = census::take(storage.as_ref(), index, &mut unpacker)?;
            for (id, listed) in &index.channels {
                let schema = index.schemas.get(&listed.schema);
                let schema = schema.map_or("", |schema| &schema.name);
                let count = counts.get(id).copied().unwrap_or_default();
                let is_it = |of: &&mut TopicSummary| of.name == listed.topic && of.schema == schema;
                // A topic may have a channel in each file.
                match topics
                    .iter_mut()
                    .find(is_it)
                    .filter(|_| self.files.len() > 1)
                {
                    Some(topic) => {
                        topic.messages += count.messages;
                        topic.bytes += count.bytes;
                        topic.largest = topic.largest.max(count.largest);
                    }
                    None => topics.push(TopicSummary {
                        name: listed.topic.clone(),
                        schema: schema.to_owned(),
                        messages: count.messages,
                        bytes: count.bytes,
                        largest: count.largest,
                    }),
                }
            }
        }
        topics.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(topics)
    }

    /// Counts the frames.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub fn frames(&self) -> Result<u64, RecordingError> {
        let mut count = 0;
        self.each_frame(|_| count += 1)?;
        Ok(count)
    }

    /// Returns the number of frames in a part, and the log times of the first and the last, in
    /// nanoseconds of Unix time.
    ///
    /// # Errors
    /// Fails if a position is after the last frame, or if the file cannot be read.
    pub fn frame_times_ns(&self, span: Span) -> Result<(u64, Option<[u64; 2]>), RecordingError> {
        let span_ns = self.span_ns(span)?;
        let (mut count, mut ends) = (0, None);
        self.each_frame(|at_ns| {
            if span_ns.contains(&at_ns) {
                let [_, last_ns] = ends.get_or_insert([at_ns; 2]);
                *last_ns = at_ns;
                count += 1;
            }
        })?;
        Ok((count, ends))
    }

    /// Returns a cursor over the messages of a part.
    ///
    /// # Errors
    /// Fails if a position is after the last frame, or if the file cannot be read.
    pub fn messages(&self, span: Span) -> Result<Messages, RecordingError> {
        let span_ns = self.span_ns(span)?;
        let mut before = 0;
        if !self.has_traces() && span.from.is_some() {
            self.each_frame(|at_ns| before += u64::from(at_ns < span_ns.start))?;
        }
        let (first, rest) = (self.files[0].clone(), &self.files[1..]);
        Ok(Messages::new(first, rest, span_ns, before))
    }

    /// Returns a cursor over a part at the end that contains the last report of losses, and
    /// possibly other messages.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub fn losses(&self) -> Result<Messages, RecordingError> {
        // There is at least one file: a recording without a file is not opened.
        let file = &self.files[self.files.len() - 1];
        let has_losses = |indexed: &&Indexed| {
            let is_losses = |(channel, _): &(u16, u64)| file.topics.is_losses(*channel);
            indexed.indexes.is_empty() || indexed.indexes.iter().any(is_losses)
        };
        let last = file.index.parts.iter().rev().find(has_losses);
        let from = last.map_or(u64::MAX, |last| last.start_ns);
        Ok(Messages::new(file.clone(), &[], from..u64::MAX, 0))
    }

    fn span_ns(&self, span: Span) -> Result<Range<u64>, RecordingError> {
        let (first, _) = self.times_ns();
        let after = |time: Duration| {
            let ns = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
            first.saturating_add(ns)
        };
        let from = match span.from {
            None => 0,
            Some(Place::After(time)) => after(time),
            Some(Place::Frame(frame)) => self
                .time_of(frame)?
                .map_err(|count| RecordingError::NoFrame { frame, count })?,
        };
        let to = match span.to {
            None => u64::MAX,
            Some(Place::After(time)) => after(time),
            // A frame after the last one means the end.
            Some(Place::Frame(frame)) => self.time_of(frame)?.unwrap_or(u64::MAX),
        };
        Ok(from..to)
    }

    /// Returns the log time of a frame, or the number of frames if there is no such frame.
    fn time_of(&self, frame: u64) -> Result<Result<u64, u64>, RecordingError> {
        let (mut count, mut time) = (0, None);
        self.each_frame(|at_ns| {
            count += 1;
            if count == frame.max(1) {
                time = Some(at_ns);
            }
        })?;
        Ok(time.ok_or(count))
    }

    /// Calls `each` with the log time of each frame, in the order of the file.
    fn each_frame(&self, mut each: impl FnMut(u64)) -> Result<(), RecordingError> {
        let mut buffer = Vec::new();
        for file in &self.files {
            let Some((channel, _)) = file.topics.frames else {
                continue;
            };
            let mut unpacker = Unpacker::new(file.storage.clone());
            for indexed in &file.index.parts {
                let storage = file.storage.as_ref();
                if times_of(storage, indexed, channel, &mut buffer, &mut each)?.is_none() {
                    load(&mut unpacker, indexed)?;
                    times_among(unpacker.records(), channel, &mut each);
                }
            }
        }
        Ok(())
    }
}

/// Loads a part. A damaged part counts as empty, as it does for a cursor.
fn load(unpacker: &mut Unpacker, indexed: &Indexed) -> Result<(), RecordingError> {
    match unpacker.load(indexed.part) {
        Err(RecordingError::Io(error)) if error.kind() != io::ErrorKind::UnexpectedEof => {
            Err(error.into())
        }
        _ => Ok(()),
    }
}

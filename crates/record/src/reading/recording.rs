//! A recording, opened.

use std::fs::File;
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
use super::layout::{HEAD_BYTES, MAGIC, attachment};
use super::scan::{self, End, times_among, times_of};
use super::storage::{FileStorage, Storage};
use super::summary;
use super::topics::Topics;

/// A recording: an MCAP file that lariat made, or another with images in it.
///
/// Any bytes may be in the file. No length in it is believed before the bytes are there, so that memory stays within some
/// times the file's size and 1 GiB for a chunk.
pub struct Recording {
    source: Source,
    about: About,
    cut_off: Option<String>,
}

/// A place in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A frame's place among the frames of the recording, from 1.
    Frame(u64),
    /// So long after the first message.
    After(Duration),
}

/// A part of a recording: its frames from one place up to, and without, another; and all that was made of these frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Span {
    /// Without it, from the beginning.
    pub from: Option<Place>,
    /// Without it, to the end.
    pub to: Option<Place>,
}

/// A topic of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicSummary {
    /// Its name.
    pub name: String,
    /// The name of its messages' definition; empty if there is none.
    pub schema: String,
    /// How many messages are on it.
    pub messages: u64,
    /// Their bytes, unpacked.
    pub bytes: u64,
    /// Bytes of the largest, at most.
    pub largest: u64,
}

impl Recording {
    /// Opens a file.
    ///
    /// # Errors
    /// It cannot be read, is no recording, or holds nothing that lariat reads.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        Self::open_topic(path, None)
    }

    /// The same; `topic` names the one whose images are the frames, where there are several.
    ///
    /// # Errors
    /// As [`open`](Self::open); or there is no such topic.
    pub fn open_topic(path: &Path, topic: Option<&str>) -> Result<Self, RecordingError> {
        Self::new(Arc::new(FileStorage::new(File::open(path)?)?), topic)
    }

    /// A recording in memory.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, RecordingError> {
        Self::new(Arc::new(bytes), None)
    }

    fn new(storage: Arc<dyn Storage>, topic: Option<&str>) -> Result<Self, RecordingError> {
        let mut magic = [0; MAGIC.len()];
        if storage.read_some(0, &mut magic)? != MAGIC {
            return Err(RecordingError::NotMcap);
        }
        let (index, end) = match summary::read(storage.as_ref())? {
            Some(index) => (index, End::Closed),
            None => {
                let found = scan::scan(&storage)?;
                (found.index, found.end)
            }
        };
        let cut = matches!(end, End::Torn { .. });
        if index.parts.is_empty() {
            return Err(RecordingError::Empty { cut });
        }
        let about = About::read(storage.as_ref(), &index)?;
        let topics = Topics::choose(&index, about.version(), topic)?;
        let cut_off = cut_off(end, storage.size(), about.version().is_some());
        Ok(Self {
            source: Source {
                offset_ns: about.monotonic_to_wall_ns(),
                storage,
                index: Arc::new(index),
                topics: Arc::new(topics),
            },
            about,
            cut_off,
        })
    }

    /// What it says of itself.
    pub fn about(&self) -> &About {
        &self.about
    }

    /// A sentence about what is missing at its end, if it was not closed.
    pub fn cut_off(&self) -> Option<&str> {
        self.cut_off.as_deref()
    }

    /// Bytes of the file.
    pub fn size(&self) -> u64 {
        self.source.storage.size()
    }

    /// The topic whose images are the frames.
    pub fn images(&self) -> Option<&str> {
        self.source.topics.images.as_deref()
    }

    /// The topics of images among which that one was chosen: several, if several cameras were recorded.
    pub fn cameras(&self) -> &[String] {
        &self.source.topics.candidates
    }

    /// Whether its frames are lariat's own, with the traces they had.
    pub fn has_traces(&self) -> bool {
        self.source.topics.has_headers
    }

    /// Log times of the first and the last message, in nanoseconds of Unix time.
    pub fn times_ns(&self) -> (u64, u64) {
        let parts = || self.source.index.parts.iter();
        let first = parts().map(|part| part.start_ns).min();
        let last = parts().map(|part| part.end_ns).max();
        (first.unwrap_or(0), last.unwrap_or(0))
    }

    /// The attachment of this name.
    ///
    /// # Errors
    /// It is damaged.
    pub fn attachment(&self, name: &str) -> Result<Option<Vec<u8>>, RecordingError> {
        // The last of a name holds.
        let mut placed = self.source.index.attachments.iter().rev();
        let Some(placed) = placed.find(|placed| placed.name == name) else {
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
        self.source.storage.read_into(at, bytes, &mut buffer)?;
        match attachment(&buffer) {
            Some((of, bytes)) if of == name => Ok(Some(bytes.to_vec())),
            _ => Err(damaged),
        }
    }

    /// The names of its attachments.
    pub fn attachments(&self) -> impl Iterator<Item = &str> {
        let placed = self.source.index.attachments.iter();
        placed.map(|placed| &placed.name[..])
    }

    /// What is on each topic, by name.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn topics(&self) -> Result<Vec<TopicSummary>, RecordingError> {
        let Source { storage, index, .. } = &self.source;
        let mut unpacker = Unpacker::new(storage.clone());
        let counts = census::take(storage.as_ref(), index, &mut unpacker)?;
        let topics = index.channels.iter().map(|(id, listed)| {
            let schema = index.schemas.get(&listed.schema);
            let count = counts.get(id).copied().unwrap_or_default();
            TopicSummary {
                name: listed.topic.clone(),
                schema: schema.map_or_else(String::new, |schema| schema.name.clone()),
                messages: count.messages,
                bytes: count.bytes,
                largest: count.largest,
            }
        });
        let mut topics: Vec<_> = topics.collect();
        topics.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(topics)
    }

    /// How many frames there are.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn frames(&self) -> Result<u64, RecordingError> {
        let mut count = 0;
        self.each_frame(|_| count += 1)?;
        Ok(count)
    }

    /// How many frames there are in a part, and the log times of the first and the last, in nanoseconds of Unix time.
    ///
    /// # Errors
    /// A place is behind the last frame, or the file cannot be read.
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

    /// A cursor over the messages of a part.
    ///
    /// # Errors
    /// A place is behind the last frame, or the file cannot be read.
    pub fn messages(&self, span: Span) -> Result<Messages, RecordingError> {
        let span_ns = self.span_ns(span)?;
        let mut before = 0;
        if !self.source.topics.has_headers && span.from.is_some() {
            self.each_frame(|at_ns| before += u64::from(at_ns < span_ns.start))?;
        }
        Ok(Messages::new(self.source.clone(), span_ns, before))
    }

    /// A cursor over a part at the end that has what was said last of losses, and whatever else is there.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn losses(&self) -> Result<Messages, RecordingError> {
        let Source { index, topics, .. } = &self.source;
        let has_losses = |indexed: &&Indexed| {
            let is_losses = |(channel, _): &(u16, u64)| topics.is_losses(*channel);
            indexed.indexes.is_empty() || indexed.indexes.iter().any(is_losses)
        };
        let last = index.parts.iter().rev().find(has_losses);
        let from = last.map_or(u64::MAX, |last| last.start_ns);
        Ok(Messages::new(self.source.clone(), from..u64::MAX, 0))
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
            // Up to a frame behind the last is up to the end.
            Some(Place::Frame(frame)) => self.time_of(frame)?.unwrap_or(u64::MAX),
        };
        Ok(from..to)
    }

    /// The log time of a frame, or how many there are.
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

    /// Tells of the log time of each frame, in the order of the file.
    fn each_frame(&self, mut each: impl FnMut(u64)) -> Result<(), RecordingError> {
        let Some((channel, _)) = self.source.topics.frames else {
            return Ok(());
        };
        let storage = self.source.storage.as_ref();
        let mut unpacker = Unpacker::new(self.source.storage.clone());
        let mut buffer = Vec::new();
        for indexed in &self.source.index.parts {
            if times_of(storage, indexed, channel, &mut buffer, &mut each)?.is_none() {
                self.load(&mut unpacker, indexed)?;
                times_among(unpacker.records(), channel, &mut each);
            }
        }
        Ok(())
    }

    /// A damaged part counts as empty: so it is to a cursor, too.
    fn load(&self, unpacker: &mut Unpacker, indexed: &Indexed) -> Result<(), RecordingError> {
        match unpacker.load(indexed.part) {
            Err(RecordingError::Io(error)) if error.kind() != io::ErrorKind::UnexpectedEof => {
                Err(error.into())
            }
            _ => Ok(()),
        }
    }
}

fn cut_off(end: End, size: u64, is_ours: bool) -> Option<String> {
    match end {
        End::Torn { at } => Some(format!(
            "this recording was not closed (its writer was killed, or the machine went down): what was written up to byte {at} \
             of {size} is whole and is read, what was not yet in a whole chunk then is missing"
        )),
        // Others may close theirs so.
        End::WithoutIndex if is_ours => Some(
            "this recording was closed in need (its disk was full, or failed): it is whole up to there".to_owned(),
        ),
        End::WithoutIndex | End::Closed => None,
    }
}

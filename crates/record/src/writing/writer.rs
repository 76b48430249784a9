//! A recording being written.
//!
//! It grows by whole chunks, each written at once ([`Staged`]) into space reserved before the chunk
//! was begun ([`Space`]). The reservation always includes the open chunk and the index at the end.
//! A full disk therefore refuses a message, but never a part of the file.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::error::WriteError;
use super::place::{Existing, Old, Opened, open};
use super::space::Space;
use super::staged::Staged;
use super::topic::Topic;
use crate::schema::{ENCODING, SCHEMA_ENCODING};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, WriteOptions};

/// A chunk is closed when it reaches this many bytes. It then contains a color image of 640×480,
/// which stays in a core's cache while it is read, checked and shown. The chunk's head and index
/// are negligible in comparison.
const CHUNK_BYTES: u64 = 1 << 19;
/// A chunk is closed after this time at the latest, so killing the recorder loses no more than
/// that.
const CHUNK_TIME: Duration = Duration::from_secs(1);
/// Bytes that a message takes in a chunk and its index in addition to its contents: 9 for the
/// record's head, 22 for the message's head, and 16 for the index.
const MESSAGE_BYTES: u64 = 48;
/// Bytes that a chunk takes in the file and in the summary in addition to its messages: heads, and
/// index entries for each of twelve topics.
const CHUNK_HEAD_BYTES: u64 = 2048;
/// Bytes that a summary takes in addition to schemas, channels, chunks and attachments: statistics,
/// offsets, and the end.
const SUMMARY_BYTES: u64 = 4096;

/// Compression of chunks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Compression {
    /// No compression.
    #[default]
    None,
    /// Fast, with a low ratio.
    Lz4,
    /// Slower, with a higher ratio.
    Zstd,
}

impl Compression {
    /// Maximum compressed size of this many bytes.
    const fn bound(self, bytes: u64) -> u64 {
        match self {
            Self::None => bytes,
            // LZ4 adds 4 bytes to an incompressible block of 64 kB, and zstd adds 3 to one of 128
            // kB. Both add a head and a tail of less than 32 bytes.
            Self::Lz4 | Self::Zstd => bytes + bytes / 4096 + 1024,
        }
    }
}

/// Description of a recording.
#[derive(Debug, Clone)]
pub struct Head {
    /// The rig, whose name is in the topics' names.
    pub rig: String,
    /// Metadata, stored under the name `lariat`.
    pub about: BTreeMap<String, String>,
}

/// Contents of a written recording.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Written {
    /// Number of messages of each topic, at the index of the topic's number.
    pub messages: [u64; Topic::ALL.len()],
    /// Length of the file.
    pub bytes: u64,
    /// True if an old recording was to be replaced, but was kept because the new one is
    /// [empty](Self::is_empty).
    pub kept_old: bool,
}

impl Written {
    /// Returns true if the recording contains nothing from a rig. Losses do not count, since they
    /// are written in any case.
    pub fn is_empty(&self) -> bool {
        !has_content(&self.messages)
    }
}

/// A recording being written. If it is dropped without [`finish`](Self::finish), it is closed, but
/// errors are ignored.
pub struct Writer {
    mcap: mcap::Writer<Staged>,
    committed: Arc<AtomicU64>,
    space: Space,
    path: PathBuf,
    /// The recording to be replaced, until that is done.
    old: Option<Old>,
    is_stream: bool,
    rig: String,
    compression: Compression,
    /// Channel number of each topic in the file, once it has one.
    channels: [Option<u16>; Topic::ALL.len()],
    messages: [u64; Topic::ALL.len()],
    /// Maximum size of the staged data, uncompressed.
    staged_bytes: u64,
    /// Maximum size of the summary.
    summary_bytes: u64,
    /// Time at which the open chunk was begun.
    since: Option<Instant>,
}

impl std::fmt::Debug for Writer {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Writer")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl Writer {
    /// Begins a recording.
    ///
    /// # Errors
    /// Fails if the file exists or cannot be created, or if there is not enough space.
    pub fn create(
        path: &Path,
        existing: Existing,
        head: &Head,
        compression: Compression,
    ) -> Result<Self, WriteError> {
        let begin = |cause| WriteError::Begin {
            path: path.to_owned(),
            cause,
        };
        let Opened {
            file,
            is_stream,
            old,
        } = open(path, existing)?;
        let space = Space::of(file.try_clone().map_err(begin)?);
        let staged = Staged::new(file, is_stream);
        let committed = staged.committed();
        let options = WriteOptions::new()
            .library(concat!("lariat ", env!("CARGO_PKG_VERSION")))
            .profile("ros2")
            // This writer closes chunks itself, by size and by time.
            .chunk_size(None)
            .calculate_data_section_crc(false)
            .compression(match compression {
                Compression::None => None,
                Compression::Lz4 => Some(mcap::Compression::Lz4),
                Compression::Zstd => Some(mcap::Compression::Zstd),
            })
            // Only the writing thread compresses; the other cores belong to the chain.
            .compression_threads(0);
        let broken = |fault| WriteError::broken(path, fault);
        let mut writer = Self {
            mcap: options.create(staged).map_err(broken)?,
            committed,
            space,
            path: path.to_owned(),
            old,
            is_stream,
            rig: head.rig.clone(),
            compression,
            channels: Default::default(),
            messages: Default::default(),
            staged_bytes: 0,
            summary_bytes: SUMMARY_BYTES,
            since: None,
        };
        writer.about(&head.about)?;
        Ok(writer)
    }

    /// Adds metadata. The last value of a key is the valid one.
    ///
    /// # Errors
    /// Fails if there is not enough space, or if a write fails.
    pub fn about(&mut self, about: &BTreeMap<String, String>) -> Result<(), WriteError> {
        let bytes: usize = about
            .iter()
            .map(|(key, value)| key.len() + value.len() + 8)
            .sum();
        self.make_room(bytes as u64, MESSAGE_BYTES)?;
        let metadata = Metadata {
            name: "lariat".to_owned(),
            metadata: about.clone(),
        };
        let outcome = self.mcap.write_metadata(&metadata);
        outcome.map_err(|fault| WriteError::broken(&self.path, fault))?;
        self.commit()
    }

    /// Adds a file to the recording. `log_ns` is its time, in nanoseconds of Unix time.
    ///
    /// # Errors
    /// Fails if there is not enough space, or if a write fails.
    pub fn attach(
        &mut self,
        name: &str,
        media_type: &str,
        log_ns: u64,
        bytes: &[u8],
    ) -> Result<(), WriteError> {
        let beside = 2 * (name.len() + media_type.len()) as u64 + 256;
        self.make_room(bytes.len() as u64, beside)?;
        let attachment = Attachment {
            log_time: log_ns,
            create_time: log_ns,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: bytes.into(),
        };
        let outcome = self.mcap.attach(&attachment);
        outcome.map_err(|fault| WriteError::broken(&self.path, fault))?;
        self.commit()
    }

    /// Writes a message: CDR in its topic's schema. `log_ns` is its time, in nanoseconds of Unix
    /// time.
    ///
    /// # Errors
    /// Fails if there is not enough space, or if a write fails. Earlier data is intact, and
    /// [`finish`](Self::finish) closes the file.
    pub fn write(
        &mut self,
        topic: Topic,
        sequence: u32,
        log_ns: u64,
        cdr: &[u8],
    ) -> Result<(), WriteError> {
        let channel_id = match self.channels[topic as usize] {
            Some(id) => id,
            None => self.add(topic)?,
        };
        self.make_room(cdr.len() as u64, 0)?;
        let header = MessageHeader {
            channel_id,
            sequence,
            log_time: log_ns,
            publish_time: log_ns,
        };
        let outcome = self.mcap.write_to_known_channel(&header, cdr);
        outcome.map_err(|fault| WriteError::broken(&self.path, fault))?;
        self.messages[topic as usize] += 1;
        self.since.get_or_insert_with(Instant::now);
        if self.staged_bytes >= CHUNK_BYTES {
            return self.commit();
        }
        self.commit_if_due()
    }

    /// Time at which the open chunk has to be closed, if one is open.
    pub fn due(&self) -> Option<Instant> {
        self.since.map(|since| since + CHUNK_TIME)
    }

    /// Closes the open chunk if it is old enough.
    ///
    /// # Errors
    /// Fails if a write fails.
    pub fn commit_if_due(&mut self) -> Result<(), WriteError> {
        match self.due() {
            Some(due) if Instant::now() >= due => self.commit(),
            _ => Ok(()),
        }
    }

    /// Closes the recording, and waits until it is on the disk.
    ///
    /// # Errors
    /// Fails if a write fails.
    pub fn finish(self) -> Result<Written, WriteError> {
        let Self {
            mut mcap,
            mut space,
            path,
            old,
            is_stream,
            messages,
            ..
        } = self;
        mcap.finish()
            .map_err(|fault| WriteError::broken(&path, fault))?;
        let staged = mcap.into_inner();
        let bytes = staged.committed().load(Ordering::Relaxed);
        let kept_old = old.is_some() && !has_content(&messages);
        let close = || -> io::Result<()> {
            if let Some(old) = old.filter(|_| !kept_old) {
                old.make_room()?;
            }
            if is_stream {
                return Ok(());
            }
            space.give_back()?;
            staged.sync()
        };
        close().map_err(|cause| WriteError::Broken { path, cause })?;
        Ok(Written {
            messages,
            bytes,
            kept_old,
        })
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Defines a topic in the file.
    fn add(&mut self, topic: Topic) -> Result<u16, WriteError> {
        let schema = topic.schema();
        let name = topic.on(&self.rig);
        // The definition is written once at its first use, and once in the summary.
        let bytes = (schema.text.len() + schema.name.len() + name.len()) as u64 + 128;
        self.make_room(bytes, bytes)?;
        let text = schema.text.as_bytes();
        let added = self
            .mcap
            .add_schema(schema.name, SCHEMA_ENCODING, text)
            .and_then(|id| self.mcap.add_channel(id, &name, ENCODING, &BTreeMap::new()));
        let id = added.map_err(|fault| WriteError::broken(&self.path, fault))?;
        self.channels[topic as usize] = Some(id);
        Ok(id)
    }

    /// Reserves room for this many more bytes, and for the end of the file after them.
    fn make_room(&mut self, bytes: u64, in_summary: u64) -> Result<(), WriteError> {
        let staged = self.staged_bytes + bytes + MESSAGE_BYTES;
        let summary = self.summary_bytes + in_summary;
        let length = self.committed.load(Ordering::Relaxed)
            + self.compression.bound(staged)
            + CHUNK_HEAD_BYTES
            + summary;
        self.space.reserve(length).map_err(|why| WriteError::Full {
            path: self.path.clone(),
            why,
        })?;
        self.staged_bytes = staged;
        self.summary_bytes = summary;
        Ok(())
    }

    /// Closes the open chunk and writes it.
    fn commit(&mut self) -> Result<(), WriteError> {
        self.since = None;
        self.staged_bytes = 0;
        self.summary_bytes += CHUNK_HEAD_BYTES;
        let outcome = self.mcap.flush();
        outcome.map_err(|fault| WriteError::broken(&self.path, fault))?;
        match self.old.take_if(|_| has_content(&self.messages)) {
            None => Ok(()),
            Some(old) => old.make_room().map_err(|cause| WriteError::Broken {
                path: self.path.clone(),
                cause,
            }),
        }
    }
}

/// Returns whether the messages include any from a rig.
fn has_content(messages: &[u64; Topic::ALL.len()]) -> bool {
    let of_losses = messages[Topic::Losses as usize];
    messages.iter().sum::<u64>() > of_losses
}

#[cfg(test)]
mod tests;

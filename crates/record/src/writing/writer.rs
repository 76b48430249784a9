//! One recording being written.
//!
//! It grows by whole chunks, each written in one go ([`Staged`]) into room that was taken before the chunk was begun
//! ([`Space`]), and that always also holds the chunk that is open and the index at the end. So a full disk refuses a message,
//! and never a part of the file.

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

/// A chunk that has so many bytes is closed: one image of 640×480 in colour, which stays in a core's cache while it is read,
/// checked and shown; and enough that its head and its index do not count.
const CHUNK_BYTES: u64 = 1 << 19;
/// A chunk is closed after so long in any case: who kills the recorder loses no more.
const CHUNK_TIME: Duration = Duration::from_secs(1);
/// What a message takes in a chunk and its index beside its own bytes: 9 of a record's head, 22 of the message's, and 16 of
/// the index.
const MESSAGE_BYTES: u64 = 48;
/// What a chunk takes beside its messages, in the file and in the summary: heads, and what each of twelve topics has in its
/// indexes.
const CHUNK_HEAD_BYTES: u64 = 2048;
/// What a summary takes beside what is added for schemas, channels, chunks and attachments: statistics, offsets, the end.
const SUMMARY_BYTES: u64 = 4096;

/// How chunks are compressed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Compression {
    /// Not at all.
    #[default]
    None,
    /// Fast, little.
    Lz4,
    /// Slower, more.
    Zstd,
}

impl Compression {
    /// The most that so many bytes can become.
    const fn bound(self, bytes: u64) -> u64 {
        match self {
            Self::None => bytes,
            // LZ4 adds 4 bytes to a block of 64 kB that it cannot compress, zstd 3 to one of 128 kB, and both a head and a
            // tail of less than 32.
            Self::Lz4 | Self::Zstd => bytes + bytes / 4096 + 1024,
        }
    }
}

/// What a recording says of itself.
#[derive(Debug, Clone)]
pub struct Head {
    /// The rig, which its topics are named after.
    pub rig: String,
    /// What stands in its metadata, under the name `lariat`.
    pub about: BTreeMap<String, String>,
}

/// What was written.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Written {
    /// Messages of each topic, at the place of its number.
    pub messages: [u64; Topic::ALL.len()],
    /// Length of the file.
    pub bytes: u64,
    /// Whether an old recording that was to make room is still there, as [nothing](Self::is_empty) came in its stead.
    pub kept_old: bool,
}

impl Written {
    /// Whether nothing of a rig is in it: what was lost is written also where nothing came.
    pub fn is_empty(&self) -> bool {
        !has_content(&self.messages)
    }
}

/// A recording being written. Dropped without [`finish`](Self::finish), it is closed, but nobody learns of a fault.
pub struct Writer {
    mcap: mcap::Writer<Staged>,
    committed: Arc<AtomicU64>,
    space: Space,
    path: PathBuf,
    /// The recording that makes room, until it has.
    old: Option<Old>,
    is_stream: bool,
    rig: String,
    compression: Compression,
    /// The number that each topic has in the file, once it has one.
    channels: [Option<u16>; Topic::ALL.len()],
    messages: [u64; Topic::ALL.len()],
    /// The most that is staged, uncompressed.
    staged_bytes: u64,
    /// The most that the summary will take.
    summary_bytes: u64,
    /// When the open chunk was begun.
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
    /// There is a file already, it could not be made, or there is no room for it.
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
            // Chunks are closed here, by size and by time.
            .chunk_size(None)
            .calculate_data_section_crc(false)
            .compression(match compression {
                Compression::None => None,
                Compression::Lz4 => Some(mcap::Compression::Lz4),
                Compression::Zstd => Some(mcap::Compression::Zstd),
            })
            // By the thread that writes, and no other: the cores are the chain's.
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

    /// Says more of the recording: what is said last of a key holds.
    ///
    /// # Errors
    /// There is no room for it, or writing failed.
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

    /// Puts a file into the recording. `log_ns`: when, in nanoseconds of Unix time.
    ///
    /// # Errors
    /// There is no room for it, or writing failed.
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

    /// Writes a message: CDR, by its topic's schema. `log_ns`: its time, in nanoseconds of Unix time.
    ///
    /// # Errors
    /// There is no room for it, or writing failed. What was written before is whole: [`finish`](Self::finish) closes it.
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

    /// When the open chunk is to be closed, if one is open.
    pub fn due(&self) -> Option<Instant> {
        self.since.map(|since| since + CHUNK_TIME)
    }

    /// Closes the open chunk if it is old enough.
    ///
    /// # Errors
    /// Writing failed.
    pub fn commit_if_due(&mut self) -> Result<(), WriteError> {
        match self.due() {
            Some(due) if Instant::now() >= due => self.commit(),
            _ => Ok(()),
        }
    }

    /// Closes the recording, and waits until the disk has it.
    ///
    /// # Errors
    /// Writing failed.
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

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes a topic known to the file.
    fn add(&mut self, topic: Topic) -> Result<u16, WriteError> {
        let schema = topic.schema();
        let name = topic.on(&self.rig);
        // Once where it is first used, once in the summary.
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

    /// Makes sure that there is room for so many bytes more, and for the end of the file behind them.
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

    /// Closes the open chunk, and writes it.
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

/// Whether anything of a rig is among the messages.
fn has_content(messages: &[u64; Topic::ALL.len()]) -> bool {
    let of_losses = messages[Topic::Losses as usize];
    messages.iter().sum::<u64>() > of_losses
}

#[cfg(test)]
mod tests;

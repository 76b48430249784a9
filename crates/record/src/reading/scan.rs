//! Rebuilds the index of a recording that was not closed, or was written without one, by scanning
//! the file from record to record. It skips over chunks and unpacks only chunks that define topics,
//! and the last chunk, because no other chunk can be torn.

use std::sync::Arc;

use super::chunk::{Part, Unpacker};
use super::error::RecordingError;
use super::index::{Index, Indexed, Placed};
use super::layout::{
    CHUNK_HEAD_BYTES, ChunkHead, HEAD_BYTES, MAGIC, Message, Records, attachment_name, head, kind,
    message_index,
};
use super::storage::Storage;

/// Number of bytes read at a time from messages outside of chunks.
const BARE_BYTES: u64 = 4 << 20;

/// Result of a scan.
pub(super) struct Found {
    pub(super) index: Index,
    pub(super) end: End,
}

/// How a recording ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// With its index.
    Closed,
    /// Regularly, but without an index.
    WithoutIndex,
    /// In the middle of a record.
    Torn {
        /// Position of that record.
        at: u64,
    },
}

/// Scans the file.
///
/// # Errors
/// Fails if the file cannot be read.
pub(super) fn scan(storage: &Arc<dyn Storage>) -> Result<Found, RecordingError> {
    let mut scan = Scan {
        storage: storage.as_ref(),
        index: Index::default(),
        buffer: Vec::new(),
    };
    let mut end = scan.walk()?;
    let mut index = scan.index;
    let mut unpacker = Unpacker::new(storage.clone());
    if end != End::WithoutIndex {
        // After a power failure, the last bytes on disk may be wrong.
        while let Some(last) = index.parts.last().filter(|last| last.part.is_chunk) {
            if unpacker.load(last.part).is_ok() {
                break;
            }
            let at = last.part.offset;
            end = End::Torn { at };
            index.parts.pop();
        }
    }
    find_topics(&mut index, &mut unpacker);
    Ok(Found { index, end })
}

struct Scan<'a> {
    storage: &'a dyn Storage,
    index: Index,
    buffer: Vec<u8>,
}

impl Scan<'_> {
    fn walk(&mut self) -> Result<End, RecordingError> {
        let mut at = MAGIC.len() as u64;
        let mut begin = [0; CHUNK_HEAD_BYTES as usize];
        loop {
            let seen = self.storage.read_some(at, &mut begin)?;
            let Some((kind, length)) = head(seen) else {
                return Ok(End::Torn { at });
            };
            let next = at
                .checked_add(HEAD_BYTES)
                .and_then(|b| b.checked_add(length));
            let Some(next) = next.filter(|&next| next <= self.storage.size()) else {
                return Ok(End::Torn { at });
            };
            if kind == kind::DATA_END {
                // Only the index after this record can be torn.
                return Ok(match self.has_end()? {
                    true => End::WithoutIndex,
                    false => End::Torn { at },
                });
            }
            let part = (at, next - at);
            match kind {
                kind::CHUNK => self.chunk(part, &seen[HEAD_BYTES as usize..]),
                kind::MESSAGE => self.bare_message(part, &seen[HEAD_BYTES as usize..]),
                kind::ATTACHMENT | kind::METADATA => self.aside(kind, part)?,
                kind::SCHEMA | kind::CHANNEL | kind::MESSAGE_INDEX => self.small(kind, part)?,
                _ => {}
            }
            at = next;
        }
    }

    /// Returns whether the file ends with the magic.
    fn has_end(&self) -> Result<bool, RecordingError> {
        let mut end = [0; MAGIC.len()];
        let at = self.storage.size().saturating_sub(MAGIC.len() as u64);
        Ok(self.storage.read_some(at, &mut end)? == MAGIC)
    }

    fn chunk(&mut self, (offset, length): (u64, u64), begin: &[u8]) {
        let Some(chunk) = ChunkHead::read(begin) else {
            return;
        };
        self.index.parts.push(Indexed {
            part: Part {
                offset,
                length,
                is_chunk: true,
            },
            start_ns: chunk.start_ns,
            end_ns: chunk.end_ns,
            indexes: Vec::new(),
        });
    }

    /// Adds a message outside of chunks to a part of such messages.
    fn bare_message(&mut self, (offset, length): (u64, u64), begin: &[u8]) {
        let Some(message) = Message::read(begin) else {
            return;
        };
        let time_ns = message.log_time_ns;
        if let Some(last) = self.index.parts.last_mut()
            && !last.part.is_chunk
            && last.part.offset + last.part.length == offset
            && last.part.length + length <= BARE_BYTES
        {
            last.part.length += length;
            last.start_ns = last.start_ns.min(time_ns);
            last.end_ns = last.end_ns.max(time_ns);
            return;
        }
        self.index.parts.push(Indexed {
            part: Part {
                offset,
                length,
                is_chunk: false,
            },
            start_ns: time_ns,
            end_ns: time_ns,
            indexes: Vec::new(),
        });
    }

    fn aside(&mut self, kind: u8, (offset, length): (u64, u64)) -> Result<(), RecordingError> {
        // Only the attachment's name is needed, which is at its beginning.
        let bytes = (length - HEAD_BYTES).min(4096);
        self.storage
            .read_into(offset + HEAD_BYTES, bytes, &mut self.buffer)?;
        let (list, name) = match kind {
            kind::ATTACHMENT => (
                &mut self.index.attachments,
                attachment_name(&self.buffer).unwrap_or_default(),
            ),
            _ => (&mut self.index.metadata, ""),
        };
        list.push(Placed {
            name: name.to_owned(),
            offset,
            length,
        });
        Ok(())
    }

    fn small(&mut self, kind: u8, (offset, length): (u64, u64)) -> Result<(), RecordingError> {
        let fields = (offset + HEAD_BYTES, length - HEAD_BYTES);
        if kind != kind::MESSAGE_INDEX {
            self.storage
                .read_into(fields.0, fields.1, &mut self.buffer)?;
            self.index.take(kind, &self.buffer);
            return Ok(());
        }
        let mut begin = [0; 6];
        let begin = self.storage.read_some(fields.0, &mut begin)?;
        if let (Some(channel), Some(last)) = (begin.first_chunk(), self.index.parts.last_mut())
            && last.part.is_chunk
        {
            let channel = u16::from_le_bytes(*channel);
            last.indexes.push((channel, offset));
        }
        Ok(())
    }
}

/// Searches for topic definitions in chunks that have messages of an unknown topic.
fn find_topics(index: &mut Index, unpacker: &mut Unpacker) {
    for i in 0..index.parts.len() {
        let indexed = &index.parts[i];
        let known = |(channel, _): &(u16, u64)| index.channels.contains_key(channel);
        let all_known = !indexed.indexes.is_empty() && indexed.indexes.iter().all(known);
        if indexed.part.is_chunk && !all_known && unpacker.load(indexed.part).is_ok() {
            index.take_topics(unpacker.records());
        }
    }
}

/// Calls `each` with the log time of each message of one channel in one part.
///
/// Returns `None` if the part has no usable index.
pub(super) fn times_of(
    storage: &dyn Storage,
    indexed: &Indexed,
    channel: u16,
    buffer: &mut Vec<u8>,
    mut each: impl FnMut(u64),
) -> Result<Option<()>, RecordingError> {
    if indexed.indexes.is_empty() {
        return Ok(None);
    }
    let of_channel = |(listed, _): &&(u16, u64)| *listed == channel;
    for (_, offset) in indexed.indexes.iter().filter(of_channel) {
        let mut begin = [0; HEAD_BYTES as usize];
        let Some((kind::MESSAGE_INDEX, length)) = head(storage.read_some(*offset, &mut begin)?)
        else {
            return Ok(None);
        };
        storage.read_into(offset + HEAD_BYTES, length, buffer)?;
        let Some(entries) = message_index(buffer, channel) else {
            return Ok(None);
        };
        entries.iter().for_each(|entry| each(entry.log_time));
    }
    Ok(Some(()))
}

/// Calls `each` with the log time of each message of one channel in records in memory.
pub(super) fn times_among(records: &[u8], channel: u16, mut each: impl FnMut(u64)) {
    for (kind, record) in Records::new(records) {
        if kind == kind::MESSAGE
            && let Some(message) = Message::read(record)
            && message.channel == channel
        {
            each(message.log_time_ns);
        }
    }
}

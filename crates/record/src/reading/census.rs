//! Counts messages and bytes on each topic from the message indexes. Chunks are unpacked only if
//! their indexes are missing.

use std::collections::BTreeMap;

use super::chunk::Unpacker;
use super::error::RecordingError;
use super::index::{Index, Indexed};
use super::layout::{
    CHUNK_HEAD_BYTES, ChunkHead, HEAD_BYTES, Message, Records, head, kind, message_index,
};
use super::storage::Storage;

/// Bytes of a message record besides the message: the record's head and the message's own.
const MESSAGE_HEAD_BYTES: u64 = HEAD_BYTES + 2 + 4 + 8 + 8;

/// Totals of a topic.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Count {
    pub(super) messages: u64,
    pub(super) bytes: u64,
    /// Bytes of the largest message.
    pub(super) largest: u64,
}

impl Count {
    fn add(&mut self, bytes: u64) {
        self.messages += 1;
        self.bytes += bytes;
        self.largest = self.largest.max(bytes);
    }
}

/// Counts messages by channel.
pub(super) fn take(
    storage: &dyn Storage,
    index: &Index,
    unpacker: &mut Unpacker,
) -> Result<BTreeMap<u16, Count>, RecordingError> {
    let mut counts = BTreeMap::new();
    let mut places = Vec::new();
    let mut buffer = Vec::new();
    for indexed in &index.parts {
        places.clear();
        let found = find_places(storage, indexed, &mut places, &mut buffer)?;
        match found {
            Some(end) => count_places(&mut places, end, &mut counts),
            // Damaged parts are not counted.
            None if unpacker.load(indexed.part).is_err() => {}
            None => count_records(unpacker.records(), &mut counts),
        }
    }
    Ok(counts)
}

/// Finds the offset and channel of each message among the unpacked records, and the end of the
/// records. Returns `None` if the indexes are unusable.
fn find_places(
    storage: &dyn Storage,
    indexed: &Indexed,
    places: &mut Vec<(u64, u16)>,
    buffer: &mut Vec<u8>,
) -> Result<Option<u64>, RecordingError> {
    if indexed.indexes.is_empty() {
        return Ok(None);
    }
    for (channel, offset) in &indexed.indexes {
        let mut begin = [0; HEAD_BYTES as usize];
        let Some((kind::MESSAGE_INDEX, length)) = head(storage.read_some(*offset, &mut begin)?)
        else {
            return Ok(None);
        };
        if storage
            .read_into(offset + HEAD_BYTES, length, buffer)
            .is_err()
        {
            return Ok(None);
        }
        let Some(entries) = message_index(buffer, *channel) else {
            return Ok(None);
        };
        places.extend(entries.iter().map(|entry| (entry.offset, *channel)));
    }
    let mut begin = [0; CHUNK_HEAD_BYTES as usize];
    let begin = storage.read_some(indexed.part.offset, &mut begin)?;
    let chunk = begin.get(HEAD_BYTES as usize..).and_then(ChunkHead::read);
    Ok(chunk.map(|chunk| chunk.unpacked))
}

/// Counts each message up to the next one. Definitions of topics between two messages are therefore
/// included.
fn count_places(places: &mut [(u64, u16)], end: u64, counts: &mut BTreeMap<u16, Count>) {
    places.sort_unstable();
    for (i, (place, channel)) in places.iter().enumerate() {
        let behind = places.get(i + 1).map_or(end, |(next, _)| *next);
        let bytes = behind.saturating_sub(*place);
        let count = counts.entry(*channel).or_default();
        count.add(bytes.saturating_sub(MESSAGE_HEAD_BYTES));
    }
}

fn count_records(records: &[u8], counts: &mut BTreeMap<u16, Count>) {
    for (kind, record) in Records::new(records) {
        if kind == kind::MESSAGE
            && let Some(message) = Message::read(record)
        {
            let count = counts.entry(message.channel).or_default();
            count.add(message.bytes.len() as u64);
        }
    }
}

//! Records of an MCAP file (<https://mcap.dev/spec>) that are read partially, or once per message.
//! The mcap crate (0.26) reads the others. It cannot read a chunk's head without the chunk, or the
//! records of a torn file. It panics on an attachment that is shorter than its own fields.

use super::fields::Fields;
use mcap::records::{MessageIndexEntry, Record};

/// First and last bytes of a file.
pub(super) const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
/// Bytes before each record: its kind, and its length in eight bytes.
pub(super) const HEAD_BYTES: u64 = 9;
/// A footer with its head, and the magic after it.
pub(super) const END_BYTES: u64 = HEAD_BYTES + 8 + 8 + 4 + MAGIC.len() as u64;
/// Head of a chunk up to its records, with a compression name of at most sixteen letters.
pub(super) const CHUNK_HEAD_BYTES: u64 = HEAD_BYTES + 8 + 8 + 8 + 4 + 4 + 16 + 8;

/// Kinds of records.
pub(super) mod kind {
    pub(crate) const FOOTER: u8 = 0x02;
    pub(crate) const SCHEMA: u8 = 0x03;
    pub(crate) const CHANNEL: u8 = 0x04;
    pub(crate) const MESSAGE: u8 = 0x05;
    pub(crate) const CHUNK: u8 = 0x06;
    pub(crate) const MESSAGE_INDEX: u8 = 0x07;
    pub(crate) const CHUNK_INDEX: u8 = 0x08;
    pub(crate) const ATTACHMENT: u8 = 0x09;
    pub(crate) const ATTACHMENT_INDEX: u8 = 0x0A;
    pub(crate) const METADATA: u8 = 0x0C;
    pub(crate) const METADATA_INDEX: u8 = 0x0D;
    pub(crate) const DATA_END: u8 = 0x0F;
}

/// Reads a record's kind and the length of its contents; `None` if the bytes are not a head.
pub(super) fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let mut fields = Fields(bytes);
    let kind = fields.u8()?;
    // A file that was extended in advance ends in zeros.
    (kind != 0).then_some((kind, fields.u64()?))
}

/// Iterates over records in memory, up to the end or the first incomplete one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Records<'a>(pub(super) Fields<'a>);

impl<'a> Records<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self(Fields(bytes))
    }
}

impl<'a> Iterator for Records<'a> {
    /// Kind and contents of a record.
    type Item = (u8, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let kind = self.0.u8()?;
        Some((kind, self.0.long_block()?))
    }
}

/// A message.
#[derive(Debug, Clone, Copy)]
pub(super) struct Message<'a> {
    pub(super) channel: u16,
    pub(super) log_time_ns: u64,
    pub(super) bytes: &'a [u8],
}

impl<'a> Message<'a> {
    pub(super) fn read(record: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(record);
        let channel = fields.u16()?;
        let _sequence = fields.u32()?;
        let log_time_ns = fields.u64()?;
        let _publish_time_ns = fields.u64()?;
        Some(Self {
            channel,
            log_time_ns,
            bytes: fields.0,
        })
    }
}

/// Head of a chunk, before its records.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChunkHead<'a> {
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
    /// Size of the unpacked records, in bytes.
    pub(super) unpacked: u64,
    /// CRC-32 of the unpacked records; 0 if none was computed.
    pub(super) crc: u32,
    pub(super) compression: &'a str,
    /// Size of the records in the file, in bytes.
    pub(super) packed: u64,
    /// Offset of the records from the chunk's first field, in bytes.
    pub(super) length: usize,
}

impl<'a> ChunkHead<'a> {
    /// Reads the head. `record` contains the chunk's fields, at least up to its records.
    pub(super) fn read(record: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(record);
        let mut head = Self {
            start_ns: fields.u64()?,
            end_ns: fields.u64()?,
            unpacked: fields.u64()?,
            crc: fields.u32()?,
            compression: fields.text()?,
            packed: fields.u64()?,
            length: 0,
        };
        head.length = record.len() - fields.0.len();
        Some(head)
    }
}

/// Returns an attachment's name and contents.
pub(super) fn attachment(record: &[u8]) -> Option<(&str, &[u8])> {
    let mut fields = Fields(record);
    let _times = fields.bytes(16)?;
    let name = fields.text()?;
    let _media_type = fields.text()?;
    let bytes = fields.long_block()?;
    let checked = &record[..record.len() - fields.0.len()];
    let crc = fields.u32()?;
    (crc == 0 || crc == crc32fast::hash(checked)).then_some((name, bytes))
}

/// Returns an attachment's name, given the beginning of its record.
pub(super) fn attachment_name(record: &[u8]) -> Option<&str> {
    let mut fields = Fields(record);
    let _times = fields.bytes(16)?;
    fields.text()
}

/// Returns the positions of one channel's messages in a chunk; `None` for a record of another kind
/// or channel, or a damaged one.
pub(super) fn message_index(record: &[u8], channel: u16) -> Option<Vec<MessageIndexEntry>> {
    match mcap::parse_record(kind::MESSAGE_INDEX, record) {
        Ok(Record::MessageIndex(index)) if index.channel_id == channel => Some(index.records),
        _ => None,
    }
}

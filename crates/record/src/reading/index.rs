//! Locates everything in a recording: topics, chunks, attachments, metadata.

use std::collections::BTreeMap;

use super::chunk::Part;
use super::layout::{Records, kind};
use mcap::records::{AttachmentIndex, MetadataIndex, Record};

/// A message definition in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Definition {
    pub(super) name: String,
    pub(super) text: Vec<u8>,
}

/// A channel in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Listed {
    pub(super) topic: String,
    pub(super) encoding: String,
    pub(super) schema: u16,
}

/// A part with messages, with the range of its log times and the positions of its message indexes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Indexed {
    pub(super) part: Part,
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
    /// Position of the message index of each channel with messages in this part. Empty if the part
    /// has no message indexes.
    pub(super) indexes: Vec<(u16, u64)>,
}

/// Position of an attachment or of metadata.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Placed {
    pub(super) name: String,
    pub(super) offset: u64,
    /// Length including the record's head.
    pub(super) length: u64,
}

/// Everything except the messages.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Index {
    pub(super) schemas: BTreeMap<u16, Definition>,
    pub(super) channels: BTreeMap<u16, Listed>,
    /// Parts in the file's order.
    pub(super) parts: Vec<Indexed>,
    pub(super) attachments: Vec<Placed>,
    pub(super) metadata: Vec<Placed>,
}

impl Index {
    /// Adds the contents of an index record, and ignores other records. Returns `false` if an index
    /// record cannot be read.
    pub(super) fn take(&mut self, kind: u8, record: &[u8]) -> bool {
        let says_where = matches!(
            kind,
            kind::SCHEMA
                | kind::CHANNEL
                | kind::CHUNK_INDEX
                | kind::ATTACHMENT_INDEX
                | kind::METADATA_INDEX
        );
        if !says_where {
            return true;
        }
        let Ok(record) = mcap::parse_record(kind, record) else {
            return false;
        };
        match record {
            Record::Schema { header, data } => {
                let definition = Definition {
                    name: header.name,
                    text: data.into_owned(),
                };
                self.schemas.entry(header.id).or_insert(definition);
            }
            Record::Channel(channel) => {
                let listed = Listed {
                    topic: channel.topic,
                    encoding: channel.message_encoding,
                    schema: channel.schema_id,
                };
                self.channels.entry(channel.id).or_insert(listed);
            }
            Record::ChunkIndex(chunk) => self.parts.push(Indexed {
                part: Part {
                    offset: chunk.chunk_start_offset,
                    length: chunk.chunk_length,
                    is_chunk: true,
                },
                start_ns: chunk.message_start_time,
                end_ns: chunk.message_end_time,
                indexes: chunk.message_index_offsets.into_iter().collect(),
            }),
            Record::AttachmentIndex(AttachmentIndex {
                name,
                offset,
                length,
                ..
            }) => self.attachments.push(Placed {
                name,
                offset,
                length,
            }),
            Record::MetadataIndex(MetadataIndex {
                name,
                offset,
                length,
            }) => self.metadata.push(Placed {
                name,
                offset,
                length,
            }),
            _ => {}
        }
        true
    }

    /// Adds the topics that are defined among messages.
    pub(super) fn take_topics(&mut self, records: &[u8]) {
        for (kind, record) in Records::new(records) {
            if matches!(kind, kind::SCHEMA | kind::CHANNEL) {
                self.take(kind, record);
            }
        }
    }
}

//! What is where in a recording: topics, chunks, attachments, metadata.

use std::collections::BTreeMap;

use super::chunk::Part;
use super::layout::{Channel, ChunkIndex, Place, Records, Schema, kind};

/// A definition of messages, as it stands in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Definition {
    pub(super) name: String,
    pub(super) text: Vec<u8>,
}

/// A topic, as it stands in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Listed {
    pub(super) topic: String,
    pub(super) encoding: String,
    pub(super) schema: u16,
}

/// A part with messages, the times between which they were logged, and where their indexes are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Indexed {
    pub(super) part: Part,
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
    /// Of each channel that has messages in it, where the index record is. Empty where there are no such records.
    pub(super) indexes: Vec<(u16, u64)>,
}

/// An attachment, or a piece of metadata.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Placed {
    pub(super) name: String,
    pub(super) offset: u64,
    /// The head included.
    pub(super) length: u64,
}

/// Everything but the messages.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Index {
    pub(super) schemas: BTreeMap<u16, Definition>,
    pub(super) channels: BTreeMap<u16, Listed>,
    /// In the file's order.
    pub(super) parts: Vec<Indexed>,
    pub(super) attachments: Vec<Placed>,
    pub(super) metadata: Vec<Placed>,
}

impl Index {
    /// Takes over what a record says, if it is one of those that say what is where; `false` if it should and cannot be
    /// read.
    pub(super) fn take(&mut self, kind: u8, record: &[u8]) -> bool {
        let taken = match kind {
            kind::SCHEMA => Schema::read(record).map(|schema| self.add_schema(schema)),
            kind::CHANNEL => Channel::read(record).map(|channel| self.add_channel(channel)),
            kind::CHUNK_INDEX => ChunkIndex::read(record).map(|chunk| self.add_chunk(chunk)),
            kind::ATTACHMENT_INDEX => {
                Place::of_attachment(record).map(|place| self.attachments.push(placed(place)))
            }
            kind::METADATA_INDEX => {
                Place::of_metadata(record).map(|place| self.metadata.push(placed(place)))
            }
            _ => Some(()),
        };
        taken.is_some()
    }

    /// Takes over the topics that are told of among messages.
    pub(super) fn take_topics(&mut self, records: &[u8]) {
        for (kind, record) in Records::new(records) {
            if matches!(kind, kind::SCHEMA | kind::CHANNEL) {
                self.take(kind, record);
            }
        }
    }

    fn add_schema(&mut self, schema: Schema) {
        let definition = Definition {
            name: schema.name.to_owned(),
            text: schema.text.to_owned(),
        };
        self.schemas.entry(schema.id).or_insert(definition);
    }

    fn add_channel(&mut self, channel: Channel) {
        let listed = Listed {
            topic: channel.topic.to_owned(),
            encoding: channel.encoding.to_owned(),
            schema: channel.schema,
        };
        self.channels.entry(channel.id).or_insert(listed);
    }

    fn add_chunk(&mut self, chunk: ChunkIndex) {
        self.parts.push(Indexed {
            part: Part {
                offset: chunk.offset,
                length: chunk.length,
                is_chunk: true,
            },
            start_ns: chunk.start_ns,
            end_ns: chunk.end_ns,
            indexes: chunk.indexes().collect(),
        });
    }
}

fn placed(place: Place) -> Placed {
    Placed {
        name: place.name.to_owned(),
        offset: place.offset,
        length: place.length,
    }
}

//! A recording, read by the format's own library.

use std::collections::BTreeMap;
use std::path::Path;

use lariat_record::{Losses, Record};
use mcap::records::Record as Raw;

/// A message.
pub(crate) struct Message {
    pub(crate) sequence: u32,
    pub(crate) log_ns: u64,
    pub(crate) cdr: Vec<u8>,
}

/// Contents of a file.
#[derive(Default)]
pub(crate) struct Recording {
    /// Messages by topic, in the order of the file.
    pub(crate) topics: BTreeMap<String, Vec<Message>>,
    /// Names and contents of the attachments.
    pub(crate) attachments: Vec<(String, Vec<u8>)>,
    /// Metadata.
    pub(crate) about: BTreeMap<String, String>,
    /// True if the file was closed, with an index.
    pub(crate) is_closed: bool,
}

impl Recording {
    /// Reads a file up to its end.
    pub(crate) fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).expect("a file");
        let mut recording = Self {
            is_closed: matches!(mcap::Summary::read(&bytes), Ok(Some(_))),
            ..Self::default()
        };
        let options = mcap::read::Options::IgnoreEndMagic.into();
        let records = mcap::read::ChunkFlattener::new_with_options(&bytes, options);
        let mut names = BTreeMap::new();
        // A file that was not closed ends with an invalid record.
        for record in records.expect("a recording").map_while(Result::ok) {
            match record {
                Raw::Channel(channel) => {
                    names.insert(channel.id, channel.topic);
                }
                Raw::Message { header, data } => {
                    let topic = names[&header.channel_id].clone();
                    recording.topics.entry(topic).or_default().push(Message {
                        sequence: header.sequence,
                        log_ns: header.log_time,
                        cdr: data.into_owned(),
                    });
                }
                Raw::Attachment { header, data, .. } => {
                    let attachment = (header.name, data.into_owned());
                    recording.attachments.push(attachment);
                }
                Raw::Metadata(metadata) => recording.about.extend(metadata.metadata),
                // The index follows.
                Raw::DataEnd(_) => break,
                _ => {}
            }
        }
        recording
    }

    /// The messages of a topic of the rig `default`.
    pub(crate) fn of(&self, topic: &str) -> &[Message] {
        self.topics
            .get(&format!("/default/{topic}"))
            .map_or(&[], Vec::as_slice)
    }

    pub(crate) fn count(&self, topic: &str) -> u64 {
        self.of(topic).len() as u64
    }

    /// Total losses.
    pub(crate) fn losses(&self) -> Losses {
        let mut losses = Losses::default();
        let last = self.of("losses").last().expect("losses");
        losses.decode(&last.cdr).expect("losses");
        losses
    }

    /// Number of frames that are recorded with their images, or counted as missing.
    pub(crate) fn frames_accounted_for(&self) -> u64 {
        self.count("image") + self.losses().dropped_frames
    }
}

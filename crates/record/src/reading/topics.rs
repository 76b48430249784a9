//! Identifies the topics of a recording that lariat reads.

use std::collections::BTreeMap;

use lariat_message::{Centerlines, Descriptors, Descriptors3, FrameHeader};

use super::error::RecordingError;
use super::index::{Definition, Index, Listed};
use crate::foxglove::Form;
use crate::schema::{ENCODING, Schema};
use crate::{COMPRESSED_IMAGE, IMAGE, Losses, Record};

/// Kind of a topic's messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    FrameHeader,
    Image(Form),
    Picture(Form),
    MaskHeader,
    MaskImage,
    MaskPicture,
    Centerlines,
    Truth,
    Descriptors,
    Losses,
}

/// Lariat's own kinds of messages, and their names.
const OWN: [(Schema, &str); 5] = [
    (FrameHeader::SCHEMA, "frames"),
    (Centerlines::SCHEMA, "centerlines"),
    (Descriptors::SCHEMA, "descriptors"),
    (Descriptors3::SCHEMA, "descriptors3"),
    (Losses::SCHEMA, "losses"),
];

/// The topics that are read from a recording.
#[derive(Debug, Clone, Default)]
pub(super) struct Topics {
    /// Kind of each channel.
    kinds: BTreeMap<u16, Kind>,
    /// The channel by which frames are counted, and its topic.
    pub(super) frames: Option<(u16, String)>,
    /// The topic of the images.
    pub(super) images: Option<String>,
    /// All topics that could have been chosen for the images.
    pub(super) candidates: Vec<String>,
    /// True if frames have lariat's headers.
    pub(super) has_headers: bool,
}

impl Topics {
    /// Chooses the topics to read. `wanted` is the topic of the images, if the user named one.
    ///
    /// # Errors
    /// Fails if there is nothing that lariat reads, or if a release with other messages made the
    /// recording.
    pub(super) fn choose(
        index: &Index,
        version: Option<&str>,
        wanted: Option<&str>,
    ) -> Result<Self, RecordingError> {
        check_release(index, version)?;
        let mut topics = Self::default();
        for (&id, listed) in &index.channels {
            if let Some(kind) = kind_of(index, listed) {
                topics.kinds.insert(id, kind);
            }
        }
        let is = |id: &u16, kind| topics.kinds.get(id) == Some(&kind);
        let with_headers = index.channels.iter();
        let headers = with_headers
            .filter(|(id, _)| is(id, Kind::FrameHeader))
            .find(|(_, listed)| wanted.is_none_or(|topic| siblings(&listed.topic, topic)));
        let images = index.channels.iter().filter(|(id, _)| {
            matches!(
                topics.kinds.get(id),
                Some(Kind::Image(_) | Kind::Picture(_))
            )
        });
        // If there are headers, the frames are the images next to them.
        let has_headers = index
            .channels
            .iter()
            .filter(|(id, _)| is(id, Kind::FrameHeader));
        let has_headers: Vec<_> = has_headers.map(|(_, header)| &header.topic).collect();
        // Depth images (of image transport) count as frames only if their topic was requested, so
        // that the error can name it.
        let is_candidate = |topic: &str| {
            let is_of_header = || has_headers.iter().any(|header| siblings(header, topic));
            !topic.ends_with(DEPTH_TRANSPORT) && (has_headers.is_empty() || is_of_header())
        };
        let mut candidates: Vec<String> = images
            .clone()
            .map(|(_, listed)| listed.topic.clone())
            .filter(|topic| is_candidate(topic))
            .collect();
        candidates.sort();
        // One topic may have both images and picture files.
        candidates.dedup();
        let mut images = images.filter(|(_, listed)| match (wanted, headers) {
            (Some(topic), _) => listed.topic == topic,
            (None, Some((_, header))) => siblings(&header.topic, &listed.topic),
            (None, None) => !listed.topic.ends_with(DEPTH_TRANSPORT) || candidates.is_empty(),
        });
        let image = images
            .next()
            .map(|(id, listed)| (*id, listed.topic.clone()));
        let headers = headers.map(|(id, listed)| (*id, listed.topic.clone()));
        if let (Some(topic), None) = (wanted, &image) {
            return Err(RecordingError::NoTopic {
                topic: topic.to_owned(),
                topics: names(index),
            });
        }
        if topics.kinds.is_empty() {
            let topics = names(index);
            return Err(RecordingError::NoImages { topics });
        }
        // Drops other images. One topic may have both images and picture files.
        let topic_of = |id: &u16| index.channels.get(id).map(|listed| &listed.topic);
        let chosen = image.as_ref().map(|(_, topic)| topic);
        let header = headers.as_ref().map(|(_, topic)| topic);
        topics.kinds.retain(|id, kind| match kind {
            Kind::Image(_) | Kind::Picture(_) => topic_of(id) == chosen,
            Kind::FrameHeader => topic_of(id) == header,
            _ => true,
        });
        topics.candidates = candidates;
        topics.has_headers = headers.is_some();
        topics.images = image.as_ref().map(|(_, topic)| topic.clone());
        topics.frames = headers.or(image);
        Ok(topics)
    }

    /// Returns whether a channel reports losses.
    pub(super) fn is_losses(&self, channel: u16) -> bool {
        self.kind(channel) == Some(Kind::Losses)
    }

    /// Kind of a channel's messages; `None` if they are ignored.
    pub(super) fn kind(&self, channel: u16) -> Option<Kind> {
        self.kinds.get(&channel).copied()
    }
}

/// Returns whether two topics belong to the same rig.
fn siblings(a: &str, b: &str) -> bool {
    let parent = |topic: &str| topic.rsplit_once('/').map(|(rig, _)| rig.to_owned());
    parent(a) == parent(b)
}

fn names(index: &Index) -> String {
    let names: Vec<_> = index
        .channels
        .values()
        .map(|listed| match index.schemas.get(&listed.schema) {
            Some(schema) => format!("{} ({})", listed.topic, schema.name),
            None => listed.topic.clone(),
        })
        .collect();
    if names.is_empty() {
        return "none".to_owned();
    }
    names.join(", ")
}

/// Ending of topics on which image transport sends depth images as PNG.
const DEPTH_TRANSPORT: &str = "/compressedDepth";

/// Images of other programs: the channel's encoding, its schema names, and the form of their
/// messages.
const OTHERS: [(&str, &str, &str, Form); 4] = [
    (
        "ros1",
        "sensor_msgs/Image",
        "sensor_msgs/CompressedImage",
        Form::Ros1,
    ),
    (
        ENCODING,
        "foxglove_msgs/msg/RawImage",
        "foxglove_msgs/msg/CompressedImage",
        Form::FoxgloveCdr,
    ),
    (
        "protobuf",
        "foxglove.RawImage",
        "foxglove.CompressedImage",
        Form::Protobuf,
    ),
    (
        "json",
        "foxglove.RawImage",
        "foxglove.CompressedImage",
        Form::Json,
    ),
];

fn kind_of(index: &Index, listed: &Listed) -> Option<Kind> {
    let schema = &index.schemas.get(&listed.schema)?.name;
    for (encoding, image, picture, form) in OTHERS {
        if listed.encoding == encoding && schema == image {
            return Some(Kind::Image(form));
        }
        if listed.encoding == encoding && schema == picture {
            return Some(Kind::Picture(form));
        }
    }
    if listed.encoding != ENCODING {
        return None;
    }
    let last = listed.topic.rsplit('/').next().unwrap_or_default();
    let kind = if *schema == FrameHeader::SCHEMA.name {
        match last {
            "masks" => Kind::MaskHeader,
            // Depth images are written for other programs and not read.
            "depth" => return None,
            _ => Kind::FrameHeader,
        }
    } else if *schema == IMAGE.name {
        match last {
            "mask_image" => Kind::MaskImage,
            "depth_image" => return None,
            _ => Kind::Image(Form::Ros2),
        }
    } else if *schema == COMPRESSED_IMAGE.name {
        match last {
            "mask_image" => Kind::MaskPicture,
            _ => Kind::Picture(Form::Ros2),
        }
    } else if *schema == Centerlines::SCHEMA.name {
        match last {
            "truth" => Kind::Truth,
            _ => Kind::Centerlines,
        }
    } else if *schema == Descriptors::SCHEMA.name {
        Kind::Descriptors
    } else if *schema == Losses::SCHEMA.name {
        Kind::Losses
    } else {
        return None;
    };
    Some(kind)
}

/// Checks the definitions of lariat's own messages.
///
/// # Errors
/// Fails if one of them differs from the definition in this release.
fn check_release(index: &Index, version: Option<&str>) -> Result<(), RecordingError> {
    for definition in index.schemas.values() {
        let ours = OWN
            .iter()
            .find(|(schema, _)| schema.name == definition.name);
        if let Some((schema, message)) = ours
            && !is_same(definition, schema)
        {
            return Err(RecordingError::OtherRelease {
                message,
                version: version.unwrap_or("of an unknown release").to_owned(),
            });
        }
    }
    Ok(())
}

/// Returns whether a definition is equivalent, ignoring comments and the names of constants.
fn is_same(definition: &Definition, ours: &Schema) -> bool {
    let Ok(text) = std::str::from_utf8(&definition.text) else {
        return false;
    };
    meaning(text).eq(meaning(ours.text))
}

fn meaning(text: &str) -> impl Iterator<Item = &str> {
    text.lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim())
        .filter(|line| !line.is_empty() && !line.contains('='))
        .map(|line| match line {
            OLD_DEGREE => DEGREE,
            line => line,
        })
}

/// The field with a curve's degree. In recordings made until October 2026, it has the second name
/// but the same meaning.
const DEGREE: &str = "uint32 degree";
const OLD_DEGREE: &str = "uint32 order";

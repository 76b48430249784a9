//! Names and contents of a recording's topics.

use lariat_message::{Centerlines, Descriptors, Descriptors3, FrameHeader};

use crate::{ANNOTATIONS, COMPRESSED_IMAGE, IMAGE, Losses, Record, Schema};

/// A topic of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Topic {
    /// Headers of frames.
    Frames,
    /// Raw pixels of frames.
    Image,
    /// Pixels of frames as PNG or JPEG.
    Picture,
    /// Headers of masks made by other programs.
    Masks,
    /// Raw pixels of masks.
    MaskImage,
    /// Pixels of masks as PNG.
    MaskPicture,
    /// Centerlines from extract.
    Centerlines,
    /// Descriptors from fit.
    Descriptors,
    /// True centerlines of rendered frames.
    Truth,
    /// Annotations of the centerlines.
    Ropes,
    /// Annotations of the control polygons.
    ControlPoints,
    /// Losses so far.
    Losses,
    /// Headers of depth images.
    Depth,
    /// Raw pixels of depth images.
    DepthImage,
    /// 3-D descriptors from fit.
    Descriptors3,
}

impl Topic {
    /// All topics, each at the index of its number.
    pub const ALL: [Self; 15] = [
        Self::Frames,
        Self::Image,
        Self::Picture,
        Self::Masks,
        Self::MaskImage,
        Self::MaskPicture,
        Self::Centerlines,
        Self::Descriptors,
        Self::Truth,
        Self::Ropes,
        Self::ControlPoints,
        Self::Losses,
        Self::Depth,
        Self::DepthImage,
        Self::Descriptors3,
    ];

    /// Name of the topic on a rig.
    pub fn on(self, rig: &str) -> String {
        let name = match self {
            Self::Frames => "frames",
            Self::Image | Self::Picture => "image",
            Self::Masks => "masks",
            Self::MaskImage | Self::MaskPicture => "mask_image",
            Self::Centerlines => "centerlines",
            Self::Descriptors => "descriptors",
            Self::Truth => "truth",
            Self::Ropes => "annotations/ropes",
            Self::ControlPoints => "annotations/control_points",
            Self::Losses => "losses",
            Self::Depth => "depth",
            Self::DepthImage => "depth_image",
            Self::Descriptors3 => "descriptors3",
        };
        format!("/{rig}/{name}")
    }

    /// Schema of its messages.
    pub const fn schema(self) -> Schema {
        match self {
            Self::Frames | Self::Masks | Self::Depth => FrameHeader::SCHEMA,
            Self::Image | Self::MaskImage | Self::DepthImage => IMAGE,
            Self::Picture | Self::MaskPicture => COMPRESSED_IMAGE,
            Self::Centerlines | Self::Truth => Centerlines::SCHEMA,
            Self::Descriptors => Descriptors::SCHEMA,
            Self::Ropes | Self::ControlPoints => ANNOTATIONS,
            Self::Losses => Losses::SCHEMA,
            Self::Descriptors3 => Descriptors3::SCHEMA,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_topic_stands_at_the_place_of_its_number() {
        for (place, topic) in Topic::ALL.into_iter().enumerate() {
            assert_eq!(topic as usize, place);
        }
    }
}

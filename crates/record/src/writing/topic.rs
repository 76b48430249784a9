//! What a recording's topics are called, and what is on each.

use lariat_message::{Centerlines, Descriptors, Descriptors3, FrameHeader};

use crate::{ANNOTATIONS, COMPRESSED_IMAGE, IMAGE, Losses, Record, Schema};

/// One topic of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Topic {
    /// What stands beside each frame.
    Frames,
    /// The frames' pixels as they are.
    Image,
    /// The frames' pixels as PNG or JPEG.
    Picture,
    /// What stands beside each mask that was made elsewhere.
    Masks,
    /// The masks' pixels as they are.
    MaskImage,
    /// The masks' pixels as PNG.
    MaskPicture,
    /// What extract saw.
    Centerlines,
    /// What fit made of it.
    Descriptors,
    /// The true centerlines of rendered frames.
    Truth,
    /// The centerlines, drawn over the image.
    Ropes,
    /// The control polygons, drawn over the image.
    ControlPoints,
    /// What was lost so far.
    Losses,
    /// What stands beside each depth image.
    Depth,
    /// The depth images' pixels as they are.
    DepthImage,
    /// What fit made of them.
    Descriptors3,
}

impl Topic {
    /// All of them, each at the place of its number.
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

    /// Its name on a rig.
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

    /// What its messages are.
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

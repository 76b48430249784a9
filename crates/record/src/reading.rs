//! Reads recordings, complete or damaged.
//!
//! An MCAP file is a sequence of records, mostly chunks of messages, with an index at its end. A
//! recorder that was killed leaves no index, and its last chunk may be torn. The index is then
//! rebuilt from the intact part. Bytes are read at given positions and never all at once.

mod about;
mod census;
mod chunk;
mod cursor;
mod entry;
mod error;
mod fields;
mod files;
mod index;
mod layout;
mod opening;
mod pictures;
mod recording;
mod scan;
mod storage;
mod summary;
mod topics;

pub use about::{About, METADATA};
pub use cursor::Messages;
pub use entry::{Entry, Frame, Pixels};
pub use error::RecordingError;
pub use files::names_a_recording;
pub use recording::{Place, Recording, Span, TopicSummary};

/// The kinds of recordings that are read, and what is supported of each.
pub const READ: [[&str; 2]; 5] = [
    [
        "MCAP, `.mcap`",
        "chunks without compression, lz4, zstd; with or without an index; cut off or damaged in places",
    ],
    [
        "`.mcap.zstd`, `.mcap.zst`",
        "unpacked into a temporary file",
    ],
    [
        "the folder of `ros2 bag record`",
        "its `.mcap` and `.mcap.zstd` files in the order of `metadata.yaml`, or by number without it",
    ],
    [
        "images",
        "`sensor_msgs` `Image` and `CompressedImage` of ROS 2 and ROS 1; `foxglove` `RawImage` and `CompressedImage` as protobuf, JSON \
         or ROS 2's CDR",
    ],
    [
        "picture files in `CompressedImage`",
        "PNG, JPEG; WebP where it is built in; the bytes tell, whatever `format` says",
    ],
];

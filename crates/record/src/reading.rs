//! Reading recordings, whole ones and what is left of others.
//!
//! An MCAP file is a row of records, most of them chunks of messages, with an index at its end. A recorder that was killed
//! leaves no index, and a last chunk that may be torn; so the index is made again then, from what is whole. The bytes are
//! read at places and never all at once.

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

/// The recordings that are read: what they are, and what of them is read.
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
        "its `.mcap` and `.mcap.zstd` files in the order of `metadata.yaml`, else by their numbers",
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

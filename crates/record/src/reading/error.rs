//! Errors of reading a recording.

use std::path::PathBuf;

use crate::cdr::CdrError;
use crate::conversion::ENCODINGS;

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be read.
    #[error("it cannot be read")]
    Io(#[from] std::io::Error),
    /// The file is not a recording.
    #[error(
        "this is not a recording: it does not begin as an MCAP file does. `lariat run --record FILE.mcap` makes one"
    )]
    NotMcap,
    /// The file is a recording of ROS 1.
    #[error(
        "it is a recording of ROS 1: convert it with `rosbags-convert --src FILE.bag --dst FOLDER --dst-storage mcap` (of the Python package rosbags)"
    )]
    Ros1,
    /// The file is a recording of ROS 2 in a database.
    #[error(
        "it is a recording of ROS 2 in SQLite: convert it to MCAP with `mcap convert FILE.db3 FILE.mcap`, or with `ros2 bag convert`"
    )]
    Sqlite,
    /// The folder contains no recording.
    #[error(
        "the folder holds no MCAP file: name the folder that `ros2 bag record` made, or the file itself"
    )]
    NoFile,
    /// The file is compressed as a whole and cannot be unpacked.
    #[error("it is compressed as a whole and cannot be unpacked into {} ({error}): make room there, or unpack it with `zstd -d`", folder.display())]
    Unpack {
        /// Folder for the unpacked file.
        folder: PathBuf,
        /// The system's error.
        error: std::io::Error,
    },
    /// One of a recording's several files cannot be read.
    #[error("its file {name} is not read: {error}")]
    OfFile {
        /// The file's name.
        name: String,
        /// The cause.
        error: Box<RecordingError>,
    },
    /// The recording contains no messages.
    #[error(
        "this recording holds no message: {}",
        if *cut { "it was cut off before its first chunk was whole, and there is nothing to save" } else { "nothing was sent while it was made" }
    )]
    Empty {
        /// True if the recording was not closed.
        cut: bool,
    },
    /// The recording contains no frames that lariat can read.
    #[error(
        "there are no images in this recording that lariat reads (sensor_msgs/Image or CompressedImage of ROS 2 or 1; foxglove.RawImage or CompressedImage as protobuf, JSON or ROS 2). Its topics are {topics}"
    )]
    NoImages {
        /// The recording's topics.
        topics: String,
    },
    /// The requested topic is missing.
    #[error("there is no topic {topic} with images in this recording. Its topics are {topics}")]
    NoTopic {
        /// The requested topic.
        topic: String,
        /// The recording's topics.
        topics: String,
    },
    /// The messages are defined differently in this release.
    #[error(
        "this recording's {message} are not those of this release: it was made by lariat {version}. Use that release to read it"
    )]
    OtherRelease {
        /// Kind of message.
        message: &'static str,
        /// The release that made the recording, if known.
        version: String,
    },
    /// A part is damaged.
    #[error(
        "the recording is damaged at byte {offset}: {why}. The parts before and after it can be read"
    )]
    Damaged {
        /// Position of the part.
        offset: u64,
        /// The cause.
        why: &'static str,
    },
    /// A part needs more memory than allowed.
    #[error(
        "a part of the recording at byte {offset} is of {bytes} bytes, and {most} are read at once: it was made with larger chunks than any tool should make"
    )]
    TooLarge {
        /// Position of the part.
        offset: u64,
        /// The size that the part claims to have.
        bytes: u64,
        /// The maximum size.
        most: u64,
    },
    /// A part is compressed by an unknown method.
    #[error(
        "the recording is compressed by {0}: lariat reads lz4, zstd and what is not compressed"
    )]
    Compression(String),
    /// A message is invalid.
    #[error("a message on {topic} cannot be read: {why}")]
    Message {
        /// The message's topic.
        topic: String,
        /// The cause.
        why: CdrError,
    },
    /// An image does not match its header.
    #[error("an image on {topic} is not of the size and format that stand with it")]
    Image {
        /// The image's topic.
        topic: String,
    },
    /// Images have an unknown encoding.
    #[error(
        "the images on {topic} are encoded as \"{encoding}\": lariat reads {}; of picture files PNG, JPEG and WebP (a video such as h264 is made into frames by its own tools)",
        ENCODINGS.join(", ")
    )]
    Encoding {
        /// The images' topic.
        topic: String,
        /// Their encoding.
        encoding: String,
    },
    /// The requested images are depth images instead of color ones.
    #[error(
        "the images on {topic} are depth images (compressedDepth), and ropes are found in colour or gray ones: choose the topic of those with --topic"
    )]
    Depth {
        /// The images' topic.
        topic: String,
    },
    /// There is no such frame.
    #[error("there is no frame {frame}: the recording holds {count}, counted from 1")]
    NoFrame {
        /// The requested frame.
        frame: u64,
        /// Number of frames.
        count: u64,
    },
}

//! What can be wrong with a recording, for whoever wants to read it.

use std::path::PathBuf;

use crate::cdr::CdrError;
use crate::conversion::ENCODINGS;

/// Why a recording cannot be read, or not here.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be read.
    #[error("it cannot be read")]
    Io(#[from] std::io::Error),
    /// It is something else.
    #[error(
        "this is not a recording: it does not begin as an MCAP file does. `lariat run --record FILE.mcap` makes one"
    )]
    NotMcap,
    /// A recording of ROS 1.
    #[error(
        "it is a recording of ROS 1: convert it with `rosbags-convert --src FILE.bag --dst FOLDER --dst-storage mcap` (of the Python package rosbags)"
    )]
    Ros1,
    /// A recording of ROS 2 in a database.
    #[error(
        "it is a recording of ROS 2 in SQLite: convert it to MCAP with `mcap convert FILE.db3 FILE.mcap`, or with `ros2 bag convert`"
    )]
    Sqlite,
    /// A folder without a recording.
    #[error(
        "the folder holds no MCAP file: name the folder that `ros2 bag record` made, or the file itself"
    )]
    NoFile,
    /// A file that is compressed as a whole.
    #[error("it is compressed as a whole and cannot be unpacked into {} ({error}): make room there, or unpack it with `zstd -d`", folder.display())]
    Unpack {
        /// Where it was to be unpacked.
        folder: PathBuf,
        /// What the system said.
        error: std::io::Error,
    },
    /// A file of a recording of several.
    #[error("its file {name} is not read: {error}")]
    OfFile {
        /// The file's name.
        name: String,
        /// What is wrong with it.
        error: Box<RecordingError>,
    },
    /// There is nothing in it.
    #[error(
        "this recording holds no message: {}",
        if *cut { "it was cut off before its first chunk was whole, and there is nothing to save" } else { "nothing was sent while it was made" }
    )]
    Empty {
        /// Whether it was not closed.
        cut: bool,
    },
    /// There are no frames that lariat could read.
    #[error(
        "there are no images in this recording that lariat reads (sensor_msgs/Image or CompressedImage of ROS 2 or 1; foxglove.RawImage or CompressedImage as protobuf, JSON or ROS 2). Its topics are {topics}"
    )]
    NoImages {
        /// What there is.
        topics: String,
    },
    /// The topic that was asked for is not there.
    #[error("there is no topic {topic} with images in this recording. Its topics are {topics}")]
    NoTopic {
        /// What was asked for.
        topic: String,
        /// What there is.
        topics: String,
    },
    /// Its messages are other ones than ours.
    #[error(
        "this recording's {message} are not those of this release: it was made by lariat {version}. Use that release to read it"
    )]
    OtherRelease {
        /// What kind of message.
        message: &'static str,
        /// Who made it, as far as it says.
        version: String,
    },
    /// A part is not what was written.
    #[error(
        "the recording is damaged at byte {offset}: {why}. The parts before and after it can be read"
    )]
    Damaged {
        /// Where the part begins.
        offset: u64,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A part needs more memory than it is given.
    #[error(
        "a part of the recording at byte {offset} is of {bytes} bytes, and {most} are read at once: it was made with larger chunks than any tool should make"
    )]
    TooLarge {
        /// Where the part begins.
        offset: u64,
        /// How large it says it is.
        bytes: u64,
        /// How large it may be.
        most: u64,
    },
    /// A part is compressed in a way that is not known here.
    #[error(
        "the recording is compressed by {0}: lariat reads lz4, zstd and what is not compressed"
    )]
    Compression(String),
    /// A message is invalid.
    #[error("a message on {topic} cannot be read: {why}")]
    Message {
        /// Its topic.
        topic: String,
        /// What is wrong with it.
        why: CdrError,
    },
    /// An image is not what its header says.
    #[error("an image on {topic} is not of the size and format that stand with it")]
    Image {
        /// Its topic.
        topic: String,
    },
    /// Images are encoded in a way that is not known here.
    #[error(
        "the images on {topic} are encoded as \"{encoding}\": lariat reads {}; of picture files PNG, JPEG and WebP (a video such as h264 is made into frames by its own tools)",
        ENCODINGS.join(", ")
    )]
    Encoding {
        /// Their topic.
        topic: String,
        /// What they are.
        encoding: String,
    },
    /// Depth images where colour ones are asked for.
    #[error(
        "the images on {topic} are depth images (compressedDepth), and ropes are found in colour or gray ones: choose the topic of those with --topic"
    )]
    Depth {
        /// Their topic.
        topic: String,
    },
    /// There is no such frame.
    #[error("there is no frame {frame}: the recording holds {count}, counted from 1")]
    NoFrame {
        /// What was asked for.
        frame: u64,
        /// How many there are.
        count: u64,
    },
}

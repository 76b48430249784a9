//! What can be wrong with a recording, for whoever wants to read it.

use crate::cdr::CdrError;

/// Why a recording cannot be read, or not here.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be read.
    #[error("it cannot be read")]
    Io(#[from] std::io::Error),
    /// It is something else.
    #[error(
        "this is no recording: it does not begin as an MCAP file does. `lariat run --record FILE.mcap` makes one"
    )]
    NotMcap,
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
        "there are no images in this recording that lariat reads (sensor_msgs/Image or CompressedImage, encoded as ROS 2 does). Its topics are {topics}"
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
        "the recording is damaged at byte {offset}: {why}. What lies before and behind can be read"
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
        "the images on {topic} are encoded as \"{encoding}\": lariat knows mono8, mono16 (in this machine's byte order), rgb8, bgr8, bgra8, yuv422_yuy2, uyvy, nv12, bayer_rggb8 and its like of 8 bits, png and jpeg"
    )]
    Encoding {
        /// Their topic.
        topic: String,
        /// What they are.
        encoding: String,
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

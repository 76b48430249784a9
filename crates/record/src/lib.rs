//! Recordings: what a chain saw and said, in MCAP files that ROS 2 and Foxglove read too.
//!
//! Every message is CDR, as ROS 2 has it, and its schema stands in the file. Each [`Record`] is one kind of message, both
//! ways; images and what is drawn over them are in the field's own schemas ([`ImageRecord`], [`encode_annotations`]).

mod annotations;
mod cdr;
mod images;
mod losses;
mod messages;
mod reading;
mod schema;
mod writing;

pub use annotations::{ANNOTATIONS, Annotated, encode_annotations};
pub use cdr::CdrError;
pub use images::{
    COMPRESSED_IMAGE, CompressedImageRecord, IMAGE, ImageRecord, encode_compressed_image,
    encode_image,
};
pub use losses::Losses;
pub use messages::Record;
pub use reading::{
    About, Entry, Frame, METADATA, Messages, Pixels, Place, Recording, RecordingError, Span,
    TopicSummary,
};
pub use schema::{ENCODING, SCHEMA_ENCODING, Schema};
pub use writing::{
    Clock, Compression, Drops, Ended, Ending, Existing, Flushed, Head, Images, NoRoom, Options,
    Recorder, RingOptions, Topic, WriteError, Writer, Written,
};

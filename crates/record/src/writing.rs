//! Writes recordings.

mod clock;
mod error;
mod pictures;
mod place;
mod queue;
mod recorder;
mod ring;
mod space;
mod staged;
mod thread;
mod topic;
mod writer;

pub use clock::Clock;
pub use error::WriteError;
pub use pictures::{Images, PictureMaker};
pub use place::Existing;
pub use recorder::{Drops, Ended, Ending, Options, Recorder, RingOptions};
pub use ring::Flushed;
pub use space::NoRoom;
pub use topic::Topic;
pub use writer::{Compression, Head, Writer, Written};

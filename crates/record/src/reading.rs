//! Reading recordings, whole ones and what is left of others.
//!
//! An MCAP file is a row of records, most of them chunks of messages, with an index at its end. A recorder that was killed
//! leaves no index, and a last chunk that may be torn; so the index is made anew then, from what is whole. The bytes are
//! read at places and never all at once.

mod about;
mod census;
mod chunk;
mod cursor;
mod entry;
mod error;
mod fields;
mod index;
mod layout;
mod recording;
mod scan;
mod storage;
mod summary;
mod topics;

pub use about::{About, METADATA};
pub use cursor::Messages;
pub use entry::{Entry, Frame, Pixels};
pub use error::RecordingError;
pub use recording::{Place, Recording, Span, TopicSummary};

//! Recordings frame by frame, as the commands about them and the page need them: messages brought together, pictures decoded.

mod gather;
mod pixels;

pub use gather::{Copied, Gather, Gathered};
pub use pixels::{Decoder, Pixels};

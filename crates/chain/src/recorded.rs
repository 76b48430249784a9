//! Recordings frame by frame, as the commands about them and the page need them: messages brought together, pictures decoded.

mod gather;
mod pixels;
mod settings;

pub use gather::{Copied, Gather, Gathered};
pub use pixels::{Decoder, Pixels};
pub use settings::{CALIBRATION, PLANE, RecordedSettings, SETTINGS, versioned_name};

//! Reads recordings frame by frame, for the commands about them and the page: gathers messages and
//! decodes pictures.

mod gather;
mod pixels;
mod settings;

pub use gather::{Copied, Gather, Gathered};
pub use pixels::{Decoder, Pixels};
pub use settings::{CALIBRATION, PLANE, RecordedSettings, SETTINGS, versioned_name};

//! Frame sources: files, video and a rendered rope with known truth.
//!
//! A [`FrameSource`] makes one frame after the other ready and writes its pixels where it is told to: whoever sends
//! the frames lends the memory, so that the pixels are written once. The [`Pacer`] says when each frame is due.
//! Nothing here knows of shared memory.

mod ahead;
mod mjpeg;
pub mod moving;
mod natural;
mod open;
mod orientation;
mod pace;
mod picture;
mod pictures;
mod rendered;
pub mod scenes;
mod source;
mod video;
mod yuv;

pub use mjpeg::{Mjpeg, MjpegError};
pub use natural::natural_order;
pub use open::{Source, open};
pub use pace::{Pace, PaceError, Pacer};
pub use rendered::RenderOptions;
pub use source::{Frame, FrameSource, SourceError};

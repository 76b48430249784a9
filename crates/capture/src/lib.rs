//! Frame sources: files, video, and a rendered and a simulated rope with known truth.
//!
//! A [`FrameSource`] makes one frame after the other ready and writes its pixels where it is told to: whoever sends
//! the frames lends the memory, if need be ahead of time, so that the pixels are written once. The [`Pacer`] says when
//! each frame is due. Nothing here knows of shared memory.

mod ahead;
mod follow;
mod lent;
mod mjpeg;
pub mod moving;
mod natural;
mod open;
mod orientation;
mod pace;
mod picture;
mod pictures;
mod piped;
mod range;
mod recorded;
mod rendered;
pub mod scenes;
mod simulated;
mod source;
mod until;
mod v4l2;
mod video;
mod y4m;
mod yuv;

pub use follow::FollowOptions;
pub use lent::{LentSlot, SlotKey};
pub use mjpeg::{Mjpeg, MjpegError};
pub use natural::natural_order;
pub use open::{FileOptions, Source, names_a_recording, open};
pub use pace::{Pace, PaceError, Pacer};
pub use picture::{PICTURES, StillPicture, names_a_picture};
pub use piped::{PipeOptions, RawFrames};
pub use range::{Position, Range};
pub use recorded::RecordingOptions;
pub use rendered::RenderOptions;
pub use simulated::{Commands, HandOptions, SimulatedOptions, open_simulated};
pub use source::{Frame, FrameSource, Next, SourceError};
pub use until::{Until, Woken};
pub use v4l2::{
    AboutCamera, CameraError, CameraOptions, Control, ControlError, ControlKind, ControlSettings,
    DEFAULT_SIZE, FormatOffer, FourCc, Interval, Io, ListedCamera, NoCommonFormat, Rates, Request,
    SizeOffer, SizeRange, list_cameras, names_a_camera,
};
pub use video::video_fps;

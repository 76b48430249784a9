//! Frame sources: cameras, files, recordings, pipes, and rendered and simulated ropes with known
//! truth.
//!
//! [`open()`] turns a [`Source`] into a [`FrameSource`]. The source writes each frame's pixels
//! once, into memory that the caller lends. A [`Pacer`] decides when each frame is due. This crate
//! does not handle shared memory itself: the capture stage (`crates/chain/src/stages/capture.rs`)
//! lends slots and sends them.
//!
//! - [`FrameSource`], [`Frame`], [`Next`], [`SourceError`]: the interface of all sources
//! - [`LentSlot`], [`SlotKey`]: memory lent ahead of need
//! - [`Until`]: what ends a wait
//! - [`Pairing`]: pairs a depth camera's images with frames, by time
//! - [`list_cameras`], [`CameraOptions`], [`ControlSettings`]: cameras
//! - [`StillPicture`], [`MaskPicture`], [`Mjpeg`]: single pictures
//!
//! # Sources
//!
//! - Pictures and folders (`pictures`): a thread decodes ahead (`ahead`), straight into lent slots.
//!   A broken file is a gap in the numbers and a warning.
//! - Video (`video`, `mjpeg_file`): in Y4M, 4:2:0 becomes NV12, 4:1:1 and 4:2:2 YUYV, 4:4:4 RGB; 9
//!   to 16 bits are rounded to 8.
//! - A growing folder (`follow`): inotify reports new files.
//! - Standard input (`piped`): live, without a thread. An end in the middle of a frame is an error.
//! - A recording (`recorded`): keeps its gaps and pace.
//! - A camera (`v4l2`). A depth camera is a source of its own.
//! - Rendered and simulated ropes (`rendered`, `simulated`).
//!
//! All frames have full range; limited range is expanded where it is read (`color_range`).
//!
//! # Cameras
//!
//! The driver fills buffers while capture sleeps, so no thread is needed. With `USERPTR` the
//! buffers *are* lent slots; the driver holds four. Otherwise frames are copied from mapped
//! buffers, or decoded from JPEG. `v4l2/negotiate` states how format, size and rate are chosen.
//! `S_FMT` never refuses a request, and settings outlive the program that made them. `v4l2/setup`
//! therefore always sets them and checks the result.
//!
//! | event | reaction |
//! |---|---|
//! | damaged, short or undecodable frame | its number becomes a gap; reported at most once per second |
//! | failed call | repeated once |
//! | `POLLERR`, `EIO` | restart after pauses that double from 50 ms to 5 s; after three failures in a row, reopen |
//! | `ENODEV` | close, wait by inotify for the name, reopen with the same settings |
//! | no frame for three periods | reported once, and again when frames return |
//!
//! A camera that cannot start ends the chain with an error. A camera that has shown a frame is
//! retried indefinitely.
//!
//! # Blank frames
//!
//! A control loop that reads nothing cannot distinguish a missing camera from a missing chain. A
//! camera therefore yields *blank* frames ([`Frame::blank`]): at once if its stream breaks, after
//! three silent periods otherwise, then every 100 ms. Extract answers with `Lost` ropes whose age
//! grows, until `keep_lost_s` has passed. Blank frames are counted but not timed. None comes before
//! the first image.
//!
//! # Known limitations
//!
//! - JPEG cameras: baseline only, and the decoder allocates in each frame ([`Mjpeg::decode`]).
//! - The readout time of a sensor is unknown, so end-of-frame stamps are corrected by the exposure
//!   time alone.
//! - If a recording has several cameras, the user has to name one.

mod ahead;
mod bits;
mod color_range;
#[cfg(all(debug_assertions, not(test)))]
mod compiled;
mod depth_files;
mod depth_pairs;
mod follow;
mod foreign;
mod lent;
mod mask_file;
mod mjpeg;
mod mjpeg_file;
mod natural;
mod open;
mod orientation;
mod pace;
mod pairing;
mod picture;
mod pictures;
mod piped;
mod range;
mod raw;
mod recorded;
mod rendered;
mod simulated;
mod source;
mod until;
mod v4l2;
mod video;
mod y4m;
mod yuv;

pub use depth_files::{DepthFiles, READ as DEPTH_IMAGES};
pub use follow::FollowOptions;
pub use lariat_drawn::{HandOptions, RenderOptions, SpaceCameras};
pub use lent::{LentSlot, SlotKey};
pub use mask_file::MaskPicture;
pub use mjpeg::{Mjpeg, MjpegError};
pub use natural::natural_order;
pub use open::{FileOptions, Source, names_a_recording, names_a_video, open};
pub use pace::{Pace, PaceError, Pacer};
pub use pairing::{MOST_IMAGES, PairCounts, Paired, Pairing};
pub use picture::{PICTURES, StillPicture, names_a_picture};
pub use pictures::foreign_example;
pub use piped::{PipeOptions, RawFrames};
pub use range::{Position, Range};
pub use raw::RawFormat;
pub use recorded::{ForeignFrames, RecordingOptions};
pub use simulated::{Commands, SimulatedOptions, open_simulated};
pub use source::{Frame, FrameSource, Next, SourceError};
pub use until::{Until, Woken};
pub use v4l2::{
    AboutCamera, CameraError, CameraOptions, Control, ControlError, ControlKind, ControlSettings,
    DEFAULT_SIZE, FormatOffer, FourCc, Interval, Io, ListedCamera, NoCommonFormat, Rates, Request,
    SizeOffer, SizeRange, Wanted, list_cameras, names_a_camera,
};
pub use video::video_fps;

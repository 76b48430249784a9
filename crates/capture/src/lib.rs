//! Frame sources: files, video, and a rendered and a simulated rope with known truth.
//!
//! A [`FrameSource`] makes one frame after the other ready and writes its pixels where it is told to: whoever sends
//! the frames lends the memory, if need be ahead of time, so that the pixels are written once. The [`Pacer`] says when
//! each frame is due. Nothing here knows of shared memory.
//!
//! # How it works
//!
//! `FrameSource` makes one frame after the other ready and writes its pixels into the memory it is lent: a slot of shared
//! memory, so that they are written once. A source that fills memory ahead of need (a camera's driver, a thread) is lent as
//! many slots at a time as it asks for (`slots_wanted`), gives one back with each frame that is in it (`Frame::slot`), and is
//! lent another for it; `crates/chain/src/stages/slot_lender.rs` keeps the books, and drops the source before the slots. A frame that has a time
//! of its own (`Frame::exposed_ns`) is not paced. A source waits through `Until`: one `poll` for its own descriptor, its own
//! moment, the end of `--duration` and the signals' pipe.
//!
//! - **Pictures** (`pictures`, `picture`, `ahead/`, `natural`): PNG, JPEG, BMP, PGM, with the features `webp` and `tiff` also these, 16 bits as the nearest 8, folders in natural order. Samples of 10
//!   and 12 bits in 16 are told by the largest one (`bits`). Files of other kinds are refused with the command that converts them (`foreign`). A thread decodes
//!   ahead (`ahead/thread`), straight into slots of shared memory that it is lent, so that nothing is decoded at the moment it is due;
//!   a small set that is looped is decoded once and copied. What a camera took sideways (EXIF) is turned upright (`orientation`). A broken file in the
//!   middle is a gap in `sequence` and a warning, not an end. `lariat trace` decodes by the same (`StillPicture`).
//! - **Masks in files** (`mask_file`): the levels of a mask, whether it is gray, coloured by instance, of 16 bits, or the alpha of a cut-out.
//! - **MJPEG files** (`mjpeg_file`): each JPEG picture of the file is a frame. One pass over the file finds where they lie.
//! - **Colour range** (`color_range`): frames travel in full range. Y, U, V in limited range are expanded where they are read: Y4M unless it says `XCOLORRANGE=FULL`
//!   (mono only if it says `LIMITED`), raw frames, other programs' recordings, and a camera's frames by its driver's `quantization`.
//! - **Y4M** (`y4m`, `video`, `yuv`): 4:2:0 becomes Nv12, 4:1:1 and 4:2:2 Yuyv, 4:4:4 Rgb8, mono Gray8; 9 to 16 bits are rounded to 8. Frames that are not shown are passed over by
//!   their lines. A file's own rate is its pace where `fps` is `"auto"`: every stage reads it in the settings, so that sink knows the period.
//! - **Standard input** (`piped`): Y4M, or raw frames whose size and format are said. A pipe is live: a frame was exposed when the last of it
//!   came; with `--fps` it is due by the schedule instead, and the pipe's writer waits. It is read in `advance`, with the wait that every
//!   source has, and no thread ahead: so a writer that stands still can be waited for, and stopped. Of the chain's processes capture alone has it. The
//!   end between two frames ends the chain in order; any other is a fault of the source, said, with exit code 1.
//! - **A part** (`range`) is a sequence of its own. `sequence` counts what was *asked for*, from 1: were it the file's number, each frame that
//!   `--every` leaves out would be lost at the source, and every reader, the control loop's too, would have to know of it to tell losses. How a
//!   frame is found again (`first + every · (n − 1)`) is said in the log.
//! - **A folder that grows** (`follow`): inotify says which file was closed or moved in; nothing is looked for, and no process of the rig wakes
//!   while nothing comes. A writer's temporary name that is a picture's too is not shown twice (the same inode, size and time). What room frames
//!   need is known with the first picture; so, of an empty folder, capture says `ready` and makes its channel then.
//! - **A recording** (`recorded/`): the reader's cursor lends the pixels, the thread copies them into the slot it is lent: that is
//!   the one copy after unpacking. A frame's truth stands behind it, and up to four frames are read ahead for it. The steps of the
//!   recorded numbers are kept, so that gaps are gaps; the steps of `exposed_ns` are its pace (`FrameSource::due_after_ns`), which holds where
//!   `fps` is `"auto"`. Images of several cameras are not chosen among: `topic` says which. Of a recorded source each third is each third of its *numbers*: a frame that was lost then is not made up for by its
//!   neighbour.
//! - **A camera, opened and set** (`v4l2/sys`, `device`, `nodes`, `offers`, `negotiate`, `setup`, `controls/`, `listing`): `sys` is the
//!   one file that knows the kernel's numbers and layouts, and each ioctl is a safe function of it, but the one that lends
//!   memory. Which format, size and rate are taken is a pure function over what the driver lists, by the rule at the head of
//!   `negotiate`, held to lists of real cameras. `S_FMT` never refuses and settings outlive their program: so format and rate are
//!   always set, and what comes back is checked against what was asked for (`setup`). The length of a row is kept where
//!   another program has set the same format with longer rows. Controls go by the names of `v4l2-ctl`, old and new; what steers
//!   others (automatics) is set first and put back last.
//! - **A camera's JPEG frames** (`mjpeg`, for `MJPG`): baseline only, of the size that was agreed on, into the memory lent
//!   as Rgb8, or Gray8 if without colour. RGB, because zune-jpeg's step to it costs no more than that to interleaved Y, U,
//!   V, which would have to be packed by one more pass; and because there is then no question of range: a JPEG's Y, U, V
//!   span 0 to 255. The usual Huffman tables are put in where the camera leaves them out. A frame cut off is
//!   refused, not shown half: the decoder is not shown the end marker, behind which it would go on in zeros. zune-jpeg
//!   takes memory for a few rows in each frame (17 pieces, 72 kB at 640×480) and gives it back; it cannot be given memory
//!   to keep, and this is the one exception to the rule that nothing is allocated in a frame. A test holds it to that.
//! - **Cameras** (`v4l2/camera`, `stream`, `driver`): below.
//! - **A depth camera** beside one in colour is a source like that one (`Wanted::Depth`: `Z16`, `Y16`), which knows nothing of the other. Which
//!   of its images belongs to which frame is known by their times alone (`pairing`); who sends both asks that.
//! - **Rendered, simulated** (`rendered`, `simulated`): the ropes of `crates/drawn` and `crates/simulation`, as a camera would have them.
//!
//! **A camera while it runs.** No thread: the driver fills buffers, capture sleeps until one is full. With `USERPTR` the buffers
//! *are* slots of shared memory: four are in the driver's hands, the full one is sent as it is, padding included, and its
//! successor queued. The kernel pins a slot's pages when it first comes by, and finds them again only under the same buffer
//! number: so there are 32 numbers, and an address keeps its own (`stream`). What cannot be written into (`REQBUFS` or `QBUF`
//! refuse it: memory in one piece is wanted, say) is mapped (`MMAP`) and copied; JPEG frames are mapped and decoded. Slots are
//! given up before the memory is: `STREAMOFF`, or, if that fails, the only descriptor is closed.
//!
//! | what happens | what is done (`camera/frames`, `camera/down`) |
//! |---|---|
//! | a number (`stamp`) | the driver's 32 bits as steps, so that a wrap is one; it goes on over restarts; gaps are losses at the source |
//! | a time (`stamp`) | start of exposure as it is; end of frame less the exposure time, if a control tells it, without the readout, which none does; no monotonic clock, a moment to come or one before the stream: the moment of arrival. Each doubt is said once |
//! | a frame flagged as damaged, cut short, or that does not decode | its buffer queued again; its number is a gap; said once a second at most |
//! | a call that fails | made once more, and said |
//! | `POLLERR`, `EIO` | stopped, buffers given up, started again; after pauses that double from 50 ms to 5 s, until it has run well for 2 s. Three failures in a row: reopened |
//! | `ENODEV` | closed, so that the driver can go. inotify on the folders of its name (`hotplug`) wakes for the node, the link in `by-id`, and its permissions; opened with the same format, rate and controls |
//! | no frame for three periods (`silence`) | said once, and once more when frames come again. The period is the camera's, or the last pause up to 0.5 s, as a camera exposes longer in the dark |
//!
//! A first start that fails ends the chain with a sentence; once it has shown a frame, a camera is never given up.
//!
//! **Lost, not silent.** While there is no image, descriptors must say so: a control loop that reads nothing cannot tell a camera
//! that is gone from a chain that is. So capture sends *blank* frames, headers of 0 × 0 pixels without bytes: at once when the
//! stream breaks or after the three periods of a stall, and then every 100 ms. Extract answers them without looking
//! (`Extractor::blank`): every rope is `Lost`, where it was, its `age_ns` going on, and forgotten after `keep_lost_s` as ever; the
//! descriptors' width and height are 0. The other ways were for fit to watch the clock, which then tells a slow extract from a
//! silent camera only by guessing, and adds a wake-up to every rig that rests; or for capture to repeat the last image, which
//! would be a lie. A blank frame has a number of its own, so that the books stay exact: it is published, and received or lost;
//! sink counts it and does not time it. Before the first image there is nothing to be lost, and no blank frame.

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

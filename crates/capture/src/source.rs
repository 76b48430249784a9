//! The trait that every source of frames implements. It reports a frame's geometry first, then
//! writes the pixels into memory lent by the caller.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use lariat_message::{Centerlines, Descriptors3, PixelFormat, SourceKind};

use crate::lent::{LentSlot, SlotKey};
use crate::picture::PICTURES;
use crate::until::Until;
use crate::v4l2::CameraError;

/// A frame: its geometry, when it was taken, and where its pixels are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// The source's own frame number, from 1. A gap is a frame lost at the source.
    pub sequence: u64,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bytes from one row's start to the next.
    pub stride: u32,
    /// How the bytes encode pixels.
    pub format: PixelFormat,
    /// When the image was taken, on the clock of [`now_ns`](lariat_message::now_ns). `None` if the
    /// caller's schedule decides when it is due.
    pub exposed_ns: Option<u64>,
    /// Slot that already holds the pixels. `None` if they still have to be
    /// [written](FrameSource::write).
    pub slot: Option<SlotKey>,
}

impl Frame {
    /// A frame without an image, sent when one is due but the source cannot give it.
    pub fn blank(sequence: u64, now_ns: u64) -> Self {
        Self {
            sequence,
            width: 0,
            height: 0,
            stride: 0,
            format: PixelFormat::Gray8,
            exposed_ns: Some(now_ns),
            slot: None,
        }
    }

    /// Bytes of the whole image.
    pub fn bytes(&self) -> usize {
        self.format.image_bytes(self.stride, self.height)
    }
}

/// Outcome of [`FrameSource::advance`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// The next frame.
    Frame(Frame),
    /// No frame yet; the wait ended early.
    Nothing,
    /// The source has ended.
    End,
}

/// Yields one frame after another: call [`advance`](Self::advance), then [`write`](Self::write)
/// unless the pixels are already in a slot.
///
/// A source that fills memory ahead of need (a thread that draws or decodes, a camera's driver)
/// borrows slots from the sender. It gets as many as it [asks for](Self::slots_wanted). With each
/// frame that is in a slot, it gives the slot back and is lent another. Dropping the source
/// releases all slots: it joins its thread or stops its driver.
pub trait FrameSource: Send {
    /// Kind of this source.
    fn kind(&self) -> SourceKind;

    /// Maximum number of bytes in a frame of this source. 0 if the number is unknown before the
    /// first frame. In that case it is known once the first frame is ready, and that frame has to
    /// be [written](Self::write).
    fn largest_frame_bytes(&self) -> usize;

    /// Returns whether [`truth`](Self::truth) has an answer.
    fn has_truth(&self) -> bool {
        false
    }

    /// The source's own frame rate, in frames per second.
    fn native_fps(&self) -> Option<f64> {
        None
    }

    /// Number of slots of [`largest_frame_bytes`](Self::largest_frame_bytes) that the source works
    /// best with. It also works with fewer, or with none.
    fn slots_wanted(&self) -> usize {
        0
    }

    /// Lends the source a slot. The slot's number differs from those of all slots that it holds.
    fn lend(&mut self, _slot: LentSlot) {}

    /// Continues after the frame with this number, which is the last frame of another source with
    /// the same settings. Call it before the first frame or slot. Returns `false` if the source
    /// starts from the beginning: a live one has nothing to skip, and a looped one does not know
    /// how many rounds to skip.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn pass_over(&mut self, _sequence: u64) -> Result<bool, SourceError> {
        Ok(false)
    }

    /// Makes the next frame ready and waits for it as long as `until` allows. Returns [`Next::End`]
    /// once the source has ended. Work that needs nothing from outside, such as decoding, may take
    /// longer.
    ///
    /// # Errors
    /// Only an error that ends the source. A lost frame is a gap in [`Frame::sequence`] and a
    /// [warning](Self::take_warning) instead.
    fn advance(&mut self, until: &Until) -> Result<Next, SourceError>;

    /// Returns the next frame, however long that takes, or `None` if the source has ended.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn next(&mut self) -> Result<Option<Frame>, SourceError> {
        let until = Until::forever();
        loop {
            match self.advance(&until)? {
                Next::Frame(frame) => return Ok(Some(frame)),
                Next::Nothing => {}
                Next::End => return Ok(None),
            }
        }
    }

    /// Writes the pixels of the frame just made ready into `pixels`, which has exactly
    /// [`Frame::bytes`] bytes; a shorter slice gets what fits. Call it at most once for each frame
    /// that is not in a slot.
    fn write(&mut self, pixels: &mut [u8]);

    /// Fills in the true centerlines of the frame just made ready: width, height, counts and
    /// curves, but not the trace. Returns `false`, and changes nothing, if the source does not know
    /// them.
    fn truth(&self, _truth: &mut Centerlines) -> bool {
        false
    }

    /// Width and height of the depth image that comes with each frame; `None` without depth images.
    fn depth_size(&self) -> Option<[u32; 2]> {
        None
    }

    /// Writes the depth image of the frame just made ready: two bytes per pixel in native byte
    /// order, row by row without padding. Call it only if the source has depth images.
    fn write_depth(&mut self, _units: &mut [u8]) {}

    /// Fills in the true 3-D shape of the ropes in the frame just made ready, if it has a depth
    /// image: all but the trace, as points without curves. Returns `false`, and changes nothing, if
    /// the source does not know it.
    fn truth_in_space(&self, _truth: &mut Descriptors3) -> bool {
        false
    }

    /// Time from the source's first frame to the one just made ready at the source's own pace, in
    /// nanoseconds. `None` for a source without a pace of its own.
    fn due_after_ns(&self) -> Option<u64> {
        None
    }

    /// Returns a sentence about something that went wrong without ending the source, such as a
    /// broken file that was skipped. Call it after each [`advance`](Self::advance) until it returns
    /// `None`.
    fn take_warning(&mut self) -> Option<String> {
        None
    }

    /// Returns a sentence about something worth knowing that is not an error, such as a camera that
    /// is back. Call it in the same way as [`take_warning`](Self::take_warning).
    fn take_news(&mut self) -> Option<String> {
        None
    }
}

/// Why a source cannot be opened or cannot continue.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// No source was named.
    #[error(
        "no source was named: say `rendered`, `simulated`, or the path of a picture, a folder of pictures or a .y4m video"
    )]
    Unnamed,
    /// The source is external, which only a chain can have.
    #[error(
        "frames of the source external go straight into a chain: start it with `lariat run --source external`, and the program that writes them alongside"
    )]
    External,
    /// A rope that cannot be simulated.
    #[error(transparent)]
    Simulated(#[from] lariat_simulation::OptionsError),
    /// The requested size leaves no room for a rendered rope.
    #[error(transparent)]
    Rendered(#[from] lariat_drawn::RenderError),
    /// A path that does not exist or cannot be read.
    #[error("cannot read {}: {error}", path.display())]
    Unreadable {
        /// The path as it was given.
        path: PathBuf,
        /// Error of the system.
        error: io::Error,
    },
    /// A folder without a picture.
    #[error("the folder {} holds no picture ({PICTURES}; but {ignored} other files): {advice}", path.display())]
    NoPictures {
        /// The folder.
        path: PathBuf,
        /// Number of other files in it.
        ignored: usize,
        /// The remedy.
        advice: String,
    },
    /// The path to follow is not a folder.
    #[error("{} is not a folder, and only a folder can be followed: name the one that pictures are put into", path.display())]
    NotAFolder {
        /// The path as it was given.
        path: PathBuf,
    },
    /// The kernel cannot watch the folder.
    #[error("cannot follow the folder {}: {error} (the limits are in /proc/sys/fs/inotify)", path.display())]
    Unwatchable {
        /// The folder.
        path: PathBuf,
        /// Error of the system.
        error: io::Error,
    },
    /// A file of another kind.
    #[error("{} {what}", path.display())]
    NotAPicture {
        /// The file.
        path: PathBuf,
        /// Its kind, and what to do.
        what: String,
    },
    /// A picture that cannot be decoded.
    #[error("{reason}")]
    Picture {
        /// A sentence that names the picture and the reason.
        reason: String,
    },
    /// A video named together with other paths.
    #[error("{} is a video, and a video is shown alone: name it without other paths", path.display())]
    VideoAmongOthers {
        /// The video.
        path: PathBuf,
    },
    /// A video that cannot be shown.
    #[error("cannot show the video {}: {what}", path.display())]
    Video {
        /// The video.
        path: PathBuf,
        /// The fault, and how to correct it.
        what: String,
    },
    /// Frames from standard input that cannot be shown.
    #[error("cannot take frames from standard input: {what}")]
    Pipe {
        /// The fault, and how to correct it.
        what: String,
    },
    /// A time in a sequence without a frame rate.
    #[error("{} s do not name a frame, as the frames have no rate: name it by its number, or say how many frames a second are shown", time.as_secs_f64())]
    NoRate {
        /// The time, counted from the first frame.
        time: Duration,
    },
    /// A range that ends before it begins.
    #[error(
        "frame {first} is to be the first and frame {last} the last: choose a range with a frame in it"
    )]
    EmptyRange {
        /// Number of the first frame.
        first: u64,
        /// Number of the last frame.
        last: u64,
    },
    /// A range that begins after the end of the sequence.
    #[error("frame {first} is to be the first, and there are only {count}: begin earlier")]
    BehindEnd {
        /// Number of the requested first frame.
        first: u64,
        /// Number of frames in the sequence.
        count: u64,
    },
    /// A recording that cannot be shown.
    #[error("cannot show the recording {}: {what}", path.display())]
    Recording {
        /// The recording.
        path: PathBuf,
        /// The fault, and how to correct it.
        what: String,
    },
    /// None of the source's frames can be decoded.
    #[error("no frame can be decoded, the first because {reason}")]
    NothingDecoded {
        /// The fault of the first one.
        reason: String,
    },
    /// A camera that cannot be used.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The decoder thread has ended unexpectedly.
    #[error(
        "the decoder stopped in the middle: this is a defect of lariat, please report it with the file it was reading"
    )]
    DecoderGone,
    /// The decoder thread cannot be started.
    #[error("cannot start the thread that decodes ahead: {0}")]
    NoThread(io::Error),
}

impl SourceError {
    /// Returns whether the camera is absent or in use, perhaps by a killed program that has not
    /// ended yet. In both cases it may come back.
    pub fn is_of_an_absent_camera(&self) -> bool {
        use CameraError::{Absent, Busy, Gone};
        matches!(
            self,
            Self::Camera(Absent { .. } | Gone { .. } | Busy { .. })
        )
    }
}

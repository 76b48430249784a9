//! What every source of frames is: geometry first, then the pixels into memory lent by the caller.

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
    /// How the bytes make pixels.
    pub format: PixelFormat,
    /// When the image was taken, on the clock of [`now_ns`](lariat_message::now_ns); `None`: whoever shows it says when it
    /// is due.
    pub exposed_ns: Option<u64>,
    /// The slot that holds the pixels already; `None`: they are [written](FrameSource::write) when they are asked for.
    pub slot: Option<SlotKey>,
}

impl Frame {
    /// A frame without an image: at this moment the source has none to give, though it is time for one.
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

/// What a source has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// The next frame.
    Frame(Frame),
    /// No frame yet, and the wait for it was ended.
    Nothing,
    /// No frame any more.
    End,
}

/// One frame after the other: [`advance`](Self::advance), then, unless the pixels are in a slot already,
/// [`write`](Self::write).
///
/// A source that fills memory ahead of need (a thread that draws or decodes, a camera's driver) is lent slots by whoever
/// sends the frames, as many as it [asks for](Self::slots_wanted). It gives one back with each frame whose pixels are in
/// it, and is lent another for it. When it is dropped it has let go of them all: its thread is joined, its driver stopped.
pub trait FrameSource: Send {
    /// What kind of source it is.
    fn kind(&self) -> SourceKind;

    /// The most bytes a frame of this source can have. 0 if that is not known before the first frame: then it is known when
    /// that is ready, and has to be [written](Self::write).
    fn largest_frame_bytes(&self) -> usize;

    /// Whether [`truth`](Self::truth) has an answer.
    fn has_truth(&self) -> bool {
        false
    }

    /// The frame rate the source itself asks for, in frames per second.
    fn native_fps(&self) -> Option<f64> {
        None
    }

    /// How many slots of [`largest_frame_bytes`](Self::largest_frame_bytes) the source is best lent at a time. It does
    /// with fewer, and with none.
    fn slots_wanted(&self) -> usize {
        0
    }

    /// Takes a slot into its hands, under a number that none of those has that it holds.
    fn lend(&mut self, _slot: LentSlot) {}

    /// Continues after the frame of this number, the last one of another source with the same settings. Called before the first
    /// frame or slot. `false` if the source starts from the beginning: a live one has nothing to skip, and a looped one does not
    /// know how many rounds to skip.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn pass_over(&mut self, _sequence: u64) -> Result<bool, SourceError> {
        Ok(false)
    }

    /// Makes the next frame ready, waiting for it as long as `until` lets it; [`Next::End`] when the source has ended, and
    /// from then on. What needs no waiting for the outside, such as a decoder, may be waited for in any case.
    ///
    /// # Errors
    /// Only what ends the source. A frame that is lost is a gap in [`Frame::sequence`] and a
    /// [warning](Self::take_warning) instead.
    fn advance(&mut self, until: &Until) -> Result<Next, SourceError>;

    /// The next frame, waited for as long as it takes; `None` when the source has ended.
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

    /// Writes the pixels of the frame just made ready into `pixels`, which has exactly [`Frame::bytes`] bytes; a
    /// shorter slice gets what fits. Call it at most once after each frame that is in no slot.
    fn write(&mut self, pixels: &mut [u8]);

    /// Fills in the true centerlines of the frame just made ready: width, height, counts and curves, not the trace.
    /// `false`, and nothing is touched, if the source does not know them.
    fn truth(&self, _truth: &mut Centerlines) -> bool {
        false
    }

    /// Width and height of the depth image that it has beside each frame; `None` if it has none.
    fn depth_size(&self) -> Option<[u32; 2]> {
        None
    }

    /// Writes the depth image of the frame just made ready: two bytes a pixel, as the machine has them, row by row without padding. Only of
    /// a source that has one.
    fn write_depth(&mut self, _units: &mut [u8]) {}

    /// Fills in where the ropes of the frame just made ready are in space, if it has a depth image: all but the trace, points without curves.
    /// `false`, and nothing is touched, if the source does not know.
    fn truth_in_space(&self, _truth: &mut Descriptors3) -> bool {
        false
    }

    /// How long after the source's first frame the one just made ready is due at its own pace, in nanoseconds; none if it has
    /// no pace of its own.
    fn due_after_ns(&self) -> Option<u64> {
        None
    }

    /// A sentence on something that went wrong without ending the source, such as a broken file that was passed
    /// over. Ask after each [`advance`](Self::advance) until there is none.
    fn take_warning(&mut self) -> Option<String> {
        None
    }

    /// A sentence on something that is worth knowing and not wrong, such as a camera that is there again. Ask likewise.
    fn take_news(&mut self) -> Option<String> {
        None
    }
}

/// Why a source cannot be opened, or cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// No source was named.
    #[error(
        "no source was named: say `rendered`, `simulated`, or the path of a picture, a folder of pictures or a .y4m video"
    )]
    Unnamed,
    /// Frames from outside are a chain's alone.
    #[error(
        "frames of the source external go straight into a chain: start it with `lariat run --source external`, and the program that writes them alongside"
    )]
    External,
    /// A rope that cannot be simulated.
    #[error(transparent)]
    Simulated(#[from] lariat_simulation::OptionsError),
    /// The size asked of the rendered rope makes no picture of a rope.
    #[error(transparent)]
    Rendered(#[from] lariat_drawn::RenderError),
    /// A path that leads nowhere, or that may not be read.
    #[error("cannot read {}: {error}", path.display())]
    Unreadable {
        /// The path as it was given.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
    /// A folder without a picture.
    #[error("the folder {} holds no picture ({PICTURES}; but {ignored} other files): {advice}", path.display())]
    NoPictures {
        /// The folder.
        path: PathBuf,
        /// How many other files are in it.
        ignored: usize,
        /// What to do.
        advice: String,
    },
    /// What is to be followed is no folder.
    #[error("{} is not a folder, and only a folder can be followed: name the one that pictures are put into", path.display())]
    NotAFolder {
        /// The path as it was given.
        path: PathBuf,
    },
    /// The kernel does not tell what happens in a folder.
    #[error("cannot follow the folder {}: {error} (the limits are in /proc/sys/fs/inotify)", path.display())]
    Unwatchable {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
    /// A file of another kind.
    #[error("{} {what}", path.display())]
    NotAPicture {
        /// The file.
        path: PathBuf,
        /// Its kind, and the remedy.
        what: String,
    },
    /// A picture that cannot be decoded.
    #[error("{reason}")]
    Picture {
        /// Which, and why.
        reason: String,
    },
    /// A video named beside other paths.
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
        /// What is wrong with it, and what would be right.
        what: String,
    },
    /// What comes out of a pipe cannot be shown.
    #[error("cannot take frames from standard input: {what}")]
    Pipe {
        /// What is wrong with it, and what would be right.
        what: String,
    },
    /// A moment of a sequence that has no rate.
    #[error("{} s do not name a frame, as the frames have no rate: name it by its number, or say how many frames a second are shown", time.as_secs_f64())]
    NoRate {
        /// The moment, from the first frame on.
        time: Duration,
    },
    /// A range that ends before it begins.
    #[error(
        "frame {first} is to be the first and frame {last} the last: choose a range with a frame in it"
    )]
    EmptyRange {
        /// The number of the first.
        first: u64,
        /// Of the last.
        last: u64,
    },
    /// A range that begins behind the end.
    #[error("frame {first} is to be the first, and there are only {count}: begin earlier")]
    BehindEnd {
        /// The number of the first that was asked for.
        first: u64,
        /// How many there are.
        count: u64,
    },
    /// A recording that cannot be shown.
    #[error("cannot show the recording {}: {what}", path.display())]
    Recording {
        /// The recording.
        path: PathBuf,
        /// What is wrong with it, and what would be right.
        what: String,
    },
    /// Not one frame of the source can be decoded.
    #[error("no frame can be decoded, the first because {reason}")]
    NothingDecoded {
        /// What is wrong with the first.
        reason: String,
    },
    /// A camera that cannot be used.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The thread that decodes is gone.
    #[error(
        "the decoder stopped in the middle: this is a defect of lariat, please report it with the file it was reading"
    )]
    DecoderGone,
    /// The thread that decodes cannot be started.
    #[error("cannot start the thread that decodes ahead: {0}")]
    NoThread(io::Error),
}

impl SourceError {
    /// Whether it is a camera that is not there, or that another program (or a killed one that still ends) has: it may come back.
    pub fn is_of_an_absent_camera(&self) -> bool {
        use CameraError::{Absent, Busy, Gone};
        matches!(
            self,
            Self::Camera(Absent { .. } | Gone { .. } | Busy { .. })
        )
    }
}

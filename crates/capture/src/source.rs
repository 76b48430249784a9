//! What every source of frames is: geometry first, then the pixels into memory lent by the caller.

use std::io;
use std::path::PathBuf;

use lariat_wire::{Centerlines, PixelFormat, SourceKind};

/// Geometry of a frame.
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
}

impl Frame {
    /// Bytes of the whole image.
    pub fn bytes(&self) -> usize {
        self.format.image_bytes(self.stride, self.height)
    }
}

/// One frame after the other: [`next`](Self::next), then [`write`](Self::write).
pub trait FrameSource: Send {
    /// What kind of source it is.
    fn kind(&self) -> SourceKind;

    /// The most bytes a frame of this source can have.
    fn largest_frame_bytes(&self) -> usize;

    /// Whether [`truth`](Self::truth) has an answer.
    fn has_truth(&self) -> bool {
        false
    }

    /// The frame rate the source itself asks for, in frames per second.
    fn native_fps(&self) -> Option<f64> {
        None
    }

    /// Makes the next frame ready; `None` when the source has ended, and from then on. May wait for a decoder.
    ///
    /// # Errors
    /// Only what ends the source. A frame that is lost is a gap in [`Frame::sequence`] and a
    /// [warning](Self::take_warning) instead.
    fn next(&mut self) -> Result<Option<Frame>, SourceError>;

    /// Writes the pixels of the frame just made ready into `pixels`, which has exactly [`Frame::bytes`] bytes; a
    /// shorter slice gets what fits. Call it at most once after each [`next`](Self::next).
    fn write(&mut self, pixels: &mut [u8]);

    /// Fills in the true centerlines of the frame just made ready: width, height, counts and curves, not the trace.
    /// `false`, and nothing is touched, if the source does not know them.
    fn truth(&self, _truth: &mut Centerlines) -> bool {
        false
    }

    /// A sentence on something that went wrong without ending the source, such as a broken file that was passed
    /// over. Ask after each [`next`](Self::next) until there is none.
    fn take_warning(&mut self) -> Option<String> {
        None
    }
}

/// Why a source cannot be opened, or cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// No source was named.
    #[error(
        "no source was named: say `rendered`, or the path of a picture, a folder of pictures or a .y4m video"
    )]
    Unnamed,
    /// The size asked of the rendered rope makes no picture of a rope.
    #[error("the rendered rope needs {what}")]
    Rendered {
        /// What is needed, and what was asked.
        what: String,
    },
    /// A path that leads nowhere, or that may not be read.
    #[error("cannot read {}: {error}", path.display())]
    Unreadable {
        /// The path as it was given.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
    /// A folder without a picture.
    #[error("the folder {} holds no PNG or JPEG file (but {ignored} others): name a folder that holds the pictures itself, not in folders of its own", path.display())]
    NoPictures {
        /// The folder.
        path: PathBuf,
        /// How many other files are in it.
        ignored: usize,
    },
    /// A file of another kind.
    #[error("{} is no PNG or JPEG picture and no .y4m video: convert it first (a video with `ffmpeg -i {} out.y4m`)", path.display(), path.display())]
    NotAPicture {
        /// The file.
        path: PathBuf,
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
    /// Not one frame of the source can be decoded.
    #[error("no frame can be decoded, the first because {reason}")]
    NothingDecoded {
        /// What is wrong with the first.
        reason: String,
    },
    /// The thread that decodes is gone.
    #[error(
        "the decoder stopped in the middle: this is a defect of lariat, please report it with the file it was reading"
    )]
    DecoderGone,
    /// The thread that decodes cannot be started.
    #[error("cannot start the thread that decodes ahead: {0}")]
    NoThread(io::Error),
}

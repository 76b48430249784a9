//! Maps the user's words to a source and opens it.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use lariat_drawn::RenderOptions;

use crate::follow::{Follow, FollowOptions};
use crate::mjpeg_file::{names_mjpeg, open_mjpeg};
use crate::picture::names_a_picture;
use crate::pictures::open_pictures;
use crate::piped::{PipeOptions, Piped};
use crate::range::Range;
use crate::recorded::{RecordingOptions, open_recording};
use crate::rendered::RenderedFrames;
use crate::simulated::{Simulated, SimulatedOptions};
use crate::source::{FrameSource, SourceError};
use crate::v4l2::{CameraOptions, open_camera};
use crate::video::open_video;

/// A source of frames to open.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A rope drawn by lariat.
    Rendered(RenderOptions),
    /// A rope simulated in real time. It rests if it is opened without commands
    /// ([`open_simulated`](crate::open_simulated)).
    Simulated(SimulatedOptions),
    /// Pictures ([`PICTURES`](crate::PICTURES)), folders of pictures, or one Y4M or MJPEG video.
    Paths {
        /// The paths, in the order in which they are shown. Pictures of a folder are in natural
        /// order.
        paths: Vec<PathBuf>,
        /// Which frames are shown, and how often.
        options: FileOptions,
    },
    /// A recording of a chain.
    Recording(RecordingOptions),
    /// A folder of pictures, and each picture that is put into it.
    Followed(FollowOptions),
    /// Standard input.
    StandardInput(PipeOptions),
    /// A camera.
    Camera(CameraOptions),
    /// The user's own program, which writes frames into the chain itself. There is nothing to open.
    External,
}

/// How a sequence of files is shown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FileOptions {
    /// The part that is shown.
    pub range: Range,
    /// True if the sequence starts again after its last frame.
    pub looped: bool,
    /// Frames per second, which maps times in the range to frames. Used for files without a rate of
    /// their own.
    pub fps: Option<f64>,
}

impl Source {
    /// Returns the source with these names. `rendered` alone is the rendered rope, `external` the
    /// user's own program, and a name [of a recording](names_a_recording) a recording. Anything
    /// else is a list of paths (write `./rendered` for a folder of that name).
    pub fn named<P: AsRef<Path>>(
        names: &[P],
        options: FileOptions,
        rendered: RenderOptions,
    ) -> Self {
        match names {
            [name] if names_a_recording(name.as_ref()) => Self::Recording(RecordingOptions {
                path: name.as_ref().to_owned(),
                topic: None,
                range: options.range,
                looped: options.looped,
            }),
            [name] if name.as_ref() == Path::new("rendered") => Self::Rendered(rendered),
            [name] if name.as_ref() == Path::new("external") => Self::External,
            _ => Self::Paths {
                paths: names.iter().map(|name| name.as_ref().to_owned()).collect(),
                options,
            },
        }
    }
}

/// Opens a source and reports every error that can be known before the first frame.
///
/// # Errors
/// The path does not exist. The folder has no pictures. The file is neither a picture nor a video.
/// The range is empty. The camera cannot be used.
pub fn open(source: &Source) -> Result<Box<dyn FrameSource>, SourceError> {
    match source {
        Source::Rendered(options) => Ok(Box::new(RenderedFrames::new(options)?)),
        Source::Simulated(options) => Ok(Box::new(Simulated::new(options, Box::new(|| None))?)),
        Source::Recording(options) => Ok(Box::new(open_recording(options)?)),
        Source::Followed(options) => Ok(Box::new(Follow::open(options)?)),
        Source::StandardInput(options) => Ok(Box::new(Piped::standard_input(options)?)),
        Source::Camera(options) => Ok(open_camera(options)?),
        Source::External => Err(SourceError::External),
        Source::Paths { paths, .. } if paths.is_empty() => Err(SourceError::Unnamed),
        Source::Paths { paths, options } => match paths.iter().find(|path| is_video(path)) {
            None => Ok(Box::new(open_pictures(paths, options)?)),
            Some(video) if paths.len() == 1 => Ok(Box::new(if names_mjpeg(video) {
                open_mjpeg(video, options)?
            } else {
                open_video(video, options)?
            })),
            Some(video) => Err(SourceError::VideoAmongOthers {
                path: video.clone(),
            }),
        },
    }
}

fn is_video(path: &Path) -> bool {
    names_a_video(path) && !path.is_dir()
}

/// Returns true if a path names a video that lariat reads.
pub fn names_a_video(path: &Path) -> bool {
    is_named(path, "y4m") || names_mjpeg(path)
}

/// Returns true if a path names a recording: a file with such a name, or a folder of such files
/// rather than of pictures, as `ros2 bag record` makes it.
pub fn names_a_recording(path: &Path) -> bool {
    if !path.is_dir() {
        return lariat_record::names_a_recording(path);
    }
    let Ok(entries) = std::fs::read_dir(path) else {
        return false;
    };
    let files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    let is_bag =
        path.join("metadata.yaml").is_file() || !files.iter().any(|file| names_a_picture(file));
    is_bag
        && files
            .iter()
            .any(|file| lariat_record::names_a_recording(file))
}

fn is_named(path: &Path, extension: &str) -> bool {
    let is_it = |found: &OsStr| found.eq_ignore_ascii_case(extension);
    path.extension().is_some_and(is_it)
}

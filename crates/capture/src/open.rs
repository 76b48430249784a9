//! From what the user named to the source that it means.

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

/// What to take frames from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A rope drawn by lariat.
    Rendered(RenderOptions),
    /// A rope that is simulated in real time; it rests if it is opened without commands
    /// ([`open_simulated`](crate::open_simulated)).
    Simulated(SimulatedOptions),
    /// Pictures ([`PICTURES`](crate::PICTURES)), folders of pictures, or one Y4M or MJPEG video.
    Paths {
        /// Shown in this order; the pictures of a folder in natural order.
        paths: Vec<PathBuf>,
        /// Which of them, and how often.
        options: FileOptions,
    },
    /// What a chain recorded.
    Recording(RecordingOptions),
    /// A folder of pictures, and each picture that is put into it.
    Followed(FollowOptions),
    /// Standard input.
    StandardInput(PipeOptions),
    /// A camera.
    Camera(CameraOptions),
    /// A program of the user's, which writes frames into the chain itself: there is nothing to open.
    External,
}

/// How a sequence of files is shown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FileOptions {
    /// Which part of it.
    pub range: Range,
    /// Whether to begin again after the last frame.
    pub looped: bool,
    /// Frames per second by which a time in the range is a frame, where the files themselves tell none.
    pub fps: Option<f64>,
}

impl Source {
    /// The source that these words name: `rendered` alone is the rendered rope, `external` a program of the user's, what [names a recording](names_a_recording)
    /// one, anything else is paths (a folder of the name `rendered` is `./rendered`).
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

/// Opens a source: everything that can be known to be wrong is said here, before the first frame.
///
/// # Errors
/// A path that does not exist, a folder without pictures, a file that is neither a picture nor a video, a range without a
/// frame, a camera that cannot be used.
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

/// Returns true if a path is that of a recording: a file by its name, or a folder that holds such files and is none of pictures, as
/// `ros2 bag record` makes it.
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

//! Frames of a video, a recording or standard input, each as a named picture.

use crate::trace::TraceArgs;
use anyhow::{Context, Result};
use lariat_capture::{FrameSource, names_a_recording, names_a_video};
use lariat_chain::picture::Picture;
use lariat_chain::pipeline::Schedule;
use lariat_chain::settings::Settings;
use std::path::{Path, PathBuf};

/// Returns whether a path names a source of many frames.
pub(super) fn names_frames(path: &Path) -> bool {
    path == Path::new("-") || names_a_recording(path) || (names_a_video(path) && !path.is_dir())
}

/// A picture to trace.
pub(super) struct Shown {
    pub(super) name: PathBuf,
    pub(super) picture: Picture,
    /// Exposure time, if known.
    pub(super) exposed_ns: Option<u64>,
    /// Time after the first picture, if the source has its own pace.
    pub(super) after_ns: Option<u64>,
}

/// A picture, or a sequence of frames.
pub(super) enum Input {
    /// A picture file; `None` once it has been read.
    File(Option<PathBuf>),
    Frames(Frames),
}

impl Input {
    /// # Errors
    /// Returns an error if a source of frames cannot be opened or lacks the requested part.
    pub(super) fn open(path: &Path, args: &TraceArgs) -> Result<Self> {
        if !names_frames(path) {
            return Ok(Self::File(Some(path.to_owned())));
        }
        let settings = Settings::resolve(&args.flags.with_source(path))?;
        Ok(Self::Frames(Frames {
            path: path.to_owned(),
            source: lariat_capture::open(&settings.source())?,
            schedule: Some(Schedule::new(&settings.capture, true)?),
        }))
    }

    /// Returns the schedule of the pictures if they form a sequence, but only once.
    pub(super) fn take_schedule(&mut self) -> Option<Schedule> {
        match self {
            Self::File(_) => None,
            Self::Frames(frames) => frames.schedule.take(),
        }
    }

    /// Returns the next picture, or `None` at the end. `complain` gets warnings about lost frames.
    ///
    /// # Errors
    /// Returns the error that ends the input.
    pub(super) fn next(
        &mut self,
        complain: &mut impl FnMut(anyhow::Error),
    ) -> Result<Option<Shown>> {
        let name = match self {
            Self::Frames(frames) => return frames.next(complain),
            Self::File(path) => path.take(),
        };
        let shown = |name: PathBuf| -> Result<Shown> {
            Ok(Shown {
                picture: Picture::load(&name)?,
                name,
                exposed_ns: None,
                after_ns: None,
            })
        };
        name.map(shown).transpose()
    }
}

/// A source of frames.
pub(super) struct Frames {
    path: PathBuf,
    source: Box<dyn FrameSource>,
    schedule: Option<Schedule>,
}

impl Frames {
    /// Returns the next frame as a picture. Its name is its number in the traced part, as if the
    /// source were a folder.
    fn next(&mut self, complain: &mut impl FnMut(anyhow::Error)) -> Result<Option<Shown>> {
        loop {
            let frame = self.source.next();
            while let Some(warning) = self.source.take_warning() {
                complain(anyhow::anyhow!(warning));
            }
            while let Some(news) = self.source.take_news() {
                eprintln!("lariat: {news}");
            }
            let frame = frame.with_context(|| self.path.display().to_string())?;
            let Some(frame) = frame else {
                return Ok(None);
            };
            // The camera was silent when this was recorded.
            if frame.width == 0 || frame.height == 0 {
                continue;
            }
            let mut pixels = vec![0; frame.bytes()];
            self.source.write(&mut pixels);
            return Ok(Some(Shown {
                name: self.path.join(frame.sequence.to_string()),
                picture: Picture::of(&frame, pixels),
                exposed_ns: frame.exposed_ns,
                after_ns: self.source.due_after_ns(),
            }));
        }
    }
}

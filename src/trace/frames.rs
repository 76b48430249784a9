//! Frames of a video, a recording or standard input, each as a picture with a name.

use crate::picture::Picture;
use crate::settings::Settings;
use crate::trace::TraceArgs;
use anyhow::{Context, Result};
use lariat_capture::{FrameSource, names_a_recording};
use std::path::{Path, PathBuf};

/// Whether a path is that of many frames in one.
pub(super) fn names_frames(path: &Path) -> bool {
    let is_video =
        (path.extension()).is_some_and(|extension| extension.eq_ignore_ascii_case("y4m"));
    path == Path::new("-") || names_a_recording(path) || (is_video && !path.is_dir())
}

/// A picture, or frame after frame.
pub(super) enum Input {
    /// A picture file; none when it has been read.
    File(Option<PathBuf>),
    Frames(Frames),
}

impl Input {
    /// # Errors
    /// A source of frames that cannot be opened, or does not have what is asked of it.
    pub(super) fn open(path: &Path, args: &TraceArgs) -> Result<Self> {
        if !names_frames(path) {
            return Ok(Self::File(Some(path.to_owned())));
        }
        let settings = Settings::resolve(&args.flags.with_source(path))?;
        Ok(Self::Frames(Frames {
            path: path.to_owned(),
            source: lariat_capture::open(&settings.source())?,
        }))
    }

    /// Whether its pictures go on from each other.
    pub(super) fn is_one_scene(&self) -> bool {
        matches!(self, Self::Frames(_))
    }

    /// The next picture, and its name; `None` at the end. `complain`: is told of what is lost.
    ///
    /// # Errors
    /// What ends it.
    pub(super) fn next(
        &mut self,
        complain: &mut impl FnMut(anyhow::Error),
    ) -> Result<Option<(PathBuf, Picture)>> {
        match self {
            Self::Frames(frames) => frames.next(complain),
            Self::File(path) => match path.take() {
                Some(path) => Picture::load(&path).map(|picture| Some((path, picture))),
                None => Ok(None),
            },
        }
    }
}

/// A source of frames.
pub(super) struct Frames {
    path: PathBuf,
    source: Box<dyn FrameSource>,
}

impl Frames {
    /// A frame is called by its number in the part that is shown, as if the source were a folder.
    fn next(
        &mut self,
        complain: &mut impl FnMut(anyhow::Error),
    ) -> Result<Option<(PathBuf, Picture)>> {
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
            // A camera that was silent when it was recorded.
            if frame.width == 0 || frame.height == 0 {
                continue;
            }
            let mut pixels = vec![0; frame.bytes()];
            self.source.write(&mut pixels);
            let name = self.path.join(frame.sequence.to_string());
            return Ok(Some((name, Picture::of(&frame, pixels))));
        }
    }
}

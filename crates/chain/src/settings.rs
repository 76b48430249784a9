//! The user's settings. They come from the defaults, `lariat.toml` and the flags, each overriding
//! the one before.
//!
//! Every setting is one row of the table in `table`, with its field, name, kind, comment and flag.
//! The check of the file, `config init`, `config show`, the command line and its help all use that
//! table.

mod arrangement;
mod camera;
mod capture;
mod change;
mod curve;
pub mod duration;
mod extract;
mod file;
mod flags;
mod keep;
mod keys;
mod kind;
mod meaning;
mod problem;
pub mod range;
mod recording;
pub(crate) mod renamed;
mod resolve;
mod run;
mod simulation;
mod table;
mod view;

pub use arrangement::{Arrangement, Cpus, STAGES, Stage, Wake};
pub use camera::CameraSettings;
pub use capture::{Capture, Fps, USUAL_FPS};
pub use change::{Concerned, settings_of, version_line, version_of};
pub use curve::{ControlPoints, Family, Fit};
pub use extract::Extract;
pub use flags::Flags;
pub use keep::with_changes;
pub use keys::template;
pub use meaning::{image_positions, image_size, mask_text, nearest, number_text};
pub use problem::Problems;
pub use recording::{COMPRESSIONS, IMAGES, Recording};
pub use resolve::Resolved;
pub use run::{Restart, Run};
pub use simulation::Simulation;
pub use view::{Camera, Unit};

use crate::stages::status::CHAIN_PID;
use anyhow::{Context, Result};
use lariat_capture::Source;
pub(crate) use run::nanoseconds;
use std::path::{Path, PathBuf};

/// The settings file that is read if none is named.
pub const FILE_NAME: &str = "lariat.toml";

/// Environment variable with the descriptor number of the file that holds a stage's settings.
pub const SETTINGS_FD: &str = "LARIAT_SETTINGS_FD";

/// All settings of a chain, section by section.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Settings {
    /// `[run]`.
    pub run: Run,
    /// `[capture]`.
    pub capture: Capture,
    /// `[simulation]`.
    pub simulation: Simulation,
    /// `[camera]`.
    pub camera: Camera,
    /// `[extract]`.
    pub extract: Extract,
    /// `[fit]`.
    pub fit: Fit,
    /// `[sink]`.
    pub sink: Sink,
    /// `[record]`.
    pub record: Recording,
    /// The settings file that was read.
    pub file: Option<PathBuf>,
    /// Version of the settings: 0 at the start of a chain, one more after each change.
    pub version: u32,
    /// Set if the curve is the default of the drawn rope and not the user's choice.
    pub has_curve_of_source: bool,
}

/// `[sink]`: what is displayed.
#[derive(Debug, Clone, PartialEq)]
pub struct Sink {
    /// True if a live line is shown while the chain runs.
    pub live: bool,
}

impl Default for Sink {
    fn default() -> Self {
        Self { live: true }
    }
}

impl Settings {
    /// Resolves the settings for these flags: the defaults, then the file (`--config`, or
    /// `./lariat.toml` if it exists), then the flags.
    ///
    /// # Errors
    /// Returns all errors in the file and the flags, with a sentence for each.
    pub fn resolve(flags: &Flags) -> Result<Self> {
        Ok(Resolved::new(flags)?.settings)
    }

    /// Resolves the settings of a whole chain, like [`resolve`](Self::resolve). However, the drawn
    /// rope gets a curve of a fixed size unless the user chooses one.
    ///
    /// # Errors
    /// Fails like [`resolve`](Self::resolve).
    pub fn of_chain(flags: &Flags) -> Result<Self> {
        Ok(Resolved::of_chain(flags)?.settings)
    }

    /// Returns the source of the frames.
    pub fn source(&self) -> Source {
        let points = self.extract.points;
        if self.capture.is_simulated() {
            return Source::Simulated((self.simulation).options(
                &self.capture,
                points,
                self.camera.is_simulated(),
            ));
        }
        self.capture.source(points)
    }

    /// Returns the input files, which no output may overwrite.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        let sources = self.capture.source.iter();
        let Camera {
            calibration,
            plane,
            depth,
            second,
            pose,
            ..
        } = &self.camera;
        let (images, camera) = (&self.capture.depth_images, &self.capture.depth_source);
        let files = [
            calibration,
            plane,
            depth,
            second,
            pose,
            images,
            camera,
            &self.file,
        ];
        let named = sources.chain(files.into_iter().flatten());
        named.map(PathBuf::as_path)
    }

    /// Returns the options of the sink. `from_start` is true if it was running before the first
    /// frame.
    pub fn sink_options(&self, from_start: bool) -> lariat_sink::Options {
        let period_ns = match self.capture.fps {
            Fps::PerSecond(fps) => Some((1e9 / fps) as u64),
            Fps::Auto if self.capture.has_own_pace() => None,
            Fps::Auto => Some((1e9 / self.capture.usual_fps()) as u64),
            Fps::Max => None,
        };
        lariat_sink::Options {
            period_ns,
            deadline_ns: self.run.deadline.map(nanoseconds),
            from_start,
        }
    }

    /// Returns all settings as the text of a `lariat.toml`. If they have changed, the text includes
    /// the version.
    pub fn text(&self) -> String {
        version_line(self.version)
            + &keys::document(|_, key| match (key.get)(self) {
                Some(value) => format!("{} = {value}\n", key.name),
                None => String::new(),
            })
    }

    /// Returns the settings of a stage. They come from its chain if they have changed since the
    /// chain began, otherwise from [`resolve`](Self::resolve).
    ///
    /// # Errors
    /// Fails like [`resolve`](Self::resolve).
    pub fn of_stage(flags: &Flags) -> Result<Self> {
        match std::env::var(SETTINGS_FD) {
            Ok(number) => {
                let text = std::fs::read_to_string(format!("/proc/self/fd/{number}"))
                    .with_context(|| format!("{SETTINGS_FD} names no file: unset it"))?;
                Self::of_text(&text)
            }
            // The chain has checked that a fitter exists.
            Err(_) if std::env::var_os(CHAIN_PID).is_some() => {
                Ok(Resolved::read(flags)?.with_curve_of_source().settings)
            }
            Err(_) => Self::resolve(flags),
        }
    }

    /// Returns the settings of a single file.
    ///
    /// # Errors
    /// Returns all errors in the file, with a sentence for each.
    pub fn of_file(path: &Path) -> Result<Self> {
        Self::resolve(&Flags::of_file(path.to_owned()))
    }
}

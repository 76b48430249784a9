//! What the user wants, from three places: the defaults, `lariat.toml`, and the flags, each overruling the
//! one before.
//!
//! Every setting is one entry of the table in `table`: its section, name and comment, how it is read and how it
//! is written. The file's check, `config init`, `config show` and the flags all go by that table.

mod arrangement;
mod camera;
mod curve;
pub mod duration;
mod file;
mod flags;
mod keys;
mod meaning;
mod problem;
pub mod range;
mod recording;
mod simulation;
mod table;
mod view;

pub use arrangement::{Arrangement, Cpus, STAGES, Stage, Wake};
pub use camera::CameraSettings;
pub use curve::{Family, Fit, Order};
pub use flags::Flags;
pub use keys::template;
pub use meaning::{image_size, mask_text, nearest, number_text};
pub use problem::Problems;
pub use recording::{COMPRESSIONS, IMAGES, Recording};
pub use simulation::Simulation;
pub use view::{Camera, Unit};

use crate::settings::keys::KEYS;
use crate::settings::problem::Origin;
use anyhow::Result;
use lariat_capture::{
    CameraOptions, FileOptions, FollowOptions, Pace, PipeOptions, Range, RawFrames, RenderOptions,
    Request, Source, names_a_camera, names_a_recording, video_fps,
};
use lariat_extract::{Mask, Method, Region};
use lariat_fit::Fitter;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The file that is read where none is named.
pub const FILE_NAME: &str = "lariat.toml";

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
}

/// `[run]`: the chain as a whole.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The name of the camera chain: 1 to 32 of a–z, 0–9, `_` and `-`.
    pub rig: String,
    /// Whether capture waits for slow readers, so that no frame is lost.
    pub lossless: bool,
    /// How long to run; without it, until the source ends or the user says so.
    pub duration: Option<Duration>,
    /// How many frames to capture at most.
    pub frames: Option<u64>,
    /// The folder for the report; without it, none is written.
    pub out: Option<PathBuf>,
    /// The file for the timeline of the last frames; without it, none is written.
    pub trace: Option<PathBuf>,
    /// The latency that counts as a miss; without it, the frame period.
    pub deadline: Option<Duration>,
    /// The recording; without it, none is made.
    pub record: Option<PathBuf>,
    /// Whether capture, extract and fit are threads of one process.
    pub fuse: bool,
    /// How the stages are arranged on the machine.
    pub arrangement: Arrangement,
}

impl Run {
    /// How long to run, in nanoseconds.
    pub fn duration_ns(&self) -> Option<u64> {
        self.duration.map(nanoseconds)
    }
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl Default for Run {
    fn default() -> Self {
        Self {
            rig: "default".to_owned(),
            lossless: false,
            duration: None,
            frames: None,
            out: None,
            trace: None,
            record: None,
            deadline: None,
            fuse: false,
            arrangement: Arrangement::default(),
        }
    }
}

/// How fast frames are sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fps {
    /// At this many frames a second.
    PerSecond(f64),
    /// As fast as they can be made.
    Max,
    /// As fast as a camera can, as a video or a recording was made; [`USUAL_FPS`] for all else.
    Auto,
}

/// Frames a second of what has no rate of its own.
pub const USUAL_FPS: f64 = 30.0;

/// `[capture]`: where frames come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// `rendered`, `simulated` or `external` alone, `-` (standard input), or the paths of pictures, folders or a video.
    pub source: Vec<PathBuf>,
    /// When frames are due.
    pub fps: Fps,
    /// Width and height, px, of a camera's picture or the rendered one; without it, about or exactly [`USUAL_SIZE`].
    pub size: Option<[u32; 2]>,
    /// Which of all rendered or simulated ropes.
    pub seed: u64,
    /// Whether files begin again after the last.
    pub looped: bool,
    /// Which part of files is shown.
    pub range: Range,
    /// Whether a folder is waited at for more.
    pub follow: bool,
    /// Which of a recording's images are shown, if it has those of several cameras.
    pub topic: Option<String>,
    /// What is asked of a camera.
    pub camera: CameraSettings,
}

/// Width and height of the rendered picture if none are asked for, px.
const USUAL_SIZE: [u32; 2] = [640, 480];

impl Default for Capture {
    fn default() -> Self {
        Self {
            source: vec![PathBuf::from("rendered")],
            fps: Fps::Auto,
            size: None,
            seed: 1,
            looped: false,
            range: Range::default(),
            follow: false,
            topic: None,
            camera: CameraSettings::default(),
        }
    }
}

impl Capture {
    /// The source itself, if it is not simulated; rendered ropes have a truth of `points` points.
    fn source(&self, points: usize) -> Source {
        if self.is_camera() {
            return Source::Camera(CameraOptions {
                path: self.source[0].clone(),
                request: self.request(),
                controls: self.camera.controls(),
                io: self.camera.io,
            });
        }
        if self.follow
            && let [folder] = &self.source[..]
        {
            return Source::Followed(FollowOptions {
                folder: folder.clone(),
                fps: match self.fps {
                    Fps::PerSecond(fps) => Some(fps),
                    Fps::Max | Fps::Auto => None,
                },
                every: self.range.every,
            });
        }
        if self.is_piped() {
            return Source::StandardInput(PipeOptions {
                raw: self.raw_frames(),
                paced: self.fps != Fps::Auto,
            });
        }
        let defaults = RenderOptions::default();
        let rendered = RenderOptions {
            seed: self.seed,
            width: self.likely_size()[0],
            height: self.likely_size()[1],
            // The rope moves at its own speed, however often it is looked at.
            frame_interval_s: match self.fps {
                Fps::PerSecond(fps) => 1.0 / fps,
                Fps::Max => defaults.frame_interval_s,
                Fps::Auto => 1.0 / USUAL_FPS,
            },
            truth_points: points as u32,
            ..defaults
        };
        let files = FileOptions {
            range: self.range,
            looped: self.looped,
            fps: match self.pace() {
                Pace::Fps(fps) => Some(fps),
                Pace::Max => None,
            },
        };
        let mut source = Source::named(&self.source, files, rendered);
        if let Source::Recording(recording) = &mut source {
            recording.topic.clone_from(&self.topic);
        }
        source
    }

    /// What frames in a pipe are, if no video.
    fn raw_frames(&self) -> Option<RawFrames> {
        let (size, format) = (self.size?, self.camera.pixel_format?.raw?);
        Some(RawFrames { size, format })
    }

    /// When frames are due.
    pub fn pace(&self) -> Pace {
        match self.fps {
            Fps::PerSecond(fps) => Pace::Fps(fps),
            Fps::Max => Pace::Max,
            Fps::Auto => Pace::Fps(self.usual_fps()),
        }
    }

    /// Frames a second if nobody says how many: those of a video, as it was made.
    fn usual_fps(&self) -> f64 {
        let video = match &self.source[..] {
            [path] if path.is_file() => video_fps(path),
            _ => None,
        };
        video.map_or(USUAL_FPS, |fps| fps / self.range.every.get() as f64)
    }

    /// The size that frames most likely have, px.
    pub fn likely_size(&self) -> [u32; 2] {
        self.size.unwrap_or(USUAL_SIZE)
    }

    /// Whether the source is a simulated rope.
    pub fn is_simulated(&self) -> bool {
        self.source[..] == [PathBuf::from("simulated")]
    }

    /// Whether the source is standard input.
    pub fn is_piped(&self) -> bool {
        self.source[..] == [PathBuf::from("-")]
    }

    /// Whether the source is a camera.
    pub fn is_camera(&self) -> bool {
        matches!(&self.source[..], [path] if names_a_camera(path))
    }

    /// Whether a process of the user's writes the frames.
    pub fn is_external(&self) -> bool {
        self.source[..] == [PathBuf::from("external")]
    }

    /// Whether frames come when they come, if nobody says otherwise: from a camera, into a folder, out of a recording or a pipe.
    pub fn has_own_pace(&self) -> bool {
        let is_recording = matches!(&self.source[..], [path] if names_a_recording(path));
        let is_live = self.is_camera() || self.is_piped() || self.is_external();
        is_live || self.follow || is_recording
    }

    /// What is asked of a camera; "max" is its best rate too.
    fn request(&self) -> Request {
        Request {
            size: self.size,
            fps: match self.fps {
                Fps::PerSecond(fps) => Some(fps),
                Fps::Max | Fps::Auto => None,
            },
            format: self.camera.pixel_format.and_then(|name| name.code),
        }
    }
}

/// `[extract]`: what is a rope, and how it is described.
#[derive(Debug, Clone, PartialEq)]
pub struct Extract {
    /// Which pixels are rope.
    pub mask: Mask,
    /// How long after its capture a frame's mask is waited for, if masks are made elsewhere.
    pub mask_deadline: Duration,
    /// How the mask becomes a centerline.
    pub method: Method,
    /// Points of a centerline.
    pub points: usize,
    /// The most ropes reported.
    pub ropes: usize,
    /// Near which position (px) the first point is, in the first frame.
    pub start: Option<[f32; 2]>,
    /// For how long a rope that is out of sight is reported.
    pub keep_lost: Duration,
    /// The part of the image that is read; without it, all.
    pub roi: Option<Region>,
}

impl Default for Extract {
    fn default() -> Self {
        Self {
            mask: Mask::Auto,
            mask_deadline: Duration::from_millis(50),
            method: Method::Skeleton,
            points: 120,
            ropes: 8,
            start: None,
            keep_lost: Duration::from_secs(1),
            roi: None,
        }
    }
}

impl Extract {
    /// The extractor's own options.
    pub fn options(&self) -> lariat_extract::Options {
        lariat_extract::Options {
            mask: self.mask.clone(),
            method: self.method,
            points: self.points,
            ropes: self.ropes,
            // The extractor sees the region alone.
            start: match (self.start, self.roi) {
                (Some([x, y]), Some(region)) => Some([x - region.x as f32, y - region.y as f32]),
                (start, _) => start,
            },
            keep_lost: self.keep_lost,
        }
    }
}

/// `[sink]`: what is shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Sink {
    /// Whether a line of figures is shown while the chain runs.
    pub live: bool,
}

impl Default for Sink {
    fn default() -> Self {
        Self { live: true }
    }
}

impl Settings {
    /// The settings that hold for these flags: defaults, then the file (`--config`, or `./lariat.toml` where
    /// there is one), then the flags.
    ///
    /// # Errors
    /// All that is wrong with the file and the flags, a sentence each.
    pub fn resolve(flags: &Flags) -> Result<Self> {
        Ok(Resolved::new(flags)?.settings)
    }

    /// The source that frames come from.
    pub fn source(&self) -> Source {
        let points = self.extract.points;
        if self.capture.is_simulated() {
            return Source::Simulated(self.simulation.options(&self.capture, points));
        }
        self.capture.source(points)
    }

    /// The files that are read, which no output may overwrite.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        let sources = self.capture.source.iter();
        let files = [&self.camera.calibration, &self.camera.plane, &self.file];
        let named = sources.chain(files.into_iter().flatten());
        named.map(PathBuf::as_path)
    }

    /// What the sink is to count by. `from_start`: it was there before the first frame.
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

    /// All that is set, as the text of a `lariat.toml`.
    pub fn text(&self) -> String {
        keys::document(|_, key| match (key.get)(self) {
            Some(value) => format!("{} = {value}\n", key.name),
            None => String::new(),
        })
    }

    /// The settings of one file alone.
    ///
    /// # Errors
    /// All that is wrong with it, a sentence each.
    pub fn of_file(path: &Path) -> Result<Self> {
        Self::resolve(&Flags::of_file(path.to_owned()))
    }
}

/// Settings, and where each of them came from.
pub struct Resolved {
    /// All of them.
    pub settings: Settings,
    /// In the order of [`KEYS`].
    origins: Vec<Origin>,
}

impl Resolved {
    /// Of flags, file and defaults.
    ///
    /// # Errors
    /// What is wrong with each of them.
    pub fn new(flags: &Flags) -> Result<Self> {
        let mut resolved = Self {
            settings: Settings::default(),
            origins: vec![Origin::Default; KEYS.len()],
        };
        let mut problems = Problems::default();
        if let Some(path) = file::path(flags.config.as_deref()) {
            for entry in file::read(&path, &mut problems)? {
                resolved.set(entry.key, entry.value, entry.origin, &mut problems);
            }
            resolved.settings.file = Some(path);
        }
        for (flag, key, value) in flags.given() {
            resolved.set(key, value.clone(), Origin::Flag(flag), &mut problems);
        }
        resolved.settle_fit(&mut problems);
        // What depends on several settings is judged only where each of them makes sense.
        if problems.is_empty() {
            resolved.check_fit(&mut problems);
            resolved.check_arrangement(&mut problems);
            resolved.check_camera(&mut problems);
            resolved.check_source(&mut problems);
        }
        problems.into_result()?;
        Ok(resolved)
    }

    fn set(&mut self, key: usize, value: toml::Value, origin: Origin, problems: &mut Problems) {
        match (KEYS[key].set)(&mut self.settings, &value) {
            Ok(()) => self.origins[key] = origin,
            Err(why) => problems.add(&origin, format!("{}: {why}", origin.quote(key, &value))),
        }
    }

    /// Which of basis and order holds, where one of them leaves no room for the other: what was said later. A flag is later
    /// than the file.
    fn settle_fit(&mut self, problems: &mut Problems) {
        let keys = ["basis", "order"].map(|name| keys::position("fit", name));
        let [Some(basis_key), Some(order_key)] = keys else {
            return;
        };
        let [basis, order] = [basis_key, order_key].map(|key| self.origins[key].clone());
        let rank = |origin: &Origin| match origin {
            Origin::Default => 0,
            Origin::File { .. } => 1,
            Origin::Flag(_) => 2,
        };
        let fit = &mut self.settings.fit;
        match (fit.basis, fit.order) {
            (Family::Auto, Some(_)) if rank(&basis) < rank(&order) => {
                fit.basis = Family::Bezier;
                self.origins[basis_key] = order;
            }
            (Family::Auto, Some(_)) if rank(&basis) > rank(&order) => fit.order = None,
            (Family::Auto, Some(_)) => problems.add(
                &order,
                "the basis \"auto\" chooses the order itself: leave the order out, or name another basis".to_owned(),
            ),
            (Family::Auto, None) | (_, Some(_)) => {}
            (_, None) => fit.order = Some(Order::Named(curve::DEFAULT_ORDER)),
        }
    }

    /// Whether there are fitters, of open and of closed curves, for these settings and number of points.
    fn check_fit(&self, problems: &mut Problems) {
        let fit = &self.settings.fit;
        let error = [false, true].into_iter().find_map(|closed| {
            let options = fit.options(self.settings.extract.points, closed);
            Fitter::new(options).err().map(|error| error.to_string())
        });
        let Some(error) = error.or(fit.unfilterable().map(str::to_owned)) else {
            return;
        };
        // Blamed on what the user has said last, of all that together make it impossible.
        let said = keys::of_section("fit")
            .chain(keys::position("extract", "points"))
            .map(|key| &self.origins[key])
            .max()
            .unwrap_or(&Origin::Default);
        problems.add(said, error);
    }

    /// Whether the calibration that is named is one.
    fn check_camera(&self, problems: &mut Problems) {
        if let Some(why) = self.settings.camera.problem() {
            let said = keys::of_section("camera")
                .map(|key| &self.origins[key])
                .max();
            problems.add(said.unwrap_or(&Origin::Default), why);
        }
    }

    /// Whether what is asked of the source can be asked of it. What stands in the file for another source than the one that a
    /// flag names is no fault.
    fn check_source(&self, problems: &mut Problems) {
        let origin = |name: &str| {
            keys::position("capture", name).map_or(&Origin::Default, |key| &self.origins[key])
        };
        // A new file names the rendered rope, which is no wish.
        let source_is_in_file = matches!(origin("source"), Origin::File { .. })
            && !self.is_default("capture", "source");
        let capture = &self.settings.capture;
        for (name, why) in range::meaningless(capture) {
            let is_meant = match origin(name) {
                Origin::Default => false,
                Origin::File { .. } => source_is_in_file && !self.is_default("capture", name),
                Origin::Flag(_) => true,
            };
            if is_meant {
                problems.add(origin(name), why);
            }
        }
        if problems.is_empty()
            && let Some((name, why)) = range::contradiction(capture)
        {
            problems.add(origin(name).max(origin("follow")), why);
        }
    }

    /// Whether a setting is what it is if nobody says anything.
    fn is_default(&self, section: &str, name: &str) -> bool {
        keys::position(section, name).is_none_or(|key| {
            let get = KEYS[key].get;
            get(&self.settings) == get(&Settings::default())
        })
    }

    /// Whether the stages can be arranged so.
    fn check_arrangement(&self, problems: &mut Problems) {
        if let Some(why) = self.settings.run.arrangement.contradiction() {
            let said = ["cpus", "wake"].into_iter();
            let said = said.filter_map(|name| keys::position("run", name));
            let said = said.map(|key| &self.origins[key]).max();
            problems.add(said.unwrap_or(&Origin::Default), why);
        }
    }

    /// All settings as the text of a `lariat.toml`, each with where it came from.
    pub fn show(&self) -> String {
        keys::document(|index, key| {
            let origin = &self.origins[index];
            match (key.get)(&self.settings) {
                Some(value) => format!("{} = {value}  # {origin}\n", key.name),
                None => format!("# {} is not set\n", key.name),
            }
        })
    }
}

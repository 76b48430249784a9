//! `[capture]`: where frames come from, and when.

use crate::settings::CameraSettings;
use lariat_capture::{
    CameraOptions, FileOptions, FollowOptions, Pace, PipeOptions, Range, RawFrames, RenderOptions,
    Request, Source, Wanted, names_a_camera, names_a_recording, names_a_video, video_fps,
};
use std::path::PathBuf;
use std::time::Duration;

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

/// Where frames come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// `rendered`, `simulated` or `external` alone, `-` (standard input), or the paths of pictures, folders or a video.
    pub source: Vec<PathBuf>,
    /// When frames are due.
    pub fps: Fps,
    /// Width and height, px, of a camera's picture or the rendered one; without it, about or exactly the usual size.
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
    /// Depth images beside pictures: a folder of them.
    pub depth_images: Option<PathBuf>,
    /// A depth camera beside a camera.
    pub depth_source: Option<PathBuf>,
    /// How far in time a frame may be from its depth image, of that camera; if not set, by that camera's period.
    pub depth_within: Option<Duration>,
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
            depth_images: None,
            depth_source: None,
            depth_within: None,
            camera: CameraSettings::default(),
        }
    }
}

impl Capture {
    /// The source itself, if it is not simulated; rendered ropes have a truth of `points` points.
    pub(super) fn source(&self, points: usize) -> Source {
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
                fps: self.asked_fps(),
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
        let mut source = Source::named(&self.source, self.file_options(), rendered);
        if let Source::Recording(recording) = &mut source {
            recording.topic.clone_from(&self.topic);
        }
        source
    }

    /// Which part of files is shown, and how.
    pub fn file_options(&self) -> FileOptions {
        FileOptions {
            range: self.range,
            looped: self.looped,
            fps: match self.pace() {
                Pace::Fps(fps) => Some(fps),
                Pace::Max => None,
            },
        }
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
    pub(super) fn usual_fps(&self) -> f64 {
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

    /// Returns true if the source is the rope that lariat draws.
    pub fn is_rendered(&self) -> bool {
        self.source[..] == [PathBuf::from("rendered")]
    }

    /// Whether the source is standard input.
    pub fn is_piped(&self) -> bool {
        self.source[..] == [PathBuf::from("-")]
    }

    /// Whether the source is a camera.
    pub fn is_camera(&self) -> bool {
        matches!(&self.source[..], [path] if names_a_camera(path))
    }

    /// Whether frames are pictures in files.
    pub fn is_of_pictures(&self) -> bool {
        let is_drawn = self.is_simulated() || self.is_rendered();
        let is_video = |path: &PathBuf| names_a_video(path);
        !self.has_own_pace() && !is_drawn && !self.source.iter().any(is_video)
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

    /// The depth camera beside the camera: asked for images of its calibration's size, as many as the other gives.
    pub(crate) fn depth_camera(&self, size: [u32; 2], fps: Option<f64>) -> Option<CameraOptions> {
        let path = self.depth_source.clone().filter(|_| self.is_camera())?;
        Some(CameraOptions {
            path,
            request: Request {
                size: Some(size),
                fps: self.asked_fps().or(fps),
                format: None,
                wanted: Wanted::Depth,
            },
            io: self.camera.io,
            ..CameraOptions::default()
        })
    }

    /// "max" is a camera's best rate, too.
    fn asked_fps(&self) -> Option<f64> {
        match self.fps {
            Fps::PerSecond(fps) => Some(fps),
            Fps::Max | Fps::Auto => None,
        }
    }

    /// What is asked of a camera.
    fn request(&self) -> Request {
        Request {
            size: self.size,
            fps: self.asked_fps(),
            format: self.camera.pixel_format.and_then(|name| name.code),
            wanted: Wanted::Pictures,
        }
    }
}

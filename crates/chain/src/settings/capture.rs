//! `[capture]`: source and pace of the frames.

use crate::settings::CameraSettings;
use lariat_capture::{
    CameraOptions, FileOptions, FollowOptions, Pace, PipeOptions, Range, RawFrames, RenderOptions,
    Request, Source, Wanted, names_a_camera, names_a_recording, names_a_video, video_fps,
};
use std::path::PathBuf;
use std::time::Duration;

/// Rate at which frames are sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fps {
    /// This many frames per second.
    PerSecond(f64),
    /// As fast as frames can be made.
    Max,
    /// The best rate of a camera, the original rate of a video or recording, and [`USUAL_FPS`]
    /// otherwise.
    Auto,
}

/// Frame rate of sources that have no rate of their own.
pub const USUAL_FPS: f64 = 30.0;

/// Source and pace of the frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// `rendered`, `simulated` or `external` alone, `-` (standard input), or the paths of pictures,
    /// folders or a video.
    pub source: Vec<PathBuf>,
    /// When frames are due.
    pub fps: Fps,
    /// Width and height of the camera's or the rendered picture, px. Without it, rendered pictures
    /// have the default size, and a camera uses a size near that.
    pub size: Option<[u32; 2]>,
    /// Seed of the rendered or simulated rope.
    pub seed: u64,
    /// True if files start again after the last one.
    pub looped: bool,
    /// The part of the files that is shown.
    pub range: Range,
    /// True if the chain waits for more pictures in a folder.
    pub follow: bool,
    /// Topic of the images in a recording that has several cameras.
    pub topic: Option<String>,
    /// Folder of depth images that belong to the pictures.
    pub depth_images: Option<PathBuf>,
    /// A depth camera in addition to the camera.
    pub depth_source: Option<PathBuf>,
    /// Maximum time between a frame and its depth image from that camera. If not set, it follows
    /// from the depth camera's period.
    pub depth_within: Option<Duration>,
    /// Settings of the camera.
    pub camera: CameraSettings,
}

/// Default width and height of the rendered picture, px.
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
    /// Returns the source unless it is simulated. The truth of rendered ropes has `points` points.
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
            // The rope moves at its own speed, regardless of the frame rate.
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

    /// Returns the options for reading files.
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

    /// Returns the format of frames in a pipe, if it is not a video.
    fn raw_frames(&self) -> Option<RawFrames> {
        let (size, format) = (self.size?, self.camera.pixel_format?.raw?);
        Some(RawFrames { size, format })
    }

    /// Returns the pace of the frames.
    pub fn pace(&self) -> Pace {
        match self.fps {
            Fps::PerSecond(fps) => Pace::Fps(fps),
            Fps::Max => Pace::Max,
            Fps::Auto => Pace::Fps(self.usual_fps()),
        }
    }

    /// Returns the default frame rate. For a video, this is the video's own rate.
    pub(super) fn usual_fps(&self) -> f64 {
        let video = match &self.source[..] {
            [path] if path.is_file() => video_fps(path),
            _ => None,
        };
        video.map_or(USUAL_FPS, |fps| fps / self.range.every.get() as f64)
    }

    /// Returns the size that frames most likely have, px.
    pub fn likely_size(&self) -> [u32; 2] {
        self.size.unwrap_or(USUAL_SIZE)
    }

    /// Returns true if the source is a simulated rope.
    pub fn is_simulated(&self) -> bool {
        self.source[..] == [PathBuf::from("simulated")]
    }

    /// Returns true if the source is the rope that lariat draws.
    pub fn is_rendered(&self) -> bool {
        self.source[..] == [PathBuf::from("rendered")]
    }

    /// Returns true if the source is standard input.
    pub fn is_piped(&self) -> bool {
        self.source[..] == [PathBuf::from("-")]
    }

    /// Returns true if the source is a camera.
    pub fn is_camera(&self) -> bool {
        matches!(&self.source[..], [path] if names_a_camera(path))
    }

    /// Returns true if frames are picture files.
    pub fn is_of_pictures(&self) -> bool {
        let is_drawn = self.is_simulated() || self.is_rendered();
        let is_video = |path: &PathBuf| names_a_video(path);
        !self.has_own_pace() && !is_drawn && !self.source.iter().any(is_video)
    }

    /// Returns true if an external process writes the frames.
    pub fn is_external(&self) -> bool {
        self.source[..] == [PathBuf::from("external")]
    }

    /// Returns true if frames arrive at their own pace by default: from a camera, a followed
    /// folder, a recording or a pipe.
    pub fn has_own_pace(&self) -> bool {
        let is_recording = matches!(&self.source[..], [path] if names_a_recording(path));
        let is_live = self.is_camera() || self.is_piped() || self.is_external();
        is_live || self.follow || is_recording
    }

    /// Returns the options of the depth camera. It should deliver images of its calibration's size,
    /// at the rate of the other camera.
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

    /// Returns the requested frame rate. For a camera, "max" is the same as its best rate.
    fn asked_fps(&self) -> Option<f64> {
        match self.fps {
            Fps::PerSecond(fps) => Some(fps),
            Fps::Max | Fps::Auto => None,
        }
    }

    /// Returns the request to a camera.
    fn request(&self) -> Request {
        Request {
            size: self.size,
            fps: self.asked_fps(),
            format: self.camera.pixel_format.and_then(|name| name.code),
            wanted: Wanted::Pictures,
        }
    }
}

//! `[camera]`: where what a camera sees lies; and which part of its images is looked at.

use crate::calibrated::Calibrated;
use crate::exit::wrong_use;
use crate::inputs;
use crate::picture::Picture;
use crate::settings::Settings;
use anyhow::Result;
use lariat_extract::Region;
use lariat_wire::Unit as Sent;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Value;

/// What descriptors are to come in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Pixels of the image; with a lens calibration, of one without distortion.
    Px,
    /// Millimetres on the plane.
    Mm,
}

pub(super) const UNITS: [(&str, Unit); 2] = [
    (Sent::Pixel.name(), Unit::Px),
    (Sent::Millimeter.name(), Unit::Mm),
];

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Px => Sent::Pixel.name(),
            Self::Mm => Sent::Millimeter.name(),
        })
    }
}

/// `[camera]`: lens and plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// The lens's calibration.
    pub calibration: Option<PathBuf>,
    /// The plane that the rope lies on.
    pub plane: Option<PathBuf>,
    /// Millimetres where a plane is named, if the user says nothing.
    pub unit: Option<Unit>,
    /// The depth camera beside it.
    pub depth: Option<PathBuf>,
    /// The second colour camera beside it, and its rig.
    pub second: Option<PathBuf>,
    /// The rig that this one runs on.
    pub second_rig: Option<String>,
    /// How far from a frame what it saw may be; `None`: three fifths of its period.
    pub second_within: Option<Duration>,
    /// Its pose before a robot.
    pub pose: Option<PathBuf>,
    /// How long after its capture a frame's depth image, or what the second camera saw, is waited for.
    pub depth_deadline: Duration,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            calibration: None,
            plane: None,
            unit: None,
            depth: None,
            second: None,
            second_rig: None,
            second_within: None,
            pose: None,
            depth_deadline: Duration::from_millis(50),
        }
    }
}

impl Camera {
    /// Whether the cameras are those that stand before the simulated rope.
    pub fn is_simulated(&self) -> bool {
        self.depth.as_deref() == Some(Path::new("simulated"))
    }

    /// What is wrong with the files it names, for pictures of this size.
    pub(super) fn problem(&self, picture: [u32; 2]) -> Option<String> {
        let load = Calibrated::load(self).map(|_| ());
        let error = load
            .and_then(|()| Calibrated::beside(self, picture).map(|_| ()))
            .err()?;
        Some(format!("{error:#}"))
    }
}

impl Settings {
    /// Whether calibration and region are for the frames of the source, as far as those are known before they come. For a chain
    /// that is started whole: a stage by itself does not know the source.
    ///
    /// # Errors
    /// They are not.
    pub fn check_frames(&self) -> Result<()> {
        if self.camera == Camera::default() && self.extract.roi.is_none() {
            return Ok(());
        }
        if self.camera.is_simulated() && !self.capture.is_simulated() {
            wrong_use!(
                "depth = \"simulated\" is the simulated rope, lifted: take that source (--source simulated), or name a file of this name by \
                 its folder, too (./simulated)"
            );
        }
        let Some(size) = known_size(self) else {
            return Ok(());
        };
        if let Some(calibrated) = Calibrated::load(&self.camera)? {
            calibrated.mapping(size)?;
        }
        if let Some(Region { x, y, .. }) = self.extract.roi
            && (x >= size[0] as usize || y >= size[1] as usize)
        {
            wrong_use!(
                "the region begins at {x}, {y} and the image has {}×{} pixels: nothing of it is left",
                size[0],
                size[1]
            );
        }
        Ok(())
    }
}

/// The frames' size, where it is known before they come: drawn ones', and the first picture's. What cannot be read is told of
/// elsewhere.
fn known_size(settings: &Settings) -> Option<[u32; 2]> {
    let source = &settings.capture.source;
    if source[..] == [PathBuf::from("rendered")] || settings.capture.is_simulated() {
        return Some(settings.capture.likely_size());
    }
    // A camera has the size that was asked for, or refuses it.
    if settings.capture.is_camera() {
        return settings.capture.size;
    }
    let (pictures, _) = inputs::pictures(source);
    let first = pictures.first().filter(|path| path.is_file())?;
    let picture = Picture::load(first).ok()?;
    Some([picture.width(), picture.height()])
}

/// A region: `[x, y, width, height]`, or `x,y,width,height`.
pub(super) fn region(value: &Value) -> Result<Region, String> {
    let numbers: Vec<Option<usize>> = match value {
        Value::Array(numbers) => numbers
            .iter()
            .map(|n| usize::try_from(n.as_integer()?).ok())
            .collect(),
        Value::String(text) => text.split(',').map(|n| n.trim().parse().ok()).collect(),
        _ => Vec::new(),
    };
    match numbers[..] {
        [Some(x), Some(y), Some(width), Some(height)]
            if width > 0 && height > 0 && [x, y, width, height].iter().all(|n| *n <= 65_536) =>
        {
            Ok(Region { x, y, width, height })
        }
        _ => Err(
            "a region is four whole numbers of pixels, the place of its top left corner, its width and its height (from 1 on): \
             [160, 120, 320, 240] in the file, 160,120,320,240 as a flag"
                .to_owned(),
        ),
    }
}

pub(super) fn region_value(region: &Region) -> Value {
    let Region {
        x,
        y,
        width,
        height,
    } = *region;
    Value::Array(
        [x, y, width, height]
            .map(|n| Value::Integer(n as i64))
            .into(),
    )
}

//! `[camera]`: mapping from the camera's images to the world, and the region of the images that is
//! processed.

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

/// Unit of descriptors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Pixels of the image or, with a lens calibration, of the undistorted image.
    Px,
    /// Millimeters on the plane.
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
    /// Calibration file of the lens.
    pub calibration: Option<PathBuf>,
    /// File with the plane on which the rope lies.
    pub plane: Option<PathBuf>,
    /// Unit of descriptors. By default, millimeters if a plane is named.
    pub unit: Option<Unit>,
    /// Calibration file of the depth camera.
    pub depth: Option<PathBuf>,
    /// Calibration file of the second color camera.
    pub second: Option<PathBuf>,
    /// Rig of the second color camera.
    pub second_rig: Option<String>,
    /// Maximum time between a frame and the second camera's view. `None` means three fifths of that
    /// camera's period.
    pub second_within: Option<Duration>,
    /// File with the camera's pose relative to a robot.
    pub pose: Option<PathBuf>,
    /// Maximum time from a frame's capture to the arrival of its depth image or second view.
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
    /// Returns true if the cameras are those of the simulated rope.
    pub fn is_simulated(&self) -> bool {
        self.depth.as_deref() == Some(Path::new("simulated"))
    }

    /// Returns an error in the files that the settings name, for pictures of this size.
    pub(super) fn problem(&self, picture: [u32; 2]) -> Option<String> {
        let load = Calibrated::load(self).map(|_| ());
        let error = load
            .and_then(|()| Calibrated::beside(self, picture).map(|_| ()))
            .err()?;
        Some(format!("{error:#}"))
    }
}

impl Settings {
    /// Checks that calibration and region fit the source's frames, as far as their size is known in
    /// advance. This is for a chain that is started as a whole, because a single stage does not
    /// know the source.
    ///
    /// # Errors
    /// Returns an error if they do not fit.
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

/// Returns the frame size if it is known in advance: that of a drawn rope, or of the first picture.
/// Another check reports an unreadable picture.
fn known_size(settings: &Settings) -> Option<[u32; 2]> {
    let source = &settings.capture.source;
    if source[..] == [PathBuf::from("rendered")] || settings.capture.is_simulated() {
        return Some(settings.capture.likely_size());
    }
    // A camera delivers the requested size or refuses it.
    if settings.capture.is_camera() {
        return settings.capture.size;
    }
    let (pictures, _) = inputs::pictures(source);
    let first = pictures.first().filter(|path| path.is_file())?;
    let picture = Picture::load(first).ok()?;
    Some([picture.width(), picture.height()])
}

/// Reads a region: `[x, y, width, height]`, or `x,y,width,height`.
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

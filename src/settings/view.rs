//! `[camera]`: where what a camera sees lies; and which part of its images is looked at.

use crate::calibrated::Calibrated;
use crate::settings::Settings;
use lariat_extract::Region;
use std::fmt;
use std::path::PathBuf;
use toml::Value;

/// What descriptors are to come in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unit {
    /// Pixels of the image; with a lens calibration, of one without distortion.
    Px,
    /// Millimetres on the plane.
    Mm,
}

pub(super) const UNITS: [(&str, Unit); 2] = [("px", Unit::Px), ("mm", Unit::Mm)];

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Px => "px",
            Self::Mm => "mm",
        })
    }
}

/// `[camera]`: lens and plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Camera {
    /// The lens's calibration.
    pub(crate) calibration: Option<PathBuf>,
    /// The plane that the rope lies on.
    pub(crate) plane: Option<PathBuf>,
    /// Millimetres where a plane is named, if the user says nothing.
    pub(crate) unit: Option<Unit>,
}

impl Camera {
    /// What is wrong with the files it names or, as far as that is known already, with the frames' size.
    pub(super) fn problem(settings: &Settings) -> Option<String> {
        let calibrated = match Calibrated::load(&settings.camera) {
            Ok(calibrated) => calibrated?,
            Err(error) => return Some(format!("{error:#}")),
        };
        let rendered = settings.capture.source == [PathBuf::from("rendered")];
        let size = rendered.then(|| settings.capture.likely_size())?;
        calibrated
            .mapping(size)
            .err()
            .map(|error| format!("{error:#}"))
    }
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

pub(super) fn region_value(region: Region) -> Value {
    let Region {
        x,
        y,
        width,
        height,
    } = region;
    Value::Array(
        [x, y, width, height]
            .map(|n| Value::Integer(n as i64))
            .into(),
    )
}

/// What is wrong with the region, if that is known before the first frame.
pub(super) fn region_problem(settings: &Settings) -> Option<String> {
    let region = settings.extract.roi?;
    let rendered = settings.capture.source == [PathBuf::from("rendered")];
    let [width, height] = settings.capture.likely_size();
    let outside = region.x >= width as usize || region.y >= height as usize;
    (rendered && outside).then(|| {
        format!(
            "the region begins at {}, {} and the image has {width}×{height} pixels: nothing of it is left",
            region.x, region.y
        )
    })
}

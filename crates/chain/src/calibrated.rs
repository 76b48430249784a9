//! The calibration that `[camera]` names: the lens, the plane, and the unit of descriptors.

use crate::plane_file;
use crate::settings;
use anyhow::{Context, Result, bail};
use lariat_camera::{Camera, DepthCalibration, Mapping, Plane, Pose, SecondCalibration};
use lariat_capture::SpaceCameras;
use lariat_wire::{Rig, Unit, members};
use std::path::{Path, PathBuf};
use toml::Table;

/// A lens, a plane, or both.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrated {
    camera: Option<Camera>,
    plane: Option<Plane>,
    unit: Unit,
    /// Says which camera was chosen if the calibration file contains several.
    notice: Option<String>,
}

/// A second device next to the color camera, used to compute rope positions in 3-D.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beside {
    /// A depth camera.
    Depth(DepthCalibration),
    /// A second color camera.
    Second(SecondCalibration),
}

impl Calibrated {
    /// Reads the files that the settings name. Returns `None` if points stay in image pixels.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read or is invalid, or if millimeters are requested
    /// without a plane.
    pub fn load(settings: &settings::Camera) -> Result<Option<Self>> {
        let read = settings.calibration.as_deref();
        let read = read.map(read_first).transpose()?;
        let (camera, notice) = match read {
            Some((camera, notice)) => (Some(camera), notice),
            None => (None, None),
        };
        // Read the plane even if it is not used now, so that errors in it are reported.
        let plane = match &settings.plane {
            Some(path) => Some(plane_file::read(path, camera.as_ref())?),
            None => None,
        };
        let mm = settings.unit.unwrap_or(if plane.is_some() {
            settings::Unit::Mm
        } else {
            settings::Unit::Px
        }) == settings::Unit::Mm;
        let (plane, unit) = match plane {
            None if mm => bail!(
                "unit = \"mm\" needs the plane that the rope lies on: make it with `lariat calibrate plane`, and name it \
                 (--plane FILE)"
            ),
            Some(plane) if mm => (Some(plane), Unit::Millimeter),
            _ if camera.is_none() => return Ok(None),
            _ => (None, Unit::IdealPixel),
        };
        Ok(Some(Self {
            camera,
            plane,
            unit,
            notice,
        }))
    }

    /// Reads the calibration of the second device and the camera's pose relative to the robot.
    /// Returns `None` if the settings name neither a depth camera nor a second color camera. A
    /// simulated device has a built-in calibration for pictures of this size.
    ///
    /// # Errors
    /// Fails like [`load`](Self::load). Also fails if the settings name both devices, or if the
    /// color camera is not calibrated.
    pub fn beside(
        settings: &settings::Camera,
        picture: [u32; 2],
    ) -> Result<Option<(Beside, Option<Pose>)>> {
        let read = |path: &Path, what: &str| {
            crate::bounded::read_text(path)
                .with_context(|| format!("cannot read {what} {}", path.display()))
        };
        let pose = match &settings.pose {
            None => None,
            Some(path) => {
                let text = read(path, "the camera's pose")?;
                let pose = Pose::from_yaml(&text).with_context(|| path.display().to_string())?;
                Some(pose)
            }
        };
        let (path, what) = match (&settings.depth, &settings.second) {
            (None, None) => return Ok(None),
            (Some(_), Some(_)) => {
                bail!("ropes are found in space by depth or by a second camera: name one of them")
            }
            (Some(path), None) => (path, "depth"),
            (None, Some(path)) => (path, "a second camera"),
        };
        if settings.is_simulated() {
            let own = SpaceCameras::new(picture);
            let depth = DepthCalibration::from_yaml(&own.depth, Camera::from_yaml(&own.color)?)?;
            let own_pose = Pose::from_yaml(&own.pose)?;
            return Ok(Some((Beside::Depth(depth), pose.or(Some(own_pose)))));
        }
        let Some(color) = &settings.calibration else {
            bail!(
                "{what} needs the colour camera's own calibration, too: name it (--calibration FILE)"
            );
        };
        let color = read_camera(color)?;
        let beside = if settings.depth.is_some() {
            let text = read(path, "the depth camera's calibration")?;
            DepthCalibration::from_yaml(&text, color).map(Beside::Depth)
        } else {
            let text = read(path, "the second camera's calibration")?;
            SecondCalibration::from_yaml(&text, color).map(Beside::Second)
        };
        let beside = beside.with_context(|| path.display().to_string())?;
        Ok(Some((beside, pose)))
    }

    /// Says which camera was chosen, if the calibration file contains several.
    pub fn notice(&self) -> Option<&str> {
        self.notice.as_deref()
    }

    /// Returns the unit of points.
    pub fn unit(&self) -> Unit {
        self.unit
    }

    /// Creates the mapping for points in frames of this size.
    ///
    /// # Errors
    /// Returns an error if the calibration or the plane is for another image size.
    pub fn mapping(&self, [width, height]: [u32; 2]) -> Result<Mapping> {
        Mapping::new(self.camera.as_ref(), self.plane.as_ref(), [width, height]).with_context(
            || format!("the calibration does not fit frames of {width}×{height} pixels"),
        )
    }
}

/// Reads a lens calibration.
///
/// # Errors
/// Returns an error if the file cannot be read or is not a calibration.
pub fn read_camera(path: &Path) -> Result<Camera> {
    read_first(path).map(|(camera, _)| camera)
}

/// Reads the lens calibration of the first camera in a file. Also returns a notice if the file
/// contains several cameras.
fn read_first(path: &Path) -> Result<(Camera, Option<String>)> {
    let shown = path.display();
    let text = crate::bounded::read_text(path)
        .with_context(|| format!("cannot read the calibration {shown} (text of OpenCV, ROS, Kalibr and others; of NumPy's arrays write mtx and dist as JSON)"))?;
    let (camera, notice) = Camera::first_of(&text).with_context(|| shown.to_string())?;
    Ok((camera, notice.map(|notice| format!("{shown}: {notice}"))))
}

/// Returns the path of the lens calibration that a running rig uses, as its fit stage announces it.
/// Returns `None` if the rig uses none.
pub fn calibration_of(rig: &Rig) -> Option<PathBuf> {
    let members = members().ok()?;
    let fit = members
        .iter()
        .find(|member| member.rig == rig.as_str() && member.stage == "fit")?;
    let settings: Table = fit.settings.parse().ok()?;
    let path = settings.get("camera")?.get("calibration")?.as_str()?;
    Some(fit.folder.join(path))
}

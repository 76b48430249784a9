//! What `[camera]` names, read: the lens, the plane, and the unit that descriptors come in.

use crate::plane_file;
use crate::settings;
use anyhow::{Context, Result, bail};
use lariat_camera::{Camera, DepthCalibration, Mapping, Plane, Pose};
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
}

impl Calibrated {
    /// Reads the files that the settings name; `None` if points are to stay where they are seen.
    ///
    /// # Errors
    /// A file that cannot be read or says what cannot be; millimetres without a plane.
    pub fn load(settings: &settings::Camera) -> Result<Option<Self>> {
        let camera = settings
            .calibration
            .as_deref()
            .map(read_camera)
            .transpose()?;
        // What is in it is looked at even if it is not used now.
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
        }))
    }

    /// The depth camera beside the colour one, and the colour camera's pose before the robot; `None` if the settings name none. What
    /// is simulated has its own, for pictures of this size.
    ///
    /// # Errors
    /// As [`load`](Self::load); no calibration of the colour camera.
    pub fn depth(
        settings: &settings::Camera,
        picture: [u32; 2],
    ) -> Result<Option<(DepthCalibration, Option<Pose>)>> {
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
        let Some(path) = &settings.depth else {
            return Ok(None);
        };
        if settings.is_simulated() {
            let own = SpaceCameras::new(picture);
            let depth = DepthCalibration::from_yaml(&own.depth, Camera::from_yaml(&own.color)?)?;
            let own_pose = Pose::from_yaml(&own.pose)?;
            return Ok(Some((depth, pose.or(Some(own_pose)))));
        }
        let Some(color) = &settings.calibration else {
            bail!(
                "depth needs the colour camera's own calibration, too: name it (--calibration FILE)"
            );
        };
        let color = read_camera(color)?;
        let text = read(path, "the depth camera's calibration")?;
        let depth = DepthCalibration::from_yaml(&text, color)
            .with_context(|| path.display().to_string())?;
        Ok(Some((depth, pose)))
    }

    /// What points come in.
    pub fn unit(&self) -> Unit {
        self.unit
    }

    /// The way of points of frames of this size.
    ///
    /// # Errors
    /// The calibration or the plane is for other images.
    pub fn mapping(&self, [width, height]: [u32; 2]) -> Result<Mapping> {
        Mapping::new(self.camera.as_ref(), self.plane.as_ref(), [width, height]).with_context(
            || format!("the calibration does not fit frames of {width}×{height} pixels"),
        )
    }
}

/// Reads a lens calibration.
///
/// # Errors
/// It cannot be read, or is not a calibration.
pub fn read_camera(path: &Path) -> Result<Camera> {
    let shown = path.display();
    let text = crate::bounded::read_text(path)
        .with_context(|| format!("cannot read the calibration {shown}"))?;
    Camera::from_yaml(&text).with_context(|| shown.to_string())
}

/// The file of the lens calibration that a running rig goes by, as its fit says of itself; `None` if there is none.
pub fn calibration_of(rig: &Rig) -> Option<PathBuf> {
    let members = members().ok()?;
    let fit = members
        .iter()
        .find(|member| member.rig == rig.as_str() && member.stage == "fit")?;
    let settings: Table = fit.settings.parse().ok()?;
    let path = settings.get("camera")?.get("calibration")?.as_str()?;
    Some(fit.folder.join(path))
}

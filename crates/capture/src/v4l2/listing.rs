//! Lists all cameras of this machine with all their properties.

use std::path::PathBuf;

use super::controls::Control;
use super::device::Device;
use super::error::CameraError;
use super::negotiate::{DEFAULT_SIZE, DEPTHS, READABLE};
use super::nodes;
use super::offers::{FormatOffer, FourCc};

/// A camera, or a node that may be one but cannot be queried.
#[derive(Debug)]
pub struct ListedCamera {
    /// Its node, such as `/dev/video0`.
    pub path: PathBuf,
    /// Names under `/dev/v4l/by-id` and `/dev/v4l/by-path`, which stay the same when the node's
    /// number changes.
    pub lasting_names: Vec<PathBuf>,
    /// Its description, or why it cannot be queried.
    pub about: Result<AboutCamera, CameraError>,
}

/// A camera's description of itself.
#[derive(Debug, Clone)]
pub struct AboutCamera {
    /// Its name.
    pub name: String,
    /// The kernel's driver.
    pub driver: String,
    /// The port that it is plugged into.
    pub bus: String,
    /// True if it has the multi-planar interface.
    pub has_planes: bool,
    /// All pixel formats, with sizes and rates.
    pub formats: Vec<FormatOffer>,
    /// All controls.
    pub controls: Vec<Control>,
}

impl FourCc {
    /// Returns whether lariat reads this pixel format, as a picture or as depth.
    pub fn is_readable(self) -> bool {
        READABLE.contains(&self.0) || DEPTHS.contains(&self.0)
    }
}

/// Lists all cameras, and all nodes that this user may not open, in the order of their numbers.
/// Changes nothing.
pub fn list_cameras() -> Vec<ListedCamera> {
    let is_of_interest = |about: &Result<AboutCamera, CameraError>| {
        // Codecs, metadata and outputs are not cameras, and need no explanation in this list.
        !matches!(
            about,
            Err(CameraError::NotACamera { .. } | CameraError::Absent { .. })
        )
    };
    nodes::all()
        .into_iter()
        .map(|node| ListedCamera {
            about: about(&node.path),
            lasting_names: nodes::lasting_names(&node.path),
            path: node.path,
        })
        .filter(|camera| is_of_interest(&camera.about))
        .collect()
}

fn about(path: &std::path::Path) -> Result<AboutCamera, CameraError> {
    let device = Device::open(path)?;
    let about = device.about();
    Ok(AboutCamera {
        name: about.card.clone(),
        driver: about.driver.clone(),
        bus: about.bus.clone(),
        has_planes: device.has_planes(),
        formats: device.offers(DEFAULT_SIZE, |_| true),
        controls: device.controls(),
    })
}

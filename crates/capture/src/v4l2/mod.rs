//! Cameras, through the kernel's Video4Linux2 interface.

mod camera;
mod controls;
mod device;
mod driver;
mod error;
mod hotplug;
mod listing;
mod losses;
mod negotiate;
mod nodes;
mod offers;
mod port;
mod recovery;
mod setup;
mod silence;
mod stamp;
mod stream;
mod sys;

pub use camera::Io;
pub use controls::{Control, ControlError, ControlKind, ControlSettings};
pub use error::CameraError;
pub use listing::{AboutCamera, ListedCamera, list_cameras};
pub use negotiate::{DEFAULT_SIZE, NoCommonFormat, Request, Wanted};
pub use nodes::names_a_camera;
pub use offers::{FormatOffer, FourCc, Interval, Rates, SizeOffer, SizeRange};
pub use port::CameraOptions;
pub(crate) use port::open_camera;

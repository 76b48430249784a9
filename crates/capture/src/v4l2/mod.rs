//! Cameras, by the kernel's Video4Linux2 interface.

#![allow(
    dead_code,
    reason = "used by the camera as a source, which is built on this"
)]

mod controls;
mod device;
mod error;
mod listing;
mod negotiate;
mod nodes;
mod offers;
mod setup;
mod sys;

pub use controls::{Control, ControlError, ControlKind, ControlSettings};
pub use error::CameraError;
pub use listing::{AboutCamera, ListedCamera, list_cameras};
pub use negotiate::{DEFAULT_SIZE, NoCommonFormat, Request};
pub use nodes::names_a_camera;
pub use offers::{FormatOffer, FourCc, Interval, Rates, SizeOffer, SizeRange};

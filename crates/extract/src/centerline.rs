//! The fourth step: turns a strand into samples along the middle of the rope, with subpixel
//! accuracy. The samples run from tip to tip, and each stores the rope's width at its place.

mod centerliner;
pub(crate) mod connector;
mod contrast;
mod edge;
pub(crate) mod extender;
pub(crate) mod extrapolate;
pub(crate) mod line;
pub(crate) mod path;
pub(crate) mod section;
pub(crate) mod shading;
pub(crate) mod smooth;
pub(crate) mod source;
mod tip_contact;

pub(crate) use centerliner::Centerliner;

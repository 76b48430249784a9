//! The fourth step: from a strand to samples along the middle of the rope, between pixels. The
//! samples run from tip to tip, and each has the rope's width there.

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

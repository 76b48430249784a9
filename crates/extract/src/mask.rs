//! The first step: from an image to one bit per pixel, rope or not, and to the difference of each
//! pixel from the table. The automatic mask also reports its doubts.

pub(crate) mod background;
pub(crate) mod cast;
mod diagnosis;
pub(crate) mod difference;
mod evened;
mod faint;
pub(crate) mod hsv;
mod hysteresis;
mod level;
mod masker;
mod meaning;
mod neural;
mod outline;
mod pattern;
mod rims;
mod rope_mask;
mod seams;
mod seeker;
pub(crate) mod shadow;
mod smoothed;
mod threshold;
mod widths;

pub(crate) use masker::Masker;
pub use masker::{MaskError, mask_of};
pub use meaning::{MaskLevels, mask_levels};
pub(crate) use rope_mask::{MaskSource, RopeMask};

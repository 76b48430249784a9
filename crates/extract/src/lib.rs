//! From an image to the ordered centerlines of the ropes in it.

mod extractor;
mod image;
mod options;
mod scene;

pub use extractor::{Extractor, Step};
pub use image::{Image, ImageError, PixelFormat};
pub use options::{HsvRange, Mask, Options, OptionsError};
pub use scene::{Crossing, Curve, Scene, Status};

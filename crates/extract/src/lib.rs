//! From an image to the ordered centerlines of the ropes in it.

mod background;
mod bits;
mod centerline;
mod color;
mod components;
mod crossings;
mod difference;
mod extractor;
mod graph;
mod hsv;
mod image;
mod line;
mod mask;
mod options;
mod overlaps;
mod pairing;
mod plane;
mod scene;
mod section;
mod skeleton;
mod smooth;
mod strands;
mod thin;
mod threshold;
mod track;
mod unroll;
mod vec2;
mod zones;

pub use extractor::{Extractor, Step};
pub use image::{Image, ImageError, PixelFormat};
pub use options::{HsvRange, Mask, Options, OptionsError};
pub use scene::{Crossing, Curve, Scene, Status};

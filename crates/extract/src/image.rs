//! Camera images in their own pixel formats. Provides colors at positions, planes of one byte per
//! pixel, values along lines through them, and the vectorized loops over all pixels.

pub(crate) mod color;
mod fetch;
pub(crate) mod gray;
pub(crate) mod kernels;
pub(crate) mod ray;
mod region;
pub(crate) mod unpack;
mod view;

pub use region::Region;
pub use view::{Image, ImageError, PixelFormat};

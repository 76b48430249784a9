//! What a camera sees. In come its bytes in its own pixel format; out come colors at places, pictures of one byte a pixel
//! and the values along lines through them, and the loops over all pixels that are written for wide registers.

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

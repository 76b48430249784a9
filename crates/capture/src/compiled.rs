//! Compiles the reading and writing of picture files once, in a build for tests. Both functions are
//! generic: without these references, every test with pictures would compile all codecs again. In a
//! release build, crates share no generic code.

use image::{DynamicImage, ImageResult, RgbImage};
use std::path::Path;

#[used]
static OPEN: fn(&'static Path) -> ImageResult<DynamicImage> = image::open;

#[used]
static SAVE: fn(&RgbImage, &'static Path) -> ImageResult<()> = RgbImage::save;

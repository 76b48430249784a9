//! Reading and writing picture files by their names, compiled here, once, in a build for tests: both are generic, and without
//! this list every test with pictures compiles all codecs again. In a release crates share no generic code.

use image::{DynamicImage, ImageResult, RgbImage};
use std::path::Path;

#[used]
static OPEN: fn(&'static Path) -> ImageResult<DynamicImage> = image::open;

#[used]
static SAVE: fn(&RgbImage, &'static Path) -> ImageResult<()> = RgbImage::save;

//! A picture file, decoded.

use anyhow::{Context, Result};
use image::{DynamicImage, GrayImage, RgbImage};
use lariat_capture::StillPicture;
use lariat_extract::{Image, ImageError, PixelFormat};
use std::fs::File;
use std::path::Path;

/// A decoded picture: grey if the file is, else RGB, 8 bits a channel.
pub(crate) struct Picture(DynamicImage);

impl Picture {
    /// Reads a PNG or JPEG, whatever its name says, as the chain sees it.
    ///
    /// # Errors
    /// There is no such file, it is no picture, or it is cut off or damaged.
    pub(crate) fn load(path: &Path) -> Result<Self> {
        let shown = path.display();
        File::open(path).with_context(|| format!("cannot open the picture {shown}"))?;
        let about = || format!("{shown} cannot be decoded");
        let StillPicture {
            width,
            height,
            format,
            pixels,
        } = StillPicture::load(path)?;
        let decoded = if format == lariat_wire::PixelFormat::Gray8 {
            GrayImage::from_raw(width, height, pixels).map(DynamicImage::ImageLuma8)
        } else {
            RgbImage::from_raw(width, height, pixels).map(DynamicImage::ImageRgb8)
        };
        decoded.map(Self).with_context(about)
    }

    pub(crate) fn width(&self) -> u32 {
        self.0.width()
    }

    pub(crate) fn height(&self) -> u32 {
        self.0.height()
    }

    /// The picture as the extractor takes it.
    ///
    /// # Errors
    /// It is larger than the extractor takes.
    pub(crate) fn image(&self) -> Result<Image<'_>, ImageError> {
        let (width, height) = (self.width() as usize, self.height() as usize);
        let (channels, format) = match self.0 {
            DynamicImage::ImageLuma8(_) => (1, PixelFormat::Gray8),
            _ => (3, PixelFormat::Rgb8),
        };
        Image::new(self.0.as_bytes(), width, height, channels * width, format)
    }

    /// As one byte a pixel.
    pub(crate) fn into_gray(self) -> Self {
        Self(DynamicImage::ImageLuma8(self.0.into_luma8()))
    }

    pub(crate) fn into_rgb(self) -> RgbImage {
        self.0.into_rgb8()
    }
}

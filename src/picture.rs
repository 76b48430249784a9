//! A picture file, decoded.

use anyhow::{Context, Result};
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageReader, RgbImage};
use lariat_extract::{Image, ImageError, PixelFormat};
use std::path::Path;

/// A decoded picture: grey if the file is, else RGB, 8 bits a channel.
pub(crate) struct Picture(DynamicImage);

impl Picture {
    /// Reads a PNG or JPEG, whatever its name says, turned as its EXIF orientation asks.
    ///
    /// # Errors
    /// There is no such file, it is no picture, or it is cut off or damaged.
    pub(crate) fn load(path: &Path) -> Result<Self> {
        let shown = path.display();
        let reader = ImageReader::open(path)
            .and_then(ImageReader::with_guessed_format)
            .with_context(|| format!("cannot open the picture {shown}"))?;
        let about = || format!("cannot read {shown} as a PNG or JPEG picture");
        let mut decoder = reader.into_decoder().with_context(about)?;
        // A damaged note beside the pixels does not spoil them.
        let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
        let mut decoded = DynamicImage::from_decoder(decoder).with_context(about)?;
        decoded.apply_orientation(orientation);
        Ok(Self(match decoded {
            DynamicImage::ImageLuma8(_) | DynamicImage::ImageRgb8(_) => decoded,
            other => DynamicImage::ImageRgb8(other.into_rgb8()),
        }))
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

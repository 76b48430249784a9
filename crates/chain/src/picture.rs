//! A decoded picture, from a file or from a frame of any source.

use anyhow::{Context, Result};
use image::RgbImage;
use lariat_capture::{Frame, StillPicture};
use lariat_extract::{Image, ImageError};
use lariat_wire::PixelFormat;
use std::fs::File;
use std::path::Path;

use crate::pipeline::pixel_format;

/// A decoded picture with 8 bits per channel if it comes from a file. It is gray if the file is
/// gray, otherwise RGB.
pub struct Picture {
    width: u32,
    height: u32,
    stride: u32,
    format: PixelFormat,
    pixels: Vec<u8>,
}

impl Picture {
    /// Reads a picture file as the chain sees it, whatever its name. Warns if the file does not
    /// define the meaning of its samples.
    ///
    /// # Errors
    /// Returns an error if the file does not exist, is not a picture, or is truncated or damaged.
    pub fn load(path: &Path) -> Result<Self> {
        let shown = path.display();
        File::open(path).with_context(|| format!("cannot open the picture {shown}"))?;
        let StillPicture {
            width,
            height,
            format,
            pixels,
            news,
        } = StillPicture::load(path)?;
        if let Some(news) = news {
            tracing::warn!("{news}");
        }
        Ok(Self {
            width,
            height,
            stride: format.row_bytes(width) as u32,
            format,
            pixels,
        })
    }

    /// Creates a picture from a frame and its bytes.
    pub fn of(frame: &Frame, pixels: Vec<u8>) -> Self {
        Self {
            width: frame.width,
            height: frame.height,
            stride: frame.stride,
            format: frame.format,
            pixels,
        }
    }

    /// Returns the number of pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the picture as input for the extractor.
    ///
    /// # Errors
    /// Returns an error if the picture is larger than the extractor accepts.
    pub fn image(&self) -> Result<Image<'_>, ImageError> {
        let [width, height, stride] =
            [self.width, self.height, self.stride].map(|length| length as usize);
        Image::new(
            &self.pixels,
            width,
            height,
            stride,
            pixel_format(self.format),
        )
    }

    /// Converts the picture to red, green and blue.
    pub fn into_rgb(self) -> RgbImage {
        let (width, height) = (self.width, self.height);
        let pixels = match self.format {
            // Pictures from files can be of any size, so they bypass the extractor's limit.
            PixelFormat::Rgb8 if self.stride == 3 * width => self.pixels,
            PixelFormat::Gray8 if self.stride == width => {
                self.pixels.iter().flat_map(|&level| [level; 3]).collect()
            }
            _ => self.image().map(|image| image.to_rgb()).unwrap_or_default(),
        };
        RgbImage::from_raw(width, height, pixels).unwrap_or_else(|| RgbImage::new(width, height))
    }
}

//! Pictures: the input of the extractor, and the background of a drawing.

use base64::prelude::{BASE64_STANDARD, Engine as _};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::imageops::{self, FilterType as Resampling};
use image::{ExtendedColorType, ImageEncoder, RgbImage};
use lariat_extract::{Image, ImageError, PixelFormat};

use crate::PaperError;

/// Longest side of a background picture: enough for half the page's width.
const SHOWN_PX: u32 = 480;
/// Levels between two shades of a background picture. Quantization hides a camera's noise and keeps
/// the PNG small.
const SHADE_STEP: u8 = 6;

/// Share of each pixel's darkness that a background picture keeps.
const PALENESS: f32 = 0.55;

/// A picture: red, green and blue of each pixel, row by row, without padding.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Name of the picture in the report.
    pub name: String,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// `3 × width × height` bytes.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// Returns the picture as an image for the extractor.
    ///
    /// # Errors
    /// Its size does not match its bytes, or is larger than the extractor accepts.
    pub(crate) fn image(&self) -> Result<Image<'_>, ImageError> {
        Image::new(
            &self.rgb,
            self.width,
            self.height,
            3 * self.width,
            PixelFormat::Rgb8,
        )
    }

    fn spoiled(&self) -> PaperError {
        let Self {
            name,
            width,
            height,
            ..
        } = self;
        PaperError::Picture(format!(
            "the picture {name} cannot be shown: its {} bytes are not {width}×{height} pixels of three",
            self.rgb.len()
        ))
    }

    /// Returns a small PNG as a `data:` URI, in few pale shades, so that drawings over it stand
    /// out.
    pub(crate) fn data_uri(&self) -> Result<String, PaperError> {
        let (width, height) = (self.width as u32, self.height as u32);
        let whole =
            RgbImage::from_raw(width, height, self.rgb.clone()).ok_or_else(|| self.spoiled())?;
        let scale = (f64::from(SHOWN_PX) / f64::from(width.max(height))).min(1.0);
        let side = |px: u32| ((f64::from(px) * scale).round() as u32).max(1);
        let mut small = imageops::resize(&whole, side(width), side(height), Resampling::Triangle);
        for value in small.iter_mut() {
            let pale = 255.0 - PALENESS * (255.0 - f32::from(*value));
            let shade = (pale / f32::from(SHADE_STEP)).round() * f32::from(SHADE_STEP);
            *value = shade.clamp(0.0, 255.0) as u8;
        }
        let mut png = Vec::new();
        PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive)
            .write_image(
                &small,
                small.width(),
                small.height(),
                ExtendedColorType::Rgb8,
            )
            .map_err(|_| self.spoiled())?;
        Ok(format!(
            "data:image/png;base64,{}",
            BASE64_STANDARD.encode(&png)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_picture_is_shown_small() {
        let picture = Picture {
            name: "grey".to_owned(),
            width: 960,
            height: 720,
            rgb: vec![128; 3 * 960 * 720],
        };
        let uri = picture.data_uri().unwrap();
        assert!(uri.starts_with("data:image/png;base64,iVBORw0KGgo"));
        assert!(uri.len() < 6000, "{}", uri.len());
    }
}

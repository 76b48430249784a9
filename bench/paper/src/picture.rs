//! Pictures: what is looked at, and how it is shown behind a drawing.

use base64::prelude::{BASE64_STANDARD, Engine as _};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::imageops::{self, FilterType as Resampling};
use image::{ExtendedColorType, ImageEncoder, RgbImage};
use lariat_extract::{Image, ImageError, PixelFormat};

use crate::PaperError;

/// The longest side of a picture behind a drawing: enough for half of a page's width.
const SHOWN_PX: u32 = 480;
/// Levels between two shades of a shown picture: a camera's noise disappears in them, and a PNG of it is small.
const SHADE_STEP: u8 = 6;

/// How much of the darkness is left.
const PALENESS: f32 = 0.55;

/// A picture: red, green and blue of each pixel, row by row, without padding.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// What it is called in the report.
    pub name: String,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `3 × width × height` bytes.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// As the extractor takes it.
    ///
    /// # Errors
    /// Its size is not what its bytes say, or larger than the extractor takes.
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

    /// A small PNG of it as a `data:` URI, in few and pale shades, so that what is drawn on it stands out.
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

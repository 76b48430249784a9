//! A picture file, decoded and upright.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use anyhow::{Context, Result};
use image::{DynamicImage, ImageDecoder, ImageReader};

/// Reads a PNG or JPEG, independent of its file name. Applies its EXIF orientation, as every viewer
/// does.
///
/// # Errors
/// The file does not exist, is not a picture, or is damaged.
pub(super) fn load(path: &Path) -> Result<DynamicImage> {
    let shown = path.display();
    let unread = || format!("cannot open the picture {shown}");
    let bytes = fs::read(path).with_context(unread)?;
    let reader = ImageReader::new(Cursor::new(&bytes[..]))
        .with_guessed_format()
        .with_context(unread)?;
    let about = || format!("cannot read {shown} as a PNG or JPEG picture");
    let mut decoder = reader.into_decoder().with_context(about)?;
    // Damaged metadata does not invalidate the pixels.
    let orientation = decoder.orientation().ok();
    let mut picture = DynamicImage::from_decoder(decoder).with_context(about)?;
    if let Some(orientation) = orientation {
        picture.apply_orientation(orientation);
    }
    Ok(picture)
}

//! Traces a picture that was dropped on the page, as `lariat trace` would: with the settings of the
//! chain that is shown, or with the defaults.

use std::io::{Cursor, Write as _};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result, ensure};
use image::ImageReader;
use lariat_chain::picture::Picture;
use lariat_chain::pipeline::{CurveFitter, FrameExtractor, FrameView};
use lariat_chain::settings::{Camera, Settings};
use lariat_extract::Mask;
use lariat_record::Losses;
use lariat_wire::{Centerlines, Descriptors, FrameHeader, PixelFormat, SourceKind};
use tempfile::NamedTempFile;

use crate::moment::{Image, Moment};

/// Maximum number of pixels of a picture: three times those of a 4K camera.
const MOST_PIXELS: u64 = 25_000_000;
/// Held while a picture is traced, because each takes a few hundred megabytes.
static TRACING: Mutex<()> = Mutex::new(());

/// Number of a moment that belongs to no frame.
const NUMBER: u64 = 0;

/// Traces a picture file with these settings.
///
/// # Errors
/// Fails if the file is not a picture, or cannot be traced.
pub(crate) fn trace(file: &[u8], mut settings: Settings) -> Result<Moment> {
    let _one = TRACING.lock().unwrap_or_else(PoisonError::into_inner);
    require_moderate(file)?;
    // Curves are drawn over the picture, the camera is unknown, and external masks do not exist.
    settings.camera = Camera::default();
    settings.fit.filter = false;
    if settings.extract.mask == Mask::External {
        settings.extract.mask = Mask::Auto;
    }
    let mut kept = NamedTempFile::new().context("there is no room for the picture")?;
    kept.write_all(file)
        .context("there is no room for the picture")?;
    let picture = Picture::load(kept.path())
        .ok()
        .context("the dropped file is not a picture that can be read")?;
    let picture = picture.into_rgb();
    let (width, height) = picture.dimensions();
    let header = FrameHeader {
        width,
        height,
        stride: 3 * width,
        pixel_format: PixelFormat::Rgb8 as u32,
        source: SourceKind::Files as u32,
        ..FrameHeader::default()
    };
    let bytes = picture.into_raw();
    let mut extractor = FrameExtractor::new(&settings.extract)?;
    let mut seen = Box::new(Centerlines::EMPTY);
    let part = extractor.part(FrameView::new(&header, &bytes).image()?)?;
    let scene = extractor.extract(&part, None, 0, &mut |_| {}, &mut seen)?;
    let notice = scene.notice;
    let notice = notice.map(|notice| extractor.sentence(notice));
    let mut curves = CurveFitter::new(&settings)?;
    curves.turn_to([width, height])?;
    let mut shapes = Box::new(Descriptors::EMPTY);
    curves.answer(&seen, &mut shapes);
    (shapes.width, shapes.height) = (width, height);
    let image = Image { header, bytes };
    let mut moment = Moment::new(NUMBER, Some(image), Some(seen), shapes, Losses::default());
    moment.notice = notice;
    Ok(moment)
}

/// Rejects a picture that would take too much memory: a small file may decode to many gigabytes.
fn require_moderate(file: &[u8]) -> Result<()> {
    let reader = ImageReader::new(Cursor::new(file)).with_guessed_format()?;
    // A file without a readable size fails when it is decoded.
    let (width, height) = reader.into_dimensions().unwrap_or_default();
    ensure!(
        u64::from(width) * u64::from(height) <= MOST_PIXELS,
        "the picture has {width}×{height} pixels, and the page takes at most {} million: `lariat trace FILE` reads larger ones",
        MOST_PIXELS / 1_000_000
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_traced_and_what_is_none_is_refused() {
        let picture =
            std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/rope.png")).unwrap();
        let moment = trace(&picture, Settings::default()).unwrap();
        assert_eq!(moment.descriptors.curves().len(), 1);
        assert!(moment.said().contains("\"ropes\":[{"));
        assert!(trace(b"no picture", Settings::default()).is_err());
        assert!(trace(&picture[..3000], Settings::default()).is_err());
    }

    #[test]
    fn a_small_file_of_a_huge_picture_is_refused_before_it_is_decoded() {
        let mut file = Vec::new();
        let white = image::GrayImage::from_pixel(9000, 3000, image::Luma([255]));
        (white.write_to(&mut Cursor::new(&mut file), image::ImageFormat::Png)).unwrap();
        let Err(why) = trace(&file, Settings::default()) else {
            panic!("it was traced");
        };
        assert!(why.to_string().contains("9000×3000 pixels"), "{why}");
    }
}

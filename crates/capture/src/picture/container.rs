//! Recognizes a picture file's format by its first bytes, and detects whether the file contains
//! several pictures.

use std::path::Path;

use image::ImageFormat;

use super::tiff::Directories;
use super::{PICTURES, broken, conversion, jpeg};
use crate::foreign::Foreign;

/// BigTIFF, which `image` reads but does not recognize.
const BIG_TIFF: [&[u8]; 2] = [b"II+\0", b"MM\0+"];

/// Returns whether a file with this start can be shown.
pub(crate) fn is_picture(head: &[u8]) -> bool {
    format_of(head).is_some()
}

pub(super) fn format_of(head: &[u8]) -> Option<ImageFormat> {
    use ImageFormat::{Bmp, Jpeg, Png, Pnm, Tiff, WebP};
    if BIG_TIFF.iter().any(|magic| head.starts_with(magic)) {
        return Some(Tiff);
    }
    let format = image::guess_format(head).ok()?;
    matches!(format, Png | Jpeg | WebP | Tiff | Bmp | Pnm).then_some(format)
}

/// Returns the format of a file that this build reads. The error is a sentence that says what the
/// file is, and what to do.
pub(super) fn readable_format(path: &Path, file: &[u8]) -> Result<ImageFormat, String> {
    let Some(format) = format_of(file) else {
        let is_named = super::names_a_picture(path) && Foreign::of(file).is_none();
        return Err(if is_named {
            broken(path, format!("it is no {PICTURES}"))
        } else {
            format!("{} {}", path.display(), stranger(path, file))
        });
    };
    if !format.reading_enabled() {
        // The Cargo feature is named after the format's file extension.
        let feature = format.extensions_str().first().unwrap_or(&"");
        let reason = format!(
            "this build of lariat reads no {}: convert it to PNG, or build lariat with `--features {feature}`",
            feature.to_uppercase()
        );
        return Err(broken(path, reason));
    }
    Ok(format)
}

/// Describes a file that lariat does not read, and what to do. The text ends a sentence that begins
/// with the path.
pub(crate) fn stranger(path: &Path, head: &[u8]) -> String {
    match Foreign::of(head).or_else(|| Foreign::named(path)) {
        Some(known) => known.advice(path),
        None => format!(
            "is neither a picture ({PICTURES}) nor a .y4m video: convert it first (a video with `ffmpeg -i {} out.y4m`)",
            path.display()
        ),
    }
}

/// Refuses a file with several pictures, because the decoder would silently show only the first.
/// Also refuses a file whose samples are not brightness. The error is a sentence.
pub(super) fn check(path: &Path, file: &[u8], format: ImageFormat) -> Result<(), String> {
    let shown = path.display();
    let unpack = format!(
        "unpack it first (`ffmpeg -i {shown} frame-%03d.png`, or `magick {shown} frame-%03d.png` where ffmpeg shows only one)"
    );
    match format {
        ImageFormat::Png if is_animated_png(file) => {
            Err(format!("{shown} is an animated PNG: {unpack}"))
        }
        ImageFormat::WebP if is_animated_webp(file) => {
            Err(format!("{shown} is an animated WebP: {unpack}"))
        }
        ImageFormat::Jpeg if jpeg::is_stream(file) => Err(format!(
            "{shown} holds several JPEG pictures: give its name the ending .mjpeg, and it is read as a video (or {unpack})"
        )),
        ImageFormat::Tiff => {
            let found = Directories::of(file);
            let samples = match found {
                Directories { pictures: 2.., .. } => {
                    let count = found.pictures;
                    return Err(format!("{shown} holds {count} pictures: {unpack}"));
                }
                _ if found.has_floats => "floating-point numbers",
                _ if found.has_palette => "places in a palette",
                _ => return Ok(()),
            };
            let reason = format!("its samples are {samples}; {}", conversion(path));
            Err(broken(path, reason))
        }
        _ => Ok(()),
    }
}

/// Returns true if a PNG is animated (PNG, third edition: an `acTL` chunk with the number of frames
/// before the first `IDAT`).
fn is_animated_png(file: &[u8]) -> bool {
    chunks(file)
        .take_while(|(name, _)| name != b"IDAT")
        .any(|(name, data)| name == *b"acTL" && data.first_chunk() > Some(&[0, 0, 0, 1]))
}

/// Name and data of a PNG's chunks (ISO/IEC 15948: each has length, name, data and checksum).
pub(super) fn chunks(file: &[u8]) -> impl Iterator<Item = ([u8; 4], &[u8])> {
    let mut rest = file.get(8..);
    std::iter::from_fn(move || {
        let (length, behind) = rest?.split_first_chunk()?;
        let (name, behind) = behind.split_first_chunk()?;
        let (data, behind) = behind.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        rest = behind.get(4..);
        Some((*name, data))
    })
}

/// Returns true if a WebP is animated, by the flag in its extended header.
fn is_animated_webp(file: &[u8]) -> bool {
    const ANIMATION: u8 = 2;
    file.get(12..16) == Some(b"VP8X") && file.get(20).is_some_and(|flags| flags & ANIMATION != 0)
}

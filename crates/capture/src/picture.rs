//! One picture file: its size from its head, its pixels as Gray8 or Rgb8.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::Path;

use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader};
use lariat_message::PixelFormat;

use crate::ahead::Layout;
use crate::orientation;
use crate::source::SourceError;

/// Larger pictures are refused: more likely a broken head than a camera.
pub(crate) const LARGEST_BYTES: u64 = 1 << 30;
/// Enough of a file for its size to be known, in all but odd cases.
const HEAD_BYTES: u64 = 64 << 10;

/// The pictures that can be shown, as words of a sentence.
pub const PICTURES: &str = "PNG, JPEG, WebP, TIFF or BMP";
/// How their names end.
const ENDINGS: [&str; 7] = ["png", "jpg", "jpeg", "webp", "tif", "tiff", "bmp"];

/// Whether a file is a picture by its name. Hidden files are not: some systems put a `._0001.png` that is no picture beside
/// each `0001.png`.
pub fn names_a_picture(path: &Path) -> bool {
    let is_hidden = path
        .file_name()
        .is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
    let known = |extension: &std::ffi::OsStr| {
        (ENDINGS.iter()).any(|known| extension.eq_ignore_ascii_case(known))
    };
    !is_hidden && path.extension().is_some_and(known)
}

/// Whether a file that begins so is one that can be shown.
pub(crate) fn is_picture(head: &[u8]) -> bool {
    format_of(head).is_some()
}

fn format_of(head: &[u8]) -> Option<ImageFormat> {
    let format = image::guess_format(head).ok()?;
    use ImageFormat::{Bmp, Jpeg, Png, Tiff, WebP};
    matches!(format, Png | Jpeg | WebP | Tiff | Bmp).then_some(format)
}

/// What a file's head says of its pixels; a sentence if it says nothing good.
pub(crate) fn probe(path: &Path) -> Result<Layout, String> {
    let unreadable = |error: io::Error| broken(path, error);
    let mut file = File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    let head_size = (&mut file).take(HEAD_BYTES).read_to_end(&mut bytes);
    let head_size = head_size.map_err(unreadable)?;
    layout(path, &bytes).or_else(|error| {
        if (head_size as u64) < HEAD_BYTES || format_of(&bytes).is_none() {
            return Err(error);
        }
        // A long profile or preview may stand before the size.
        let mut rest = file.take(LARGEST_BYTES);
        rest.read_to_end(&mut bytes).map_err(unreadable)?;
        layout(path, &bytes)
    })
}

fn layout(path: &Path, bytes: &[u8]) -> Result<Layout, String> {
    decoder(path, bytes).map(|(_, layout, _)| layout)
}

fn broken(path: &Path, error: impl std::fmt::Display) -> String {
    format!("{} cannot be decoded ({error})", path.display())
}

/// A decoder of the pixels as they are stored, the upright picture's layout, and how to turn the one into the other.
fn decoder<'a>(
    path: &Path,
    bytes: &'a [u8],
) -> Result<(impl ImageDecoder + 'a, Layout, Orientation), String> {
    let format = format_of(bytes).ok_or_else(|| broken(path, format!("it is no {PICTURES}")))?;
    if !format.reading_enabled() {
        // The name of a feature is the name of its files.
        let feature = format.extensions_str().first().unwrap_or(&"");
        return Err(broken(
            path,
            format!(
                "this build of lariat reads no {}: convert it to PNG, or build lariat with `--features {feature}`",
                feature.to_uppercase()
            ),
        ));
    }
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder();
    let mut decoder = decoder.map_err(|error| broken(path, error))?;
    // A damaged note beside the pixels does not spoil them.
    let orientation = match format {
        // The decoder knows no notes behind the pixels, where some programs put them.
        ImageFormat::Png => png_note(bytes).and_then(Orientation::from_exif_chunk),
        _ => decoder.orientation().ok(),
    }
    .unwrap_or(Orientation::NoTransforms);
    let (width, height) = decoder.dimensions();
    let format = if decoder.color_type().has_color() {
        PixelFormat::Rgb8
    } else {
        PixelFormat::Gray8
    };
    // The decoder's own pixels have 8 bytes at most.
    if u64::from(width) * u64::from(height) > LARGEST_BYTES / 8 {
        return Err(broken(
            path,
            format!("{width}×{height} pixels are too many"),
        ));
    }
    let (width, height) = if orientation::is_sideways(orientation) {
        (height, width)
    } else {
        (width, height)
    };
    let layout = Layout {
        width,
        height,
        stride: format.row_bytes(width) as u32,
        format,
    };
    Ok((decoder, layout, orientation))
}

/// A picture file, decoded as a source of frames shows it: upright, without alpha, 8 bits a channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StillPicture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `Gray8` if the file has no colour, else `Rgb8`.
    pub format: PixelFormat,
    /// Rows one after the other, without padding.
    pub pixels: Vec<u8>,
}

impl StillPicture {
    /// Reads a picture file ([`PICTURES`]), whatever its name says.
    ///
    /// # Errors
    /// There is no such file, it is no picture, or it is cut off or damaged.
    pub fn load(path: &Path) -> Result<Self, SourceError> {
        let broken = |reason| SourceError::Picture { reason };
        let mut pixels = vec![0; probe(path).map_err(broken)?.bytes()];
        let mut decoder = PictureDecoder::default();
        let layout = decoder.decode(path, &mut pixels).map_err(broken)?;
        pixels.truncate(layout.bytes());
        Ok(Self {
            width: layout.width,
            height: layout.height,
            format: layout.format,
            pixels,
        })
    }
}

/// Decodes one picture after the other, in the same memory.
#[derive(Default)]
pub(crate) struct PictureDecoder {
    file: Vec<u8>,
    /// Pixels with alpha or of 16 bits, before they are reduced.
    full: Vec<u8>,
    /// Pixels as they are stored, before they are turned upright.
    stored: Vec<u8>,
}

impl PictureDecoder {
    /// Decodes a file into the beginning of `pixels`, upright; alpha is left out, 16 bits become 8. A sentence if it cannot.
    pub(crate) fn decode(&mut self, path: &Path, pixels: &mut [u8]) -> Result<Layout, String> {
        let mut file = std::mem::take(&mut self.file);
        file.clear();
        let read =
            File::open(path).and_then(|open| open.take(LARGEST_BYTES).read_to_end(&mut file));
        let decoded = match read {
            Ok(_) => self.decode_file(path, &file, pixels),
            Err(error) => Err(broken(path, error)),
        };
        self.file = file;
        decoded
    }

    /// Bytes of the pixels of such a file; a sentence if it says nothing good of them.
    pub(crate) fn size(path: &Path, file: &[u8]) -> Result<usize, String> {
        layout(path, file).map(|layout| layout.bytes())
    }

    /// Decodes the bytes of a file. `path`: what to call it.
    pub(crate) fn decode_file(
        &mut self,
        path: &Path,
        file: &[u8],
        pixels: &mut [u8],
    ) -> Result<Layout, String> {
        if format_of(file) == Some(ImageFormat::Jpeg) && is_cut_off(file) {
            return Err(broken(path, "the file is cut off"));
        }
        let (decoder, layout, orientation) = decoder(path, file)?;
        let (width, height) = decoder.dimensions();
        let color = decoder.color_type();
        let Some(upright) = pixels.get_mut(..layout.bytes()) else {
            return Err(format!(
                "{} has {}×{} pixels, more than room was made for at the start: begin with the largest",
                path.display(),
                layout.width,
                layout.height
            ));
        };
        let turned = orientation != Orientation::NoTransforms;
        let pixels = if turned {
            self.stored.resize(layout.bytes(), 0);
            &mut self.stored[..]
        } else {
            &mut *upright
        };
        if matches!(color, ColorType::L8 | ColorType::Rgb8) {
            decoder.read_image(pixels)
        } else {
            // In range: `decoder` has looked.
            self.full.resize(decoder.total_bytes() as usize, 0);
            decoder.read_image(&mut self.full)
        }
        .map_err(|error| broken(path, error))?;
        match color {
            ColorType::L8 | ColorType::Rgb8 => {}
            ColorType::La8 => drop_alpha::<1>(&self.full, pixels),
            ColorType::Rgba8 => drop_alpha::<3>(&self.full, pixels),
            ColorType::L16 => reduce::<1, 1>(&self.full, pixels),
            ColorType::La16 => reduce::<1, 2>(&self.full, pixels),
            ColorType::Rgb16 => reduce::<3, 3>(&self.full, pixels),
            ColorType::Rgba16 => reduce::<3, 4>(&self.full, pixels),
            other => {
                let reason = format!("its pixels are {other:?}, of which lariat knows nothing");
                return Err(broken(path, reason));
            }
        }
        if turned {
            let channels = layout.bytes() / (width as usize * height as usize).max(1);
            let size = (width as usize, height as usize);
            orientation::turn(orientation, &self.stored, size, channels, upright);
        }
        Ok(layout)
    }
}

/// The EXIF note of a PNG (ISO/IEC 15948: each chunk its length, its name, its data, its checksum).
fn png_note(file: &[u8]) -> Option<&[u8]> {
    let mut rest = file.get(8..)?;
    loop {
        let (head, behind) = rest.split_at_checked(8)?;
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let (data, behind) = behind.split_at_checked(length)?;
        if head.ends_with(b"eXIf") {
            return Some(data);
        }
        rest = behind.get(4..)?;
    }
}

/// Whether a JPEG file lacks its end: the decoder would fill the rest with grey and say nothing.
///
/// Follows the segments (ITU-T T.81, annex B) up to the end of the image: previews lie inside of segments, and what
/// some cameras append lies behind it.
fn is_cut_off(file: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    const END_OF_IMAGE: u8 = 0xd9;
    let mut at = 2;
    while let Some(&[lead, marker]) = file.get(at..at + 2) {
        match (lead, marker) {
            (0xff, END_OF_IMAGE) => return false,
            // A fill byte.
            (0xff, 0xff) => at += 1,
            (0xff, _) => {
                let Some(&[high, low]) = file.get(at + 2..at + 4) else {
                    return true;
                };
                at += 2 + usize::from(u16::from_be_bytes([high, low]));
                if marker == START_OF_SCAN {
                    at += scan_length(file.get(at..).unwrap_or_default());
                }
            }
            // No marker where one should be: broken in another way, for the decoder to judge.
            _ => return false,
        }
    }
    true
}

/// Bytes of image data up to the next marker; in it 0xff is followed by 0 or is a restart marker.
fn scan_length(data: &[u8]) -> usize {
    data.windows(2)
        .position(|pair| pair[0] == 0xff && !matches!(pair[1], 0 | 0xd0..=0xd7))
        .unwrap_or(data.len())
}

fn drop_alpha<const COLORS: usize>(full: &[u8], pixels: &mut [u8]) {
    let full = full.chunks_exact(COLORS + 1);
    for (pixel, full) in pixels.chunks_exact_mut(COLORS).zip(full) {
        pixel.copy_from_slice(&full[..COLORS]);
    }
}

/// Native 16-bit samples to the nearest 8-bit ones: 65535 is 255.
fn reduce<const COLORS: usize, const CHANNELS: usize>(full: &[u8], pixels: &mut [u8]) {
    let full = full.chunks_exact(2 * CHANNELS);
    for (pixel, full) in pixels.chunks_exact_mut(COLORS).zip(full) {
        for (value, sample) in pixel.iter_mut().zip(full.chunks_exact(2)) {
            let sample = u32::from(u16::from_ne_bytes([sample[0], sample[1]]));
            *value = ((sample + 128) / 257) as u8;
        }
    }
}

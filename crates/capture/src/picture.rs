//! Reads one picture file: its size from the header, its pixels as Gray8 or Rgb8.

mod container;
mod jpeg;
mod samples;
mod scans;
mod tiff;

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::Path;

use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader};
use lariat_message::PixelFormat;

use crate::ahead::Layout;
use crate::bits::Bits;
use crate::orientation;
use crate::source::SourceError;
use container::{chunks, format_of, readable_format};
pub(crate) use container::{is_picture, stranger};
pub(crate) use jpeg::{END_OF_IMAGE, START_OF_IMAGE, START_OF_SCAN, is_in_scan, is_start_of_frame};

/// Maximum size of a picture. A larger size is more likely a broken header than a camera's picture.
pub(crate) const LARGEST_BYTES: u64 = 1 << 30;
/// Number of leading bytes in which the picture's size is looked for first. Files in which it comes
/// later are unusual.
const HEAD_BYTES: u64 = 64 << 10;

/// The picture formats that can be shown, worded for use in a sentence.
pub const PICTURES: &str = "PNG, JPEG, WebP, TIFF, BMP or PGM";
/// File name extensions of these formats.
const ENDINGS: [&str; 11] = [
    "png", "jpg", "jpeg", "webp", "tif", "tiff", "bmp", "pgm", "ppm", "pbm", "pnm",
];

/// Returns whether a file's name is that of a picture. Hidden files are not: some systems add a
/// `._0001.png`, which is not a picture, to each `0001.png`.
pub fn names_a_picture(path: &Path) -> bool {
    let known = |extension: &std::ffi::OsStr| {
        (ENDINGS.iter()).any(|known| extension.eq_ignore_ascii_case(known))
    };
    !is_hidden(path) && path.extension().is_some_and(known)
}

/// Returns true if a name is that of a hidden file.
pub(crate) fn is_hidden(path: &Path) -> bool {
    let name = path.file_name();
    name.is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

/// Reads the layout of a file's pixels from its header. The error is a sentence.
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
        // A long profile or preview may precede the size.
        let mut rest = file.take(LARGEST_BYTES);
        rest.read_to_end(&mut bytes).map_err(unreadable)?;
        layout(path, &bytes)
    })
}

/// Appends the bytes of a picture's file, at most [`LARGEST_BYTES`].
pub(crate) fn read_file(path: &Path, bytes: &mut Vec<u8>) -> io::Result<()> {
    File::open(path)?.take(LARGEST_BYTES).read_to_end(bytes)?;
    Ok(())
}

fn layout(path: &Path, bytes: &[u8]) -> Result<Layout, String> {
    let format = readable_format(path, bytes)?;
    let bytes = &jpeg::with_tables(bytes);
    Opened::new(path, bytes, format).map(|opened| opened.layout)
}

fn broken(path: &Path, error: impl std::fmt::Display) -> String {
    format!("{} cannot be decoded ({error})", path.display())
}

/// A picture file whose header was read.
struct Opened<'a> {
    /// Decoder of the stored pixels.
    decoder: Box<dyn ImageDecoder + 'a>,
    /// The layout of the upright picture.
    layout: Layout,
    /// How to turn the pixels upright.
    orientation: Orientation,
}

impl<'a> Opened<'a> {
    fn new(path: &Path, bytes: &'a [u8], format: ImageFormat) -> Result<Self, String> {
        let mut decoder = Box::new(decoder(path, bytes, format)?);
        // Damaged metadata does not spoil the pixels.
        let orientation = match format {
            // The decoder does not read metadata after the pixels, where some programs store it.
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
        // The decoder uses at most 8 bytes per pixel.
        if u64::from(width) * u64::from(height) > LARGEST_BYTES / 8 {
            let reason = format!("{width}×{height} pixels are too many");
            return Err(broken(path, reason));
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
        Ok(Self {
            decoder,
            layout,
            orientation,
        })
    }
}

/// Creates a decoder of a file in a format that this build reads.
fn decoder<'a>(
    path: &Path,
    bytes: &'a [u8],
    format: ImageFormat,
) -> Result<impl ImageDecoder + 'a, String> {
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder();
    decoder.map_err(|error| {
        // Gives a more precise reason if there is one.
        if let Err(known) = container::check(path, bytes, format) {
            return known;
        }
        match error {
            image::ImageError::Unsupported(kind) => {
                broken(path, format!("{kind}; {}", conversion(path)))
            }
            error => broken(path, error),
        }
    })
}

/// The command that converts a picture to a format that lariat reads.
fn conversion(path: &Path) -> String {
    let shown = path.display();
    format!(
        "convert it first: `ffmpeg -i {shown} out.png`, or `magick {shown} out.png` where ffmpeg cannot"
    )
}

/// A picture file, decoded as a frame source shows it: upright, without alpha, 8 bits per channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StillPicture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `Gray8` for a file without color, otherwise `Rgb8`.
    pub format: PixelFormat,
    /// Rows in order, without padding.
    pub pixels: Vec<u8>,
    /// A sentence about the meaning of its samples, if the file leaves that open.
    pub news: Option<String>,
}

impl StillPicture {
    /// Reads a picture file ([`PICTURES`]), whatever its extension.
    ///
    /// # Errors
    /// The file is missing, is not a picture, or is cut off or damaged.
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
            news: decoder.take_news(),
        })
    }
}

/// Decodes pictures one after another, in the same memory.
#[derive(Default)]
pub(crate) struct PictureDecoder {
    file: Vec<u8>,
    /// Pixels with alpha or 16 bits, before they are reduced.
    full: Vec<u8>,
    /// Stored pixels, before they are turned upright.
    stored: Vec<u8>,
    /// Number of bits in the samples of 16-bit pictures.
    bits: Bits,
    news: Option<String>,
}

impl PictureDecoder {
    /// Decodes a file into the start of `pixels`, upright. Drops alpha and reduces 16 bits to 8.
    /// The error is a sentence.
    pub(crate) fn decode(&mut self, path: &Path, pixels: &mut [u8]) -> Result<Layout, String> {
        let mut file = std::mem::take(&mut self.file);
        file.clear();
        let decoded = match read_file(path, &mut file) {
            Ok(()) => self.decode_file(path, &file, pixels),
            Err(error) => Err(broken(path, error)),
        };
        self.file = file;
        decoded
    }

    /// Returns the number of bytes of a file's pixels. The error is a sentence.
    pub(crate) fn size(path: &Path, file: &[u8]) -> Result<usize, String> {
        layout(path, file).map(|layout| layout.bytes())
    }

    /// Returns a sentence about the meaning of the last picture's samples, once, if the file leaves
    /// that open.
    pub(crate) fn take_news(&mut self) -> Option<String> {
        self.news.take()
    }

    /// Decodes the bytes of a file without reducing its samples. `path` is used in messages.
    pub(crate) fn decode_full(&mut self, path: &Path, file: &[u8]) -> Result<FullPicture, String> {
        let format = readable_format(path, file)?;
        container::check(path, file, format)?;
        let file = &jpeg::with_tables(file);
        let opened = Opened::new(path, file, format)?;
        let Opened {
            layout,
            orientation,
            decoder,
        } = &opened;
        let (orientation, color) = (*orientation, decoder.color_type());
        let (width, height) = decoder.dimensions();
        let mut stored = vec![0; decoder.total_bytes() as usize];
        let size = [layout.width, layout.height];
        self.read(path, file, (format, opened), &mut stored)?;
        let mut samples = stored;
        if orientation != Orientation::NoTransforms {
            let lying = samples.clone();
            let bytes = usize::from(color.bytes_per_pixel());
            let lengths = (width as usize, height as usize);
            orientation::turn(orientation, &lying, lengths, bytes, &mut samples);
        }
        Ok(FullPicture {
            size,
            color,
            samples,
        })
    }

    /// Decodes the bytes of a file. `path` is used in messages.
    pub(crate) fn decode_file(
        &mut self,
        path: &Path,
        file: &[u8],
        pixels: &mut [u8],
    ) -> Result<Layout, String> {
        let format = readable_format(path, file)?;
        container::check(path, file, format)?;
        let file = &jpeg::with_tables(file);
        let opened = Opened::new(path, file, format)?;
        let layout = opened.layout;
        let Some(upright) = pixels.get_mut(..layout.bytes()) else {
            return Err(format!(
                "{} has {}×{} pixels, more than room was made for at the start: begin with the largest",
                path.display(),
                layout.width,
                layout.height
            ));
        };
        let (width, height) = opened.decoder.dimensions();
        let orientation = opened.orientation;
        if orientation == Orientation::NoTransforms {
            self.decode_stored(path, file, (format, opened), upright)?;
            return Ok(layout);
        }
        let mut stored = std::mem::take(&mut self.stored);
        stored.resize(layout.bytes(), 0);
        let decoded = self.decode_stored(path, file, (format, opened), &mut stored);
        if decoded.is_ok() {
            let size = (width as usize, height as usize);
            let channels = layout.bytes() / (size.0 * size.1).max(1);
            orientation::turn(orientation, &stored, size, channels, upright);
        }
        self.stored = stored;
        decoded.map(|()| layout)
    }

    /// Decodes the stored pixels.
    fn decode_stored(
        &mut self,
        path: &Path,
        file: &[u8],
        (format, opened): (ImageFormat, Opened),
        pixels: &mut [u8],
    ) -> Result<(), String> {
        let color = opened.decoder.color_type();
        if matches!(color, ColorType::L8 | ColorType::Rgb8) {
            return self.read(path, file, (format, opened), pixels);
        }
        let mut full = std::mem::take(&mut self.full);
        // In range: checked by `Opened`.
        full.resize(opened.decoder.total_bytes() as usize, 0);
        let read = self.read(path, file, (format, opened), &mut full);
        let reduced = read.and_then(|()| {
            let said = samples::see_bits(&mut self.bits, color, &full);
            let said = said.map(|said| format!("{}: {said}", path.display()));
            self.news = self.news.take().or(said);
            samples::reduce(color, &full, self.bits, pixels).map_err(|reason| broken(path, reason))
        });
        self.full = full;
        reduced
    }

    /// Reads the samples of a file unchanged.
    fn read(
        &self,
        path: &Path,
        file: &[u8],
        (format, opened): (ImageFormat, Opened),
        samples: &mut [u8],
    ) -> Result<(), String> {
        let decoder = opened.decoder;
        if format == ImageFormat::Jpeg {
            if scans::has_low_color_scans(file) {
                if scans::decode(file, samples) {
                    return Ok(());
                }
                return Err(format!(
                    "{} is a JPEG with several scans and fewer rows of colour, damaged or of a kind that lariat does not decode: write it \
                     again without loss (`jpegtran {} > out.jpg`)",
                    path.display(),
                    path.display()
                ));
            }
            if jpeg::End::of(file) == jpeg::End::Missing {
                let (width, height) = decoder.dimensions();
                let is_whole = jpeg::decode_without_end(file, [width, height], samples);
                return if is_whole {
                    Ok(())
                } else {
                    Err(broken(path, "the file is cut off"))
                };
            }
        }
        (decoder.read_image_boxed(samples)).map_err(|error| broken(path, error))
    }
}

/// An upright picture with samples that are not reduced.
pub(crate) struct FullPicture {
    /// Width and height, in pixels.
    pub(crate) size: [u32; 2],
    pub(crate) color: ColorType,
    /// Samples from the decoder; those of 16 bits are native-endian.
    pub(crate) samples: Vec<u8>,
}

/// The EXIF data of a PNG.
fn png_note(file: &[u8]) -> Option<&[u8]> {
    let note = chunks(file).find(|(name, _)| name == b"eXIf");
    note.map(|(_, data)| data)
}

//! One picture file: its size from its head, its pixels as Gray8 or Rgb8.

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

/// Larger pictures are refused: more likely a broken head than a camera.
pub(crate) const LARGEST_BYTES: u64 = 1 << 30;
/// Enough of a file for its size to be known, in all but odd cases.
const HEAD_BYTES: u64 = 64 << 10;

/// The pictures that can be shown, as words of a sentence.
pub const PICTURES: &str = "PNG, JPEG, WebP, TIFF, BMP or PGM";
/// How their names end.
const ENDINGS: [&str; 11] = [
    "png", "jpg", "jpeg", "webp", "tif", "tiff", "bmp", "pgm", "ppm", "pbm", "pnm",
];

/// Whether a file is a picture by its name. Hidden files are not: some systems put a `._0001.png` that is no picture beside
/// each `0001.png`.
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

/// A picture file whose head was read.
struct Opened<'a> {
    /// A decoder of the pixels as they are stored.
    decoder: Box<dyn ImageDecoder + 'a>,
    /// The layout of the upright picture.
    layout: Layout,
    /// The turn that makes the pixels upright.
    orientation: Orientation,
}

impl<'a> Opened<'a> {
    fn new(path: &Path, bytes: &'a [u8], format: ImageFormat) -> Result<Self, String> {
        let mut decoder = Box::new(decoder(path, bytes, format)?);
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

/// A decoder of a file of a format that this build reads.
fn decoder<'a>(
    path: &Path,
    bytes: &'a [u8],
    format: ImageFormat,
) -> Result<impl ImageDecoder + 'a, String> {
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder();
    decoder.map_err(|error| {
        // The reason may be one that is known here.
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

/// The command that converts a picture to a kind that lariat reads.
fn conversion(path: &Path) -> String {
    let shown = path.display();
    format!(
        "convert it first: `ffmpeg -i {shown} out.png`, or `magick {shown} out.png` where ffmpeg cannot"
    )
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
    /// A sentence on what its samples mean, if the file leaves it open.
    pub news: Option<String>,
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
            news: decoder.take_news(),
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
    /// The number of bits in samples of pictures of 16 bits.
    bits: Bits,
    news: Option<String>,
}

impl PictureDecoder {
    /// Decodes a file into the beginning of `pixels`, upright; alpha is left out, 16 bits become 8. A sentence if it cannot.
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

    /// Bytes of the pixels of such a file; a sentence if it says nothing good of them.
    pub(crate) fn size(path: &Path, file: &[u8]) -> Result<usize, String> {
        layout(path, file).map(|layout| layout.bytes())
    }

    /// A sentence on what the samples of the last picture mean, once, if the file leaves it open.
    pub(crate) fn take_news(&mut self) -> Option<String> {
        self.news.take()
    }

    /// Decodes the bytes of a file with all that its samples say. `path`: what to call it.
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

    /// Decodes the bytes of a file. `path`: what to call it.
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

    /// Decodes pixels as they are stored.
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
        // In range: `Opened` has looked.
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

    /// Reads the samples of a file as they are.
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

/// A picture with all that its samples say, upright.
pub(crate) struct FullPicture {
    /// Width and height, in pixels.
    pub(crate) size: [u32; 2],
    pub(crate) color: ColorType,
    /// As the decoder gives them: numbers of 16 bits in the machine's order.
    pub(crate) samples: Vec<u8>,
}

/// The EXIF note of a PNG.
fn png_note(file: &[u8]) -> Option<&[u8]> {
    let note = chunks(file).find(|(name, _)| name == b"eXIf");
    note.map(|(_, data)| data)
}

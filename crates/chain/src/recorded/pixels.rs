//! Decodes the pixels of a recorded frame, whatever their encoding.

use anyhow::{Context, Result, bail};
use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::{ColorType, DynamicImage, ImageDecoder, ImageReader};
use lariat_capture::ForeignFrames;
use lariat_record::{Pixels as Recorded, Recording};
use lariat_wire::{FrameHeader, PixelFormat};
use std::io::Cursor;

/// Encoding of the bytes of a recorded frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pixels {
    /// No bytes were kept.
    None,
    /// Raw pixels as the header describes them.
    Raw,
    /// A PNG file.
    Png,
    /// A JPEG file.
    Jpeg,
    /// Another picture file.
    Other,
}

impl Pixels {
    /// Returns the encoding and the bytes.
    pub fn split(pixels: Recorded<'_>) -> (Self, &[u8]) {
        match pixels {
            Recorded::None => (Self::None, &[]),
            Recorded::Raw(bytes) => (Self::Raw, bytes),
            Recorded::Png(bytes) => (Self::Png, bytes),
            Recorded::Jpeg(bytes) => (Self::Jpeg, bytes),
            Recorded::Other(bytes) => (Self::Other, bytes),
        }
    }
}

/// Decodes pictures into memory that is reused.
#[derive(Debug, Default)]
pub struct Decoder {
    pixels: Vec<u8>,
    /// State for recordings of other programs.
    foreign: Option<ForeignFrames>,
}

impl Decoder {
    /// Creates a decoder for the frames of this recording. [`Decoder::default`] assumes that lariat
    /// recorded them.
    pub fn of(recording: &Recording) -> Self {
        let is_own = recording.about().version().is_some();
        Self {
            foreign: (!is_own).then(ForeignFrames::default),
            ..Self::default()
        }
    }

    /// Returns header and bytes as the extractor needs them. A PNG by lariat yields the exact frame
    /// (BGRA as RGB), and a JPEG yields RGB or gray. Raw frames of another program are expanded to
    /// full range.
    ///
    /// # Errors
    /// Returns an error if the pixels are missing or cannot be decoded.
    pub fn decode<'a>(
        &'a mut self,
        header: &FrameHeader,
        kind: Pixels,
        bytes: &'a [u8],
    ) -> Result<(FrameHeader, &'a [u8])> {
        let about = || {
            format!(
                "the picture of frame {} in the recording cannot be read",
                header.trace.sequence
            )
        };
        match kind {
            Pixels::None => bail!(
                "frame {} was recorded without its image",
                header.trace.sequence
            ),
            Pixels::Raw => Ok((*header, self.in_full_range(header, bytes))),
            Pixels::Png => {
                let decoder = PngDecoder::new(Cursor::new(bytes)).with_context(about)?;
                self.read(header, decoder).with_context(about)
            }
            Pixels::Jpeg => {
                let decoder = JpegDecoder::new(Cursor::new(bytes)).with_context(about)?;
                self.read(header, decoder).with_context(about)
            }
            Pixels::Other => {
                let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
                let decoder = reader
                    .with_context(about)?
                    .into_decoder()
                    .with_context(about)?;
                self.read(header, decoder).with_context(about)
            }
        }
    }

    /// Returns what was found out about another program's frames. Each finding is returned only
    /// once.
    pub fn take_news(&mut self) -> Option<String> {
        self.foreign.as_mut()?.take_news()
    }

    fn in_full_range<'a>(&'a mut self, header: &FrameHeader, bytes: &'a [u8]) -> &'a [u8] {
        let Some(foreign) = &mut self.foreign else {
            return bytes;
        };
        self.pixels.clear();
        self.pixels.extend_from_slice(bytes);
        foreign.normalize(header, &mut self.pixels);
        &self.pixels
    }

    fn read(
        &mut self,
        header: &FrameHeader,
        decoder: impl ImageDecoder,
    ) -> Result<(FrameHeader, &[u8])> {
        let (width, height) = decoder.dimensions();
        let said = (header.width, header.height);
        if said != (0, 0) && said != (width, height) {
            bail!(
                "it is {width}×{height} pixels, and its frame {}×{}",
                said.0,
                said.1
            );
        }
        let channels = match decoder.color_type() {
            ColorType::L8 => 1,
            ColorType::L16 if header.format() == Some(PixelFormat::Gray16) => 2,
            ColorType::Rgb8 => 3,
            // A picture from another program.
            _ => {
                self.pixels = DynamicImage::from_decoder(decoder)?.into_rgb8().into_raw();
                return Ok((self.header(header, width, height, 3), &self.pixels));
            }
        };
        self.pixels.resize(decoder.total_bytes() as usize, 0);
        decoder.read_image(&mut self.pixels)?;
        if header.format() == Some(PixelFormat::Bgr8) && channels == 3 {
            self.pixels
                .as_chunks_mut::<3>()
                .0
                .iter_mut()
                .for_each(|p| p.swap(0, 2));
            let header = FrameHeader {
                stride: 3 * width,
                ..*header
            };
            return Ok((header, &self.pixels));
        }
        Ok((self.header(header, width, height, channels), &self.pixels))
    }

    fn header(&self, header: &FrameHeader, width: u32, height: u32, channels: u32) -> FrameHeader {
        let format = match channels {
            1 => PixelFormat::Gray8,
            2 => PixelFormat::Gray16,
            _ => PixelFormat::Rgb8,
        };
        FrameHeader {
            width,
            height,
            stride: channels * width,
            pixel_format: format as u32,
            ..*header
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raw_frames_of_other_programs_are_expanded_to_full_range() {
        let header = FrameHeader {
            width: 2,
            height: 1,
            stride: 4,
            pixel_format: PixelFormat::Yuyv as u32,
            ..FrameHeader::default()
        };
        let yuyv = [235, 128, 16, 240];
        let decoded = |mut decoder: Decoder| {
            let (_, bytes) = decoder.decode(&header, Pixels::Raw, &yuyv).expect("pixels");
            bytes.to_vec()
        };
        assert_eq!(decoded(Decoder::default()), yuyv);
        let foreign = Some(ForeignFrames::default());
        let decoder = Decoder {
            foreign,
            ..Decoder::default()
        };
        assert_eq!(decoded(decoder), [255, 128, 0, 255]);
    }
}

//! MJPEG files: consecutive JPEG pictures, as written by `ffmpeg -c copy`, ustreamer and
//! mjpg-streamer.
//!
//! Bytes between the pictures, such as the part headers of an HTTP stream, are skipped. Such a file
//! does not contain a frame rate.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use lariat_message::{PixelFormat, SourceKind};

use crate::ahead::{Ahead, Decode, Plan, Step};
use crate::open::FileOptions;
use crate::picture::{
    END_OF_IMAGE, PictureDecoder, START_OF_IMAGE, START_OF_SCAN, is_in_scan, is_start_of_frame,
};
use crate::source::SourceError;

/// File name extensions of such files.
const ENDINGS: [&str; 3] = ["mjpeg", "mjpg", "mjpe"];

/// Returns true if a path names an MJPEG file.
pub(crate) fn names_mjpeg(path: &Path) -> bool {
    let ending = path.extension();
    ending.is_some_and(|ending| {
        ENDINGS
            .iter()
            .any(|known| ending.eq_ignore_ascii_case(known))
    })
}

/// Opens an MJPEG file.
pub(crate) fn open_mjpeg(path: &Path, options: &FileOptions) -> Result<Ahead, SourceError> {
    let unreadable = |error| SourceError::Unreadable {
        path: path.to_owned(),
        error,
    };
    let file = File::open(path).map_err(unreadable)?;
    let (parts, is_cut_off) = Scanner::new(&file).parts().map_err(unreadable)?;
    if parts.is_empty() {
        return Err(SourceError::Video {
            path: path.to_owned(),
            what: "it holds no whole JPEG picture: convert it first (`ffmpeg -i IN -pix_fmt yuv420p OUT.y4m`)".to_owned(),
        });
    }
    let frames = options.range.frames(options.fps)?;
    let count = parts.len() as u64;
    if frames.of(count) == 0 {
        return Err(SourceError::BehindEnd {
            first: frames.first,
            count,
        });
    }
    let last = frames
        .first
        .saturating_add((frames.of(count) - 1).saturating_mul(frames.every));
    // In range: the first frame is within the parts.
    let chosen = parts.into_iter().skip(frames.first as usize - 1);
    let parts: Vec<Part> = (chosen.step_by(frames.every as usize))
        .take(frames.of(count) as usize)
        .collect();
    let warning = format!(
        "{} is cut off in frame {}, which is left out",
        path.display(),
        count + 1
    );
    let plan = Plan {
        kind: SourceKind::Video,
        largest_frame_bytes: parts.iter().map(Part::pixel_bytes).max().unwrap_or(0),
        native_fps: None,
        looped: options.looped,
        has_truth: false,
        total_bytes: parts.iter().map(|part| part.pixel_bytes() as u64).sum(),
        warnings: (is_cut_off && last >= count)
            .then_some(warning)
            .into_iter()
            .collect(),
        news: frames.news(),
    };
    let video = MjpegVideo {
        path: path.to_owned(),
        file,
        parts,
        next: 0,
        jpeg: Vec::new(),
        decoder: PictureDecoder::default(),
    };
    Ahead::start(video, plan)
}

/// A picture in the file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Part {
    /// Its number, from 1.
    number: u64,
    from: u64,
    bytes: u64,
    /// Width and height, in pixels.
    size: [u16; 2],
    is_gray: bool,
}

impl Part {
    fn pixel_bytes(&self) -> usize {
        let format = if self.is_gray {
            PixelFormat::Gray8
        } else {
            PixelFormat::Rgb8
        };
        format.row_bytes(self.size[0].into()) * usize::from(self.size[1])
    }
}

/// Finds the pictures (ITU-T T.81, annex B).
struct Scanner<R> {
    reader: BufReader<R>,
    at: u64,
}

impl<R: Read> Scanner<R> {
    fn new(input: R) -> Self {
        Self {
            reader: BufReader::with_capacity(1 << 16, input),
            at: 0,
        }
    }

    /// Returns the complete pictures, and whether another picture is cut off.
    fn parts(mut self) -> io::Result<(Vec<Part>, bool)> {
        let mut parts = Vec::new();
        while let Some(from) = self.start()? {
            let mut part = Part {
                number: parts.len() as u64 + 1,
                from,
                ..Part::default()
            };
            match self.rest(&mut part) {
                Ok(true) => {
                    part.bytes = self.at - from;
                    parts.push(part);
                }
                // These bytes are between pictures.
                Ok(false) => {}
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                    return Ok((parts, true));
                }
                Err(error) => return Err(error),
            }
        }
        Ok((parts, false))
    }

    fn byte(&mut self) -> io::Result<u8> {
        let mut byte = [0];
        self.reader.read_exact(&mut byte)?;
        self.at += 1;
        Ok(byte[0])
    }

    /// Skips past the next run of 0xFF bytes. Returns the byte after the run, or `None` at the end.
    fn behind_marker_byte(&mut self) -> io::Result<Option<u8>> {
        self.at += self.reader.skip_until(0xff)? as u64;
        loop {
            match self.byte() {
                Ok(0xff) => {}
                Ok(byte) => return Ok(Some(byte)),
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
                Err(error) => return Err(error),
            }
        }
    }

    /// Returns where the next picture begins; `None` at the end.
    fn start(&mut self) -> io::Result<Option<u64>> {
        while let Some(byte) = self.behind_marker_byte()? {
            if byte == START_OF_IMAGE {
                return Ok(Some(self.at - 2));
            }
        }
        Ok(None)
    }

    /// Reads to the end of a picture. Returns `false` if it is not a picture.
    fn rest(&mut self, part: &mut Part) -> io::Result<bool> {
        let cut_off = || io::Error::from(io::ErrorKind::UnexpectedEof);
        if self.byte()? != 0xff {
            return Ok(false);
        }
        let mut marker = self.byte()?;
        loop {
            match marker {
                END_OF_IMAGE => return Ok(part.size != [0; 2]),
                0xff => {
                    marker = self.byte()?;
                    continue;
                }
                marker if is_in_scan(marker) || marker == START_OF_IMAGE => return Ok(false),
                _ => {}
            }
            let length = u64::from(u16::from_be_bytes([self.byte()?, self.byte()?]));
            let end = self.at + length.saturating_sub(2);
            if is_start_of_frame(marker) && length >= 8 {
                let [_, h, e, w, i, channels] = self.six()?;
                part.size = [[w, i], [h, e]].map(u16::from_be_bytes);
                part.is_gray = channels == 1;
            }
            while self.at < end {
                self.byte()?;
            }
            marker = if marker == START_OF_SCAN {
                self.behind_scan()?.ok_or_else(cut_off)?
            } else if self.byte()? == 0xff {
                self.byte()?
            } else {
                return Ok(false);
            };
        }
    }

    fn six(&mut self) -> io::Result<[u8; 6]> {
        let mut six = [0; 6];
        for byte in &mut six {
            *byte = self.byte()?;
        }
        Ok(six)
    }

    /// Returns the marker after a scan's data; `None` at the end.
    fn behind_scan(&mut self) -> io::Result<Option<u8>> {
        while let Some(byte) = self.behind_marker_byte()? {
            if !is_in_scan(byte) {
                return Ok(Some(byte));
            }
        }
        Ok(None)
    }
}

struct MjpegVideo {
    path: PathBuf,
    file: File,
    parts: Vec<Part>,
    next: usize,
    /// The picture being decoded.
    jpeg: Vec<u8>,
    decoder: PictureDecoder,
}

impl Decode for MjpegVideo {
    fn rewind(&mut self) -> Result<(), SourceError> {
        self.next = 0;
        Ok(())
    }

    fn decode(&mut self, pixels: &mut [u8]) -> Step {
        let Some(part) = self.parts.get(self.next) else {
            return Step::End(None);
        };
        self.next += 1;
        let name = format!("frame {} of {}", part.number, self.path.display());
        self.jpeg.resize(part.bytes as usize, 0);
        let mut file = &self.file;
        let read = file
            .seek(SeekFrom::Start(part.from))
            .and_then(|_| file.read_exact(&mut self.jpeg));
        if let Err(error) = read {
            return Step::Lost(format!("{name} cannot be read: {error}"));
        }
        match self
            .decoder
            .decode_file(Path::new(&name), &self.jpeg, pixels)
        {
            Ok(layout) => Step::Decoded(layout),
            Err(reason) => Step::Lost(reason),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ExtendedColorType, GrayImage, ImageEncoder, Luma, codecs::jpeg::JpegEncoder};

    fn jpeg(width: u32) -> Vec<u8> {
        let mut file = Vec::new();
        let picture = GrayImage::from_fn(width, 9, |x, y| Luma([(37 * x + 11 * y) as u8]));
        let encoder = JpegEncoder::new(&mut file);
        encoder
            .write_image(&picture, width, 9, ExtendedColorType::L8)
            .expect("it is written");
        file
    }

    #[test]
    fn pictures_are_found_whatever_lies_between_them() {
        let (a, b) = (jpeg(20), jpeg(33));
        for between in [
            &b""[..],
            b"\r\n--boundary\r\nContent-Length: 9\r\n\r\n",
            b"\xff\xff\x00",
        ] {
            let file = [between, &a, between, &b, between].concat();
            let (parts, is_cut_off) = Scanner::new(&file[..]).parts().expect("it is read");
            let sizes: Vec<_> = parts.iter().map(|part| part.size).collect();
            assert_eq!(sizes, [[20, 9], [33, 9]]);
            assert!(parts.iter().all(|part| part.is_gray) && !is_cut_off);
            let second = parts[1];
            let end = (second.from + second.bytes) as usize;
            assert_eq!(file[second.from as usize..end], b);
        }
    }

    #[test]
    fn a_picture_that_is_cut_off_is_not_counted() {
        let (a, b) = (jpeg(20), jpeg(33));
        for end in [3, 30, b.len() - 2] {
            let file = [&a, &b[..end]].concat();
            let (parts, is_cut_off) = Scanner::new(&file[..]).parts().expect("it is read");
            assert_eq!((parts.len(), is_cut_off), (1, true), "{end}");
        }
    }
}

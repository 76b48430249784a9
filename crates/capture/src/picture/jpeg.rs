//! Structure of a JPEG file (ITU-T T.81, annex B): what it lacks, and where it ends.

use std::borrow::Cow;

use crate::mjpeg::{HUFFMAN_TABLES, Mjpeg};

pub(crate) const START_OF_IMAGE: u8 = 0xd8;
pub(crate) const END_OF_IMAGE: u8 = 0xd9;
pub(crate) const START_OF_SCAN: u8 = 0xda;
const DEFINE_HUFFMAN: u8 = 0xc4;

/// The end of a file's image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// Position after the end marker.
    At(usize),
    /// The end marker is missing: the decoder would silently fill the rest with gray.
    Missing,
    /// A marker is missing where one should be; the decoder decides.
    Broken,
}

impl End {
    /// Skips the segments up to the end of the image. Previews are inside segments. Data that some
    /// cameras append comes after the end.
    pub(super) fn of(file: &[u8]) -> Self {
        let mut at = 2;
        while let Some(&[lead, marker]) = file.get(at..at + 2) {
            match (lead, marker) {
                (0xff, END_OF_IMAGE) => return Self::At(at + 2),
                // A fill byte.
                (0xff, 0xff) => at += 1,
                (0xff, _) => {
                    let Some(&[high, low]) = file.get(at + 2..at + 4) else {
                        return Self::Missing;
                    };
                    at += 2 + usize::from(u16::from_be_bytes([high, low]));
                    if marker == START_OF_SCAN {
                        at += scan_length(file.get(at..).unwrap_or_default());
                    }
                }
                _ => return Self::Broken,
            }
        }
        Self::Missing
    }
}

/// Number of bytes of image data before the next marker. In the data, 0xff is followed by 0 or is a
/// restart marker.
fn scan_length(data: &[u8]) -> usize {
    data.windows(2)
        .position(|pair| pair[0] == 0xff && !is_in_scan(pair[1]))
        .unwrap_or(data.len())
}

/// Returns true if a byte after 0xff belongs to a scan.
pub(crate) fn is_in_scan(byte: u8) -> bool {
    matches!(byte, 0 | 0xd0..=0xd7)
}

/// Returns true for a start-of-frame marker, whose segment contains the size.
pub(crate) fn is_start_of_frame(marker: u8) -> bool {
    // 0xc4, 0xc8 and 0xcc are tables and a reserved number.
    matches!(marker, 0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf)
}

/// Yields marker and body of each segment up to the first scan's.
pub(super) fn head(file: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut at = Some(2);
    std::iter::from_fn(move || {
        let mut from = at?;
        while file.get(from..from + 2) == Some(&[0xff, 0xff]) {
            from += 1;
        }
        let &[0xff, marker, high, low] = file.get(from..)?.first_chunk()? else {
            return None;
        };
        let end = from + 2 + usize::from(u16::from_be_bytes([high, low]));
        let body = file.get(from + 4..end)?;
        at = (marker != START_OF_SCAN).then_some(end);
        Some((marker, body))
    })
}

/// Adds the standard Huffman tables to a file whose first scan is Huffman-coded but not preceded by
/// tables. Cameras and AVI files omit them.
pub(super) fn with_tables(file: &[u8]) -> Cow<'_, [u8]> {
    let has_scan = head(file).any(|(marker, _)| marker == START_OF_SCAN);
    let is_baseline = head(file).any(|(marker, _)| matches!(marker, 0xc0 | 0xc1));
    let has_tables = head(file).any(|(marker, _)| marker == DEFINE_HUFFMAN);
    if !has_scan || !is_baseline || has_tables {
        return Cow::Borrowed(file);
    }
    let (start, rest) = file.split_at(2);
    Cow::Owned([start, &HUFFMAN_TABLES, rest].concat())
}

/// Decodes a baseline file without an end marker into `samples`. Returns `false` if more than the
/// marker is missing.
///
/// A JPEG does not contain its length. Bytes after a complete image change nothing, but bytes after
/// an incomplete one are decoded in place of the missing data. The file is therefore decoded twice,
/// followed by bytes whose first bits differ. It is complete if the pictures are equal.
pub(super) fn decode_without_end(
    file: &[u8],
    [width, height]: [u32; 2],
    samples: &mut [u8],
) -> bool {
    // More than the 8 bytes that the decoder reads ahead.
    const BEHIND: usize = 32;
    // The first byte of the end marker may be present.
    let whole = file.strip_suffix(&[0xff]).unwrap_or(file);
    let mut decoder = Mjpeg::new(width, height);
    let mut decode = |byte: u8, samples: &mut [u8]| {
        let file = [whole, &[byte; BEHIND]].concat();
        decoder.decode(&file, samples).is_ok()
    };
    let mut other = vec![0; samples.len()];
    if !decode(0x00, samples) {
        return false;
    }
    let mut bytes = [0xaa, 0x55].into_iter();
    bytes.all(|byte| decode(byte, &mut other) && other == samples)
}

/// Width and height in pixels, from the start of frame.
pub(super) fn size(file: &[u8]) -> Option<[u16; 2]> {
    let (_, body) = head(file).find(|&(marker, _)| is_start_of_frame(marker))?;
    let &[_, h, e, w, i] = body.first_chunk()?;
    Some([[w, i], [h, e]].map(u16::from_be_bytes))
}

/// Returns true if a picture of the same size directly follows the first one. The file is then a
/// stream, not a picture followed by a preview or a short film.
pub(super) fn is_stream(file: &[u8]) -> bool {
    // Cameras that append pictures list them in a segment (CIPA DC-007).
    let lists = |(marker, body): (u8, &[u8])| marker == 0xe2 && body.starts_with(b"MPF\0");
    let End::At(end) = End::of(file) else {
        return false;
    };
    let next = &file[end..];
    next.starts_with(&[0xff, START_OF_IMAGE, 0xff])
        && !head(file).any(lists)
        && size(next).is_some_and(|next| size(file) == Some(next))
}

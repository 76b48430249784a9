//! The header of a JPEG (ITU-T T.81, annex B): everything before the coded image.

use lariat_message::PixelFormat;

use super::MjpegError;

const START_OF_IMAGE: u8 = 0xD8;
const END_OF_IMAGE: u8 = 0xD9;
const START_OF_SCAN: u8 = 0xDA;
const HUFFMAN_TABLES: u8 = 0xC4;

/// Properties of the image from its header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Head {
    /// Width and height, in pixels.
    pub(super) size: [u32; 2],
    /// True if the image has color.
    color: bool,
    /// True if it contains Huffman tables.
    pub(super) has_tables: bool,
    /// Largest horizontal sampling factor: a coded unit is 8 · `widest` pixels wide and contains
    /// `blocks` blocks of 8 × 8 samples.
    widest: u32,
    blocks: u32,
    /// Offset of the coded image.
    scan: usize,
}

/// Size, number of channels, and `widest` and `blocks` as in [`Head`].
struct Start {
    size: [u32; 2],
    channels: u8,
    widest: u32,
    blocks: u32,
}

impl Head {
    /// Reads the segments before the coded image.
    pub(super) fn read(jpeg: &[u8]) -> Result<Self, MjpegError> {
        match *jpeg {
            [] => return Err(MjpegError::Empty),
            [0xFF, START_OF_IMAGE, ..] => {}
            _ => return Err(damaged("it does not begin as a JPEG does")),
        }
        let (mut start, mut has_tables) = (None, false);
        let mut at = 2;
        loop {
            let (marker, body) = segment(jpeg, &mut at)?;
            match marker {
                HUFFMAN_TABLES => has_tables = true,
                // Both are sequential and Huffman-coded.
                0xC0 | 0xC1 if start.is_some() => return Err(damaged("it has two sizes")),
                0xC0 | 0xC1 => start = Some(Start::read(body)?),
                0xC2 => return Err(unsupported("a progressive JPEG")),
                // The skipped numbers are tables (0xC4), a reserved number, and one for arithmetic
                // coding.
                0xC3 | 0xC5..=0xC7 | 0xC9..=0xCB | 0xCD..=0xCF => {
                    return Err(unsupported("a lossless, hierarchical or arithmetic JPEG"));
                }
                START_OF_SCAN => {
                    let start = start.ok_or_else(|| damaged("it has no size"))?;
                    if body.first() != Some(&start.channels) {
                        return Err(unsupported("a JPEG whose channels come one by one"));
                    }
                    return Ok(Self {
                        size: start.size,
                        color: start.channels == 3,
                        has_tables,
                        widest: start.widest,
                        blocks: start.blocks,
                        scan: at,
                    });
                }
                _ => {}
            }
        }
    }

    /// Format of the decoded image.
    pub(super) fn format(&self) -> PixelFormat {
        if self.color {
            PixelFormat::Rgb8
        } else {
            PixelFormat::Gray8
        }
    }

    /// Number of blocks of 8 × 8 samples in a row of coded units.
    pub(super) fn blocks_a_row(&self) -> usize {
        (self.size[0].div_ceil(8 * self.widest) * self.blocks) as usize
    }

    /// Returns where the coded image ends: within its end marker, if it has one. The search starts
    /// at the end, where the marker usually is.
    ///
    /// The marker's first byte is kept, for a decoder that reads one more byte after the image's
    /// last bit.
    pub(super) fn end(&self, jpeg: &[u8]) -> usize {
        let scan = &jpeg[self.scan..];
        let end = scan
            .windows(2)
            .rposition(|pair| *pair == [0xFF, END_OF_IMAGE]);
        end.map_or(jpeg.len(), |end| self.scan + end + 1)
    }
}

impl Start {
    /// Parses the body of a start of frame.
    fn read(body: &[u8]) -> Result<Self, MjpegError> {
        let Some((&[bits, h, e, w, i, channels], each)) = body.split_first_chunk() else {
            return Err(damaged("its size is cut off"));
        };
        if bits != 8 {
            return Err(unsupported("a JPEG of more than 8 bits a channel"));
        }
        if !matches!(channels, 1 | 3) {
            return Err(unsupported("neither gray nor of three channels"));
        }
        let (mut widest, mut blocks) = (1, 0);
        for channel in each.chunks_exact(3).take(channels.into()) {
            let [across, down] = [channel[1] >> 4, channel[1] & 15].map(u32::from);
            widest = widest.max(across);
            blocks += across * down;
        }
        if channels == 1 {
            // A single channel is coded block by block, whatever its factors.
            (widest, blocks) = (1, 1);
        }
        Ok(Self {
            size: [[w, i], [h, e]].map(|side| u16::from_be_bytes(side).into()),
            channels,
            widest,
            blocks,
        })
    }
}

/// Reads the marker at `at` and the body of its segment, and moves `at` past them.
fn segment<'a>(jpeg: &'a [u8], at: &mut usize) -> Result<(u8, &'a [u8]), MjpegError> {
    let rest = jpeg.get(*at..).unwrap_or_default();
    // Any number of fill bytes may precede a marker.
    let fill = rest.iter().take_while(|&&byte| byte == 0xFF).count();
    let &marker = rest.get(fill).ok_or(MjpegError::CutOff)?;
    if fill == 0 {
        return Err(damaged("its head has no marker where one should be"));
    }
    // These markers come without a segment.
    if matches!(marker, 0x00 | 0x01 | 0xD0..=END_OF_IMAGE) {
        return Err(damaged("its head holds what belongs into its image"));
    }
    let rest = &rest[fill + 1..];
    let &length = rest.first_chunk().ok_or(MjpegError::CutOff)?;
    let length = usize::from(u16::from_be_bytes(length));
    let segment = rest.get(..length).ok_or(MjpegError::CutOff)?;
    let body = segment
        .get(2..)
        .ok_or_else(|| damaged("its head holds a segment without a length"))?;
    *at += fill + 1 + length;
    Ok((marker, body))
}

fn damaged(what: &str) -> MjpegError {
    MjpegError::Damaged {
        what: what.to_owned(),
    }
}

fn unsupported(what: &'static str) -> MjpegError {
    MjpegError::Unsupported { what }
}

//! The head of a JPEG (ITU-T T.81, annex B): all that stands before the coded image.

use lariat_message::PixelFormat;

use super::MjpegError;

const START_OF_IMAGE: u8 = 0xD8;
const END_OF_IMAGE: u8 = 0xD9;
const START_OF_SCAN: u8 = 0xDA;
const HUFFMAN_TABLES: u8 = 0xC4;

/// What the head says of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Head {
    /// Width and height, in pixels.
    pub(super) size: [u32; 2],
    /// Whether it is with colour.
    color: bool,
    /// Whether any Huffman tables come along.
    pub(super) has_tables: bool,
    /// The largest sampling factor along a row, and the blocks of 8 × 8 samples of a unit: so many columns of those blocks
    /// are coded together.
    widest: u32,
    blocks: u32,
    /// Where the coded image begins.
    scan: usize,
}

/// The size, the number of channels, and as in [`Head`].
struct Start {
    size: [u32; 2],
    channels: u8,
    widest: u32,
    blocks: u32,
}

impl Head {
    /// Follows the segments up to the coded image.
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
                // Both are coded in one go, by Huffman.
                0xC0 | 0xC1 if start.is_some() => return Err(damaged("it has two sizes")),
                0xC0 | 0xC1 => start = Some(Start::read(body)?),
                0xC2 => return Err(unsupported("a progressive JPEG")),
                // Those between are tables (0xC4), a reserved number and what arithmetic coding needs.
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

    /// What the image is decoded to.
    pub(super) fn format(&self) -> PixelFormat {
        if self.color {
            PixelFormat::Rgb8
        } else {
            PixelFormat::Gray8
        }
    }

    /// The blocks of 8 × 8 samples that one row of units is made of.
    pub(super) fn blocks_a_row(&self) -> usize {
        (self.size[0].div_ceil(8 * self.widest) * self.blocks) as usize
    }

    /// Where the coded image ends: within its end marker if there is one. It is sought from the back, where it is near.
    ///
    /// The marker's first byte is kept, so that a decoder that asks for more when the image's last bit is used finds some.
    pub(super) fn end(&self, jpeg: &[u8]) -> usize {
        let scan = &jpeg[self.scan..];
        let end = scan
            .windows(2)
            .rposition(|pair| *pair == [0xFF, END_OF_IMAGE]);
        end.map_or(jpeg.len(), |end| self.scan + end + 1)
    }
}

impl Start {
    /// The body of a start of frame.
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
            // A channel that is alone is coded block by block, whatever its factors.
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

/// The marker at `at` and the body of its segment, behind which `at` is then.
fn segment<'a>(jpeg: &'a [u8], at: &mut usize) -> Result<(u8, &'a [u8]), MjpegError> {
    let rest = jpeg.get(*at..).unwrap_or_default();
    // Any number of fill bytes may stand before a marker.
    let fill = rest.iter().take_while(|&&byte| byte == 0xFF).count();
    let &marker = rest.get(fill).ok_or(MjpegError::CutOff)?;
    if fill == 0 {
        return Err(damaged("its head has no marker where one should be"));
    }
    // Those stand alone.
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

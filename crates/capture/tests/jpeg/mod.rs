//! Encodes a camera's frames and the expected pixels. It is a baseline JPEG encoder (ITU-T T.81)
//! with features that picture encoders lack: any color sampling, and no Huffman tables. It keeps
//! what it has encoded, as exactly as floats allow.
#![allow(dead_code, reason = "each test binary uses a part of it")]

mod blocks;
mod huffman;

use blocks::Channel;
use huffman::{Bits, Code, codes};

/// How a frame is encoded.
#[derive(Debug, Clone)]
pub(crate) struct Coding {
    /// Sampling factors, horizontal and vertical, of Y and of UV.
    pub(crate) factors: [[usize; 2]; 2],
    pub(crate) gray: bool,
    /// Increase of the quantization from one frequency to the next; the lowest frequency has 1.
    pub(crate) step: u8,
    /// Number of units between restart markers; 0 for none.
    pub(crate) restart: usize,
    /// True to include the Huffman tables.
    pub(crate) tables: bool,
}

impl Coding {
    /// The coding of most cameras: color at half the width, no tables.
    pub(crate) const CAMERA: Self = Self {
        factors: [[2, 1], [1, 1]],
        gray: false,
        step: 3,
        restart: 0,
        tables: false,
    };
}

/// A frame and the pixels that it decodes to: RGB, or one byte per pixel.
pub(crate) struct Encoded {
    pub(crate) jpeg: Vec<u8>,
    pub(crate) pixels: Vec<u8>,
    /// Offset of the coded image.
    pub(crate) scan: usize,
}

/// Encodes a JPEG with the `image` crate, which writes the standard Huffman tables.
pub(crate) fn by_image(
    pixels: &[u8],
    [width, height]: [usize; 2],
    gray: bool,
    quality: u8,
) -> Vec<u8> {
    let mut jpeg = Vec::new();
    let color = if gray {
        image::ExtendedColorType::L8
    } else {
        image::ExtendedColorType::Rgb8
    };
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, quality)
        .encode(pixels, width as u32, height as u32, color)
        .expect("a picture of this size can be encoded");
    jpeg
}

/// The segments before the coded image: marker, and all bytes including it.
pub(crate) fn segments(jpeg: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut at = 2;
    let mut last = 0;
    std::iter::from_fn(move || {
        if last == 0xDA {
            return None;
        }
        last = jpeg[at + 1];
        let length = 2 + usize::from(u16::from_be_bytes([jpeg[at + 2], jpeg[at + 3]]));
        at += length;
        Some((last, &jpeg[at - length..at]))
    })
}

/// Removes the Huffman tables from a frame.
pub(crate) fn without_tables(jpeg: &[u8]) -> Vec<u8> {
    let kept = segments(jpeg).filter(|(marker, _)| *marker != 0xC4);
    let head: usize = 2 + segments(jpeg).map(|(_, bytes)| bytes.len()).sum::<usize>();
    let kept = kept.flat_map(|(_, bytes)| bytes);
    let mut frame = vec![0xFF, 0xD8];
    frame.extend(kept);
    frame.extend(&jpeg[head..]);
    frame
}

/// Encodes an RGB picture.
pub(crate) fn encode(rgb: &[u8], size: [usize; 2], coding: &Coding) -> Encoded {
    let [luma, chroma] = coding.factors;
    let factors = if coding.gray {
        vec![[1, 1]]
    } else {
        vec![luma, chroma, chroma]
    };
    let most = [0, 1].map(|axis| factors.iter().map(|f| f[axis]).max().unwrap_or(1));
    let units = [0, 1].map(|axis| size[axis].div_ceil(8 * most[axis]));
    let mut channels: Vec<Channel> = (0..factors.len())
        .map(|c| Channel::sample(rgb, size, units, most, factors[c], c))
        .collect();
    let quantization: [u8; 64] = std::array::from_fn(|k| {
        let [u, v] = [k % 8, k / 8];
        ((u + v) as u8)
            .saturating_mul(coding.step)
            .saturating_add(1)
    });
    let tables = by_image(&[0; 3], [1, 1], false, 50);
    let mut jpeg = head(&factors, size, &quantization, coding, &tables);
    let scan = jpeg.len();
    let codes = codes(&tables);
    let mut bits = Bits::default();
    let mut last_dc = [0; 3];
    for unit in 0..units[0] * units[1] {
        if coding.restart > 0 && unit > 0 && unit % coding.restart == 0 {
            bits.end();
            let number = (unit / coding.restart - 1) % 8;
            bits.bytes.extend([0xFF, 0xD0 + number as u8]);
            last_dc = [0; 3];
        }
        let [x, y] = [unit % units[0], unit / units[0]];
        for (c, channel) in channels.iter_mut().enumerate() {
            let [across, down] = factors[c];
            for (dx, dy) in (0..down).flat_map(|dy| (0..across).map(move |dx| (dx, dy))) {
                let levels = channel.quantize([x * across + dx, y * down + dy], &quantization);
                let [dc, ac]: [&Code; 2] = [&codes[0][c.min(1)], &codes[1][c.min(1)]];
                bits.block(&levels, &mut last_dc[c], dc, ac);
            }
        }
    }
    bits.end();
    jpeg.extend(bits.bytes);
    jpeg.extend([0xFF, 0xD9]);
    let pixels = blocks::pixels(&channels, size);
    Encoded { jpeg, pixels, scan }
}

/// Encodes an RGB picture of whole units with one scan per channel.
pub(crate) fn encode_in_scans(rgb: &[u8], size: [usize; 2], factors: [[usize; 2]; 2]) -> Encoded {
    let coding = Coding {
        factors,
        tables: true,
        ..Coding::CAMERA
    };
    let factors = [factors[0], factors[1], factors[1]];
    let most = [0, 1].map(|axis| factors.iter().map(|f| f[axis]).max().unwrap_or(1));
    let units = [0, 1].map(|axis| size[axis] / (8 * most[axis]));
    let tables = by_image(&[0; 3], [1, 1], false, 50);
    let (quantization, codes) = ([2; 64], codes(&tables));
    let mut jpeg = head(&factors, size, &quantization, &coding, &tables);
    // Remove the header of the scan of all channels.
    jpeg.truncate(jpeg.len() - 14);
    let scan = jpeg.len();
    let mut channels = Vec::new();
    for c in 0..3 {
        let mut channel = Channel::sample(rgb, size, units, most, factors[c], c);
        let tables = if c == 0 { 0x00 } else { 0x11 };
        jpeg.extend([0xFF, 0xDA, 0, 8, 1, c as u8 + 1, tables, 0, 63, 0]);
        let (mut bits, mut last_dc) = (Bits::default(), 0);
        let [across, down] = [0, 1].map(|axis| units[axis] * factors[c][axis]);
        for (x, y) in (0..down).flat_map(|y| (0..across).map(move |x| (x, y))) {
            let levels = channel.quantize([x, y], &quantization);
            bits.block(
                &levels,
                &mut last_dc,
                &codes[0][c.min(1)],
                &codes[1][c.min(1)],
            );
        }
        bits.end();
        jpeg.extend(bits.bytes);
        channels.push(channel);
    }
    jpeg.extend([0xFF, 0xD9]);
    let pixels = blocks::pixels(&channels, size);
    Encoded { jpeg, pixels, scan }
}

/// Everything before the coded image.
fn head(
    factors: &[[usize; 2]],
    [width, height]: [usize; 2],
    quantization: &[u8; 64],
    coding: &Coding,
    tables: &[u8],
) -> Vec<u8> {
    let mut jpeg = vec![0xFF, 0xD8, 0xFF, 0xDB, 0, 67, 0];
    jpeg.extend(blocks::ZIGZAG.map(|k| quantization[k]));
    let channels = factors.len() as u8;
    jpeg.extend([0xFF, 0xC0, 0, 8 + 3 * channels, 8]);
    jpeg.extend((height as u16).to_be_bytes());
    jpeg.extend((width as u16).to_be_bytes());
    jpeg.push(channels);
    for (c, [across, down]) in (1..).zip(factors) {
        jpeg.extend([c, (across << 4 | down) as u8, 0]);
    }
    if coding.tables {
        let tables = segments(tables).filter(|(marker, _)| *marker == 0xC4);
        jpeg.extend(tables.flat_map(|(_, bytes)| bytes));
    }
    if coding.restart > 0 {
        jpeg.extend([0xFF, 0xDD, 0, 4]);
        jpeg.extend((coding.restart as u16).to_be_bytes());
    }
    jpeg.extend([0xFF, 0xDA, 0, 6 + 2 * channels, channels]);
    for c in 1..=channels {
        jpeg.extend([c, if c == 1 { 0x00 } else { 0x11 }]);
    }
    jpeg.extend([0, 63, 0]);
    jpeg
}

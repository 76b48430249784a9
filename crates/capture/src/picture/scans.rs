//! Decodes baseline JPEGs with one scan per channel and fewer rows of color than of brightness
//! (`jpegtran -scans`).
//!
//! zune-jpeg 0.5 silently decodes them to stripes (its issues 419, 422 and 448). A scan of one
//! channel is coded like a gray picture of the channel's size (ITU-T T.81, A.2.2). zune-jpeg
//! decodes gray pictures correctly, so each scan is converted to one.

use crate::color_range::ColorRange;
use crate::mjpeg::Mjpeg;
use crate::yuv::write_rgb;

use super::jpeg::{START_OF_SCAN, head, is_in_scan};

const QUANTIZATION: u8 = 0xdb;
const HUFFMAN: u8 = 0xc4;
const RESTART_INTERVAL: u8 = 0xdd;

/// Returns true if a file has such scans.
pub(super) fn has_low_color_scans(file: &[u8]) -> bool {
    let mut rows = None;
    for (marker, body) in head(file) {
        match (marker, body) {
            (0xc0 | 0xc1, [_, _, _, _, _, 3, channels @ ..]) => {
                let down = |channel: &[u8]| channel.get(1).map_or(1, |factors| factors & 15);
                let mut down = channels.chunks_exact(3).map(down);
                rows = down.next().zip(down.max());
            }
            (START_OF_SCAN, [count, ..]) => {
                return *count < 3 && rows.is_some_and(|(light, color)| light > color);
            }
            _ => {}
        }
    }
    false
}

/// A channel of the picture.
struct Channel {
    id: u8,
    table: u8,
    /// Width and height, in samples.
    size: [usize; 2],
    samples: Option<Vec<u8>>,
}

/// Decodes a file into `pixels`, three bytes each. Returns `false` if it is damaged or if two
/// channels share a scan.
pub(super) fn decode(file: &[u8], pixels: &mut [u8]) -> bool {
    read(file, pixels).is_some()
}

fn read(file: &[u8], pixels: &mut [u8]) -> Option<()> {
    let (mut at, mut tables) = (2, Vec::new());
    let (mut size, mut channels) = ([0; 2], Vec::new());
    while channels.is_empty() || channels.iter().any(|c: &Channel| c.samples.is_none()) {
        let &[0xff, marker, high, low] = file.get(at..)?.first_chunk()? else {
            return None;
        };
        if marker == 0xff {
            at += 1;
            continue;
        }
        let end = at + 2 + usize::from(u16::from_be_bytes([high, low]));
        let segment = file.get(at..end)?;
        let body = segment.get(4..)?;
        at = end;
        match marker {
            QUANTIZATION | HUFFMAN | RESTART_INTERVAL => tables.extend_from_slice(segment),
            0xc0 | 0xc1 => (size, channels) = frame(body)?,
            START_OF_SCAN => {
                let data = &file[at..];
                let is_end = |pair: &[u8]| pair[0] == 0xff && !is_in_scan(pair[1]);
                let length = data.windows(2).position(is_end).unwrap_or(data.len());
                at += length;
                let &[1, id, coding, ..] = body else {
                    return None;
                };
                let channel = channels.iter_mut().find(|channel| channel.id == id)?;
                channel.decode(&tables, coding, &data[..length])?;
            }
            _ => {}
        }
    }
    write(size, &channels, pixels)
}

/// Reads the picture's size and its channels from a start of frame.
fn frame(body: &[u8]) -> Option<([usize; 2], Vec<Channel>)> {
    let (&[_, h, e, w, i, _], channels) = body.split_first_chunk()?;
    let size = [[w, i], [h, e]].map(|side| usize::from(u16::from_be_bytes(side)));
    let factors = |channel: &[u8]| [channel[1] >> 4, channel[1] & 15].map(usize::from);
    let each = channels.chunks_exact(3);
    let most = [0, 1].map(|axis| each.clone().map(|c| factors(c)[axis]).max().unwrap_or(1));
    let channel = |channel: &[u8]| Channel {
        id: channel[0],
        table: channel[2],
        size: [0, 1].map(|axis| (size[axis] * factors(channel)[axis]).div_ceil(most[axis].max(1))),
        samples: None,
    };
    Some((size, each.map(channel).collect()))
}

impl Channel {
    /// Decodes the channel's scan as a gray picture.
    fn decode(&mut self, tables: &[u8], coding: u8, data: &[u8]) -> Option<()> {
        let [width, height] = self.size;
        let sides = self.size.map(|side| (side as u16).to_be_bytes());
        let [[w, i], [h, e]] = sides;
        let start = [0xff, 0xc0, 0, 11, 8, h, e, w, i, 1, 1, 0x11, self.table];
        let scan = [0xff, START_OF_SCAN, 0, 8, 1, 1, coding, 0, 63, 0];
        let jpeg = [&[0xff, 0xd8], tables, &start, &scan, data, &[0xff, 0xd9]].concat();
        let mut samples = vec![0; width * height];
        let decoded = Mjpeg::new(width as u32, height as u32).decode(&jpeg, &mut samples);
        self.samples = decoded.ok().map(|_| samples);
        self.samples.as_ref().map(|_| ())
    }

    /// Returns the value at a pixel of a picture of this size, by linear interpolation. A sample is
    /// at the center of the pixels that it covers.
    fn at(&self, size: [usize; 2], pixel: [usize; 2]) -> u8 {
        let place = |axis: usize| {
            let (samples, pixels) = (self.size[axis], size[axis]);
            let of = pixels.div_ceil(samples.max(1)) as f32;
            let place = (pixel[axis] as f32 + 0.5) / of - 0.5;
            let place = place.clamp(0.0, samples.saturating_sub(1) as f32);
            let first = place as usize;
            (
                first,
                (first + 1).min(samples.saturating_sub(1)),
                place - first as f32,
            )
        };
        let (x, y) = (place(0), place(1));
        let samples = self.samples.as_deref().unwrap_or_default();
        let sample = |x: usize, y: usize| {
            let sample = samples.get(y * self.size[0] + x);
            sample.map_or(0.0, |&sample| f32::from(sample))
        };
        let along = |row: usize| sample(x.0, row) * (1.0 - x.2) + sample(x.1, row) * x.2;
        (along(y.0) * (1.0 - y.2) + along(y.1) * y.2 + 0.5) as u8
    }
}

/// Writes the channels as RGB.
fn write(size: [usize; 2], channels: &[Channel], pixels: &mut [u8]) -> Option<()> {
    let [y, u, v] = channels else {
        return None;
    };
    if size[0] == 0 || pixels.len() != 3 * size[0] * size[1] {
        return None;
    }
    for (index, pixel) in pixels.chunks_exact_mut(3).enumerate() {
        let place = [index % size[0], index / size[0]];
        let [y, u, v] = [y, u, v].map(|channel| [channel.at(size, place)]);
        write_rgb(ColorRange::Full, [&y, &u, &v], pixel);
    }
    Some(())
}

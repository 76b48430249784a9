//! A camera's JPEG frames from a fuzzer's bytes, and the invariants that must hold after each. A
//! frame has a valid header and any image after it, or is damaged, or consists of arbitrary bytes.

use arbitrary::Arbitrary;
use lariat_capture::Mjpeg;
use lariat_message::PixelFormat;

/// Bytes after the lent memory that must remain unchanged.
const GUARD: [u8; 64] = [0xA5; 64];

/// A few frames of one camera.
#[derive(Arbitrary, Debug)]
pub struct Frames {
    /// Negotiated image size, with sides of 1 to 256 pixels.
    width: u8,
    height: u8,
    frames: Vec<Frame>,
}

#[derive(Arbitrary, Debug)]
enum Frame {
    Any(Vec<u8>),
    Made(Made),
}

#[derive(Arbitrary, Debug)]
struct Made {
    channels: Channels,
    /// Number of units between restart markers.
    restart: Option<u8>,
    quantization: [u8; 2],
    tables: Option<Vec<Table>>,
    /// Segments that are irrelevant to the image.
    others: Vec<(u8, Vec<u8>)>,
    image: Vec<u8>,
    /// After the image: an end marker, and more bytes.
    ended: bool,
    rest: Vec<u8>,
    /// Bytes changed in transit, and the length after which everything is lost.
    changes: Vec<(u16, u8)>,
    length: Option<u16>,
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Channels {
    Gray,
    /// Sampling factors of each component, as in the header.
    Common(Common),
    Any([u8; 3]),
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Common {
    Whole,
    HalfWidth,
    Half,
    HalfHeight,
    QuarterWidth,
}

/// Class and destination, number of codes of each length, and their values.
#[derive(Arbitrary, Debug)]
struct Table(u8, [u8; 16], Vec<u8>);

impl Frames {
    /// Decodes the frames with one decoder, and checks the results.
    pub fn run(&self) {
        let [width, height] = [self.width, self.height].map(|side| u32::from(side) + 1);
        let mut decoder = Mjpeg::new(width, height);
        let largest = decoder.largest_frame_bytes();
        for frame in &self.frames {
            let jpeg = match frame {
                Frame::Any(bytes) => bytes.clone(),
                Frame::Made(made) => made.bytes([width, height]),
            };
            let mut into = vec![0; largest];
            into.extend(GUARD);
            let decoded = decoder.decode(&jpeg, &mut into);
            assert!(into.ends_with(&GUARD));
            let Ok(format) = decoded else { continue };
            assert!(matches!(format, PixelFormat::Rgb8 | PixelFormat::Gray8));
            assert_eq!(decoder.format(&jpeg), Ok(format));
            // In exactly as much memory, and with a fresh decoder.
            let bytes = format.row_bytes(width) * height as usize;
            let mut exactly = vec![0; bytes];
            let again = Mjpeg::new(width, height).decode(&jpeg, &mut exactly);
            assert_eq!(again, Ok(format));
            assert!(exactly == into[..bytes]);
        }
    }
}

impl Made {
    fn bytes(&self, [width, height]: [u32; 2]) -> Vec<u8> {
        let mut jpeg = vec![0xFF, 0xD8];
        for (marker, body) in self.others.iter().take(4) {
            segment(&mut jpeg, *marker, body);
        }
        for (number, level) in (0..).zip(self.quantization) {
            let mut table = [level; 65];
            table[0] = number;
            segment(&mut jpeg, 0xDB, &table);
        }
        let factors = match self.channels {
            Channels::Gray => vec![0x11],
            Channels::Any(factors) => factors.to_vec(),
            Channels::Common(common) => vec![common.luma(), 0x11, 0x11],
        };
        let mut body = vec![
            8,
            (height >> 8) as u8,
            height as u8,
            (width >> 8) as u8,
            width as u8,
        ];
        body.push(factors.len() as u8);
        for (c, factor) in (0..).zip(&factors) {
            body.extend([c + 1, *factor, c.min(1)]);
        }
        segment(&mut jpeg, 0xC0, &body);
        for Table(class, lengths, values) in self.tables.iter().flatten().take(6) {
            let count = lengths.iter().map(|&n| usize::from(n)).sum();
            let values = values.iter().chain(std::iter::repeat(&0)).take(count);
            let body: Vec<u8> = std::iter::once(class)
                .chain(lengths)
                .chain(values)
                .copied()
                .collect();
            segment(&mut jpeg, 0xC4, &body);
        }
        if let Some(restart) = self.restart {
            segment(&mut jpeg, 0xDD, &[0, restart]);
        }
        let mut body = vec![factors.len() as u8];
        for c in 0..factors.len() as u8 {
            body.extend([c + 1, 0x11 * c.min(1)]);
        }
        body.extend([0, 63, 0]);
        segment(&mut jpeg, 0xDA, &body);
        jpeg.extend(&self.image);
        if self.ended {
            jpeg.extend([0xFF, 0xD9]);
        }
        jpeg.extend(&self.rest);
        let length = jpeg.len();
        for &(at, byte) in &self.changes {
            jpeg[usize::from(at) % length] = byte;
        }
        if let Some(most) = self.length {
            jpeg.truncate(most.into());
        }
        jpeg
    }
}

impl Common {
    fn luma(self) -> u8 {
        match self {
            Common::Whole => 0x11,
            Common::HalfWidth => 0x21,
            Common::Half => 0x22,
            Common::HalfHeight => 0x12,
            Common::QuarterWidth => 0x41,
        }
    }
}

fn segment(jpeg: &mut Vec<u8>, marker: u8, body: &[u8]) {
    let body = &body[..body.len().min(usize::from(u16::MAX) - 2)];
    jpeg.extend([0xFF, marker]);
    jpeg.extend((body.len() as u16 + 2).to_be_bytes());
    jpeg.extend(body);
}

//! PNGs of every kind, built sample by sample, and how they are shown.

use std::fs;
use std::path::Path;

use lariat_capture::{FileOptions, RenderOptions, Source, open};
use lariat_message::PixelFormat;

/// Color types of a PNG (ISO/IEC 15948, 11.2.2).
const GRAY: u8 = 0;
const RGB: u8 = 2;
const PALETTE: u8 = 3;
const GRAY_ALPHA: u8 = 4;
const RGB_ALPHA: u8 = 6;

/// First column and row of each Adam7 pass, and the steps to the next ones.
const PASSES: [[usize; 4]; 7] = [
    [0, 0, 8, 8],
    [4, 0, 8, 8],
    [0, 4, 4, 8],
    [2, 0, 4, 4],
    [0, 2, 2, 4],
    [1, 0, 2, 2],
    [0, 1, 1, 2],
];

/// Odd numbers larger than a block of Adam7.
const WIDTH: usize = 13;
const HEIGHT: usize = 11;

#[derive(Clone, Copy, PartialEq)]
struct Kind {
    color: u8,
    depth: u8,
    interlaced: bool,
    /// True if a color, or the palette's entries, are transparent (a `tRNS` chunk).
    see_through: bool,
    /// The EXIF orientation, and whether it precedes the pixels.
    turned: Option<(u8, bool)>,
}

impl Kind {
    const fn new(color: u8, depth: u8) -> Self {
        Self {
            color,
            depth,
            interlaced: false,
            see_through: false,
            turned: None,
        }
    }

    fn channels(self) -> usize {
        match self.color {
            GRAY | PALETTE => 1,
            GRAY_ALPHA => 2,
            RGB => 3,
            _ => 4,
        }
    }

    /// The largest sample.
    fn white(self) -> u32 {
        (1 << self.depth) - 1
    }

    /// Covers all samples at every depth. Alpha takes values between transparent and opaque too.
    fn sample(self, x: usize, y: usize, channel: usize) -> u32 {
        (x * 7919 + y * 104_729 + channel * 31) as u32 % (self.white() + 1)
    }

    /// The pixel as it is shown, before the picture is turned.
    fn shown(self, x: usize, y: usize) -> Vec<u8> {
        let eight_bits = |channel| {
            let value = self.sample(x, y, channel);
            ((value * 255 + self.white() / 2) / self.white()) as u8
        };
        match self.color {
            GRAY | GRAY_ALPHA => vec![eight_bits(0)],
            PALETTE => palette(self.sample(x, y, 0)).to_vec(),
            _ => (0..3).map(eight_bits).collect(),
        }
    }
}

fn palette(index: u32) -> [u8; 3] {
    [index as u8, 255 - index as u8, (index * 37) as u8]
}

fn png(kind: Kind) -> Vec<u8> {
    let mut head = [(WIDTH as u32).to_be_bytes(), (HEIGHT as u32).to_be_bytes()].concat();
    head.extend([kind.depth, kind.color, 0, 0, kind.interlaced.into()]);
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    chunk(&mut file, b"IHDR", &head);
    if kind.color == PALETTE {
        let colors: Vec<u8> = (0..=kind.white()).flat_map(palette).collect();
        chunk(&mut file, b"PLTE", &colors);
    }
    if kind.see_through {
        match kind.color {
            PALETTE => chunk(&mut file, b"tRNS", &[0, 100]),
            GRAY => chunk(&mut file, b"tRNS", &[0, 1]),
            _ => chunk(&mut file, b"tRNS", &[0, 1, 0, 2, 0, 3]),
        }
    }
    if let Some((orientation, true)) = kind.turned {
        chunk(&mut file, b"eXIf", &note(orientation));
    }
    chunk(&mut file, b"IDAT", &zlib(&scanlines(kind)));
    if let Some((orientation, false)) = kind.turned {
        chunk(&mut file, b"eXIf", &note(orientation));
    }
    chunk(&mut file, b"IEND", &[]);
    file
}

/// An EXIF entry with the picture's orientation (CIPA DC-008: one TIFF entry, 0x0112).
fn note(orientation: u8) -> Vec<u8> {
    let mut tiff = b"II*\0\x08\0\0\0".to_vec();
    tiff.extend([1, 0, 0x12, 0x01, 3, 0, 1, 0, 0, 0, orientation, 0, 0, 0]);
    tiff.extend([0; 4]);
    tiff
}

/// The stored samples, with the filter type "none" before each row.
fn scanlines(kind: Kind) -> Vec<u8> {
    let whole = [[0, 0, 1, 1]];
    let passes = if kind.interlaced { &PASSES[..] } else { &whole };
    let mut data = Vec::new();
    for &[left, top, across, down] in passes {
        if left >= WIDTH {
            continue;
        }
        for y in (top..HEIGHT).step_by(down) {
            data.push(0);
            let (mut bits, mut count) = (0_u32, 0);
            for x in (left..WIDTH).step_by(across) {
                for channel in 0..kind.channels() {
                    bits = bits << kind.depth | kind.sample(x, y, channel);
                    count += u32::from(kind.depth);
                    while count >= 8 {
                        count -= 8;
                        data.push((bits >> count) as u8);
                        bits &= (1 << count) - 1;
                    }
                }
            }
            if count > 0 {
                data.push((bits << (8 - count)) as u8);
            }
        }
    }
    data
}

/// Wraps data in an uncompressed zlib stream (RFC 1950, 1951).
fn zlib(data: &[u8]) -> Vec<u8> {
    let length = data.len() as u16;
    let mut stream = vec![0x78, 0x01, 1];
    stream.extend(length.to_le_bytes());
    stream.extend((!length).to_le_bytes());
    stream.extend(data);
    let (mut a, mut b) = (1_u32, 0_u32);
    for byte in data {
        a = (a + u32::from(*byte)) % 65521;
        b = (b + a) % 65521;
    }
    stream.extend((b << 16 | a).to_be_bytes());
    stream
}

fn chunk(file: &mut Vec<u8>, name: &[u8; 4], data: &[u8]) {
    file.extend((data.len() as u32).to_be_bytes());
    let begin = file.len();
    file.extend(name);
    file.extend(data);
    let crc = file[begin..].iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ ((crc & 1) * 0xedb8_8320)
        })
    });
    file.extend((!crc).to_be_bytes());
}

/// Width, height, format and pixels of the file as a source shows it.
fn shown(path: &Path) -> ([u32; 2], PixelFormat, Vec<u8>) {
    let source = Source::named(&[path], FileOptions::default(), RenderOptions::default());
    let mut source = open(&source).unwrap();
    let frame = source.next().unwrap().unwrap();
    let mut pixels = vec![0xA5; frame.bytes()];
    source.write(&mut pixels);
    ([frame.width, frame.height], frame.format, pixels)
}

fn assert_shown_as_drawn(kind: Kind) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    fs::write(&path, png(kind)).unwrap();
    let about = format!(
        "colour type {}, {} bits, interlaced {}, tRNS {}",
        kind.color, kind.depth, kind.interlaced, kind.see_through
    );
    let (size, format, pixels) = shown(&path);
    assert_eq!(size, [WIDTH as u32, HEIGHT as u32], "{about}");
    let gray = matches!(kind.color, GRAY | GRAY_ALPHA);
    let expected = if gray {
        PixelFormat::Gray8
    } else {
        PixelFormat::Rgb8
    };
    assert_eq!(format, expected, "{about}");
    let drawn: Vec<u8> = (0..HEIGHT)
        .flat_map(|y| (0..WIDTH).flat_map(move |x| kind.shown(x, y)))
        .collect();
    assert_eq!(pixels, drawn, "{about}");
}

#[test]
fn every_kind_is_shown_as_it_was_drawn() {
    let kinds = [
        (GRAY, &[1, 2, 4, 8, 16][..]),
        (RGB, &[8, 16]),
        (PALETTE, &[1, 2, 4, 8]),
        (GRAY_ALPHA, &[8, 16]),
        (RGB_ALPHA, &[8, 16]),
    ];
    for (color, depths) in kinds {
        for &depth in depths {
            for interlaced in [false, true] {
                for see_through in [false, true] {
                    if see_through && matches!(color, GRAY_ALPHA | RGB_ALPHA) {
                        continue;
                    }
                    assert_shown_as_drawn(Kind {
                        interlaced,
                        see_through,
                        ..Kind::new(color, depth)
                    });
                }
            }
        }
    }
}

#[test]
fn a_note_on_how_it_lies_is_heeded_before_the_pixels_and_behind_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    // Stored column and row of a pixel in the upright picture, for each orientation (CIPA DC-008,
    // 4.6.5).
    let (right, bottom) = (WIDTH - 1, HEIGHT - 1);
    type Place = fn(usize, usize, usize, usize) -> (usize, usize);
    let places: [Place; 8] = [
        |x, y, _, _| (x, y),
        |x, y, right, _| (right - x, y),
        |x, y, right, bottom| (right - x, bottom - y),
        |x, y, _, bottom| (x, bottom - y),
        |x, y, _, _| (y, x),
        |x, y, _, bottom| (y, bottom - x),
        |x, y, right, bottom| (right - y, bottom - x),
        |x, y, right, _| (right - y, x),
    ];
    for (number, place) in (1..).zip(places) {
        for is_before in [true, false] {
            for (color, depth) in [(GRAY, 8), (RGB, 16)] {
                let kind = Kind {
                    turned: Some((number, is_before)),
                    ..Kind::new(color, depth)
                };
                fs::write(&path, png(kind)).unwrap();
                let ([width, height], _, pixels) = shown(&path);
                let sideways = number > 4;
                assert_eq!(width as usize, if sideways { HEIGHT } else { WIDTH });
                let upright: Vec<u8> = (0..height as usize)
                    .flat_map(|y| (0..width as usize).map(move |x| (x, y)))
                    .map(|(x, y)| place(x, y, right, bottom))
                    .flat_map(|(x, y)| kind.shown(x, y))
                    .collect();
                assert_eq!(pixels, upright, "{number} {is_before} {depth}");
            }
        }
    }
}

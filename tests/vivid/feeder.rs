#![allow(unsafe_code)] // One ioctl, which tells a v4l2loopback device the format that it is fed.
//! Feeds a rendered rope to a v4l2loopback device as Motion JPEG, as a USB camera sends it:
//!
//!     vivid-feeder DEVICE WIDTHxHEIGHT FPS [without-tables] [damaged=N]
//!     vivid-feeder DEVICE WIDTHxHEIGHT FPS depth=DEVICE code=CODE
//!
//! `without-tables`: leaves out the Huffman tables, as many cameras do to save bytes. `damaged=N`:
//! cuts every Nth frame in half. `depth`: shows a lifted rope at rest instead, in color (`RGB3`). A
//! depth camera 15 mm to the right of the color camera shows it on a second device, in the pixel
//! format `code`: `Z16` or `Y16`. The program runs until it is killed.

use std::error::Error;
use std::fs::File;
use std::io::{Cursor, Write};
use std::time::{Duration, Instant};

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use lariat_capture::{RenderOptions, Source};
use lariat_drawn::space::{DepthSensor, Eye, LiftOptions, LiftedRope, depth, picture};
use rustix::ioctl::{Updater, ioctl, opcode};

/// Number of frames that are drawn in advance and then fed repeatedly, because drawing takes longer
/// than a frame.
const FRAMES: usize = 20;

/// `v4l2_format` with a `v4l2_pix_format`, as words.
type Format = [u64; 26];

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [device, size, fps, options @ ..] = &words[..] else {
        return Err(
            "say DEVICE WIDTHxHEIGHT FPS [without-tables] [damaged=N] [depth=DEVICE code=CODE]"
                .into(),
        );
    };
    let (width, height) = size.split_once('x').ok_or("a size is WIDTHxHEIGHT")?;
    let (width, height): (u32, u32) = (width.parse()?, height.parse()?);
    let fps: f64 = fps.parse()?;
    let option = |name: &str| options.iter().find_map(|option| option.strip_prefix(name));
    if let (Some(depth), Some(code)) = (option("depth="), option("code=")) {
        return feed_in_space([device, depth], code, [width, height], fps);
    }
    let without_tables = options.iter().any(|option| option == "without-tables");
    let damaged: Option<usize> = option("damaged=").map(str::parse).transpose()?;

    let frames = frames(width, height, fps, without_tables)?;
    let mut device = File::options().read(true).write(true).open(device)?;
    // Maximum size of a frame; a JPEG has no rows.
    set_format(&device, b"MJPG", [width, height], [0, 4 * width * height])?;
    eprintln!("feeding");
    let began = Instant::now();
    for count in 0_usize.. {
        let due = Duration::from_secs_f64(count as f64 / fps);
        std::thread::sleep(due.saturating_sub(began.elapsed()));
        let frame = &frames[count % frames.len()];
        let is_damaged = damaged.is_some_and(|nth| count % nth == nth - 1);
        let end = if is_damaged {
            frame.len() / 2
        } else {
            frame.len()
        };
        // One write is one frame.
        device.write_all(&frame[..end])?;
    }
    Ok(())
}

/// Feeds a lifted rope in front of two cameras.
fn feed_in_space(
    devices: [&str; 2],
    code: &str,
    [width, height]: [u32; 2],
    fps: f64,
) -> Result<(), Box<dyn Error>> {
    let code = format!("{code:<4}");
    let code = code.as_bytes().try_into()?;
    let size = [width as usize, height as usize];
    let focal_px = f64::from(width * 72 / 100);
    let eye = Eye::above(focal_px, size, 500.0, 15.0, 30.0);
    let options = LiftOptions {
        length_mm: 500.0,
        radius_mm: 5.0,
        lift_mm: 80.0,
        crossings: 0,
    };
    let rope = LiftedRope::new(&options, &eye, 3)?;
    let beside = eye.beside([-15.0, 0.0, 0.0], focal_px, size);
    let units = depth(&rope, &beside, &DepthSensor::STEREO, 3);
    let frames = [
        picture(&rope, &eye, 3),
        units.iter().flat_map(|unit| unit.to_le_bytes()).collect(),
    ];
    let open = |path| File::options().read(true).write(true).open(path);
    let (mut color, mut beside) = (open(devices[0])?, open(devices[1])?);
    set_format(
        &color,
        b"RGB3",
        [width, height],
        [3 * width, 3 * width * height],
    )?;
    set_format(
        &beside,
        code,
        [width, height],
        [2 * width, 2 * width * height],
    )?;
    let steps = rope.points.windows(2).map(|pair| {
        let squares = (0..3).map(|k| (pair[1][k] - pair[0][k]).powi(2));
        squares.sum::<f64>().sqrt()
    });
    eprintln!("feeding a rope of {:.0} mm", steps.sum::<f64>());
    let began = Instant::now();
    for count in 0_u32.. {
        let due = Duration::from_secs_f64(f64::from(count) / fps);
        std::thread::sleep(due.saturating_sub(began.elapsed()));
        color.write_all(&frames[0])?;
        beside.write_all(&frames[1])?;
    }
    Ok(())
}

fn frames(
    width: u32,
    height: u32,
    fps: f64,
    without_tables: bool,
) -> Result<Vec<Vec<u8>>, Box<dyn Error>> {
    let mut source = lariat_capture::open(&Source::Rendered(RenderOptions {
        width,
        height,
        frame_interval_s: 1.0 / fps,
        ..RenderOptions::default()
    }))?;
    let mut frames = Vec::with_capacity(FRAMES);
    while frames.len() < FRAMES {
        let frame = source.next()?.ok_or("the rendered rope never ends")?;
        let mut pixels = vec![0; frame.bytes()];
        source.write(&mut pixels);
        let rows = pixels.chunks(frame.stride as usize);
        let rgb: Vec<u8> = rows
            .flat_map(|row| &row[..3 * width as usize])
            .copied()
            .collect();
        let mut jpeg = Cursor::new(Vec::new());
        JpegEncoder::new_with_quality(&mut jpeg, 90).write_image(
            &rgb,
            width,
            height,
            ExtendedColorType::Rgb8,
        )?;
        let jpeg = jpeg.into_inner();
        frames.push(match without_tables {
            true => without_huffman_tables(&jpeg),
            false => jpeg,
        });
    }
    Ok(frames)
}

/// Removes the segments of Huffman tables, which are the standard's own, from a JPEG.
fn without_huffman_tables(jpeg: &[u8]) -> Vec<u8> {
    const HUFFMAN_TABLES: u8 = 0xc4;
    const START_OF_SCAN: u8 = 0xda;
    let mut out = jpeg[..2].to_vec();
    let mut at = 2;
    while let [0xff, marker, high, low, ..] = jpeg[at..] {
        if marker == START_OF_SCAN {
            break;
        }
        let end = at + 2 + usize::from(u16::from_be_bytes([high, low]));
        if marker != HUFFMAN_TABLES {
            out.extend_from_slice(&jpeg[at..end]);
        }
        at = end;
    }
    out.extend_from_slice(&jpeg[at..]);
    out
}

/// Sets the format. `[row_bytes, bytes]`: sizes of a row and of a frame.
fn set_format(
    device: &File,
    code: &[u8; 4],
    [width, height]: [u32; 2],
    [row_bytes, bytes]: [u32; 2],
) -> rustix::io::Result<()> {
    const VIDEO_OUTPUT: u32 = 2;
    const FIELD_NONE: u32 = 1;
    let pair = |first: u32, second: u32| {
        let [a, b, c, d] = first.to_ne_bytes();
        let [e, f, g, h] = second.to_ne_bytes();
        u64::from_ne_bytes([a, b, c, d, e, f, g, h])
    };
    let mut format: Format = [0; 26];
    format[0] = pair(VIDEO_OUTPUT, 0);
    format[1] = pair(width, height);
    format[2] = pair(u32::from_le_bytes(*code), FIELD_NONE);
    format[3] = pair(row_bytes, bytes);
    // SAFETY: the argument of VIDIOC_S_FMT is a v4l2_format of 208 bytes, without a pointer for
    // this type.
    unsafe {
        ioctl(
            device,
            Updater::<{ opcode::read_write::<Format>(b'V', 5) }, Format>::new(&mut format),
        )
    }
}

#![allow(unsafe_code)] // One ioctl, to tell a v4l2loopback device what it is fed.
//! Feeds a v4l2loopback device with a rendered rope as Motion JPEG, as a USB camera sends it:
//!
//!     vivid-feeder DEVICE WIDTHxHEIGHT FPS [without-tables] [damaged=N]
//!
//! `without-tables`: the Huffman tables are left out, which is how many cameras save bytes. `damaged=N`: of every Nth frame
//! only half is there. Goes on until it is killed.

use std::error::Error;
use std::fs::File;
use std::io::{Cursor, Write};
use std::time::{Duration, Instant};

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use lariat_capture::{RenderOptions, Source};
use rustix::ioctl::{Updater, ioctl, opcode};

/// Frames that are drawn before the first is fed, to be fed round and round: drawing takes longer than a frame.
const FRAMES: usize = 20;

/// `v4l2_format` with a `v4l2_pix_format`, in words.
type Format = [u64; 26];

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [device, size, fps, options @ ..] = &words[..] else {
        return Err("say DEVICE WIDTHxHEIGHT FPS [without-tables] [damaged=N]".into());
    };
    let (width, height) = size.split_once('x').ok_or("a size is WIDTHxHEIGHT")?;
    let (width, height): (u32, u32) = (width.parse()?, height.parse()?);
    let fps: f64 = fps.parse()?;
    let without_tables = options.iter().any(|option| option == "without-tables");
    let damaged: Option<usize> = (options.iter())
        .find_map(|option| option.strip_prefix("damaged="))
        .map(str::parse)
        .transpose()?;

    let frames = frames(width, height, fps, without_tables)?;
    let mut device = File::options().read(true).write(true).open(device)?;
    set_format(&device, width, height)?;
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

/// A JPEG without its segments of Huffman tables, which are the standard's own.
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

fn set_format(device: &File, width: u32, height: u32) -> rustix::io::Result<()> {
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
    format[2] = pair(u32::from_le_bytes(*b"MJPG"), FIELD_NONE);
    // Bytes of a row, which a JPEG does not have, and the most that a frame can have.
    format[3] = pair(0, 4 * width * height);
    // SAFETY: VIDIOC_S_FMT's argument is a v4l2_format, of 208 bytes and without a pointer for this type.
    unsafe {
        ioctl(
            device,
            Updater::<{ opcode::read_write::<Format>(b'V', 5) }, Format>::new(&mut format),
        )
    }
}

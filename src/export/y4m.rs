//! Frames as a Y4M video, which `lariat run --source` can play. 8-bit gray, YUYV, UYVY and NV12 are
//! lossless. RGB is rounded to YUV, and Bayer patterns are demosaiced first.

use super::{Part, Written};
use anyhow::{Context, Result, bail};
use lariat_chain::pipeline::FrameView;
use lariat_chain::recorded::{Decoder, Pixels};
use lariat_chain::settings::USUAL_FPS;
use lariat_wire::{FrameHeader, PixelFormat};
use std::io::Write;

pub(super) fn write(part: &Part, file: &mut impl Write) -> Result<Written> {
    let about = || part.failure();
    let fps = frames_per_second(part)?;
    let mut frames = part.frames()?;
    let mut decoder = Decoder::of(part.recording);
    let mut planes = Vec::new();
    let mut first: Option<FrameHeader> = None;
    let (mut place, mut count, mut blank) = (0, 0_u64, 0_u64);
    while let Some(frame) = frames.next_frame()? {
        let wanted = part.is_wanted(place);
        place += 1;
        let (kind, bytes) = Pixels::split(frame.pixels);
        if !wanted || kind == Pixels::None {
            blank += u64::from(wanted);
            continue;
        }
        let (header, bytes) = decoder.decode(&frame.header, kind, bytes)?;
        let kind = |of: &FrameHeader| (of.width, of.height, of.pixel_format);
        match &first {
            None => {
                let line = head(&header, fps)?;
                file.write_all(line.as_bytes()).with_context(about)?;
                first = Some(header);
            }
            Some(first) if kind(first) == kind(&header) => {}
            Some(_) => bail!(
                "frame {} has another size or format than those before it, which a video cannot have: export the parts by \
                 themselves (--from, --to)",
                header.trace.sequence
            ),
        }
        planes.clear();
        separate(&header, bytes, &mut planes)?;
        file.write_all(b"FRAME\n").with_context(about)?;
        file.write_all(&planes).with_context(about)?;
        count += 1;
    }
    let Some(first) = first else {
        bail!("there are no images in this part of the recording");
    };
    let mut notes = Vec::from_iter(decoder.take_news());
    match first.format() {
        Some(PixelFormat::Gray8 | PixelFormat::Yuyv | PixelFormat::Uyvy | PixelFormat::Nv12) => {}
        Some(PixelFormat::Gray16) => notes.push(
            "the frames have 16 bits and the video has 8: their levels are rounded (--format png is exact)".to_owned(),
        ),
        _ => notes.push(
            "the frames are RGB and a Y4M video is YUV: colors are rounded, by up to two levels (--format png is exact)"
                .to_owned(),
        ),
    }
    if blank > 0 {
        notes.push(format!(
            "{blank} frames have no image, and are not in the video"
        ));
    }
    Ok(Written {
        what: format!("a video of {count} frames at {fps:.3} frames/s"),
        notes,
    })
}

/// Frame rate of the part, from the capture times.
fn frames_per_second(part: &Part) -> Result<f64> {
    let all = match part.frame_times_ns()? {
        (count @ 2.., Some([first_ns, last_ns])) if last_ns > first_ns => {
            (count - 1) as f64 * 1e9 / (last_ns - first_ns) as f64
        }
        _ => USUAL_FPS,
    };
    Ok(all / part.args.every.get() as f64)
}

/// First line of the file.
fn head(header: &FrameHeader, fps: f64) -> Result<String> {
    let chroma = match header.format() {
        Some(PixelFormat::Gray8 | PixelFormat::Gray16) => "mono",
        Some(PixelFormat::Yuyv | PixelFormat::Uyvy) => "422",
        Some(PixelFormat::Nv12) => "420jpeg",
        Some(_) => "444",
        None => bail!(
            "the frames are in pixel format {}, which this release does not know",
            header.pixel_format
        ),
    };
    let (width, height) = (header.width, header.height);
    let thousandths = (fps * 1000.0).round().clamp(1.0, 1e9);
    Ok(format!(
        "YUV4MPEG2 W{width} H{height} F{thousandths}:1000 Ip A1:1 C{chroma} XCOLORRANGE=FULL\n"
    ))
}

/// Appends the planes Y, U and V of a frame, one after the other and without row padding.
fn separate(header: &FrameHeader, bytes: &[u8], to: &mut Vec<u8>) -> Result<()> {
    let (width, height) = (header.width as usize, header.height as usize);
    let stride = header.stride as usize;
    let rows = || bytes.chunks_exact(stride).take(height);
    match header.format() {
        Some(PixelFormat::Gray8) => rows().for_each(|row| to.extend_from_slice(&row[..width])),
        // With an odd width, only one pixel of the last pair is part of the image.
        Some(PixelFormat::Yuyv) => packed(rows(), width, [0, 1, 3], to),
        Some(PixelFormat::Uyvy) => packed(rows(), width, [1, 0, 2], to),
        Some(PixelFormat::Nv12) => {
            rows().for_each(|row| to.extend_from_slice(&row[..width]));
            let pairs = bytes.chunks_exact(stride).skip(height);
            for channel in [0, 1] {
                let rows = pairs.clone().take(height.div_ceil(2));
                for row in rows {
                    let pairs = row.chunks(2).take(width.div_ceil(2));
                    to.extend(pairs.map(|pair| pair.get(channel).copied().unwrap_or(128)));
                }
            }
        }
        Some(PixelFormat::Rgb8) => rgb(rows(), width, [0, 1, 2], to),
        Some(PixelFormat::Bgr8) => rgb(rows(), width, [2, 1, 0], to),
        Some(format) => {
            let pixels = FrameView::new(header, bytes).image()?.to_rgb();
            if format == PixelFormat::Gray16 {
                to.extend(pixels.iter().step_by(3));
            } else {
                rgb(pixels.chunks_exact(3 * width), width, [0, 1, 2], to);
            }
        }
        None => {}
    }
    Ok(())
}

/// Splits rows that store two pixels in four bytes. `[y, u, v]`: positions of the first luma byte
/// and of the two chroma bytes.
fn packed<'a>(
    rows: impl Iterator<Item = &'a [u8]> + Clone,
    width: usize,
    [y, u, v]: [usize; 3],
    to: &mut Vec<u8>,
) {
    for row in rows.clone() {
        to.extend(row.iter().skip(y).step_by(2).take(width));
    }
    for place in [u, v] {
        for row in rows.clone() {
            to.extend(row.iter().skip(place).step_by(4).take(width.div_ceil(2)));
        }
    }
}

/// Converts by ITU-R BT.601 in full range. Reading the video back inverts this, except for
/// rounding.
fn rgb<'a>(
    rows: impl Iterator<Item = &'a [u8]> + Clone,
    width: usize,
    places: [usize; 3],
    to: &mut Vec<u8>,
) {
    const OF: [([f32; 3], f32); 3] = [
        ([0.299, 0.587, 0.114], 0.0),
        ([-0.168_736, -0.331_264, 0.5], 128.0),
        ([0.5, -0.418_688, -0.081_312], 128.0),
    ];
    for (weights, middle) in OF {
        for row in rows.clone() {
            for pixel in row.chunks_exact(3).take(width) {
                let of = |i: usize| weights[i] * f32::from(pixel[places[i]]);
                let level = of(0) + of(1) + of(2) + middle;
                to.push(level.round().clamp(0.0, 255.0) as u8);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(format: PixelFormat, width: u32, height: u32) -> FrameHeader {
        FrameHeader {
            width,
            height,
            stride: format.row_bytes(width) as u32,
            pixel_format: format as u32,
            ..FrameHeader::default()
        }
    }

    fn planes(format: PixelFormat, width: u32, height: u32, bytes: &[u8]) -> Vec<u8> {
        let mut to = Vec::new();
        separate(&header(format, width, height), bytes, &mut to).unwrap();
        to
    }

    #[test]
    fn packed_pixels_are_taken_apart_to_the_bit() {
        let yuyv = [1, 10, 2, 20, 3, 11, 4, 21];
        let apart = [1, 2, 3, 4, 10, 11, 20, 21];
        assert_eq!(planes(PixelFormat::Yuyv, 4, 1, &yuyv), apart);
        let uyvy = [10, 1, 20, 2, 11, 3, 21, 4];
        assert_eq!(planes(PixelFormat::Uyvy, 4, 1, &uyvy), apart);
        let nv12 = [1, 2, 3, 4, 10, 20];
        let apart = [1, 2, 3, 4, 10, 20];
        assert_eq!(planes(PixelFormat::Nv12, 2, 2, &nv12), apart);
        assert_eq!(planes(PixelFormat::Gray8, 2, 1, &[7, 8]), [7, 8]);
        assert_eq!(planes(PixelFormat::Gray16, 2, 1, &[7, 7, 8, 8]), [7, 8]);
    }

    #[test]
    fn gray_colors_keep_their_level_in_yuv() {
        for level in 0..=255 {
            let apart = planes(PixelFormat::Rgb8, 1, 1, &[level; 3]);
            assert_eq!(apart, [level, 128, 128]);
        }
        let red = planes(PixelFormat::Rgb8, 1, 1, &[255, 0, 0]);
        assert_eq!(red, planes(PixelFormat::Bgr8, 1, 1, &[0, 0, 255]));
        assert_eq!(red, [76, 85, 255]);
        assert_eq!(red, planes(PixelFormat::Bgra8, 1, 1, &[0, 0, 255, 9]));
        let mosaic = [[255, 0, 255], [0, 0, 0], [255, 0, 255]].concat();
        let filled = planes(PixelFormat::BayerRggb8, 3, 3, &mosaic);
        assert_eq!(filled, [[76; 9], [85; 9], [255; 9]].concat());
    }

    #[test]
    fn the_head_is_one_that_the_reader_knows() {
        let line = head(&header(PixelFormat::Nv12, 640, 480), 29.97).unwrap();
        assert_eq!(
            line,
            "YUV4MPEG2 W640 H480 F29970:1000 Ip A1:1 C420jpeg XCOLORRANGE=FULL\n"
        );
    }
}

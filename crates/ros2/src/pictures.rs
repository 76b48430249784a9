//! A frame as JPEG, with or without the ropes drawn on it: `sensor_msgs/CompressedImage`.
//!
//! Images are compressed, because RustDDS takes tens of milliseconds to send 1 MB and cannot send
//! 10 MB.

use anyhow::{Context, Result};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder, RgbImage};
use lariat_chain::canvas::Canvas;
use lariat_record::{
    CompressedImageRecord, Images, PictureMaker, encode_compressed_image, encode_image, rope_color,
};
use lariat_wire::{Centerlines, FrameHeader};

use crate::messages::Header;

const END: [u8; 3] = [255; 3];

/// Makes images, in buffers that it keeps.
pub(crate) struct Pictures {
    quality: u8,
    maker: PictureMaker,
    raw: Vec<u8>,
    file: Vec<u8>,
}

impl Pictures {
    pub(crate) fn new(quality: u8) -> Self {
        Self {
            quality,
            maker: PictureMaker::default(),
            raw: Vec::new(),
            file: Vec::new(),
        }
    }

    /// Writes the frame as a compressed image. Returns `false` for a blank frame, and for a Bayer
    /// pattern, which JPEG does not support.
    pub(crate) fn plain(
        &mut self,
        frame: &FrameHeader,
        bytes: &[u8],
        header: &Header,
        into: &mut Vec<u8>,
    ) -> bool {
        encode_image(
            frame,
            bytes,
            header.stamp_ns,
            header.frame_id,
            &mut self.raw,
        ) && self
            .maker
            .make(&self.raw, Images::Jpeg(self.quality), into)
            .is_ok_and(|made| made)
    }

    /// Writes a frame that is already a compressed image, with the ropes drawn as extract found
    /// them. Each has its own color, gray where it is covered, and a dot at its first end.
    ///
    /// # Errors
    /// It is not a compressed image.
    pub(crate) fn with_ropes(
        &mut self,
        plain: &[u8],
        seen: &Centerlines,
        header: &Header,
        into: &mut Vec<u8>,
    ) -> Result<()> {
        let plain = CompressedImageRecord::decode(plain)?;
        let picture =
            image::load_from_memory(plain.data).context("the picture was not read again")?;
        let drawn = draw(picture.into_rgb8(), seen);
        self.file.clear();
        JpegEncoder::new_with_quality(&mut self.file, self.quality).write_image(
            &drawn,
            drawn.width(),
            drawn.height(),
            ExtendedColorType::Rgb8,
        )?;
        encode_compressed_image(&self.file, "jpeg", header.stamp_ns, header.frame_id, into);
        Ok(())
    }
}

fn draw(picture: RgbImage, seen: &Centerlines) -> RgbImage {
    let mut canvas = Canvas::on(picture);
    for rope in seen.curves() {
        let points: Vec<[f64; 2]> = rope.points().iter().map(|p| p.map(f64::from)).collect();
        let width_px = (0.3 * f64::from(rope.width_px)).max(2.0);
        canvas.line(&points, width_px);
        if rope.closed != 0
            && let (Some(first), Some(last)) = (points.first(), points.last())
        {
            canvas.line(&[*last, *first], width_px);
        }
        canvas.ink(rope_color(rope.track), 1.0);
        if let Some(first) = points.first() {
            canvas.dots(&[*first], 2.5 * width_px).ink(END, 1.0);
        }
    }
    canvas.picture
}

//! A picture full of ropes for warming up. After extracting from it, an extractor's buffers are
//! large enough for camera images, so that the first crossing causes no allocation in the middle of
//! a motion.

use crate::image::{Image, PixelFormat};

/// Number of ropes in each direction.
const ROPES: usize = 4;
const TABLE: u8 = 200;
const ROPE: u8 = 40;

/// A gray picture of four wavy ropes from left to right over four from top to bottom, with sixteen
/// crossings.
pub(crate) fn picture(width: usize, height: usize) -> Vec<u8> {
    let mut pixels = vec![TABLE; width * height];
    // A fortieth of the shorter side: thick enough for a rope, and thin enough to leave table in
    // between.
    let half = (width.min(height) / 80).max(2);
    for rope in 0..ROPES {
        for x in width / 16..width - width / 16 {
            let middle = wave(x, width, rope, height);
            let rows = middle.saturating_sub(half)..(middle + half).min(height);
            rows.for_each(|y| pixels[y * width + x] = ROPE);
        }
        for y in height / 16..height - height / 16 {
            let middle = wave(y, height, rope, width);
            let columns = middle.saturating_sub(half)..(middle + half).min(width);
            pixels[y * width..][columns].fill(ROPE);
        }
    }
    pixels
}

/// The table alone.
pub(crate) fn bare(width: usize, height: usize) -> Vec<u8> {
    vec![TABLE; width * height]
}

/// Distance of a rope from the edge at `along`: its own lane, and the swing of a curve to either
/// side.
fn wave(along: usize, length: usize, rope: usize, across: usize) -> usize {
    let t = along as f32 / length.max(1) as f32 * 2.0 - 1.0;
    let swing = (1.0 - t * t) * t * 0.2;
    let lane = (rope as f32 + 0.5) / ROPES as f32;
    ((lane + swing / ROPES as f32) * across as f32) as usize
}

/// That picture as an image, if an image can have this size.
pub(crate) fn image(pixels: &[u8], width: usize, height: usize) -> Option<Image<'_>> {
    Image::new(pixels, width, height, width, PixelFormat::Gray8).ok()
}

//! Encoding of pictures as a GIF in which each picture holds only what has changed.
//!
//! A camera's noise changes every pixel. A pixel is drawn again only if it differs from its last
//! drawn value by more than [`NOISE`]. Otherwise it is transparent and the previous pixel stays.
//! GIF compresses long runs of one index well.

use anyhow::{Context, Result};
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use image::{Rgb, RgbImage, Rgba, RgbaImage, imageops};

/// Maximum difference in byte steps for which a pixel is kept.
const NOISE: u8 = 7;
/// Duration of the last picture, in hundredths of a second.
const LAST_CS: u16 = 200;
/// Shortest duration that players respect.
const SHORTEST_CS: u16 = 2;
/// Color quantization that considers every pixel, so that thin lines in rare colors keep their
/// colors.
const SPEED: i32 = 1;

/// Encodes pictures of one size as a looping GIF. Each is shown from its time on, in seconds.
///
/// # Errors
/// There is no picture, or it is too large for a GIF.
pub(super) fn gif(pictures: &[(f64, RgbImage)]) -> Result<Vec<u8>> {
    let (_, first) = pictures
        .first()
        .context("there is no film, as no image came that it could be made of")?;
    let side = |px: u32| u16::try_from(px).context("images of this size do not fit into a GIF");
    let (width, height) = (side(first.width())?, side(first.height())?);
    let mut bytes = Vec::new();
    // Each picture has its own palette.
    let mut encoder = Encoder::new(&mut bytes, width, height, &[])?;
    encoder.set_repeat(Repeat::Infinite)?;
    // The value with which each pixel was last drawn.
    let mut shown: Vec<Option<[u8; 3]>> = vec![None; first.pixels().len()];
    for (i, (at_s, picture)) in pictures.iter().enumerate() {
        let delay = match pictures.get(i + 1) {
            Some((next_s, _)) => hundredths(*next_s).saturating_sub(hundredths(*at_s)),
            None => u64::from(LAST_CS),
        };
        let delay = delay.clamp(SHORTEST_CS.into(), u16::MAX.into()) as u16;
        let mut frame = changes(picture, &mut shown);
        frame.delay = delay;
        encoder.write_frame(&frame)?;
    }
    drop(encoder);
    Ok(bytes)
}

/// Rounds the time since the film's start, so that rounding errors do not accumulate.
fn hundredths(at_s: f64) -> u64 {
    (100.0 * at_s).round() as u64
}

/// Returns the smallest rectangle that contains all changed pixels, and records them as shown.
fn changes(picture: &RgbImage, shown: &mut [Option<[u8; 3]>]) -> Frame<'static> {
    let mut changed = RgbaImage::new(picture.width(), picture.height());
    // Left, top, right, bottom. One pixel if none has changed, because a frame cannot be empty.
    let mut bounds: Option<[u32; 4]> = None;
    for ((x, y, &Rgb(pixel)), shown) in picture.enumerate_pixels().zip(shown) {
        if shown.is_some_and(|shown| is_near(shown, pixel)) {
            continue;
        }
        *shown = Some(pixel);
        let [red, green, blue] = pixel;
        changed.put_pixel(x, y, Rgba([red, green, blue, u8::MAX]));
        let [left, top, right, bottom] = bounds.unwrap_or([x, y, x, y]);
        bounds = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
    }
    let [left, top, right, bottom] = bounds.unwrap_or_default();
    let (width, height) = (right + 1 - left, bottom + 1 - top);
    let mut part = imageops::crop_imm(&changed, left, top, width, height).to_image();
    // The casts fit u16, because the whole picture does.
    Frame {
        left: left as u16,
        top: top as u16,
        dispose: DisposalMethod::Keep,
        ..Frame::from_rgba_speed(width as u16, height as u16, &mut part, SPEED)
    }
}

fn is_near(a: [u8; 3], b: [u8; 3]) -> bool {
    (0..3).all(|k| a[k].abs_diff(b[k]) <= NOISE)
}

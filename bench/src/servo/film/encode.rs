//! Pictures as a GIF: one palette for all, and of each picture only what has changed.
//!
//! A camera's noise changes every pixel. A pixel is drawn again only when it differs from what it was drawn for by more
//! than [`NOISE`]; else it is transparent, and what was there stays. Long runs of one index are what GIF packs well.

use anyhow::{Context, Result};
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use image::{Rgb, RgbImage};

use super::palette::Palette;

/// Steps of a byte by which a pixel may differ and yet stay.
const NOISE: u8 = 7;
/// How long the last picture stays, in hundredths of a second.
const LAST_CS: u16 = 200;
/// The shortest that players obey.
const SHORTEST_CS: u16 = 2;
/// The palette is made of so many pictures.
const SAMPLED: usize = 8;

/// A GIF without end of pictures of one size, each from its time on, in seconds.
///
/// # Errors
/// There is no picture, or it is larger than a GIF can be.
pub(super) fn gif(pictures: &[(f64, RgbImage)]) -> Result<Vec<u8>> {
    let (_, first) = pictures
        .first()
        .context("there is no film, as no image came that it could be made of")?;
    let side = |px: u32| u16::try_from(px).context("a film of such large images is no GIF");
    let (width, height) = (side(first.width())?, side(first.height())?);
    let step = pictures.len().div_ceil(SAMPLED);
    let sampled = pictures.iter().rev().step_by(step);
    let mut palette =
        Palette::of(sampled.flat_map(|(_, picture)| picture.pixels().map(|Rgb(rgb)| rgb)));
    let colors = palette.bytes();
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height, &colors)?;
    encoder.set_repeat(Repeat::Infinite)?;
    // What each pixel was drawn for, before the palette.
    let mut shown: Vec<Option<[u8; 3]>> = vec![None; first.pixels().len()];
    for (i, (at_s, picture)) in pictures.iter().enumerate() {
        let delay = match pictures.get(i + 1) {
            Some((next_s, _)) => hundredths(*next_s).saturating_sub(hundredths(*at_s)),
            None => u64::from(LAST_CS),
        };
        let delay = delay.clamp(SHORTEST_CS.into(), u16::MAX.into()) as u16;
        let mut frame = changes(picture, &mut shown, &mut palette);
        frame.delay = delay;
        encoder.write_frame(&frame)?;
    }
    drop(encoder);
    Ok(bytes)
}

/// Of the film's own beginning, so that what is rounded does not add up.
fn hundredths(at_s: f64) -> u64 {
    (100.0 * at_s).round() as u64
}

/// The smallest rectangle with all pixels that have changed; they are noted as shown.
fn changes(
    picture: &RgbImage,
    shown: &mut [Option<[u8; 3]>],
    palette: &mut Palette,
) -> Frame<'static> {
    let width = picture.width() as usize;
    let mut indices = vec![palette.transparent(); picture.pixels().len()];
    // Left, top, right, bottom: of one pixel if none has changed, as a frame cannot be empty.
    let mut bounds: Option<[usize; 4]> = None;
    for (i, (&Rgb(pixel), shown)) in picture.pixels().zip(shown).enumerate() {
        if shown.is_some_and(|shown| is_near(shown, pixel)) {
            continue;
        }
        *shown = Some(pixel);
        indices[i] = palette.nearest(pixel);
        let (x, y) = (i % width, i / width);
        let [left, top, right, bottom] = bounds.unwrap_or([x, y, x, y]);
        bounds = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
    }
    let [left, top, right, bottom] = bounds.unwrap_or_default();
    let rows = indices.chunks_exact(width).skip(top).take(bottom + 1 - top);
    let buffer: Vec<u8> = rows.flat_map(|row| &row[left..=right]).copied().collect();
    // Not beyond u16: the whole picture is not.
    Frame {
        left: left as u16,
        top: top as u16,
        width: (right + 1 - left) as u16,
        height: (bottom + 1 - top) as u16,
        transparent: Some(palette.transparent()),
        dispose: DisposalMethod::Keep,
        buffer: buffer.into(),
        ..Frame::default()
    }
}

fn is_near(a: [u8; 3], b: [u8; 3]) -> bool {
    (0..3).all(|k| a[k].abs_diff(b[k]) <= NOISE)
}

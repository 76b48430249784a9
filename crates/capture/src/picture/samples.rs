//! Converts a decoder's samples to the pixels of a picture: drops alpha, reduces 16 bits to 8.

use image::ColorType;

use crate::bits::{self, Bits};

/// Takes note of how many bits a picture's samples have. Returns a sentence if that changes their
/// meaning.
pub(super) fn see_bits(bits: &mut Bits, color: ColorType, full: &[u8]) -> Option<String> {
    match color {
        ColorType::L16 | ColorType::Rgb16 => bits.see(bits::largest(full)),
        // Alpha is at its maximum where the picture is opaque, which says nothing about the bits.
        ColorType::La16 => bits.see(largest_color::<2>(full)),
        ColorType::Rgba16 => bits.see(largest_color::<4>(full)),
        _ => None,
    }
}

fn largest_color<const CHANNELS: usize>(full: &[u8]) -> u16 {
    let pixels = full.chunks_exact(2 * CHANNELS);
    let colors = pixels.map(|pixel| bits::largest(&pixel[..2 * (CHANNELS - 1)]));
    colors.max().unwrap_or(0)
}

/// Reduces samples to `pixels`. 16-bit samples are rounded to 8 bits, so that 65535 becomes 255.
///
/// # Errors
/// The pixels are of a kind that lariat does not know.
pub(super) fn reduce(
    color: ColorType,
    full: &[u8],
    bits: Bits,
    pixels: &mut [u8],
) -> Result<(), String> {
    match color {
        ColorType::L8 | ColorType::Rgb8 => pixels.copy_from_slice(full),
        ColorType::La8 => drop_alpha::<1>(full, pixels),
        ColorType::Rgba8 => drop_alpha::<3>(full, pixels),
        ColorType::L16 => narrow::<1, 1>(full, bits, pixels),
        ColorType::La16 => narrow::<1, 2>(full, bits, pixels),
        ColorType::Rgb16 => narrow::<3, 3>(full, bits, pixels),
        ColorType::Rgba16 => narrow::<3, 4>(full, bits, pixels),
        other => {
            return Err(format!(
                "its pixels are {other:?}, which lariat does not read"
            ));
        }
    }
    Ok(())
}

fn drop_alpha<const COLORS: usize>(full: &[u8], pixels: &mut [u8]) {
    let full = full.chunks_exact(COLORS + 1);
    for (pixel, full) in pixels.chunks_exact_mut(COLORS).zip(full) {
        pixel.copy_from_slice(&full[..COLORS]);
    }
}

fn narrow<const COLORS: usize, const CHANNELS: usize>(full: &[u8], bits: Bits, pixels: &mut [u8]) {
    let full = full.chunks_exact(2 * CHANNELS);
    for (pixel, full) in pixels.chunks_exact_mut(COLORS).zip(full) {
        for (value, sample) in pixel.iter_mut().zip(full.chunks_exact(2)) {
            let sample = bits.widen(u16::from_ne_bytes([sample[0], sample[1]]));
            *value = ((u32::from(sample) + 128) / 257) as u8;
        }
    }
}

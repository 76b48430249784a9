//! The table under the rope, drawn once as a plain, faintly mottled surface in uneven light; and
//! the camera's noise.

use super::RenderOptions;
use super::mottling::Mottling;
use lariat_portable::SplitMix64;

/// Largest noise value. Drawn values stay this far from 0 and 255, so that noise needs no
/// saturation.
pub(crate) const LARGEST_NOISE: u8 = 10;
/// Size of the noise table in bytes: small enough for a core's cache, large enough that no pattern
/// shows.
const NOISE_BYTES: usize = 1 << 16;

/// Converts a value to a byte that noise cannot push out of range.
#[inline(always)]
pub(crate) fn to_byte(value: f32) -> u8 {
    let low = f32::from(LARGEST_NOISE);
    let whole = whole_part((value + 0.5).clamp(low, 255.0 - low));
    (whole + FRACTIONLESS).to_bits() as u8
}

/// From this value on, floats have no fraction, and their lowest bits are those of the integer.
const FRACTIONLESS: f32 = (1 << 23) as f32;

/// Whole part of a number from 0 to 2²². A conversion to an integer gives the same result but is
/// slower: it treats numbers out of range separately in each lane.
#[inline(always)]
pub(crate) fn whole_part(value: f32) -> f32 {
    let nearest = (value + FRACTIONLESS) - FRACTIONLESS;
    if nearest > value {
        nearest - 1.0
    } else {
        nearest
    }
}

/// The empty table, three bytes per pixel.
pub(crate) fn lit_table(options: &RenderOptions) -> Vec<u8> {
    let random = &mut SplitMix64::of_stream(options.seed, 2);
    let (width, height) = (options.width as usize, options.height as usize);
    // Position of the lamp near an upper corner; its light falls off with the square of the
    // distance.
    let lamp = [random.uniform(0.1, 0.9), random.uniform(0.0, 0.3)];
    let mottling = Mottling::<64>::new(random);
    let mut pixels = Vec::with_capacity(3 * width * height);
    let scale = 1.0 / width.max(height) as f64;
    for y in 0..height {
        for x in 0..width {
            let at = [x as f64 * scale, y as f64 * scale];
            let from_lamp = [at[0] - lamp[0], at[1] - lamp[1]];
            let falloff = 1.0 / (1.0 + 0.5 * dot(from_lamp, from_lamp));
            let from_centre = [
                at[0] - 0.5 * width as f64 * scale,
                at[1] - 0.5 * height as f64 * scale,
            ];
            let vignette = 1.0 - 0.35 * dot(from_centre, from_centre);
            let light = falloff * vignette * (1.0 + 0.025 * mottling.at(at, [9.0, 31.0]));
            for channel in options.table_rgb {
                pixels.push(to_byte((f64::from(channel) * light) as f32));
            }
        }
    }
    pixels
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The camera's noise: a table of approximately normal values. Each row of each frame uses a
/// different section of it.
#[derive(Debug)]
pub(crate) struct SensorNoise {
    table: Vec<u8>,
    seed: u64,
}

impl SensorNoise {
    /// Makes noise for rows of at most `row_bytes`.
    pub(crate) fn new(seed: u64, sigma: f64, row_bytes: usize) -> Self {
        let random = &mut SplitMix64::of_stream(seed, 3);
        let limit = f64::from(LARGEST_NOISE);
        // A sum of four uniform numbers in [−½, ½) has a variance of ⅓.
        let scale = sigma * 3f64.sqrt();
        let table = (0..NOISE_BYTES + row_bytes)
            .map(|_| {
                let sum: f64 = (0..4).map(|_| random.uniform(-0.5, 0.5)).sum();
                let value = (scale * sum).clamp(-limit, limit);
                // Stored in two's complement, so that a wrapping byte addition works for either
                // sign.
                (value + if value < 0.0 { -0.5 } else { 0.5 }) as i8 as u8
            })
            .collect();
        Self { table, seed }
    }

    /// Computes `noisy = clean + noise`, row by row, for rows of `row_bytes`.
    pub(crate) fn add(&self, sequence: u64, row_bytes: usize, clean: &[u8], noisy: &mut [u8]) {
        let random = &mut SplitMix64::of_stream(self.seed ^ 0x5EED, sequence);
        let rows = clean
            .chunks_exact(row_bytes)
            .zip(noisy.chunks_exact_mut(row_bytes));
        for (clean, noisy) in rows {
            let start = random.next_u64() as usize % NOISE_BYTES;
            let noise = &self.table[start..start + row_bytes];
            for ((noisy, clean), noise) in noisy.iter_mut().zip(clean).zip(noise) {
                *noisy = clean.wrapping_add(*noise);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_spread_asked_for_and_no_bias() {
        let noise = SensorNoise::new(5, 2.5, 3000);
        let clean = vec![128u8; 300_000];
        let mut noisy = vec![0; clean.len()];
        noise.add(1, 3000, &clean, &mut noisy);
        let errors: Vec<f64> = noisy.iter().map(|&v| f64::from(v) - 128.0).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        assert!(mean.abs() < 0.05, "{mean}");
        assert!((variance.sqrt() - 2.5).abs() < 0.1, "{variance}");
    }
}

//! Simulation of a camera.

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

use crate::canvas::{Canvas, Field, blur, direction, dot, happens, minus, normal, spread};
use lariat_portable::SplitMix64;

/// Returns the exposed picture with three bytes per pixel.
pub(crate) fn expose(canvas: &mut Canvas, random: &mut SplitMix64) -> anyhow::Result<Vec<u8>> {
    light(canvas, random);
    if happens(random, 0.12) {
        smear(canvas, random);
    }
    if happens(random, 0.75) {
        let sigma_px = if happens(random, 0.85) {
            random.uniform_f32(0.3, 1.2)
        } else {
            random.uniform_f32(1.0, 2.5)
        };
        blur(canvas, sigma_px);
    }
    if happens(random, 0.3) {
        sharpen(canvas, random.uniform_f32(0.3, 1.8));
    }
    develop(canvas, random);
    add_noise(canvas, random);
    let bytes: Vec<u8> = canvas
        .values
        .iter()
        .flatten()
        .map(|value| (value + 0.5).clamp(0.0, 255.0) as u8)
        .collect();
    if happens(random, 0.7) {
        compressed(&bytes, canvas.side, random)
    } else {
        Ok(bytes)
    }
}

/// Sometimes adds the brightness gradient of a lamp at the side, and the shadow of an object
/// outside the picture.
fn light(canvas: &mut Canvas, random: &mut SplitMix64) {
    let side = canvas.side as f32;
    let middle = [0.5 * side; 2];
    if happens(random, 0.4) {
        let fall = direction(random.uniform_f32(0.0, 6.3))
            .map(|c| c * random.uniform_f32(0.0, 0.9) / side);
        for (at, pixel) in canvas.places() {
            let gain = 1.0 + dot(minus(at, middle), fall);
            *pixel = pixel.map(|value| value * gain);
        }
    }
    if happens(random, 0.15) {
        let along = direction(random.uniform_f32(0.0, 6.3));
        let from = [(); 2].map(|()| random.uniform_f32(0.0, side));
        let soft_px = spread(random, 1.0, 40.0);
        let dark = random.uniform_f32(0.15, 0.6);
        for (at, pixel) in canvas.places() {
            let share = (0.5 + dot(minus(at, from), along) / soft_px).clamp(0.0, 1.0);
            *pixel = pixel.map(|value| value * (1.0 - dark * share));
        }
    }
}

/// Averages over the camera's motion while the shutter is open.
fn smear(canvas: &mut Canvas, random: &mut SplitMix64) {
    let way_px = spread(random, 1.5, 9.0);
    let along = direction(random.uniform_f32(0.0, 3.2));
    let (side, still) = (canvas.side, canvas.clone());
    let steps = (2.0 * way_px) as usize + 2;
    let edge = |c: f32| c.round().clamp(0.0, side as f32 - 1.0) as usize;
    for (at, pixel) in canvas.places() {
        let mut sum = [0.0; 3];
        for k in 0..steps {
            let off = way_px * (k as f32 / (steps - 1) as f32 - 0.5);
            let [x, y] = [0, 1].map(|k| edge(at[k] + off * along[k]));
            let value = still.values[y * side + x];
            sum = [0, 1, 2].map(|k| sum[k] + value[k]);
        }
        *pixel = sum.map(|value| value / steps as f32);
    }
}

fn sharpen(canvas: &mut Canvas, by: f32) {
    let mut soft = canvas.clone();
    blur(&mut soft, 1.1);
    for (pixel, soft) in canvas.values.iter_mut().zip(soft.values) {
        *pixel = [0, 1, 2].map(|k| pixel[k] + by * (pixel[k] - soft[k]));
    }
}

/// Applies white balance, exposure and a tone curve. Sometimes removes some or all of the color.
fn develop(canvas: &mut Canvas, random: &mut SplitMix64) {
    let exposure = random.uniform_f32(0.6, 1.25);
    let gain = [(); 3].map(|()| exposure * random.uniform_f32(0.86, 1.15));
    let lift = random.uniform_f32(-14.0, 18.0);
    let gamma = random.uniform_f32(0.7, 1.4);
    let gray = if happens(random, 0.07) {
        1.0
    } else {
        random.uniform_f32(-0.6, 0.6).max(0.0)
    };
    for pixel in &mut canvas.values {
        let lit = [0, 1, 2].map(|k| {
            let value = ((pixel[k] * gain[k] + lift) / 255.0).clamp(0.0, 1.0);
            255.0 * libm::powf(value, gamma)
        });
        let luma = 0.3 * lit[0] + 0.59 * lit[1] + 0.11 * lit[2];
        *pixel = lit.map(|value| value + gray * (luma - value));
    }
}

fn add_noise(canvas: &mut Canvas, random: &mut SplitMix64) {
    let levels = if happens(random, 0.9) {
        (3.5 * normal(random)).abs()
    } else {
        random.uniform_f32(6.0, 22.0)
    };
    let mut noise = Field::of(canvas.side, [0.0; 3]);
    for value in &mut noise.values {
        *value = [(); 3].map(|()| levels * normal(random));
    }
    if happens(random, 0.4) {
        // Correlated as after demosaicing.
        blur(&mut noise, 0.7);
    }
    for (pixel, noise) in canvas.values.iter_mut().zip(noise.values) {
        *pixel = [0, 1, 2].map(|k| pixel[k] + noise[k]);
    }
}

fn compressed(bytes: &[u8], side: usize, random: &mut SplitMix64) -> anyhow::Result<Vec<u8>> {
    let quality = 35 + random.below(62) as u8;
    let mut file = Vec::new();
    JpegEncoder::new_with_quality(&mut file, quality).encode(
        bytes,
        side as u32,
        side as u32,
        ExtendedColorType::Rgb8,
    )?;
    let picture = image::load_from_memory(&file)?;
    Ok(picture.into_rgb8().into_raw())
}

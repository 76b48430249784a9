//! Converts the light from the table and the ropes to the bytes of a picture: shadow, light, blur,
//! motion, noise.

use super::ground::Ground;
use super::paint::Painted;
use super::style::Style;
use crate::rendered::mottling::Mottling;
use lariat_portable::SplitMix64;

/// Scales of the table's pattern: 35 and 11 px.
const OCTAVES: [f64; 2] = [1.0 / 35.0, 1.0 / 11.0];

/// Exposes the picture, three bytes per pixel.
pub(super) fn expose(
    painted: &Painted,
    look: &Style,
    ground: &Ground,
    [width, height]: [usize; 2],
    random: &mut SplitMix64,
) -> Vec<u8> {
    let mut shadow = Vec::new();
    if look.shadow > 0.0 {
        shadow = painted.cover.iter().map(|&cover| [cover; 3]).collect();
        shadow = moved(&shadow, [width, height], look.shadow_px);
        if look.shadow_blur_px > 0.0 {
            blur(&mut shadow, [width, height], look.shadow_blur_px);
        }
    }
    let pattern = Mottling::<32>::new(random);
    let mut picture = Vec::with_capacity(width * height);
    for (i, (light, cover)) in painted.light.iter().zip(&painted.cover).enumerate() {
        let (x, y) = (i % width, i / width);
        let at = [x as f64 / width as f64, y as f64 / height as f64];
        let away = [0, 1].map(|k| at[k] - look.spot[k]);
        let spot = 1.0 / (1.0 + 12.0 * (away[0] * away[0] + away[1] * away[1]));
        let lamp = look.exposure
            * (1.0
                + look.fall[0] * (at[0] - 0.5) as f32
                + look.fall[1] * (at[1] - 0.5) as f32
                + look.spot_light * spot as f32);
        let shade = shadow.get(i).map_or(1.0, |s| 1.0 - look.shadow * s[0]);
        let table =
            shade * (1.0 + look.mottling * pattern.at([x, y].map(|c| c as f64), OCTAVES) as f32);
        let ground = ground.at(look.table, [x, y].map(|c| c as f64));
        picture.push([0, 1, 2].map(|k| lamp * (light[k] + (1.0 - cover) * ground[k] * table)));
    }
    if look.grain > 0.0 {
        add_grain(&mut picture, look, random);
    }
    blur(&mut picture, [width, height], look.blur_px);
    if look.motion_px != [0.0; 2] {
        smear(&mut picture, [width, height], look.motion_px);
    }
    let mut bytes = Vec::with_capacity(3 * width * height);
    for value in picture.iter().flatten() {
        let noisy = value + look.noise * normal(random);
        bytes.push((noisy + 0.5).clamp(0.0, 255.0) as u8);
    }
    bytes
}

/// Adds noise that the lens will blur. `look.grain`: its standard deviation after the blur, in
/// levels.
fn add_grain(picture: &mut [[f32; 3]], look: &Style, random: &mut SplitMix64) {
    // A Gaussian blur leaves 1 / (2 √π σ) of white noise.
    let sigma = look.grain * 2.0 * std::f32::consts::PI.sqrt() * look.blur_px;
    for value in picture.iter_mut().flatten() {
        *value += sigma * normal(random);
    }
}

/// Approximately normal number with variance 1: a sum of four uniform numbers in [−½, ½) has a
/// variance of ⅓.
fn normal(random: &mut SplitMix64) -> f32 {
    let bits = random.next_u64();
    let sum: f32 = (0..4)
        .map(|k| ((bits >> (16 * k)) & 0xFFFF) as f32 / 65536.0 - 0.5)
        .sum();
    sum * 3f32.sqrt()
}

/// Gaussian blur; pixels outside the image equal those at the border.
fn blur(picture: &mut [[f32; 3]], [width, height]: [usize; 2], sigma_px: f32) {
    // The Gaussian is below 2 % of its peak beyond 2.8 σ.
    let reach = (2.8 * sigma_px).ceil().max(1.0) as isize;
    let mut kernel: Vec<f32> = (-reach..=reach)
        .map(|d| libm::expf(-0.5 * (d as f32 / sigma_px).powi(2)))
        .collect();
    let sum: f32 = kernel.iter().sum();
    kernel.iter_mut().for_each(|weight| *weight /= sum);
    let reach = kernel.len() / 2;
    // A row that is extended on both sides by the reach of the blur, with copies of its first and
    // its last pixel.
    let mut row = vec![[0.0; 3]; width + 2 * reach];
    for blurred in picture.chunks_exact_mut(width) {
        let (first, last) = (blurred[0], blurred[width - 1]);
        row[..reach].fill(first);
        row[reach..][..width].copy_from_slice(blurred);
        row[reach + width..].fill(last);
        blurred.fill([0.0; 3]);
        for (k, &weight) in kernel.iter().enumerate() {
            add(blurred, weight, &row[k..][..width]);
        }
    }
    let before = picture.to_vec();
    for (y, blurred) in picture.chunks_exact_mut(width).enumerate() {
        blurred.fill([0.0; 3]);
        for (k, &weight) in kernel.iter().enumerate() {
            let from = (y + k).saturating_sub(reach).min(height - 1);
            add(blurred, weight, &before[from * width..][..width]);
        }
    }
}

/// Adds pixels, multiplied by a weight.
#[inline]
fn add(sums: &mut [[f32; 3]], weight: f32, values: &[[f32; 3]]) {
    let sums = sums.as_flattened_mut().iter_mut();
    for (sum, value) in sums.zip(values.as_flattened()) {
        *sum += weight * value;
    }
}

/// The picture moved by a fraction of a pixel, by linear interpolation.
fn moved(picture: &[[f32; 3]], [width, height]: [usize; 2], by: [f32; 2]) -> Vec<[f32; 3]> {
    let value = |x: isize, y: isize| {
        let x = x.clamp(0, width as isize - 1) as usize;
        let y = y.clamp(0, height as isize - 1) as usize;
        picture[y * width + x]
    };
    let whole = by.map(|d| d.floor() as isize);
    let [u, v] = [by[0] - whole[0] as f32, by[1] - whole[1] as f32];
    (0..width * height)
        .map(|i| {
            let (x, y) = (
                (i % width) as isize - whole[0],
                (i / width) as isize - whole[1],
            );
            let (a, b) = (value(x, y), value(x - 1, y));
            let (c, d) = (value(x, y - 1), value(x - 1, y - 1));
            [0, 1, 2].map(|k| {
                (1.0 - v) * ((1.0 - u) * a[k] + u * b[k]) + v * ((1.0 - u) * c[k] + u * d[k])
            })
        })
        .collect()
}

/// Averages the picture while it moves from −`by`/2 to +`by`/2, so that the truth is at the middle
/// of the motion.
fn smear(picture: &mut [[f32; 3]], size: [usize; 2], by: [f32; 2]) {
    // Each step is less than half a pixel.
    let steps = ((by[0] * by[0] + by[1] * by[1]).sqrt() / 0.4)
        .ceil()
        .max(1.0) as usize;
    let mut sum = vec![[0.0; 3]; picture.len()];
    for k in 0..steps {
        let share = (k as f32 + 0.5) / steps as f32 - 0.5;
        let frame = moved(picture, size, by.map(|d| share * d));
        for (sum, value) in sum.iter_mut().zip(frame) {
            for (sum, value) in sum.iter_mut().zip(value) {
                *sum += value / steps as f32;
            }
        }
    }
    picture.copy_from_slice(&sum);
}

//! One training picture.

use crate::canvas::{Canvas, Field, blur, happens, normal, scaled, spread};
use crate::path::Path;
use crate::photographs::Photographs;
use crate::rope::{Laid, Lamp, RopeStyle};
use crate::{camera, ground, thing};
use lariat_portable::SplitMix64;

/// Bytes per pixel: three of color, the share that ropes cover, and 255 at a seam between two ropes
/// side by side (otherwise 0).
pub(crate) const CHANNELS: usize = 5;

/// A square picture, row by row.
pub(crate) struct Scene {
    /// Three bytes per pixel.
    pub(crate) rgb: Vec<u8>,
    /// Share of each pixel that ropes cover.
    cover: Vec<f32>,
    seams: Vec<bool>,
    /// Number of the visible part of a rope at each pixel, from 1 on. 0 on the background. A rope
    /// that leaves the picture and comes back has two parts.
    pub(crate) labels: Vec<u8>,
}

impl Scene {
    /// Returns [`CHANNELS`] bytes per pixel.
    pub(crate) fn interleaved(&self) -> Vec<u8> {
        let rest = self.cover.iter().zip(&self.seams);
        let pixels = self.rgb.as_chunks::<3>().0.iter().zip(rest);
        let pixel = |(&[red, green, blue], (cover, &seam)): (&[u8; 3], (&f32, &bool))| {
            let seam = if seam { 255 } else { 0 };
            [red, green, blue, (255.0 * cover + 0.5) as u8, seam]
        };
        pixels.flat_map(pixel).collect()
    }
}

/// Draws the picture of a seed.
pub(crate) fn draw(seed: u64, side: usize, photographs: &Photographs) -> anyhow::Result<Scene> {
    let random = &mut SplitMix64::of_stream(seed, 0x7EA);
    let mut canvas = ground::draw(side, photographs, random);
    let clutter = match random.below(10) {
        0..4 => 0,
        4..7 => 1 + random.below(5),
        7 | 8 => 5 + random.below(12),
        _ => 12 + random.below(25),
    };
    (0..clutter).for_each(|_| thing::lay(&mut canvas, random));
    if happens(random, 0.1) {
        // The background is out of focus, because the ropes are in front of it.
        blur(&mut canvas, spread(random, 1.5, 8.0));
    }
    let (mut laid, width_px) = match happens(random, 0.1) {
        true => harness_on(canvas, random),
        false => ropes_on(canvas, random),
    };
    if happens(random, 0.15) {
        cover(&mut laid, random);
    }
    let seams = laid.seams(width_px).values;
    let labels = laid.labels();
    let rgb = camera::expose(&mut laid.canvas, random)?;
    Ok(Scene {
        rgb,
        cover: laid.cover.values,
        seams,
        labels,
    })
}

/// Draws up to eight ropes, alone or in bundles. Returns their usual width too.
fn ropes_on(canvas: Canvas, random: &mut SplitMix64) -> (Laid, f32) {
    let side = canvas.side;
    let mut laid = Laid::on(canvas);
    let lamp = Lamp::draw(random);
    let usual_px = if happens(random, 0.9) {
        spread(random, 2.4, 20.0)
    } else {
        spread(random, 16.0, 44.0)
    };
    let most = if usual_px > 12.0 { 3 } else { 8 };
    let count = [0, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 5, 6, 8][random.below(14)].min(most);
    let shared = RopeStyle::draw(random);
    let is_uniform = happens(random, 0.2);
    for _ in 0..count {
        let width_px = (usual_px * (1.0 + 0.18 * normal(random))).clamp(2.2, 48.0);
        let look = if is_uniform {
            shared.clone()
        } else {
            RopeStyle::draw(random)
        };
        let path = Path::draw(side, width_px, random);
        let look = match happens(random, 0.1) {
            true => like_the_ground(look, &laid.canvas, random),
            false => look,
        };
        if path.points.len() < (3.0 * width_px) as usize + 8 {
            continue;
        }
        laid.lay(&path, width_px, &look, &lamp, random);
        if happens(random, 0.18) {
            // A bundle: other ropes next to this one, in contact or nearly so.
            let gap = random.uniform_f32(0.95, 1.25);
            let wander = random.uniform_f32(0.0, 0.3);
            let period_px = random.uniform_f32(60.0, 300.0);
            for k in 1..2 + random.below(3) {
                let away_px = |i: usize| {
                    width_px * k as f32 * (gap + wander * (libm::sinf(i as f32 / period_px) + 1.0))
                };
                let look = if is_uniform {
                    shared.clone()
                } else {
                    RopeStyle::draw(random)
                };
                laid.lay(&path.beside(away_px), width_px, &look, &lamp, random);
            }
        }
    }
    (laid, usual_px)
}

/// Draws thin wires side by side that fan out towards one end and sometimes cross. Returns their
/// width too.
fn harness_on(canvas: Canvas, random: &mut SplitMix64) -> (Laid, f32) {
    let side = canvas.side;
    let mut laid = Laid::on(canvas);
    let lamp = Lamp::draw(random);
    let width_px = spread(random, 2.2, 9.0);
    let shared = RopeStyle::draw(random);
    let is_uniform = happens(random, 0.25);
    for _ in 0..1 + random.below(2) {
        let path = Path::gentle(side, random);
        let count = 3 + random.below(14);
        let gap = spread(random, 0.95, 2.2);
        let fan = random.uniform_f32(-3.0, 4.0).max(0.0);
        let wander = random.uniform_f32(-0.5, 1.2).max(0.0);
        let length = path.points.len() as f32;
        for k in 0..count {
            let place = k as f32 - 0.5 * (count - 1) as f32;
            let period_px = random.uniform_f32(25.0, 150.0);
            let phase = random.uniform_f32(0.0, 6.3);
            let away_px = |i: usize| {
                let (along_px, share) = (i as f32, i as f32 / length);
                let off = wander * libm::sinf(phase + along_px / period_px);
                width_px * (place * (gap + fan * share * share) + off)
            };
            let look = match is_uniform {
                true => shared.clone(),
                false => RopeStyle::draw(random),
            };
            laid.lay(&path.beside(away_px), width_px, &look, &lamp, random);
        }
    }
    (laid, width_px)
}

/// Gives a rope nearly the color of some point of the background: white on white, gray on gray.
fn like_the_ground(look: RopeStyle, canvas: &Canvas, random: &mut SplitMix64) -> RopeStyle {
    let ground = canvas.values[random.below(canvas.values.len())];
    let by = match happens(random, 0.5) {
        true => random.uniform_f32(0.7, 0.92),
        false => random.uniform_f32(1.08, 1.35),
    };
    look.of_color(scaled(ground, by))
}

/// Draws an object over the ropes: a tool, a gripper, a label. Ropes that it hides are not labeled.
fn cover(laid: &mut Laid, random: &mut SplitMix64) {
    let mut above: Canvas = laid.canvas.clone();
    thing::lay(&mut above, random);
    let mut changed = Field::of(above.side, 0.0);
    let pairs = above.values.iter().zip(&laid.canvas.values);
    for (share, (after, before)) in changed.values.iter_mut().zip(pairs) {
        let off: f32 = (0..3).map(|k| (after[k] - before[k]).abs()).sum();
        // A shadow counts as hiding too, although it only darkens. The distinction is rarely worth
        // the effort.
        *share = (off / 24.0).min(1.0);
    }
    let hidden: f32 = changed.values.iter().sum();
    if hidden > 0.2 * (above.side * above.side) as f32 {
        return;
    }
    laid.canvas = above;
    for (i, &share) in changed.values.iter().enumerate() {
        laid.hide(i, share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 128;

    fn scene(seed: u64) -> Vec<u8> {
        drawn(seed).interleaved()
    }

    fn drawn(seed: u64) -> Scene {
        let photographs = Photographs::of(None).expect("none are asked for");
        draw(seed, SIDE, &photographs).expect("a picture")
    }

    #[test]
    fn the_same_seed_draws_the_same_picture() {
        assert_eq!(scene(1), scene(1));
        assert_ne!(scene(1), scene(2));
    }

    /// A seam without rope in the ground truth would teach the network to break ropes.
    #[test]
    fn seams_lie_on_ropes_and_ropes_are_seen() {
        let (mut seams, mut on_ropes, mut ropes) = (0, 0, 0);
        for seed in 0..40 {
            for &[.., cover, seam] in scene(seed).as_chunks::<CHANNELS>().0 {
                ropes += usize::from(cover > 127);
                seams += usize::from(seam > 0);
                on_ropes += usize::from(seam > 0 && cover > 0);
            }
        }
        let share = ropes as f32 / (40 * SIDE * SIDE) as f32;
        assert!((0.03..0.5).contains(&share), "{share}");
        assert!(seams > 100 && on_ropes == seams, "{on_ropes} of {seams}");
    }

    #[test]
    fn labels_number_the_ropes_where_they_are_seen() {
        let (mut several, mut covered, mut unnumbered) = (0, 0, 0);
        for seed in 0..20 {
            let scene = drawn(seed);
            several += usize::from(scene.labels.contains(&2));
            for (&label, &cover) in scene.labels.iter().zip(&scene.cover) {
                assert!(label == 0 || cover >= 0.5);
                covered += usize::from(cover >= 0.5);
                unnumbered += usize::from(cover >= 0.5 && label == 0);
            }
        }
        // If the edges of two ropes share a pixel, neither may cover half of it.
        assert!(100 * unnumbered < covered, "{unnumbered} of {covered}");
        assert!(several > 5, "{several}");
    }
}

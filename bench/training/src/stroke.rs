//! Strokes of a brush or a pen: curved like ropes, but flat, and rarely of constant width.

use crate::canvas::{Canvas, Rgb, color, covered, dot, happens, minus, mix, spread};
use crate::path::Path;
use lariat_portable::SplitMix64;

/// Draws one stroke anywhere.
pub(crate) fn lay(canvas: &mut Canvas, random: &mut SplitMix64) {
    let width_px = spread(random, 1.0, 24.0);
    let rgb = color(random);
    along_a_path(canvas, width_px, rgb, random);
}

/// Draws a painter's picture: layers of strokes and drops, each in a few colors.
pub(crate) fn many(canvas: &mut Canvas, random: &mut SplitMix64) {
    for _ in 0..1 + random.below(4) {
        layer(canvas, random);
    }
}

fn layer(canvas: &mut Canvas, random: &mut SplitMix64) {
    let palette = [(); 4].map(|()| color(random));
    let usual_px = spread(random, 1.2, 20.0);
    let share = random.uniform_f32(0.1, 0.9);
    let drops = if happens(random, 0.5) { 0.6 } else { 0.0 };
    let area = (canvas.side * canvas.side) as f32;
    let mut painted = 0.0;
    while painted < share * area {
        let width_px = (usual_px * spread(random, 0.4, 2.5)).max(0.8);
        let rgb = palette[random.below(palette.len())];
        painted += if happens(random, drops) {
            drop(canvas, 0.7 * width_px, rgb, random)
        } else {
            along_a_path(canvas, width_px, rgb, random)
        };
    }
}

/// Draws a stroke and returns the approximate number of pixels that it covers.
fn along_a_path(canvas: &mut Canvas, width_px: f32, rgb: Rgb, random: &mut SplitMix64) -> f32 {
    let path = Path::draw(canvas.side, width_px, random);
    // A stroke is a part of such a path.
    let length = (width_px * spread(random, 3.0, 60.0)) as usize + 4;
    let first = random.below(path.points.len());
    let points = &path.points[first..path.points.len().min(first + length)];
    let swell = random.uniform_f32(0.0, 0.8);
    let period_px = width_px * spread(random, 2.0, 12.0);
    let phase = random.uniform_f32(0.0, 6.3);
    let ends_thin = happens(random, 0.5);
    let last = points.len() as f32;
    let mut cover = Vec::new();
    for (i, &at) in points.iter().enumerate() {
        let along = i as f32;
        let bulge = 1.0 + swell * libm::sinf(phase + along / period_px);
        let end = (along.min(last - along) / (4.0 * width_px)).min(1.0);
        let thin = if ends_thin { end.sqrt() } else { 1.0 };
        stamp(canvas, at, 0.5 * width_px * bulge * thin, &mut cover);
    }
    paint(canvas, &cover, rgb);
    last * width_px
}

fn drop(canvas: &mut Canvas, radius_px: f32, rgb: Rgb, random: &mut SplitMix64) -> f32 {
    let side = canvas.side as f32;
    let at = [(); 2].map(|()| random.uniform_f32(0.0, side));
    let mut cover = Vec::new();
    stamp(canvas, at, radius_px, &mut cover);
    paint(canvas, &cover, rgb);
    3.0 * radius_px * radius_px
}

/// Appends the pixels that a disc covers, with their shares.
fn stamp(canvas: &Canvas, at: [f32; 2], radius_px: f32, cover: &mut Vec<(usize, f32)>) {
    let side = canvas.side as f32;
    let [columns, rows] = at.map(|c| {
        let bound = |c: f32| c.clamp(0.0, side - 1.0) as usize;
        bound(c - radius_px - 1.0)..bound(c + radius_px + 2.0)
    });
    for y in rows {
        for x in columns.clone() {
            let off = minus([x as f32, y as f32], at);
            let share = covered(dot(off, off).sqrt() - radius_px);
            if share > 0.0 {
                cover.push((y * canvas.side + x, share));
            }
        }
    }
}

/// Paints each pixel with the largest of its shares.
fn paint(canvas: &mut Canvas, cover: &[(usize, f32)], rgb: Rgb) {
    let mut largest = std::collections::HashMap::new();
    for &(i, share) in cover {
        let old = largest.entry(i).or_insert(0.0_f32);
        *old = old.max(share);
    }
    for (i, share) in largest {
        canvas.values[i] = mix(canvas.values[i], rgb, share);
    }
}

//! Draws ropes: finds the strand that each of 16 samples per pixel sees, and its light.
//!
//! The normals at a line's points divide its surroundings into slabs. A sample is in one slab of a
//! strand, so a strand never covers itself. If two strands cover a sample, the nearest crossing of
//! the two decides which is on top. A rope ends in a flat cut across its tip, with the true end at
//! the middle of the cut.

use super::layout::{Layout, Top};
use super::line::{Line, dot, minus};
use super::style::{Coat, Style};

/// Number of samples per pixel. They are at the first 16 points of Hammersley's sequence. Each of
/// 16 rows and 16 columns contains one sample, so an edge along the pixels is as exact as any other
/// edge, to 1/32 px.
const SAMPLES: usize = 16;
/// Number of rows drawn at a time.
const STRIP: usize = 8;
/// Direction to the lamp: from the upper left, and from above.
const LAMP: [f32; 3] = [-0.40, -0.52, 0.755];

/// Position on a rope that a sample sees.
#[derive(Debug, Clone, Copy)]
struct Hit {
    /// Index of the rope; `NONE` for the table.
    rope: u32,
    along_px: f32,
    /// Position across the rope, from −1 at one edge to 1 at the other.
    across: f32,
}

const NONE: u32 = u32::MAX;

/// Ropes without a background: for each pixel, light times coverage, and the coverage itself.
pub(super) struct Painted {
    pub(super) light: Vec<[f32; 3]>,
    pub(super) cover: Vec<f32>,
}

/// Draws all ropes.
pub(super) fn paint(layout: &Layout, look: &Style, width: usize, height: usize) -> Painted {
    let mut painted = Painted {
        light: vec![[0.0; 3]; width * height],
        cover: vec![0.0; width * height],
    };
    let nothing = Hit {
        rope: NONE,
        along_px: 0.0,
        across: 0.0,
    };
    let mut seen = vec![nothing; STRIP * width * SAMPLES];
    for top in (0..height).step_by(STRIP) {
        let rows = STRIP.min(height - top);
        seen.fill(nothing);
        for rope in 0..layout.lines.len() {
            look_at(layout, rope, [top, rows, width], &mut seen);
        }
        for (i, points) in seen.chunks_exact(SAMPLES).take(rows * width).enumerate() {
            let pixel = top * width + i;
            for point in points.iter().filter(|point| point.rope != NONE) {
                let rope = point.rope as usize;
                let light = lit(
                    &layout.lines[rope],
                    layout.width_px,
                    &look.coats[rope],
                    point,
                );
                painted.cover[pixel] += 1.0 / SAMPLES as f32;
                for (sum, value) in painted.light[pixel].iter_mut().zip(light) {
                    *sum += value / SAMPLES as f32;
                }
            }
        }
    }
    painted
}

/// Enters one rope into a strip of rows.
fn look_at(layout: &Layout, rope: usize, [top, rows, width]: [usize; 3], seen: &mut [Hit]) {
    let line = &layout.lines[rope];
    let half_px = 0.5 * layout.width_px;
    let reach_px = half_px + 1.0;
    let [low, high] = [top as f64 - reach_px - 1.0, (top + rows) as f64 + reach_px];
    for i in 0..line.segments() {
        let [p, q] = line.segment(i);
        if p[1].max(q[1]) < low || p[1].min(q[1]) > high {
            continue;
        }
        let clamp = |value: f64, size: usize| value.clamp(0.0, size as f64) as usize;
        let y = clamp(p[1].min(q[1]) - reach_px - top as f64, rows)
            ..clamp(p[1].max(q[1]) + reach_px + 2.0 - top as f64, rows);
        let x =
            clamp(p[0].min(q[0]) - reach_px, width)..clamp(p[0].max(q[0]) + reach_px + 2.0, width);
        let slab = Slab::new(line, i, half_px);
        for row in y {
            for column in x.clone() {
                let at = [column as f64, (top + row) as f64];
                if !slab.is_near(at) {
                    continue;
                }
                let points = &mut seen[(row * width + column) * SAMPLES..][..SAMPLES];
                for (k, point) in points.iter_mut().enumerate() {
                    let Some((along_px, across)) = slab.holds(sample(at, k)) else {
                        continue;
                    };
                    let new = Hit {
                        rope: rope as u32,
                        along_px: along_px as f32,
                        across: across as f32,
                    };
                    if point.rope == NONE || is_over(&layout.tops, new, *point) {
                        *point = new;
                    }
                }
            }
        }
    }
}

/// Sample `k` of a pixel.
fn sample(at: [f64; 2], k: usize) -> [f64; 2] {
    let reversed = (k as u8).reverse_bits() >> 4;
    let unit = 1.0 / SAMPLES as f64;
    [
        at[0] - 0.5 + (k as f64 + 0.5) * unit,
        at[1] - 0.5 + (f64::from(reversed) + 0.5) * unit,
    ]
}

/// Returns whether strand `a` covers strand `b`. Their nearest crossing decides. Without a
/// crossing, the strand that was laid later is on top.
fn is_over(tops: &[Top], a: Hit, b: Hit) -> bool {
    let mut nearest_px = f64::INFINITY;
    let mut is_over = true;
    for top in tops {
        for (upper, lower, is_upper) in [(a, b, true), (b, a, false)] {
            if top.lines == [upper.rope as usize, lower.rope as usize] {
                let away_px = (top.along_px[0] - f64::from(upper.along_px)).abs()
                    + (top.along_px[1] - f64::from(lower.along_px)).abs();
                if away_px < nearest_px {
                    nearest_px = away_px;
                    is_over = is_upper;
                }
            }
        }
    }
    is_over
}

/// One segment of a rope with its surroundings.
struct Slab {
    points: [[f64; 2]; 2],
    /// Directions of the planes that bound the slab.
    along: [[f64; 2]; 2],
    normal: [f64; 2],
    start_px: f64,
    step_px: f64,
    half_px: f64,
}

impl Slab {
    fn new(line: &Line, i: usize, half_px: f64) -> Self {
        let points = line.segment(i);
        let count = line.points.len();
        let direction = |at: usize| {
            let (before, after) = if line.closed {
                ((at + count - 1) % count, (at + 1) % count)
            } else {
                (at.saturating_sub(1), (at + 1).min(count - 1))
            };
            minus(line.points[after], line.points[before])
        };
        let chord = minus(points[1], points[0]);
        let length_px = dot(chord, chord).sqrt().max(1e-12);
        Self {
            points,
            along: [direction(i), direction((i + 1) % count)],
            normal: [-chord[1] / length_px, chord[0] / length_px],
            start_px: i as f64 * line.step_px,
            step_px: line.step_px,
            half_px,
        }
    }

    /// Returns whether any sample of the pixel here can be in the slab.
    fn is_near(&self, at: [f64; 2]) -> bool {
        // Half the diagonal of a pixel.
        const PIXEL: f64 = 0.71;
        let from = minus(at, self.points[0]);
        let across_px = dot(from, self.normal).abs();
        let along_px = from[0] * self.normal[1] - from[1] * self.normal[0];
        // The planes tilt by the turn of one step. At radii of at least 1.5 widths, this shifts the
        // slab's edge by less than a third of a step.
        across_px < self.half_px + PIXEL
            && along_px > -PIXEL - self.step_px
            && along_px < self.step_px * 2.0 + PIXEL
    }

    /// Arc length and position across for a point in the slab.
    fn holds(&self, at: [f64; 2]) -> Option<(f64, f64)> {
        let from = dot(minus(at, self.points[0]), self.along[0]);
        let to = dot(minus(at, self.points[1]), self.along[1]);
        if from < 0.0 || to >= 0.0 {
            return None;
        }
        let across_px = dot(minus(at, self.points[0]), self.normal);
        let along_px = self.start_px + self.step_px * from / (from - to).max(1e-12);
        (across_px.abs() <= self.half_px).then(|| (along_px, across_px / self.half_px))
    }
}

/// Light from a position on a rope.
fn lit(line: &Line, width_px: f64, coat: &Coat, seen: &Hit) -> [f32; 3] {
    let tangent = line.tangent(f64::from(seen.along_px));
    let lamp_across = LAMP[0] * -tangent[1] as f32 + LAMP[1] * tangent[0] as f32;
    let away = seen.across;
    let up = (1.0 - away * away).max(0.0).sqrt();
    let facing = (lamp_across * away + LAMP[2] * up).max(0.0);
    // Strands wind around the rope: seen from above they are oblique, and they curve at the sides.
    let width = width_px as f32;
    let turns =
        seen.along_px / (coat.pitch_widths * width) + 0.55 * away + 0.15 * away * away * away;
    let phase = turns.rem_euclid(1.0);
    let strand = 4.0 * phase * (1.0 - phase);
    let dash = (seen.along_px / (coat.dash_widths * width)).rem_euclid(1.0) < 0.5;
    let light = (0.62 + 0.45 * facing)
        * (1.0 - coat.twist * (1.0 - strand))
        * if dash { 1.0 - coat.dashes } else { 1.0 };
    let shine = coat.shine * (facing / 0.96).min(1.0).powi(coat.shine_power);
    let rgb = match coat.second {
        Some(second) if turns.rem_euclid(2.0) < 1.0 => second,
        _ => coat.rgb,
    };
    rgb.map(|value| value * light + shine)
}

#[cfg(test)]
mod tests {
    use super::super::Class;
    use super::*;
    use lariat_portable::SplitMix64;

    fn straight(from: [f64; 2], to: [f64; 2], width_px: f64) -> Painted {
        let line = Line::through(&[from, to], false, 200);
        let layout = Layout {
            seen_px: vec![[0.0, line.length_px()]],
            border: vec![[false; 2]],
            tops: Vec::new(),
            touches: Vec::new(),
            covering: None,
            lines: vec![line],
            width_px,
        };
        let random = &mut SplitMix64::of_stream(1, 1);
        let look = Style::of(Class::Medium, 1, 1, width_px, random);
        paint(&layout, &look, 120, 100)
    }

    #[test]
    fn a_rope_covers_its_length_times_its_width_about_its_middle() {
        // Lines along the pixels and oblique lines, with widths that are not whole numbers.
        for (from, to) in [
            ([20.0, 40.3], [100.0, 40.3]),
            ([20.4, 20.0], [91.7, 83.1]),
            ([60.21, 15.0], [60.21, 88.0]),
        ] {
            for width_px in [4.0, 7.3, 16.9] {
                let painted = straight(from, to, width_px);
                let length_px = ((to[0] - from[0]).powi(2) + (to[1] - from[1]).powi(2)).sqrt();
                let area: f64 = painted.cover.iter().map(|&c| f64::from(c)).sum();
                // There are two edges, each exact to 1/32 px at worst.
                let off_px = (area / length_px - width_px).abs();
                assert!(off_px < 0.0626, "{width_px} px: {off_px}");
                for k in 0..2 {
                    let weighted = painted
                        .cover
                        .iter()
                        .enumerate()
                        .map(|(i, &c)| f64::from(c) * [i % 120, i / 120][k] as f64);
                    let middle = weighted.sum::<f64>() / area;
                    let wanted = 0.5 * (from[k] + to[k]);
                    assert!((middle - wanted).abs() < 0.04, "{middle} for {wanted}");
                }
            }
        }
    }
}

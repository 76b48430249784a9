//! Draws the rope along its centerline: round, twisted, lit from the side, with soft edges and a faint shadow.
//!
//! The normals at the centerline's points cut the rope's surroundings into slabs, one for each segment; a pixel lies
//! in one slab of a strand, so a strand never covers itself, and where the rope crosses itself the slabs drawn later
//! lie over the earlier ones, shadow and all. The ends are cut flat, their corners a little rounded.
//!
//! All arithmetic is IEEE +, −, ×, ÷ and √ in a fixed order: every bit is the same on every machine.

use std::ops::Range;

use super::RenderOptions;
use super::table::to_byte;

/// Half the distance over which the rope's edge goes from cover to none: the blur of a good lens.
const SOFT_PX: f32 = 0.9;
/// How much the shadow takes from the light at the rope's edge.
const SHADOW: f32 = 0.22;
/// Towards the lamp: from the upper left, and from above.
const LAMP: [f32; 3] = [-0.40, -0.52, 0.755];

/// An image of three bytes a pixel, without padding.
pub(crate) struct Canvas<'a> {
    pub(crate) pixels: &'a mut [u8],
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// Rows and columns that were drawn on; the ends are excluded.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Area {
    pub(crate) x: [usize; 2],
    pub(crate) y: [usize; 2],
}

/// The rope's looks.
#[derive(Debug)]
pub(crate) struct Brush {
    half_px: f32,
    /// From the centerline to the end of the shadow.
    reach_px: f32,
    /// Radius of the ends' corners.
    corner_px: f32,
    /// One over the half width, over the width of the shadow, and over the length along the rope from one strand of
    /// the twist to the next.
    per_half: f32,
    per_shadow: f32,
    per_pitch: f32,
    rgb: [f32; 3],
    length_px: f32,
}

/// Where the centerline passes a point: the point, and the direction of the normal's plane.
#[derive(Clone, Copy)]
struct Gate {
    at: [f32; 2],
    along: [f32; 2],
}

impl Gate {
    /// How far a pixel lies beyond the gate, along the rope. The two slabs at a gate get the very same value, so that
    /// every pixel is in exactly one of them.
    fn beyond(&self, x: f32, y: f32) -> f32 {
        (x - self.at[0]) * self.along[0] + (y - self.at[1]) * self.along[1]
    }
}

/// One segment with its surroundings.
struct Slab {
    from: Gate,
    to: Gate,
    /// Unit normal of the segment.
    normal: [f32; 2],
    /// Arc length at `from`, and of the segment.
    start_px: f32,
    step_px: f32,
    /// Within which distances of the gates pixels belong to the slab: [0, 0] but at the tips.
    overhang_px: [f32; 2],
    /// The lamp's direction across the rope.
    lamp_across: f32,
}

impl Brush {
    pub(crate) fn new(options: &RenderOptions, length_px: f64) -> Self {
        let half_px = (options.rope_px / 2.0) as f32;
        let shadow_px = 1.5 + 0.3 * half_px;
        Self {
            half_px,
            reach_px: half_px + shadow_px,
            corner_px: 0.35 * half_px,
            per_half: 1.0 / half_px,
            per_shadow: 1.0 / shadow_px,
            per_pitch: 1.0 / (1.1 * half_px),
            rgb: options.rope_rgb.map(f32::from),
            length_px: length_px as f32,
        }
    }

    /// Draws the rope; later points of the line lie over earlier ones.
    pub(crate) fn draw(&self, line: &[[f64; 2]], canvas: &mut Canvas) {
        let segments = line.len() - 1;
        let step_px = self.length_px / segments as f32;
        let mut from = gate(line, 0, step_px);
        for i in 0..segments {
            let to = gate(line, i + 1, step_px);
            let chord = [
                ((line[i + 1][0] - line[i][0]) as f32) / step_px,
                ((line[i + 1][1] - line[i][1]) as f32) / step_px,
            ];
            let normal = [-chord[1], chord[0]];
            let overhang = |is_tip| if is_tip { self.reach_px } else { 0.0 };
            let slab = Slab {
                from,
                to,
                normal,
                start_px: i as f32 * step_px,
                step_px,
                overhang_px: [overhang(i == 0), overhang(i + 1 == segments)],
                lamp_across: LAMP[0] * normal[0] + LAMP[1] * normal[1],
            };
            self.draw_slab(&slab, canvas);
            from = to;
        }
    }

    /// The part of the canvas that [`draw`](Self::draw) can touch.
    pub(crate) fn area(&self, line: &[[f64; 2]], width: usize, height: usize) -> Area {
        let span = |axis: usize, size: usize| {
            let low = line.iter().map(|p| p[axis]).fold(f64::MAX, f64::min);
            let high = line.iter().map(|p| p[axis]).fold(f64::MIN, f64::max);
            // A tip's corner is farther than the reach, by √2.
            let reach = 1.5 * f64::from(self.reach_px) + 2.0;
            [
                ((low - reach).max(0.0) as usize).min(size),
                ((high + reach).max(0.0) as usize).min(size),
            ]
        };
        Area {
            x: span(0, width),
            y: span(1, height),
        }
    }

    fn draw_slab(&self, slab: &Slab, canvas: &mut Canvas) {
        let bounds = slab.bounds(self.reach_px);
        for row in slab.rows(self.reach_px, canvas.height) {
            let y = row as f32;
            let columns = Bound::columns(&bounds, y, canvas.width);
            let start = 3 * (row * canvas.width + columns.start);
            let pixels = canvas.pixels[start..].chunks_exact_mut(3);
            for (column, pixel) in columns.zip(pixels) {
                let x = column as f32;
                let from = slab.from.beyond(x, y);
                let to = slab.to.beyond(x, y);
                if from >= -slab.overhang_px[0] && to < slab.overhang_px[1] {
                    let along_px = slab.start_px + slab.step_px * (from / (from - to));
                    let across_px = slab.across(x, y);
                    self.draw_pixel(slab.lamp_across, along_px, across_px, pixel);
                }
            }
        }
    }

    /// Shadow, then rope, over what is there.
    fn draw_pixel(&self, lamp_across: f32, along_px: f32, across_px: f32, pixel: &mut [u8]) {
        let outside_px = self.outside_px(along_px, across_px);
        if outside_px >= self.reach_px - self.half_px {
            return;
        }
        let away = across_px * self.per_half;
        let cover = edge(outside_px);
        let mut light = 1.0;
        if cover < 1.0 {
            // The side away from the lamp lies in the deeper shadow.
            let side = (0.6 - 0.6 * lamp_across * away).clamp(0.1, 1.2);
            let near = 1.0 - outside_px.max(0.0) * self.per_shadow;
            light -= SHADOW * side * near * near;
        }
        let shade = if cover > 0.0 {
            self.shade(lamp_across, along_px, away.clamp(-1.0, 1.0))
        } else {
            [0.0; 2]
        };
        let (under, over) = (light * (1.0 - cover), [shade[0] * cover, shade[1] * cover]);
        for (value, rope) in pixel.iter_mut().zip(self.rgb) {
            *value = to_byte(f32::from(*value) * under + rope * over[0] + over[1]);
        }
    }

    /// Distance from the rope's outline, negative inside: a band, cut at its ends with rounded corners.
    fn outside_px(&self, along_px: f32, across_px: f32) -> f32 {
        let beside = across_px.abs() - self.half_px;
        let beyond = (-along_px).max(along_px - self.length_px);
        if beyond < -self.corner_px - SOFT_PX {
            return beside;
        }
        let (u, v) = (beside + self.corner_px, beyond + self.corner_px);
        let inner = u.max(v).min(0.0);
        let (u, v) = (u.max(0.0), v.max(0.0));
        inner + (u * u + v * v).sqrt() - self.corner_px
    }

    /// How bright the rope's colour is where it is seen, and how much white light it throws back.
    fn shade(&self, lamp_across: f32, along_px: f32, away: f32) -> [f32; 2] {
        let up = (1.0 - away * away).sqrt();
        let facing = (lamp_across * away + LAMP[2] * up).max(0.0);
        // Strands wind around the rope: seen from above they lean, and curve at the sides.
        let phase = along_px * self.per_pitch + 0.55 * away + 0.15 * away * away * away + 64.0;
        let within = phase - phase as i32 as f32;
        let strand = 4.0 * within * (1.0 - within);
        let strand = strand * (2.0 - strand);
        let square = facing * facing;
        let shine = square * square * square * square;
        let light = (0.36 + 0.74 * facing) * (0.7 + 0.3 * strand);
        [light, 26.0 * shine * strand]
    }
}

/// How much of a pixel the rope covers whose centre is so far outside.
fn edge(outside_px: f32) -> f32 {
    let x = (0.5 - outside_px * (0.5 / SOFT_PX)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// The gate at a point: across the mean direction of the two segments that meet there.
fn gate(line: &[[f64; 2]], i: usize, step_px: f32) -> Gate {
    let (before, after) = (line[i.saturating_sub(1)], line[(i + 1).min(line.len() - 1)]);
    let segments = if i == 0 || i + 1 == line.len() {
        1.0
    } else {
        2.0
    };
    let scale = 1.0 / (segments * step_px);
    Gate {
        at: [line[i][0] as f32, line[i][1] as f32],
        along: [
            (after[0] - before[0]) as f32 * scale,
            (after[1] - before[1]) as f32 * scale,
        ],
    }
}

impl Slab {
    /// Signed distance of a pixel from the segment's line.
    fn across(&self, x: f32, y: f32) -> f32 {
        (x - self.from.at[0]) * self.normal[0] + (y - self.from.at[1]) * self.normal[1]
    }

    /// The rows between the slab's corners: the gates, moved by their overhang, out to the reach.
    fn rows(&self, reach_px: f32, height: usize) -> Range<usize> {
        let ys = |gate: &Gate, overhang_px: f32| {
            let middle = gate.at[1] + overhang_px * gate.along[1];
            [
                middle - reach_px * gate.along[0],
                middle + reach_px * gate.along[0],
            ]
        };
        let ([a, b], [c, d]) = (
            ys(&self.from, -self.overhang_px[0]),
            ys(&self.to, self.overhang_px[1]),
        );
        span(a.min(b).min(c).min(d), a.max(b).max(c).max(d), height)
    }

    /// The slab's outline: behind the one gate, before the other, within reach on both sides.
    fn bounds(&self, reach_px: f32) -> [Bound; 4] {
        let bound = |at: [f32; 2], normal: [f32; 2], offset: f32| Bound {
            at,
            slope: normal[1] / normal[0],
            offset: offset / normal[0],
            is_upper: normal[0] > 0.0,
            is_steep: normal[0].abs() > 1e-3,
        };
        let minus = |v: [f32; 2]| [-v[0], -v[1]];
        let (from, to) = (&self.from, &self.to);
        [
            bound(from.at, minus(from.along), self.overhang_px[0]),
            bound(to.at, to.along, self.overhang_px[1]),
            bound(from.at, self.normal, reach_px),
            bound(from.at, minus(self.normal), reach_px),
        ]
    }
}

/// The half plane (p − at) · normal ≤ offset, solved for x.
struct Bound {
    at: [f32; 2],
    slope: f32,
    offset: f32,
    is_upper: bool,
    /// Whether the edge crosses rows at all; a level one bounds the rows alone.
    is_steep: bool,
}

impl Bound {
    /// The columns of a row that can be within all bounds, and a pixel more on either side.
    fn columns(bounds: &[Self; 4], y: f32, width: usize) -> Range<usize> {
        let [mut low, mut high] = [0.0f32, width as f32];
        for bound in bounds.iter().filter(|bound| bound.is_steep) {
            let x = bound.at[0] + bound.offset - bound.slope * (y - bound.at[1]);
            if bound.is_upper {
                high = high.min(x);
            } else {
                low = low.max(x);
            }
        }
        span(low, high, width)
    }
}

/// From the pixel before the lower value to the one behind the higher, within the image.
fn span(low: f32, high: f32, size: usize) -> Range<usize> {
    // `as usize` takes negative numbers to 0.
    let (low, high) = (low as usize, ((high + 2.0) as usize).min(size));
    low.min(high)..high
}

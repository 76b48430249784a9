//! Draws the rope along its centerline: round and twisted, lit from the side, with soft edges and a
//! faint shadow.
//!
//! The normals at the centerline's points divide the rope's surroundings into slabs, one per
//! segment. A pixel is in one slab of a strand, so a strand never covers itself. Where the rope
//! crosses itself, slabs drawn later cover earlier ones, including the shadow. The ends are cut
//! flat with slightly rounded corners.
//!
//! All arithmetic is IEEE +, −, ×, ÷ and √ in a fixed order, so every bit is the same on every
//! machine.

use std::ops::Range;

use super::RenderOptions;
use super::table::{to_byte, whole_part};
use lariat_portable::{Arch, Simd, WithSimd};

/// Half the distance over which the coverage falls from 1 to 0 at the rope's edge: the blur of a
/// good lens.
const SOFT_PX: f32 = 0.9;
/// Share of the light that the shadow takes at the rope's edge.
const SHADOW: f32 = 0.22;
/// Direction to the lamp: from the upper left, and from above.
const LAMP: [f32; 3] = [-0.40, -0.52, 0.755];

/// Number of pixels of a row that are drawn at once.
const LANES: usize = 8;

/// Offset of each of these pixels from the first.
const OFFSETS: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// An image of three bytes per pixel, without padding, at least [`LANES`] pixels wide. Its values
/// are in the range of [`to_byte`], so pixels outside the drawing are written back unchanged.
pub(crate) struct Canvas<'a> {
    pub(crate) pixels: &'a mut [u8],
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// Rows and columns that were drawn on; the upper bounds are excluded.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Area {
    pub(crate) x: [usize; 2],
    pub(crate) y: [usize; 2],
}

/// Appearance of the rope.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Brush {
    half_px: f32,
    /// Distance from the centerline to the end of the shadow.
    reach_px: f32,
    /// Radius of the corners at the ends.
    corner_px: f32,
    /// Inverses of three lengths: half the width, the width of the shadow, and the pitch of the
    /// twist (from strand to strand, along the rope).
    per_half: f32,
    per_shadow: f32,
    per_pitch: f32,
    rgb_lanes: [[f32; 3]; LANES],
    length_px: f32,
}

/// Application of the brush to a line.
struct Drawing<'a, 'b>(&'a Brush, &'a [[f64; 2]], &'a mut Canvas<'b>);

impl WithSimd for Drawing<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        // A copy: with a reference, the compiler must assume that drawing changes the brush, and
        // would read it again for each pixel.
        let brush = *self.0;
        brush.draw_slabs(self.1, self.2);
    }
}

/// A point of the centerline, with the normal vector of the plane that cuts the line there at a
/// right angle.
#[derive(Clone, Copy)]
struct Gate {
    at: [f32; 2],
    along: [f32; 2],
}

impl Gate {
    /// Distance of a pixel beyond the gate, along the rope. Both slabs at a gate compute exactly
    /// the same value, so every pixel is in exactly one of them.
    #[inline(always)]
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
    /// Arc length at `from`, and length of the segment.
    start_px: f32,
    step_px: f32,
    /// True if the rope's end may be inside.
    is_at_tip: bool,
    /// Distances beyond the two gates up to which pixels belong to the slab: [0, 0] except at the
    /// tips.
    overhang_px: [f32; 2],
    /// Component of the lamp's direction across the rope.
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
            rgb_lanes: [options.rope_rgb.map(f32::from); LANES],
            length_px: length_px as f32,
        }
    }

    /// Draws the rope; later points of the line cover earlier ones.
    pub(crate) fn draw(&self, line: &[[f64; 2]], canvas: &mut Canvas) {
        Arch::new().dispatch(Drawing(self, line, canvas));
    }

    #[inline(always)]
    fn draw_slabs(&self, line: &[[f64; 2]], canvas: &mut Canvas) {
        let segments = line.len() - 1;
        let step_px = self.length_px / segments as f32;
        // One pixel more than needed covers any rounding.
        let near_px = self.tip_px() + 1.0;
        let mut from = gate(line, 0, step_px);
        for i in 0..segments {
            let to = gate(line, i + 1, step_px);
            let chord = [
                ((line[i + 1][0] - line[i][0]) as f32) / step_px,
                ((line[i + 1][1] - line[i][1]) as f32) / step_px,
            ];
            let normal = [-chord[1], chord[0]];
            let start_px = i as f32 * step_px;
            let overhang = |is_tip| if is_tip { self.reach_px } else { 0.0 };
            let slab = Slab {
                from,
                to,
                normal,
                start_px,
                step_px,
                is_at_tip: start_px < near_px || start_px + step_px > self.length_px - near_px,
                overhang_px: [overhang(i == 0), overhang(i + 1 == segments)],
                lamp_across: LAMP[0] * normal[0] + LAMP[1] * normal[1],
            };
            if slab.is_at_tip {
                self.draw_slab::<true>(&slab, canvas);
            } else {
                self.draw_slab::<false>(&slab, canvas);
            }
            from = to;
        }
    }

    /// Returns the part of the canvas that [`draw`](Self::draw) can touch.
    pub(crate) fn area(&self, line: &[[f64; 2]], width: usize, height: usize) -> Area {
        let span = |axis: usize, size: usize| {
            let low = line.iter().map(|p| p[axis]).fold(f64::MAX, f64::min);
            let high = line.iter().map(|p| p[axis]).fold(f64::MIN, f64::max);
            // A tip's corner is √2 times as far as the reach.
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

    #[inline(always)]
    fn draw_slab<const IS_AT_TIP: bool>(&self, slab: &Slab, canvas: &mut Canvas) {
        let bounds = slab.bounds(self.reach_px);
        let row_bytes = 3 * canvas.width;
        for row in slab.rows(self.reach_px, canvas.height) {
            let y = row as f32;
            let mut columns = Bound::columns(&bounds, y, canvas.width);
            let pixels = &mut canvas.pixels[row * row_bytes..][..row_bytes];
            while !columns.is_empty() {
                let first = columns.start.min(canvas.width - LANES);
                if let Some(pixels) = pixels[3 * first..].first_chunk_mut() {
                    self.draw_pixels::<IS_AT_TIP>(slab, first, &columns, y, pixels);
                }
                columns.start = first + LANES;
            }
        }
    }

    /// Draws first the shadow and then the rope, in those pixels from column `first` on that are in
    /// the slab. There is no branch, so that the compiler can vectorize it.
    #[inline(always)]
    fn draw_pixels<const IS_AT_TIP: bool>(
        &self,
        slab: &Slab,
        first: usize,
        columns: &Range<usize>,
        y: f32,
        pixels: &mut [u8; 3 * LANES],
    ) {
        let (low, high) = (columns.start as f32, columns.end as f32);
        // One value per byte, because a pixel has three.
        let [mut under, mut light, mut shine] = [[[0.0; 3]; LANES]; 3];
        for i in 0..LANES {
            let x = first as f32 + OFFSETS[i];
            let from = slab.from.beyond(x, y);
            let to = slab.to.beyond(x, y);
            let along_px = slab.start_px + slab.step_px * (from / (from - to));
            let across_px = slab.across(x, y);
            let outside_px = if IS_AT_TIP {
                self.outside_px(along_px, across_px)
            } else {
                across_px.abs() - self.half_px
            };
            let away = across_px * self.per_half;
            let cover = edge(outside_px);
            // The side away from the lamp has the deeper shadow.
            let side = (0.6 - 0.6 * slab.lamp_across * away).clamp(0.1, 1.2);
            let near = 1.0 - outside_px.max(0.0) * self.per_shadow;
            let shadow = if cover < 1.0 {
                SHADOW * side * near * near
            } else {
                0.0
            };
            let shade = self.shade(slab.lamp_across, along_px, away.clamp(-1.0, 1.0));
            let is_drawn = (from >= -slab.overhang_px[0])
                & (to < slab.overhang_px[1])
                & (outside_px < self.reach_px - self.half_px)
                & (x >= low)
                & (x < high);
            // Pixels outside get no coverage and full light, so they remain unchanged.
            let of_drawn = |value: f32, other: f32| [if is_drawn { value } else { other }; 3];
            under[i] = of_drawn((1.0 - shadow) * (1.0 - cover), 1.0);
            light[i] = of_drawn(shade[0] * cover, 0.0);
            shine[i] = of_drawn(shade[1] * cover, 0.0);
        }
        let rgb = self.rgb_lanes.as_flattened();
        let (under, light, shine) = (
            under.as_flattened(),
            light.as_flattened(),
            shine.as_flattened(),
        );
        for (i, value) in pixels.iter_mut().enumerate() {
            *value = to_byte(f32::from(*value) * under[i] + rgb[i] * light[i] + shine[i]);
        }
    }

    /// Distance from the rope's outline, negative inside. The outline is a band, cut at its ends
    /// with rounded corners.
    #[inline(always)]
    fn outside_px(&self, along_px: f32, across_px: f32) -> f32 {
        let beside = across_px.abs() - self.half_px;
        let beyond = (-along_px).max(along_px - self.length_px);
        let (u, v) = (beside + self.corner_px, beyond + self.corner_px);
        let inner = u.max(v).min(0.0);
        let (u, v) = (u.max(0.0), v.max(0.0));
        let rounded = inner + (u * u + v * v).sqrt() - self.corner_px;
        if beyond < -self.tip_px() {
            beside
        } else {
            rounded
        }
    }

    /// Distance from the ends within which the outline differs from a band.
    fn tip_px(&self) -> f32 {
        self.corner_px + SOFT_PX
    }

    /// Brightness of the rope's color at a point, and the amount of white light that it reflects.
    #[inline(always)]
    fn shade(&self, lamp_across: f32, along_px: f32, away: f32) -> [f32; 2] {
        let up = (1.0 - away * away).sqrt();
        let facing = (lamp_across * away + LAMP[2] * up).max(0.0);
        // Strands wind around the rope: seen from above they are oblique, and they curve at the
        // sides.
        let phase = along_px * self.per_pitch + 0.55 * away + 0.15 * away * away * away + 64.0;
        let within = phase - whole_part(phase);
        let strand = 4.0 * within * (1.0 - within);
        let strand = strand * (2.0 - strand);
        let square = facing * facing;
        let shine = square * square * square * square;
        let light = (0.36 + 0.74 * facing) * (0.7 + 0.3 * strand);
        [light, 26.0 * shine * strand]
    }
}

/// Share of a pixel that the rope covers, from the distance of its center from the outline.
#[inline(always)]
fn edge(outside_px: f32) -> f32 {
    let x = (0.5 - outside_px * (0.5 / SOFT_PX)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Gate at a point, normal to the mean direction of the two segments that meet there.
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
    #[inline(always)]
    fn across(&self, x: f32, y: f32) -> f32 {
        (x - self.from.at[0]) * self.normal[0] + (y - self.from.at[1]) * self.normal[1]
    }

    /// Rows between the slab's corners. The corners are at the gates, moved by their overhang, and
    /// at the reach on both sides.
    #[inline(always)]
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

    /// Outline of the slab: beyond one gate, before the other, and within reach on both sides.
    #[inline(always)]
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
    /// True if the edge crosses rows at all; a horizontal edge bounds only the rows.
    is_steep: bool,
}

impl Bound {
    /// Columns of a row that can be within all bounds.
    #[inline(always)]
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

/// Pixels between the two values, within the image. A tenth of a pixel is added on either side,
/// which is more than rounding loses.
fn span(low: f32, high: f32, size: usize) -> Range<usize> {
    // `as usize` turns negative numbers into 0.
    let (low, high) = ((low + 0.9) as usize, ((high + 1.1) as usize).min(size));
    low.min(high)..high
}

#[cfg(test)]
mod tests {
    use super::super::portable::sin_turns;
    use super::*;

    #[test]
    fn a_rope_is_the_same_in_all_registers() {
        let options = RenderOptions {
            width: 101,
            height: 83,
            rope_px: 3.5,
            ..RenderOptions::default()
        };
        // The line goes over the right border and the bottom, and crosses itself twice.
        let line: Vec<[f64; 2]> = (0..=200)
            .map(|i| {
                let turns = f64::from(i) / 80.0;
                [
                    55.0 + 45.0 * sin_turns(turns),
                    50.0 + 38.0 * sin_turns(0.6 * turns),
                ]
            })
            .collect();
        let brush = Brush::new(&options, 500.0);
        let drawn = Arch::all().into_iter().map(|arch| {
            let mut pixels = vec![128; 3 * 101 * 83];
            let mut canvas = Canvas {
                pixels: &mut pixels,
                width: 101,
                height: 83,
            };
            arch.dispatch(Drawing(&brush, &line, &mut canvas));
            pixels
        });
        let drawn: Vec<_> = drawn.collect();
        assert!(drawn[0].iter().any(|&value| value != 128));
        assert!(drawn.iter().all(|other| *other == drawn[0]));
    }
}

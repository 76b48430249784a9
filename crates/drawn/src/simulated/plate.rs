//! Parts of robots: flat, with round corners, lit from the upper left, with a soft shadow on what
//! is below.
//!
//! All arithmetic is IEEE +, −, ×, ÷ and √ in a fixed order.

use crate::rendered::draw::{Area, Canvas};
use crate::rendered::table::to_byte;

/// Half the distance over which the coverage falls from 1 to 0 at an edge.
const SOFT_PX: f32 = 0.9;
/// Offset of the shadow, and the distance over which it fades.
const SHADOW_AT: [f32; 2] = [2.5, 3.5];
const SHADOW_PX: f32 = 5.0;
/// Share of the light that the shadow takes.
const SHADOW: f32 = 0.16;
/// Width of the rim; and its contrast in levels: brighter toward the lamp, darker on the other
/// side.
const RIM_PX: f32 = 2.0;
const RIM: f32 = 22.0;
/// Direction to the lamp, in the picture.
const LAMP: [f32; 2] = [-0.61, -0.79];

/// A rectangle with round corners.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plate {
    pub(super) middle: [f32; 2],
    /// Unit vector along its first side.
    pub(super) along: [f32; 2],
    /// Half the lengths of its sides.
    pub(super) half: [f32; 2],
    pub(super) corner: f32,
    pub(super) rgb: [f32; 3],
}

impl Plate {
    /// Darkens the canvas by this plate's shadow.
    pub(super) fn shade(&self, canvas: &mut Canvas) {
        let fallen = Self {
            middle: [0, 1].map(|axis| self.middle[axis] + SHADOW_AT[axis]),
            ..*self
        };
        fallen.each_pixel(SHADOW_PX, canvas, |outside_px, _, pixel| {
            let share = ((SHADOW_PX - outside_px) / (2.0 * SHADOW_PX)).clamp(0.0, 1.0);
            let light = 1.0 - SHADOW * smooth(share);
            for value in pixel {
                *value = to_byte(f32::from(*value) * light);
            }
        });
    }

    /// Draws the plate over the canvas.
    pub(super) fn draw(&self, canvas: &mut Canvas) {
        self.each_pixel(SOFT_PX, canvas, |outside_px, facing, pixel| {
            let cover = smooth((SOFT_PX - outside_px) / (2.0 * SOFT_PX));
            let rim = (1.0 + outside_px / RIM_PX).clamp(0.0, 1.0);
            for (value, own) in pixel.iter_mut().zip(self.rgb) {
                let lit = own + RIM * rim * facing;
                *value = to_byte(f32::from(*value) + cover * (lit - f32::from(*value)));
            }
        });
    }

    /// Returns the part of the canvas that [`draw`](Self::draw) and [`shade`](Self::shade) can
    /// touch.
    pub(super) fn area(&self, width: usize, height: usize) -> Area {
        self.bounds(SHADOW_PX + 6.0, width, height)
    }

    fn bounds(&self, reach_px: f32, width: usize, height: usize) -> Area {
        let [a, b] = self.along.map(f32::abs);
        let wide = a * self.half[0] + b * self.half[1] + reach_px;
        let high = b * self.half[0] + a * self.half[1] + reach_px;
        // `as usize` turns negative numbers into 0.
        let span = |middle: f32, half: f32, size: usize| {
            let (low, high) = ((middle - half) as usize, (middle + half + 2.0) as usize);
            [low.min(size), high.min(size)]
        };
        Area {
            x: span(self.middle[0], wide, width),
            y: span(self.middle[1], high, height),
        }
    }

    /// Calls `with` for each pixel that is less than `reach_px` outside. Passes the distance of the
    /// pixel's center from the outline, and how much that side faces the lamp.
    fn each_pixel(
        &self,
        reach_px: f32,
        canvas: &mut Canvas,
        mut with: impl FnMut(f32, f32, &mut [u8]),
    ) {
        let Area {
            x: columns,
            y: rows,
        } = self.bounds(reach_px, canvas.width, canvas.height);
        let [cos, sin] = self.along;
        let inner = self.half.map(|half| half - self.corner);
        let lamp = [LAMP[0] * cos + LAMP[1] * sin, LAMP[1] * cos - LAMP[0] * sin];
        for y in rows[0]..rows[1] {
            let start = 3 * (y * canvas.width + columns[0]);
            let pixels = canvas.pixels[start..].chunks_exact_mut(3);
            for (x, pixel) in (columns[0]..columns[1]).zip(pixels) {
                let (dx, dy) = (x as f32 - self.middle[0], y as f32 - self.middle[1]);
                let (u, v) = (dx * cos + dy * sin, dy * cos - dx * sin);
                let (beyond_u, beyond_v) = (u.abs() - inner[0], v.abs() - inner[1]);
                let (past_u, past_v) = (beyond_u.max(0.0), beyond_v.max(0.0));
                let past = (past_u * past_u + past_v * past_v).sqrt();
                let outside_px = past + beyond_u.max(beyond_v).min(0.0) - self.corner;
                if outside_px >= reach_px {
                    continue;
                }
                let facing = if past > 1e-3 {
                    (lamp[0] * past_u * u.signum() + lamp[1] * past_v * v.signum()) / past
                } else if beyond_u > beyond_v {
                    lamp[0] * u.signum()
                } else {
                    lamp[1] * v.signum()
                };
                with(outside_px, facing, pixel);
            }
        }
    }
}

/// Smooth step from 0 to 1, with horizontal ends.
pub(super) fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

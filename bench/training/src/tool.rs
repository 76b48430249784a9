//! Metal tools and fasteners: bars that are round like ropes, but stiff and short, with one or two
//! bends.

use std::f32::consts::PI;

use crate::canvas::{
    Canvas, Field, Rgb, Vec2, color, covered, direction, dot, happens, minus, normal, scaled,
    shadow, spread,
};
use lariat_portable::SplitMix64;

/// Draws one tool anywhere.
pub(crate) fn lay(canvas: &mut Canvas, random: &mut SplitMix64) {
    let half_px = 0.5 * spread(random, 4.0, 26.0);
    let rgb = match happens(random, 0.8) {
        true => [random.uniform_f32(50.0, 215.0); 3].map(|level| level + 5.0 * normal(random)),
        false => color(random),
    };
    let side = canvas.side as f32;
    let at = [(); 2].map(|()| random.uniform_f32(0.0, side));
    match random.below(4) {
        0 | 1 => Bar::bent(at, half_px, random).lay(canvas, rgb, random),
        2 => spanner(canvas, at, half_px, rgb, random),
        _ => screw(canvas, at, half_px, rgb, random),
    }
}

/// A round body along a polyline: its centerline, half its width, and the pitch of its thread, if
/// any.
struct Bar {
    middle: Vec<Vec2>,
    half_px: f32,
    thread_px: Option<f32>,
}

impl Bar {
    /// Returns a key with a short arm, a hook or a bracket: straight parts joined by tight arcs.
    fn bent(at: Vec2, half_px: f32, random: &mut SplitMix64) -> Self {
        let mut heading = random.uniform_f32(0.0, 2.0 * PI);
        let (mut at, mut middle) = (at, vec![at]);
        let mut walk = |middle: &mut Vec<Vec2>, heading: f32, length: f32| {
            let step = direction(heading);
            at = [at[0] + length * step[0], at[1] + length * step[1]];
            middle.push(at);
        };
        walk(&mut middle, heading, half_px * spread(random, 6.0, 45.0));
        for _ in 0..[0, 1, 1, 1, 2][random.below(5)] {
            let bend = random.uniform_f32(1.2, 1.9) * if happens(random, 0.5) { 1.0 } else { -1.0 };
            let radius = half_px * random.uniform_f32(1.2, 4.0);
            for _ in 0..3 {
                heading += bend / 3.0;
                walk(&mut middle, heading, radius * bend.abs() / 3.0);
            }
            walk(&mut middle, heading, half_px * spread(random, 2.0, 16.0));
        }
        Self {
            middle,
            half_px,
            thread_px: None,
        }
    }

    /// Returns a point's signed distance from the body, its coordinate across the body in half
    /// widths, and its coordinate along it in pixels.
    fn place(&self, at: Vec2) -> (f32, f32, f32) {
        let (mut nearest, mut across, mut along, mut begin) = (f32::MAX, 0.0, 0.0, 0.0);
        for pair in self.middle.windows(2) {
            let step = minus(pair[1], pair[0]);
            let length = dot(step, step).sqrt().max(1e-3);
            let (step, off) = (step.map(|c| c / length), minus(at, pair[0]));
            let (x, y) = (dot(off, step), off[1] * step[0] - off[0] * step[1]);
            let beyond = x - x.clamp(0.0, length);
            let away = (y * y + beyond * beyond).sqrt();
            if away < nearest {
                (nearest, across, along) = (away, y / self.half_px, begin + x);
            }
            begin += length;
        }
        // Cut off square.
        let ends = (-along).max(along - begin);
        ((nearest - self.half_px).max(ends), across, along)
    }

    fn lay(&self, canvas: &mut Canvas, rgb: Rgb, random: &mut SplitMix64) {
        let mut cover = Field::of(canvas.side, 0.0);
        for (at, value) in cover.places() {
            *value = covered(self.place(at).0);
        }
        let by = [(); 2].map(|()| 0.5 * self.half_px * normal(random));
        let fall = shadow(&cover, by, 0.4 * self.half_px + 0.5);
        canvas.darken(&fall, random.uniform_f32(0.0, 0.7));
        let (dark, shine) = (random.uniform_f32(0.2, 0.9), random.uniform_f32(0.0, 160.0));
        let lamp = random.uniform_f32(-0.6, 0.6);
        // Hexagonal or round.
        let is_flat = happens(random, 0.4);
        canvas.lay(|at| {
            let (distance, across, along) = self.place(at);
            let across = match is_flat {
                true => (1.5 * across).round() / 1.5,
                false => across,
            };
            let facing = (1.0 - (across - lamp) * (across - lamp)).max(0.0);
            let turn = self.thread_px.map_or(1.0, |pitch| {
                0.75 + 0.25 * libm::sinf(2.0 * PI * along / pitch + across)
            });
            let light = turn * (dark + (1.0 - dark) * facing);
            let glint = shine * libm::powf(facing, 12.0);
            let paint = scaled(rgb, light).map(|value| value + glint);
            (covered(distance), paint)
        });
    }
}

/// Draws a flat body with a head at one or both ends: a ring or jaws.
fn spanner(canvas: &mut Canvas, at: Vec2, half_px: f32, rgb: Rgb, random: &mut SplitMix64) {
    let along = direction(random.uniform_f32(0.0, 2.0 * PI));
    let length = half_px * spread(random, 10.0, 30.0);
    let head = half_px * random.uniform_f32(1.7, 2.6);
    let hole = head * random.uniform_f32(0.4, 0.7);
    let is_open = [(); 2].map(|()| happens(random, 0.5));
    let has_two = happens(random, 0.6);
    let shade = random.uniform_f32(0.6, 1.4);
    canvas.lay(|place| {
        let off = minus(place, at);
        let (x, y) = (dot(off, along), off[1] * along[0] - off[0] * along[1]);
        let mut distance = (y.abs() - half_px).max((-x).max(x - length));
        for (end, is_open) in [0.0, length].into_iter().zip(is_open) {
            if end > 0.0 && !has_two {
                break;
            }
            let beyond = if end > 0.0 { x - end } else { -x };
            let away = (beyond * beyond + y * y).sqrt();
            let gap = match is_open && beyond > 0.0 {
                true => y.abs() - hole,
                false => away - hole,
            };
            distance = distance.min(away - head).max(-gap);
        }
        let light = 1.0 + (shade - 1.0) * (1.0 + distance / half_px).clamp(0.0, 1.0);
        (covered(distance), scaled(rgb, light))
    });
}

/// Draws a screw with its head, or a nut.
fn screw(canvas: &mut Canvas, at: Vec2, half_px: f32, rgb: Rgb, random: &mut SplitMix64) {
    let angle = random.uniform_f32(0.0, 2.0 * PI);
    let along = direction(angle);
    if happens(random, 0.6) {
        let length = half_px * random.uniform_f32(3.0, 14.0);
        let rod = Bar {
            middle: vec![at, [0, 1].map(|k| at[k] + length * along[k])],
            half_px: 0.6 * half_px,
            thread_px: Some((half_px * random.uniform_f32(0.2, 0.7)).max(1.5)),
        };
        rod.lay(canvas, rgb, random);
    }
    let sides = [0.0, 1.0, 2.0].map(|k| direction(angle + k * PI / 3.0));
    let hole = half_px * random.uniform_f32(0.0, 0.7);
    let inner = random.uniform_f32(0.2, 1.2);
    canvas.lay(|place| {
        let off = minus(place, at);
        let beyond = sides.iter().map(|&side| dot(off, side).abs() - half_px);
        let distance = beyond.fold(f32::MIN, f32::max);
        let light = if dot(off, off) < hole * hole {
            inner
        } else {
            1.0 - 0.3 * dot(off, along) / half_px
        };
        (covered(distance), scaled(rgb, light))
    });
}

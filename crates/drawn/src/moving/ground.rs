//! What the ropes of a film lie on, as a camera sees it that may move.

use super::Story;
use crate::RenderOptions;
use crate::rendered::portable::sin_turns;
use crate::rendered::table::{lit_table, to_byte};
use crate::scenes::{self, Class};

/// How far a camera moves to either side, as a share of the picture's shorter side, and how long it takes there and back.
const SWAY: f64 = 0.07;
const PERIODS_S: [f64; 2] = [4.7, 3.6];

/// A surface, as large as all that a camera gets to see of it.
#[derive(Debug)]
pub(super) struct Ground {
    rgb: Vec<u8>,
    /// Pixels of it beyond the picture on every side.
    margin: usize,
    size: [usize; 2],
}

impl Ground {
    /// The ground of a story; one that is no plain table says the rope's color.
    pub(super) fn of(story: Story, options: &mut RenderOptions) -> Self {
        let size = [options.width, options.height].map(|side| side as usize);
        let margin = if story.is_panned() {
            (SWAY * size[0].min(size[1]) as f64) as usize + 2
        } else {
            0
        };
        let sides = size.map(|side| side + 2 * margin);
        let rgb = if story.is_cluttered() {
            let class = [Class::OnClutter, Class::OnTexture][options.seed as usize % 2];
            let (rgb, rope) = scenes::surface(class, options.seed / 2, sides);
            options.rope_rgb = rope;
            rgb.iter().map(|&level| to_byte(level.into())).collect()
        } else {
            let [width, height] = sides.map(|side| side as u32);
            lit_table(&RenderOptions {
                width,
                height,
                ..*options
            })
        };
        Self { rgb, margin, size }
    }

    /// Fills `out` with what a camera sees at a moment; returns how far it has moved, in pixels.
    pub(super) fn film(&self, time_s: f64, out: &mut Vec<u8>) -> [f64; 2] {
        if self.margin == 0 {
            out.clone_from(&self.rgb);
            return [0.0; 2];
        }
        let sway_px = (self.margin - 2) as f64;
        let moved_px = PERIODS_S.map(|period_s| sway_px * sin_turns(time_s / period_s));
        let from = moved_px.map(|px| px + self.margin as f64);
        let whole = from.map(|px| px as usize);
        let [fx, fy] = [0, 1].map(|axis| (from[axis] - whole[axis] as f64) as f32);
        let stride = 3 * (self.size[0] + 2 * self.margin);
        out.clear();
        for y in 0..self.size[1] {
            let start = (whole[1] + y) * stride + 3 * whole[0];
            let [upper, lower] = [start, start + stride].map(|at| &self.rgb[at..]);
            for i in 0..3 * self.size[0] {
                let mix =
                    |a: u8, b: u8, share: f32| f32::from(a) + share * (f32::from(b) - f32::from(a));
                let above = mix(upper[i], upper[i + 3], fx);
                let below = mix(lower[i], lower[i + 3], fx);
                out.push(to_byte(above + fy * (below - above)));
            }
        }
        moved_px
    }
}

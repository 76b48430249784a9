//! A hand with closed fingers that comes in from below, rests on the rope and leaves. It is drawn
//! once and then moved over the picture.

use super::plate::smooth;
use crate::rendered::draw::{Area, Canvas};
use crate::rendered::table::to_byte;

/// Time to come in, and to leave, in seconds.
const MOVES_S: f64 = 0.3;
const SKIN_RGB: [f32; 3] = [206.0, 150.0, 118.0];
/// Offset of its shadow, and the share of the light that the shadow takes.
const SHADOW_AT: [i64; 2] = [5, 7];
const SHADOW: f32 = 0.2;
/// Width of its picture, and position of the palm's middle in it.
const WIDTH: usize = 240;
const MIDDLE: [usize; 2] = [120, 160];
/// Maximum length of the forearm below the palm's middle.
const ARM_PX: usize = 700;
/// Rounding of the joints between its parts.
const ROUND_PX: f32 = 7.0;

/// Time at which a hand covers the rope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandOptions {
    /// Start of its rest, in seconds from the first frame; it begins to come in shortly before.
    pub at_s: f64,
    /// Duration of its rest, in seconds.
    pub for_s: f64,
}

/// A thick line between two points, relative to the palm's middle.
struct Limb {
    from: [f32; 2],
    to: [f32; 2],
    radius: f32,
}

/// Four fingers, the thumb, the palm and the arm.
const LIMBS: [Limb; 8] = [
    limb([-38.0, -25.0], [-43.0, -96.0], 13.0),
    limb([-13.0, -35.0], [-15.0, -124.0], 14.0),
    limb([13.0, -35.0], [13.0, -118.0], 14.0),
    limb([36.0, -25.0], [39.0, -88.0], 12.0),
    limb([38.0, 25.0], [88.0, -28.0], 14.0),
    limb([-16.0, -8.0], [-13.0, 30.0], 38.0),
    limb([16.0, -8.0], [13.0, 30.0], 38.0),
    limb([0.0, 50.0], [0.0, 900.0], 36.0),
];

const fn limb(from: [f32; 2], to: [f32; 2], radius: f32) -> Limb {
    Limb { from, to, radius }
}

impl Limb {
    /// Distance of a point from the outline, negative inside.
    fn outside_px(&self, at: [f32; 2]) -> f32 {
        let [bx, by] = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let [px, py] = [at[0] - self.from[0], at[1] - self.from[1]];
        let share = ((px * bx + py * by) / (bx * bx + by * by)).clamp(0.0, 1.0);
        let (x, y) = (px - share * bx, py - share * by);
        (x * x + y * y).sqrt() - self.radius
    }
}

/// Picture of the hand, and its resting place.
#[derive(Debug)]
pub(super) struct Hand {
    options: HandOptions,
    /// Color and coverage (0 to 255) of each pixel.
    pixels: Vec<[u8; 4]>,
    /// Resting place of the palm: the position of the rope's middle when the hand comes.
    rests_at: Option<[f64; 2]>,
}

impl Hand {
    pub(super) fn new(options: HandOptions) -> Self {
        let rows = MIDDLE[1] + ARM_PX;
        let mut pixels = Vec::with_capacity(WIDTH * rows);
        for y in 0..rows {
            for x in 0..WIDTH {
                let at = [x as f32 - MIDDLE[0] as f32, y as f32 - MIDDLE[1] as f32];
                pixels.push(skin(at));
            }
        }
        Self {
            options,
            pixels,
            rests_at: None,
        }
    }

    /// Draws the hand at its position at this time, with the rope's middle at `rope`. Returns the
    /// drawn area.
    pub(super) fn draw(&mut self, time_s: f64, rope: [f64; 2], canvas: &mut Canvas) -> Area {
        let HandOptions { at_s, for_s } = self.options;
        let into = (time_s - (at_s - MOVES_S)) / MOVES_S;
        let out = (time_s - (at_s + for_s)) / MOVES_S;
        if into <= 0.0 || out >= 1.0 {
            return Area::default();
        }
        let rests_at = *self.rests_at.get_or_insert(rope);
        // The hand is slow at its resting place and fast at the picture's edge, where fingertips
        // that are visible alone could be mistaken for another object.
        let (into, out) = (into.min(1.0), out.max(0.0));
        let away = (1.0 - into) * (1.0 - into) + out * out;
        let below_px = away * (canvas.height as f64 - rests_at[1] + MIDDLE[1] as f64);
        let corner = [
            rests_at[0] as i64 - MIDDLE[0] as i64,
            (rests_at[1] + below_px) as i64 - MIDDLE[1] as i64,
        ];
        let fallen = [corner[0] + SHADOW_AT[0], corner[1] + SHADOW_AT[1]];
        self.each_pixel(fallen, canvas, |skin, pixel| {
            let light = 1.0 - SHADOW * f32::from(skin[3]) / 255.0;
            for value in pixel {
                *value = to_byte(f32::from(*value) * light);
            }
        });
        self.each_pixel(corner, canvas, |skin, pixel| {
            let cover = f32::from(skin[3]) / 255.0;
            for (value, own) in pixel.iter_mut().zip(skin) {
                let under = f32::from(*value);
                *value = to_byte(under + cover * (f32::from(*own) - under));
            }
        });
        let (a, b) = (
            self.area(corner, canvas.width, canvas.height),
            self.area(fallen, canvas.width, canvas.height),
        );
        Area {
            x: [a.x[0], b.x[1]],
            y: [a.y[0], b.y[1]],
        }
    }

    /// Returns the part of the canvas that its picture covers.
    fn area(&self, corner: [i64; 2], width: usize, height: usize) -> Area {
        let span = |low: i64, long: usize, size: usize| {
            [low, low + long as i64].map(|place| place.clamp(0, size as i64) as usize)
        };
        Area {
            x: span(corner[0], WIDTH, width),
            y: span(corner[1], self.pixels.len() / WIDTH, height),
        }
    }

    fn each_pixel(
        &self,
        corner: [i64; 2],
        canvas: &mut Canvas,
        mut with: impl FnMut(&[u8; 4], &mut [u8]),
    ) {
        let Area { x, y } = self.area(corner, canvas.width, canvas.height);
        for row in y[0]..y[1] {
            let source = (row as i64 - corner[1]) as usize * WIDTH;
            let first = (x[0] as i64 - corner[0]) as usize;
            let skin = &self.pixels[source + first..source + first + (x[1] - x[0])];
            let start = 3 * (row * canvas.width + x[0]);
            let pixels = canvas.pixels[start..].chunks_exact_mut(3);
            for (skin, pixel) in skin.iter().zip(pixels) {
                if skin[3] > 0 {
                    with(skin, pixel);
                }
            }
        }
    }
}

/// Color and coverage at a point, relative to the palm's middle. The limbs merge smoothly and
/// darken toward their edges.
fn skin(at: [f32; 2]) -> [u8; 4] {
    let mut outside_px = f32::MAX;
    for limb in &LIMBS {
        let other = limb.outside_px(at);
        // A polynomial smooth minimum (Quilez).
        let near = (ROUND_PX - (outside_px - other).abs()).max(0.0) / ROUND_PX;
        outside_px = outside_px.min(other) - 0.25 * ROUND_PX * near * near;
    }
    let cover = smooth(0.5 - 0.5 * outside_px);
    let round = smooth(-outside_px / 16.0);
    let light = 0.8 + 0.2 * round;
    let [r, g, b] = SKIN_RGB.map(|c| to_byte(c * light));
    [r, g, b, (255.0 * cover) as u8]
}

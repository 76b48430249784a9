//! Objects next to a rope that are not ropes, but that a mask mistakes for ropes.

use super::line::{Vec2, dot, minus, norm};
use super::style::{Rgb, Style, from_hsv};
use crate::rendered::portable::{cos_turns, sin_turns};
use lariat_portable::SplitMix64;

/// Share of the picture's width that separates ropes on the left from objects on the right.
pub(super) const FROM: f64 = 0.62;

/// Letters as strokes in a box of 1 × 1, each as its corners in order.
const LETTERS: [&[Vec2]; 6] = [
    &[[0.0, 0.0], [0.0, 1.0], [0.7, 1.0]],
    &[[0.0, 1.0], [0.0, 0.0], [0.8, 1.0], [0.8, 0.0]],
    &[[0.0, 0.0], [0.4, 1.0], [0.8, 0.0]],
    &[[0.0, 0.0], [0.7, 0.0], [0.0, 1.0], [0.7, 1.0]],
    &[[0.7, 0.0], [0.0, 0.0], [0.0, 1.0], [0.7, 1.0]],
    &[[0.2, 0.0], [0.2, 1.0]],
];

#[derive(Debug)]
enum Kind {
    /// A straight body between two points. From the share `cap` of its length on, it has a second
    /// color.
    Pen { ends: [Vec2; 2], cap: f64 },
    /// Another surface on one side of a straight line, with a line along it.
    Board { at: Vec2, normal: Vec2, shade: f32 },
    /// A ring around a point.
    Rim {
        at: Vec2,
        radius_px: f64,
        inside: f32,
    },
    /// A rectangle around a point, with half side lengths along each of two directions.
    Box {
        at: Vec2,
        along: Vec2,
        half_px: Vec2,
    },
    /// Straight strokes.
    Letters { strokes: Vec<[Vec2; 2]> },
}

/// One object.
#[derive(Debug)]
pub(super) struct Thing {
    kind: Kind,
    width_px: f64,
    colors: [Rgb; 2],
}

impl Thing {
    /// Makes the object of a seed to the right of the ropes, in colors that differ from the
    /// table's.
    pub(super) fn of(seed: u64, size_px: Vec2, look: &Style, random: &mut SplitMix64) -> Self {
        let side_px = size_px[0].min(size_px[1]);
        let low = [FROM * size_px[0] + 8.0, 8.0];
        let room = minus([size_px[0] - 8.0, size_px[1] - 8.0], low);
        Self::within(seed % 5, [low, room], side_px, look, random)
    }

    /// Makes several objects of all kinds, anywhere.
    pub(super) fn clutter(size_px: Vec2, look: &Style, random: &mut SplitMix64) -> Vec<Self> {
        let side_px = size_px[0].min(size_px[1]);
        let count = 6 + random.next_u64() % 9;
        let thing = |_| {
            let room = [(); 2].map(|()| side_px * random.uniform(0.2, 0.6));
            let low = [0, 1].map(|k| random.uniform(-0.3, 1.0) * (size_px[k] - 0.4 * room[k]));
            // Boxes and text are the most common.
            let kind = [0, 1, 2, 3, 4, 4, 5, 5, 5][random.next_u64() as usize % 9];
            Self::within(kind, [low, room], side_px, look, random)
        };
        (0..count).map(thing).collect()
    }

    /// Makes an object of a kind in a part of the picture, given by its upper left corner and its
    /// size.
    fn within(
        kind: u64,
        [low, room]: [Vec2; 2],
        side_px: f64,
        look: &Style,
        random: &mut SplitMix64,
    ) -> Self {
        let at = |x: f64, y: f64| [low[0] + x * room[0], low[1] + y * room[1]];
        let turns = random.uniform(0.0, 1.0);
        let along = [cos_turns(turns), sin_turns(turns)];
        let colors = [(); 2].map(|()| color_off(look.table, random));
        let (kind, width_px) = match kind {
            pen @ (0 | 1) => {
                let length_px = random.uniform(0.75, 0.98) * room[0].min(room[1]);
                let widths = if pen == 0 {
                    random.uniform(11.0, 17.0)
                } else {
                    random.uniform(6.5, 9.0)
                };
                let middle = at(0.5, random.uniform(0.35, 0.65));
                let half = [0, 1].map(|k| 0.5 * length_px * along[k]);
                let ends = [minus(middle, half), [0, 1].map(|k| middle[k] + half[k])];
                let cap = random.uniform(0.6, 1.2);
                (Kind::Pen { ends, cap }, length_px / widths)
            }
            2 => {
                // From top to bottom, or nearly.
                let lean = random.uniform(-0.03, 0.03);
                let kind = Kind::Board {
                    at: at(random.uniform(0.3, 0.6), 0.5),
                    normal: [cos_turns(lean), sin_turns(lean)],
                    shade: 1.0 + (random.sign() * random.uniform(0.06, 0.14)) as f32,
                };
                (kind, side_px * random.uniform(0.008, 0.02))
            }
            3 => {
                let radius_px = random.uniform(0.3, 0.45) * room[0].min(room[1]);
                let kind = Kind::Rim {
                    at: at(0.5, random.uniform(0.35, 0.65)),
                    radius_px,
                    inside: random.uniform(0.92, 1.08) as f32,
                };
                (kind, radius_px * random.uniform(0.06, 0.14))
            }
            5 => {
                let half_px = [0, 1].map(|k| 0.5 * room[k] * random.uniform(0.4, 1.0));
                let at = at(0.5, 0.5);
                (Kind::Box { at, along, half_px }, 1.0)
            }
            _ => {
                let count = 3.0 + (3.0 * random.uniform(0.0, 1.0)).floor();
                let high_px = room[0] / (1.3 * count) * random.uniform(0.8, 1.1);
                let top = random.uniform(0.1, 0.8);
                let mut strokes = Vec::new();
                for i in 0..count as usize {
                    let letter = LETTERS[random.next_u64() as usize % LETTERS.len()];
                    let from = at((i as f64 + 0.1) / count, top);
                    let on = |p: Vec2| [0, 1].map(|k| from[k] + high_px * p[k]);
                    strokes.extend(letter.windows(2).map(|pair| [on(pair[0]), on(pair[1])]));
                }
                let width_px = (high_px * random.uniform(0.09, 0.14)).max(3.0);
                (Kind::Letters { strokes }, width_px)
            }
        };
        Self {
            kind,
            width_px,
            colors,
        }
    }

    /// Color of the table at a point, with the object on it.
    pub(super) fn on(&self, table: Rgb, at: Vec2) -> Rgb {
        let half_px = 0.5 * self.width_px;
        let (ground, far_px, color) = match &self.kind {
            Kind::Pen { ends, cap } => {
                let (far_px, along) = from_stroke(*ends, at);
                (table, far_px, self.colors[usize::from(along > *cap)])
            }
            Kind::Board {
                at: on,
                normal,
                shade,
            } => {
                let off_px = dot(minus(at, *on), *normal);
                let share = (off_px + 0.5).clamp(0.0, 1.0) as f32;
                let ground = table.map(|c| c * (1.0 + share * (shade - 1.0)));
                (ground, off_px.abs(), self.colors[0])
            }
            Kind::Rim {
                at: middle,
                radius_px,
                inside,
            } => {
                let off_px = norm(minus(at, *middle)) - radius_px;
                let share = (0.5 - off_px).clamp(0.0, 1.0) as f32;
                let ground = table.map(|c| c * (1.0 + share * (inside - 1.0)));
                (ground, off_px.abs(), self.colors[0])
            }
            Kind::Box {
                at: middle,
                along,
                half_px,
            } => {
                let off = minus(at, *middle);
                let aside = [-along[1], along[0]];
                let beyond = [dot(off, *along), dot(off, aside)].map(f64::abs);
                let far_px = (beyond[0] - half_px[0]).max(beyond[1] - half_px[1]);
                (table, far_px.max(0.0), self.colors[0])
            }
            Kind::Letters { strokes } => {
                let far = strokes.iter().map(|&stroke| from_stroke(stroke, at).0);
                (table, far.fold(f64::INFINITY, f64::min), self.colors[0])
            }
        };
        let cover = (half_px + 0.5 - far_px).clamp(0.0, 1.0) as f32;
        [0, 1, 2].map(|k| ground[k] + cover * (color[k] - ground[k]))
    }
}

/// Distance of a point from a straight stroke, and position of the nearest point along it, from 0
/// to 1.
fn from_stroke([from, to]: [Vec2; 2], at: Vec2) -> (f64, f64) {
    let way = minus(to, from);
    let along = (dot(minus(at, from), way) / dot(way, way).max(1e-9)).clamp(0.0, 1.0);
    let nearest = [0, 1].map(|k| from[k] + along * way[k]);
    (norm(minus(at, nearest)), along)
}

/// Color that differs clearly from the table's.
fn color_off(table: Rgb, random: &mut SplitMix64) -> Rgb {
    loop {
        let hue = random.uniform(0.0, 1.0);
        let rgb = from_hsv(hue, random.uniform(0.0, 0.9), random.uniform(20.0, 240.0));
        let off = (0..3).map(|k| (rgb[k] - table[k]).abs());
        if off.fold(0.0, f32::max) > 90.0 {
            return rgb;
        }
    }
}

//! Ground under the ropes: the table's own color, or a surface with more detail.

use super::Class;
use super::line::{Vec2, dot};
use super::style::{Rgb, Style, from_hsv};
use super::thing::Thing;
use crate::rendered::mottling::Mottling;
use crate::rendered::portable::{cos_turns, sin_turns, smoothstep};
use lariat_portable::SplitMix64;

/// A surface.
pub(super) enum Ground {
    /// A single color, with objects on it.
    Things(Vec<Thing>),
    /// A transition from the table's color to another, across a line.
    Gradient {
        to: Rgb,
        at: Vec2,
        /// Direction across the line, scaled so that the transition has length 1.
        across: Vec2,
    },
    /// Lighter and darker waves in one direction, with bends.
    Texture(Texture),
}

impl Ground {
    /// Makes the surface of a class.
    pub(super) fn of(
        class: Class,
        seed: u64,
        size_px: Vec2,
        look: &Style,
        random: &mut SplitMix64,
    ) -> Self {
        match class {
            Class::Things => Self::Things(vec![Thing::of(seed, size_px, look, random)]),
            Class::OnClutter => Self::Things(Thing::clutter(size_px, look, random)),
            Class::OnTexture => Self::Texture(Texture::of(seed, random)),
            Class::Taut if seed % 4 == 1 => Self::Texture(Texture::of(seed / 4, random)),
            Class::Taut if seed % 4 > 1 => Self::Things(Thing::clutter(size_px, look, random)),
            Class::Gradient => {
                let turns = random.uniform(0.0, 1.0);
                let length_px = random.uniform(0.15, 0.8) * size_px[0].min(size_px[1]);
                Self::Gradient {
                    to: look.table_to,
                    at: size_px.map(|side| side * random.uniform(0.35, 0.65)),
                    across: [cos_turns(turns), sin_turns(turns)].map(|c| c / length_px),
                }
            }
            _ => Self::Things(Vec::new()),
        }
    }

    /// Color at a point, for a table of color `table`.
    pub(super) fn at(&self, table: Rgb, at: Vec2) -> Rgb {
        match self {
            Self::Things(things) => things
                .iter()
                .fold(table, |table, thing| thing.on(table, at)),
            Self::Gradient {
                to,
                at: middle,
                across,
            } => {
                let off = [at[0] - middle[0], at[1] - middle[1]];
                let share = smoothstep(dot(off, *across) + 0.5) as f32;
                [0, 1, 2].map(|k| table[k] + share * (to[k] - table[k]))
            }
            Self::Texture(texture) => texture.on(table, at),
        }
    }
}

enum Kind {
    /// Cut growth rings: waves across a direction, bent and torn along it.
    Wood,
    /// Threads over and under each other.
    Cloth,
    /// Shapes in a few inks, with sharp edges.
    Print([Rgb; 3]),
    /// Stones of many sizes and brightnesses.
    Gravel,
}

/// Pattern of a surface.
pub(super) struct Texture {
    kind: Kind,
    /// Largest change of the light.
    strength: f32,
    period_px: f64,
    along: Vec2,
    waves: Mottling<32>,
    others: Mottling<64>,
}

impl Texture {
    fn of(seed: u64, random: &mut SplitMix64) -> Self {
        let turns = random.uniform(0.0, 1.0);
        let mut ink = || {
            from_hsv(
                random.uniform(0.0, 1.0),
                random.uniform(0.0, 0.6),
                random.uniform(60.0, 230.0),
            )
        };
        let inks = [ink(), ink(), ink()];
        let (kind, strength, period_px) = match seed % 4 {
            0 => (Kind::Wood, [0.2, 0.45], [10.0, 40.0]),
            1 => (Kind::Cloth, [0.2, 0.5], [4.0, 16.0]),
            2 => (Kind::Print(inks), [0.6, 1.0], [40.0, 110.0]),
            _ => (Kind::Gravel, [0.25, 0.6], [5.0, 20.0]),
        };
        Self {
            kind,
            strength: random.uniform(strength[0], strength[1]) as f32,
            period_px: random.uniform(period_px[0], period_px[1]),
            along: [cos_turns(turns), sin_turns(turns)],
            waves: Mottling::new(random),
            others: Mottling::new(random),
        }
    }

    fn on(&self, table: Rgb, at: Vec2) -> Rgb {
        let [cos, sin] = self.along;
        // An offset far from the origin on both axes, where the pattern has no seam.
        let turned = [
            at[0] * cos + at[1] * sin + 1e4,
            at[1] * cos - at[0] * sin + 1e4,
        ];
        let units = turned.map(|c| c / self.period_px);
        let lit = |value: f64| table.map(|c| c * (1.0 + self.strength * value as f32));
        match &self.kind {
            Kind::Wood => {
                let bent = units[1] + 3.0 * self.waves.at(turned, [1.0 / 300.0, 1.0 / 90.0]);
                let fiber = self.others.at([0.08 * turned[0], turned[1]], [1.0, 0.5]);
                lit(0.6 * sin_turns(bent) + 0.4 * fiber)
            }
            Kind::Cloth => {
                let thread = |along: f64| sin_turns(along);
                let over = thread(0.5 * units[0]) * thread(0.5 * units[1]);
                let uneven = self.waves.at(turned, [1.0 / 40.0, 1.0 / 12.0]);
                lit(0.7 * over + 0.3 * uneven)
            }
            Kind::Print(inks) => {
                let levels = [0.0, 0.31, 0.67].map(|by| {
                    let moved = [units[0] + 37.0 * by, units[1] + 23.0 * by];
                    self.waves.at(moved, [1.0, 2.0])
                });
                // The edge is about two pixels wide.
                let mut color = table;
                for (ink, level) in inks.iter().zip(levels) {
                    let share =
                        self.strength * smoothstep(0.25 * self.period_px * (level - 0.25)) as f32;
                    color = [0, 1, 2].map(|k| color[k] + share * (ink[k] - color[k]));
                }
                color
            }
            Kind::Gravel => {
                let stones = self.waves.at(units, [0.7, 1.9]);
                let grains = self.others.at(units, [2.3, 0.4]);
                lit(0.7 * stones + 0.5 * grains)
            }
        }
    }
}

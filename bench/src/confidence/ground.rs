//! Backgrounds of a drawn rope: patterns that make it hard to see.

use lariat_portable::SplitMix64;

/// Texture added to the drawn background.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ground {
    Plain,
    Faint,
    Strong,
    Cluttered,
    Noisy,
}

impl Ground {
    pub(super) const ALL: [Self; 5] = [
        Self::Plain,
        Self::Faint,
        Self::Strong,
        Self::Cluttered,
        Self::Noisy,
    ];

    /// Returns the strength of the pattern, in levels.
    fn levels(self) -> f32 {
        match self {
            Self::Plain => 0.0,
            Self::Faint => 12.0,
            Self::Strong => 30.0,
            Self::Cluttered => 90.0,
            Self::Noisy => 20.0,
        }
    }

    /// Adds the pattern around the rope. `cover` is the share of each pixel that the rope covers.
    pub(super) fn lay(self, rgb: &mut [u8], cover: &[u8], width: usize, random: &mut SplitMix64) {
        let levels = self.levels() * random.uniform(0.5, 1.5) as f32;
        let pattern = Pattern::of(random, width, cover.len() / width);
        for (i, (pixel, cover)) in rgb.chunks_exact_mut(3).zip(cover).enumerate() {
            let shown = levels * (1.0 - f32::from(*cover) / 255.0);
            let add = pattern.at([(i % width) as f32, (i / width) as f32]);
            for (channel, add) in pixel.iter_mut().zip(add) {
                *channel = (f32::from(*channel) + shown * add) as u8;
            }
        }
        if self == Self::Noisy {
            let sigma = random.uniform(4.0, 22.0);
            for byte in rgb {
                // Three uniform values of variance 1/12 each: 1/4 in all.
                let sum: f64 = (0..3).map(|_| random.uniform(-0.5, 0.5)).sum();
                *byte = (f64::from(*byte) + 2.0 * sigma * sum) as u8;
            }
        }
    }
}

/// A pattern with values between about −1 and 1.
struct Pattern {
    kind: u32,
    period_px: f32,
    turn: [f32; 2],
    tint: [f32; 3],
    things: Vec<Thing>,
    waves: Waves,
}

/// A stroke, or the half-plane on one side of it.
struct Thing {
    from: [f32; 2],
    way: [f32; 2],
    color: [f32; 3],
    half_px: f32,
}

impl Pattern {
    fn of(random: &mut SplitMix64, width: usize, height: usize) -> Self {
        let mut one = |from: f64, to: f64| random.uniform(from, to) as f32;
        let kind = one(0.0, 5.0) as u32;
        let period_px = one(6.0, 60.0);
        let angle = one(0.0, std::f64::consts::TAU);
        let count = one(3.0, 14.0) as usize;
        let (right, bottom) = (width as f64, height as f64);
        let things = (0..count).map(|_| {
            let [from, to] = [0, 1].map(|_| [one(0.0, right), one(0.0, bottom)]);
            Thing {
                from,
                way: [to[0] - from[0], to[1] - from[1]],
                color: [0, 1, 2].map(|_| one(-1.0, 1.0)),
                half_px: one(1.0, 12.5),
            }
        });
        let things = things.collect();
        let tint = [0, 1, 2].map(|_| one(0.3, 1.0));
        Self {
            kind,
            period_px,
            turn: [libm::cosf(angle), libm::sinf(angle)],
            tint,
            things,
            waves: Waves::of(random, [width, height], period_px as usize),
        }
    }

    fn at(&self, [x, y]: [f32; 2]) -> [f32; 3] {
        let [cos, sin] = self.turn;
        let [u, v] = [x * cos + y * sin, y * cos - x * sin].map(|along| along / self.period_px);
        let tinted = |value: f32| self.tint.map(|tint| tint * value);
        match self.kind {
            // Squares, waves, cloth.
            0 => tinted(((u.floor() + v.floor()).rem_euclid(2.0)) - 0.5),
            1 => tinted(0.5 * libm::sinf(std::f32::consts::TAU * u)),
            2 => tinted(self.waves.at([x, y])),
            // Strokes; later ones are on top.
            3 => {
                let hit = |thing: &&Thing| thing.is_on([x, y]);
                (self.things.iter().rev().find(hit)).map_or([0.0; 3], |thing| thing.color)
            }
            // Surfaces.
            _ => (self.things.iter())
                .filter(|thing| thing.is_left_of([x, y]))
                .fold([0.0; 3], |sum, thing| {
                    [0, 1, 2].map(|c| sum[c] + 0.5 * thing.color[c])
                }),
        }
    }
}

impl Thing {
    fn is_on(&self, at: [f32; 2]) -> bool {
        let off = [at[0] - self.from[0], at[1] - self.from[1]];
        let [dx, dy] = self.way;
        let along = ((off[0] * dx + off[1] * dy) / (dx * dx + dy * dy).max(1.0)).clamp(0.0, 1.0);
        let beside = [off[0] - along * dx, off[1] - along * dy];
        beside[0] * beside[0] + beside[1] * beside[1] < self.half_px * self.half_px
    }

    fn is_left_of(&self, at: [f32; 2]) -> bool {
        (at[0] - self.from[0]) * self.way[1] > (at[1] - self.from[1]) * self.way[0]
    }
}

/// Random values at the corners of cells, interpolated between them.
pub(super) struct Waves {
    cell_px: usize,
    across: usize,
    corners: Vec<f32>,
}

impl Waves {
    pub(super) fn of(random: &mut SplitMix64, [width, height]: [usize; 2], cell_px: usize) -> Self {
        let cell_px = cell_px.max(4);
        let across = width / cell_px + 2;
        let corners = across * (height / cell_px + 2);
        let corners = (0..corners).map(|_| random.uniform(-1.0, 1.0) as f32);
        Self {
            cell_px,
            across,
            corners: corners.collect(),
        }
    }

    pub(super) fn at(&self, at: [f32; 2]) -> f32 {
        let [x, y] = at.map(|c| c / self.cell_px as f32);
        let (left, top) = (x as usize, y as usize);
        let corner =
            |right: usize, down: usize| self.corners[(top + down) * self.across + left + right];
        let mix = |from: f32, to: f32, share: f32| from + share * (to - from);
        let (x, y) = (x.fract(), y.fract());
        mix(
            mix(corner(0, 0), corner(1, 0), x),
            mix(corner(0, 1), corner(1, 1), x),
            y,
        )
    }
}

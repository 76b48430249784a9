//! Value noise: random heights on a grid with smooth interpolation, as the mottling of a table.

use lariat_portable::SplitMix64;

/// Heights between −1 and 1 on a grid of `GRID` × `GRID` points that repeats without end.
#[derive(Debug, Clone)]
pub(crate) struct Mottling<const GRID: usize> {
    heights: Vec<f64>,
}

impl<const GRID: usize> Mottling<GRID> {
    pub(crate) fn new(random: &mut SplitMix64) -> Self {
        Self {
            heights: (0..GRID * GRID)
                .map(|_| random.uniform(-1.0, 1.0))
                .collect(),
        }
    }

    /// Sum of two octaves at a nonnegative position. The second octave has half the amplitude.
    /// `scales`: grid points per unit in each octave.
    pub(crate) fn at(&self, at: [f64; 2], scales: [f64; 2]) -> f64 {
        self.octave(at.map(|c| c * scales[0])) + 0.5 * self.octave(at.map(|c| c * scales[1]))
    }

    fn octave(&self, [x, y]: [f64; 2]) -> f64 {
        let (column, row) = (x as usize, y as usize);
        let ease = |x: f64| x * x * (3.0 - 2.0 * x);
        let (u, v) = (ease(x - column as f64), ease(y - row as f64));
        let height = |column: usize, row: usize| self.heights[(row % GRID) * GRID + column % GRID];
        let upper = height(column, row) * (1.0 - u) + height(column + 1, row) * u;
        let lower = height(column, row + 1) * (1.0 - u) + height(column + 1, row + 1) * u;
        upper * (1.0 - v) + lower * v
    }
}

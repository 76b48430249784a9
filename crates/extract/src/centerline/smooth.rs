//! Smoothing that does not shrink: the positions and widths that fit the measured ones and bend
//! least.
//!
//! Whittaker, "On a new method of graduation" (1923): minimize Σ wᵢ (zᵢ − mᵢ)² + λ Σ (Δ²z)ᵢ². A
//! wave of k radians per sample is damped by 1 / (1 + λk⁴). An arc of radius R therefore loses only
//! R·(ℓ/R)⁴, where ℓ = λ^¼ is the reach. A moving average of the same reach loses ℓ²/R. Unmeasured
//! stretches (w = 0) continue as a cubic, which bridges crossings.

use lariat_portable::{Arch, Simd, WithSimd};

use super::line::{Line, Sample};

/// Memory of the solver. The matrix is symmetric with two bands next to its diagonal.
#[derive(Debug, Default)]
pub(crate) struct Smoother {
    rows: Vec<[Bands; 2]>,
    ring: Vec<Sample>,
}

/// Right-hand side of a row: x, y, width, and a zero that fills the register.
type Right = [f64; 4];

/// The bands next to the diagonal in one row, and its right-hand side.
#[derive(Clone, Copy, Debug, Default)]
struct Bands {
    first: f64,
    second: f64,
    right: Right,
}

/// An eliminated row, before and after division by the diagonal.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    before: Bands,
    after: Bands,
}

/// Maximum number of rows in the middle.
const MIDDLE: usize = 3;

/// Minimum weight. It keeps the matrix regular where hardly anything is measured.
const LEAST_WEIGHT: f64 = 1e-5;

/// Number of samples that fix the position and direction of the adjacent smoothed part, and the
/// weight that keeps them in place.
const HELD: usize = 2;
const STIFF: f32 = 1e6;

impl Smoother {
    /// Smooths the positions and widths of `line` with a reach of `reach` samples.
    pub(crate) fn smooth(&mut self, line: &mut Line, reach: f32) {
        let lambda = f64::from(reach).powi(4);
        if !line.closed {
            self.solve(&mut line.samples, lambda);
            return;
        }
        // A ring is opened, with an overlap on both sides that is longer than the reach.
        let n = line.samples.len();
        let overlap = n.min((8.0 * reach) as usize + 64);
        let mut ring = std::mem::take(&mut self.ring);
        ring.clear();
        ring.extend_from_slice(&line.samples[n - overlap..]);
        ring.extend_from_slice(&line.samples);
        ring.extend_from_slice(&line.samples[..overlap]);
        self.solve(&mut ring, lambda);
        line.samples.copy_from_slice(&ring[overlap..overlap + n]);
        self.ring = ring;
    }

    /// Smooths only the last `count` samples at either end of the line. They continue the others.
    pub(crate) fn smooth_ends(&mut self, line: &mut Line, reach: f32, count: usize) {
        let n = line.samples.len();
        // The influence of the tips ends at four reaches.
        let count = count + (4.0 * reach) as usize + HELD;
        if 2 * count >= n || line.closed {
            return self.smooth(line, reach);
        }
        let lambda = f64::from(reach).powi(4);
        for (part, held) in [(0..count, count - HELD), (n - count..n, 0)] {
            let part = &mut line.samples[part];
            let held = held..held + HELD;
            let mut weights = [0.0; HELD];
            for (weight, sample) in weights.iter_mut().zip(&mut part[held.clone()]) {
                *weight = std::mem::replace(&mut sample.weight, STIFF);
            }
            self.solve(part, lambda);
            for (weight, sample) in weights.iter().zip(&mut part[held]) {
                sample.weight = *weight;
            }
        }
    }

    fn solve(&mut self, samples: &mut [Sample], lambda: f64) {
        let n = samples.len();
        if n < 3 {
            return;
        }
        self.rows.resize((n - 2) / 2, [Bands::default(); 2]);
        Arch::new().dispatch(System {
            rows: &mut self.rows,
            samples,
            lambda,
        });
    }
}

/// The equations of some samples, for the widest registers. Each row waits for the one before it,
/// so they are eliminated from both ends at once, toward the two or three in the middle.
struct System<'a> {
    rows: &'a mut [[Bands; 2]],
    samples: &'a mut [Sample],
    lambda: f64,
}

impl WithSimd for System<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        let ends = self.eliminate();
        let middle = self.solve_middle(&ends);
        self.substitute(middle);
    }
}

impl System<'_> {
    /// The diagonal and the bands of row `i`, which is counted from either end and belongs to
    /// `sample`. Each second difference (1, −2, 1) adds its outer product.
    #[inline(always)]
    fn row(&self, i: usize, sample: usize) -> (f64, Bands) {
        let (n, sample) = (self.samples.len(), &self.samples[sample]);
        let [ahead, across, back] =
            [i + 2 < n, i >= 1 && i + 1 < n, i >= 2].map(|is| f64::from(u8::from(is)));
        let weight = f64::from(sample.weight).max(LEAST_WEIGHT);
        let [x, y] = sample.at;
        let bands = Bands {
            first: -2.0 * self.lambda * (ahead + across),
            second: self.lambda * ahead,
            right: [x, y, sample.width_px, 0.0].map(|value| weight * f64::from(value)),
        };
        (weight + self.lambda * (ahead + 4.0 * across + back), bands)
    }

    /// Eliminates the outer rows from those farther in. Returns the last two from either end.
    #[inline(always)]
    fn eliminate(&mut self) -> [[Row; 2]; 2] {
        let n = self.samples.len();
        let mut ends = [[Row::default(); 2]; 2];
        for i in 0..self.rows.len() {
            for (end, [older, last]) in ends.iter_mut().enumerate() {
                let (diagonal, mut here) = self.row(i, if end == 0 { i } else { n - 1 - i });
                let diagonal = diagonal - older.before.second * older.after.second;
                // The term that needs the division of the previous row comes last.
                let diagonal = diagonal - last.before.first * last.after.first;
                here.first -= last.before.second * last.after.first;
                for c in 0..4 {
                    let right = here.right[c] - older.after.second * older.before.right[c];
                    here.right[c] = right - last.after.first * last.before.right[c];
                }
                let inverse = 1.0 / diagonal;
                let after = Bands {
                    first: here.first * inverse,
                    second: here.second * inverse,
                    right: here.right.map(|r| r * inverse),
                };
                self.rows[i][end] = after;
                let before = here;
                (*older, *last) = (*last, Row { before, after });
            }
        }
        ends
    }

    /// Solves the rows in the middle, after those toward the `ends` are eliminated from them.
    #[inline(always)]
    fn solve_middle(&self, ends: &[[Row; 2]; 2]) -> [Right; MIDDLE] {
        let (from, count) = (self.rows.len(), self.samples.len() - 2 * self.rows.len());
        let mut matrix = [[0.0; MIDDLE]; MIDDLE];
        let mut right = [Right::default(); MIDDLE];
        for k in 0..MIDDLE {
            // A third row that does not exist is an identity row.
            matrix[k][k] = 1.0;
            if k < count {
                let (diagonal, bands) = self.row(from + k, from + k);
                (matrix[k][k], right[k]) = (diagonal, bands.right);
                for (beside, ahead) in [(k + 1, bands.first), (k + 2, bands.second)] {
                    if beside < count {
                        (matrix[k][beside], matrix[beside][k]) = (ahead, ahead);
                    }
                }
            }
        }
        for ([older, last], [near, far]) in ends.iter().zip([[0, 1], [count - 1, count - 2]]) {
            matrix[near][near] -=
                last.before.first * last.after.first + older.before.second * older.after.second;
            matrix[near][far] -= last.before.second * last.after.first;
            matrix[far][near] = matrix[near][far];
            matrix[far][far] -= last.before.second * last.after.second;
            let (last_right, older_right) = (last.before.right, older.before.right);
            for (to, (a, b)) in right[near]
                .iter_mut()
                .zip(last_right.iter().zip(older_right))
            {
                *to -= last.after.first * a + older.after.second * b;
            }
            for (to, a) in right[far].iter_mut().zip(last_right) {
                *to -= last.after.second * a;
            }
        }
        // Gaussian elimination. A positive definite matrix needs no pivoting.
        for k in 0..MIDDLE {
            let (pivot, known) = (matrix[k], right[k]);
            for i in (0..MIDDLE).filter(|&i| i != k) {
                let share = matrix[i][k] / pivot[k];
                for (to, of) in matrix[i].iter_mut().zip(pivot) {
                    *to -= share * of;
                }
                for (to, of) in right[i].iter_mut().zip(known) {
                    *to -= share * of;
                }
            }
        }
        for (k, row) in right.iter_mut().enumerate() {
            row.iter_mut().for_each(|value| *value /= matrix[k][k]);
        }
        right
    }

    /// Fills in the samples, from the `middle` outward.
    #[inline(always)]
    fn substitute(&mut self, middle: [Right; MIDDLE]) {
        let n = self.samples.len();
        let (from, count) = (self.rows.len(), n - 2 * self.rows.len());
        for (k, value) in middle[..count].iter().enumerate() {
            put(&mut self.samples[from + k], value);
        }
        let mut known = [
            [middle[0], middle[1]],
            [middle[count - 1], middle[count - 2]],
        ];
        for (i, rows) in self.rows.iter().enumerate().rev() {
            for ((end, row), [next, after]) in rows.iter().enumerate().zip(&mut known) {
                let mut here = Right::default();
                for c in 0..4 {
                    here[c] = (row.right[c] - row.second * after[c]) - row.first * next[c];
                }
                put(
                    &mut self.samples[if end == 0 { i } else { n - 1 - i }],
                    &here,
                );
                (*after, *next) = (*next, here);
            }
        }
    }
}

#[inline(always)]
fn put(sample: &mut Sample, &[x, y, width_px, _]: &Right) {
    sample.at = [x as f32, y as f32];
    // A width extrapolated from where it was seen may fall below zero.
    sample.width_px = (width_px as f32).max(0.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn arc(n: usize, radius: f32, hidden: std::ops::Range<usize>) -> Line {
        let samples = (0..n)
            .map(|i| {
                let (sin, cos) = (i as f32 / radius).sin_cos();
                let weight = if hidden.contains(&i) { 0.0 } else { 1.0 };
                // Hidden samples contain nonsense.
                let r = radius * (0.5 + 0.5 * weight);
                Sample {
                    at: [r * cos, r * sin],
                    weight,
                    width_px: 7.0,
                    side: 0.0,
                }
            })
            .collect();
        Line {
            samples,
            closed: false,
            border: [false; 2],
        }
    }

    #[test]
    fn an_arc_keeps_its_radius_and_is_bridged_where_it_is_hidden() {
        let mut line = arc(60, 20.0, 25..35);
        Smoother::default().smooth(&mut line, 3.0);
        for (i, sample) in line.samples.iter().enumerate() {
            let radius = crate::vec2::norm(sample.at);
            // Smoothing straightens a free end over its reach, which moves the end by ℓ²/R.
            let allowed = if (8..52).contains(&i) { 0.1 } else { 0.45 };
            assert!((radius - 20.0).abs() < allowed, "{i}: {radius}");
            assert!((sample.width_px - 7.0).abs() < 1e-3);
        }
    }

    /// Solves the equations by Gaussian elimination of the full matrix. Returns x and y of each
    /// sample.
    fn by_the_whole_matrix(samples: &[Sample], lambda: f64) -> Vec<[f64; 2]> {
        let n = samples.len();
        let mut rows = vec![vec![0.0; n + 2]; n];
        for (i, sample) in samples.iter().enumerate() {
            let weight = f64::from(sample.weight).max(LEAST_WEIGHT);
            rows[i][i] = weight;
            rows[i][n] = weight * f64::from(sample.at[0]);
            rows[i][n + 1] = weight * f64::from(sample.at[1]);
        }
        let difference = [1.0, -2.0, 1.0];
        for i in 0..n - 2 {
            for (a, p) in difference.iter().enumerate() {
                for (b, q) in difference.iter().enumerate() {
                    rows[i + a][i + b] += lambda * p * q;
                }
            }
        }
        for k in 0..n {
            let pivot = rows[k].clone();
            for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
                let share = row[k] / pivot[k];
                row.iter_mut()
                    .zip(&pivot)
                    .for_each(|(to, of)| *to -= share * of);
            }
        }
        (0..n)
            .map(|i| [rows[i][n] / rows[i][i], rows[i][n + 1] / rows[i][i]])
            .collect()
    }

    proptest! {
        #[test]
        fn what_is_smoothed_solves_the_equations(
            values in proptest::collection::vec((0.0f32..100.0, 0.0f32..100.0, 0usize..4), 3..24),
            reach in 0.5f32..6.0,
        ) {
            let n = values.len();
            let sample = |(i, &(x, y, weight)): (usize, &(f32, f32, usize))| Sample {
                at: [x, y],
                weight: if i == 0 || i == n - 1 { 1.0 } else { [0.0, 0.2, 1.0, 1.0][weight] },
                width_px: 9.0,
                side: 0.0,
            };
            let samples: Vec<_> = values.iter().enumerate().map(sample).collect();
            let expected = by_the_whole_matrix(&samples, f64::from(reach).powi(4));
            let mut line = Line { samples, closed: false, border: [false; 2] };
            Smoother::default().smooth(&mut line, reach);
            for (sample, expected) in line.samples.iter().zip(expected) {
                for (at, expected) in sample.at.into_iter().zip(expected) {
                    prop_assert!((at - expected as f32).abs() < 1e-3);
                }
                prop_assert!((sample.width_px - 9.0).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn a_width_that_falls_where_the_rope_is_hidden_stops_at_nothing() {
        let mut line = arc(60, 20.0, 12..60);
        for (i, sample) in line.samples.iter_mut().enumerate() {
            sample.width_px = 9.0 - 0.5 * i as f32;
        }
        Smoother::default().smooth(&mut line, 3.0);
        assert!(line.samples.iter().all(|s| s.width_px >= 0.0));
    }

    #[test]
    fn a_ring_stays_closed() {
        let turn = std::f32::consts::TAU;
        let samples: Vec<_> = (0..90)
            .map(|i| {
                let (sin, cos) = (i as f32 * turn / 90.0).sin_cos();
                Sample {
                    at: [15.0 * cos, 15.0 * sin],
                    weight: 1.0,
                    width_px: 3.0,
                    side: 0.0,
                }
            })
            .collect();
        let mut line = Line {
            samples,
            closed: true,
            border: [false; 2],
        };
        Smoother::default().smooth(&mut line, 4.0);
        assert!(
            line.samples
                .iter()
                .all(|s| (crate::vec2::norm(s.at) - 15.0).abs() < 0.1)
        );
    }
}

//! Smoothing that does not shrink: the positions and widths that fit the measured ones and bend
//! least.
//!
//! Whittaker, "On a new method of graduation" (1923): minimize Σ wᵢ (zᵢ − mᵢ)² + λ Σ (Δ²z)ᵢ². A
//! wave of k radians a sample is damped by 1 / (1 + λk⁴), so an arc of radius R loses only
//! R·(ℓ/R)⁴, where ℓ = λ^¼ is the reach; a moving average of the same reach loses ℓ²/R. Where
//! nothing is measured (w = 0) the solution goes on as a cubic: that is how a crossing is bridged.

use pulp::{Arch, Simd, WithSimd};

use crate::line::{Line, Sample};

/// Memory of the solver: the matrix is symmetric with two bands beside its diagonal.
#[derive(Debug, Default)]
pub(crate) struct Smoother {
    rows: Vec<Row>,
    ring: Vec<Sample>,
}

/// One row of the factor L·D·Lᵀ, and of the right sides: x, y, width, and one that fills the register.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    first: f64,
    second: f64,
    right: [f64; 4],
}

/// Keeps the matrix regular where hardly anything is measured.
const LEAST_WEIGHT: f64 = 1e-5;

/// Two samples that stay where they are, by this weight, hold place and direction of what is smoothed beside them.
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
        // A ring is opened with an overlap on both sides that is longer than the reach.
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

    /// Smooths only the last `count` samples of the line's either end, which go on from the others as these are.
    pub(crate) fn smooth_ends(&mut self, line: &mut Line, reach: f32, count: usize) {
        let n = line.samples.len();
        // Beyond four reaches the tips no longer tell.
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
        self.rows.resize(n, Row::default());
        Arch::new().dispatch(System {
            rows: &mut self.rows,
            samples,
            lambda,
        });
    }
}

/// The equations of some samples, of as many rows, for the widest registers.
struct System<'a> {
    rows: &'a mut [Row],
    samples: &'a mut [Sample],
    lambda: f64,
}

impl WithSimd for System<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self {
            rows,
            samples,
            lambda,
        } = self;
        let n = rows.len();
        // Of the last two rows: the factors, what they were before the division, and the right sides before it.
        let (mut last, mut before) = (Eliminated::default(), Eliminated::default());
        for (i, (row, sample)) in rows.iter_mut().zip(&*samples).enumerate() {
            // Each second difference (1, −2, 1) adds its outer product.
            let [ahead, across, back] =
                [i + 2 < n, i >= 1 && i + 1 < n, i >= 2].map(|is| f64::from(u8::from(is)));
            let weight = f64::from(sample.weight).max(LEAST_WEIGHT);
            let diagonal = weight + lambda * (ahead + 4.0 * across + back)
                - last.row.first * last.first
                - before.row.second * before.second;
            let first = -2.0 * lambda * (ahead + across) - last.row.first * last.second;
            let second = lambda * ahead;
            let value = [sample.at[0], sample.at[1], sample.width_px, 0.0];
            let right: [f64; 4] = std::array::from_fn(|c| {
                weight * f64::from(value[c])
                    - last.row.first * last.right[c]
                    - before.row.second * before.right[c]
            });
            let inverse = 1.0 / diagonal;
            *row = Row {
                first: first * inverse,
                second: second * inverse,
                right: right.map(|r| r * inverse),
            };
            before = last;
            last = Eliminated {
                row: *row,
                first,
                second,
                right,
            };
        }
        let (mut next, mut after) = ([0.0; 4], [0.0; 4]);
        for (row, sample) in rows.iter().zip(samples).rev() {
            let here: [f64; 4] =
                std::array::from_fn(|c| row.right[c] - row.first * next[c] - row.second * after[c]);
            sample.at = [here[0] as f32, here[1] as f32];
            // Carried on from where it was seen, a width may fall through zero.
            sample.width_px = (here[2] as f32).max(0.0);
            (next, after) = (here, next);
        }
    }
}

/// A row that has been eliminated, and what it was before its division by the diagonal.
#[derive(Clone, Copy, Debug, Default)]
struct Eliminated {
    row: Row,
    first: f64,
    second: f64,
    right: [f64; 4],
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(n: usize, radius: f32, hidden: std::ops::Range<usize>) -> Line {
        let samples = (0..n)
            .map(|i| {
                let (sin, cos) = (i as f32 / radius).sin_cos();
                let weight = if hidden.contains(&i) { 0.0 } else { 1.0 };
                // What is hidden is filled with nonsense.
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
            // A free end is straightened over the reach: ℓ²/R there.
            let allowed = if (8..52).contains(&i) { 0.1 } else { 0.45 };
            assert!((radius - 20.0).abs() < allowed, "{i}: {radius}");
            assert!((sample.width_px - 7.0).abs() < 1e-3);
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

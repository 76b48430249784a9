//! Smoothing that does not shrink: the positions and widths that fit the measured ones and bend
//! least.
//!
//! Whittaker, "On a new method of graduation" (1923): minimize Σ wᵢ (zᵢ − mᵢ)² + λ Σ (Δ²z)ᵢ². A
//! wave of k radians a sample is damped by 1 / (1 + λk⁴), so an arc of radius R loses only
//! R·(ℓ/R)⁴, where ℓ = λ^¼ is the reach; a moving average of the same reach loses ℓ²/R. Where
//! nothing is measured (w = 0) the solution goes on as a cubic: that is how a crossing is bridged.

use crate::line::{Line, Sample};

/// Memory of the solver: the matrix is symmetric with two bands beside its diagonal.
#[derive(Debug, Default)]
pub(crate) struct Smoother {
    rows: Vec<Row>,
    ring: Vec<Sample>,
}

/// One row of the factor L·D·Lᵀ, and of the three right sides.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    diagonal: f64,
    first: f64,
    second: f64,
    right: [f64; 3],
}

/// Keeps the matrix regular where hardly anything is measured.
const LEAST_WEIGHT: f64 = 1e-5;

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

    fn solve(&mut self, samples: &mut [Sample], lambda: f64) {
        let n = samples.len();
        if n < 3 {
            return;
        }
        self.rows.clear();
        self.rows.extend(samples.iter().map(|s| {
            let w = f64::from(s.weight).max(LEAST_WEIGHT);
            let value = [s.at[0], s.at[1], s.width_px];
            Row {
                diagonal: w,
                first: 0.0,
                second: 0.0,
                right: value.map(|v| w * f64::from(v)),
            }
        }));
        for i in 0..n - 2 {
            // Each second difference (1, −2, 1) adds its outer product.
            self.rows[i].diagonal += lambda;
            self.rows[i + 1].diagonal += 4.0 * lambda;
            self.rows[i + 2].diagonal += lambda;
            self.rows[i].first -= 2.0 * lambda;
            self.rows[i + 1].first -= 2.0 * lambda;
            self.rows[i].second += lambda;
        }
        self.eliminate();
        for (sample, row) in samples.iter_mut().zip(&self.rows) {
            sample.at = [row.right[0] as f32, row.right[1] as f32];
            // Carried on from where it was seen, a width may fall through zero.
            sample.width_px = (row.right[2] as f32).max(0.0);
        }
    }

    fn eliminate(&mut self) {
        let n = self.rows.len();
        for i in 0..n {
            let Row {
                diagonal,
                first,
                second,
                right,
            } = self.rows[i];
            let (l1, l2) = (first / diagonal, second / diagonal);
            if i + 1 < n {
                let next = &mut self.rows[i + 1];
                next.diagonal -= l1 * first;
                next.first -= l1 * second;
                (0..3).for_each(|c| next.right[c] -= l1 * right[c]);
            }
            if i + 2 < n {
                let after = &mut self.rows[i + 2];
                after.diagonal -= l2 * second;
                (0..3).for_each(|c| after.right[c] -= l2 * right[c]);
            }
            let row = &mut self.rows[i];
            (row.first, row.second) = (l1, l2);
            (0..3).for_each(|c| row.right[c] /= diagonal);
        }
        for i in (0..n).rev() {
            let next = if i + 1 < n {
                self.rows[i + 1].right
            } else {
                [0.0; 3]
            };
            let after = if i + 2 < n {
                self.rows[i + 2].right
            } else {
                [0.0; 3]
            };
            let row = &mut self.rows[i];
            (0..3).for_each(|c| row.right[c] -= row.first * next[c] + row.second * after[c]);
        }
    }
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

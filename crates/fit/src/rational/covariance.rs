//! Covariance of the control points under noise in the points, with known weights.
//!
//! The free control points are then `P (c − R₀c₀ − Rₙc₍N₋₁₎)` with `P = (RᵀR)⁻¹Rᵀ`; without pinned
//! ends, the last two terms are absent. `P` gives no weight to pinned end points, so their noise
//! and that of the others are independent: `C = PPᵀ + (PR₀)(PR₀)ᵀ + (PRₙ)(PRₙ)ᵀ`.

use super::design::Design;
use super::projection::Projection;
use super::triangular::{solve_lower, solve_lower_transposed};

/// Memory for the matrix and its parts.
pub(super) struct Covariance {
    matrix: Vec<f64>,
    /// `S` of `(RᵀR)⁻¹ = SSᵀ`, `free × free`.
    root: Vec<f64>,
    /// `PR₀` and `PRₙ`, interleaved.
    pub(super) of_ends: Vec<[f64; 2]>,
}

impl Covariance {
    pub(super) fn new(design: &Design) -> Self {
        Self {
            matrix: vec![0.0; design.count * design.count],
            root: vec![0.0; design.free() * design.free()],
            of_ends: vec![[0.0; 2]; design.free()],
        }
    }

    /// Computes `C`, row by row.
    pub(super) fn at(&mut self, design: &Design, projection: &Projection) -> &[f64] {
        let (count, free, first) = (design.count, design.free(), design.first_free());
        // (RᵀR)⁻¹ = D⁻¹ T⁻¹ L⁻ᵀ L⁻¹ T⁻ᵀ D⁻¹, D the weights.
        self.root.fill(0.0);
        for k in 0..free {
            self.root[k * free + k] = 1.0;
        }
        solve_lower_transposed(&projection.factor, free, &mut self.root, free);
        design.to_bernstein(&mut self.root, free);
        for (row, weight) in self
            .root
            .chunks_exact_mut(free.max(1))
            .zip(&projection.weights[first..])
        {
            row.iter_mut().for_each(|number| *number /= weight);
        }
        if design.pinned {
            self.project_ends(design, projection);
        }
        let row = |k: usize| &self.root[k * free..(k + 1) * free];
        for k in 0..free {
            for l in 0..=k {
                let mut sum: f64 = row(k).iter().zip(row(l)).map(|(a, b)| a * b).sum();
                sum += self.of_ends[k][0] * self.of_ends[l][0]
                    + self.of_ends[k][1] * self.of_ends[l][1];
                self.matrix[(k + first) * count + l + first] = sum;
                self.matrix[(l + first) * count + k + first] = sum;
            }
        }
        if design.pinned {
            for (side, end) in [0, count - 1].into_iter().enumerate() {
                for (k, of_ends) in self.of_ends.iter().enumerate() {
                    self.matrix[(k + 1) * count + end] = -of_ends[side];
                    self.matrix[end * count + k + 1] = -of_ends[side];
                }
                self.matrix[end * count + end] = 1.0;
            }
        }
        &self.matrix
    }

    /// Computes `PR₀` and `PRₙ`.
    fn project_ends(&mut self, design: &Design, projection: &Projection) {
        let free = design.free();
        for (along, scaled) in self
            .of_ends
            .iter_mut()
            .zip(projection.scaled.chunks_exact(design.stride))
        {
            *along = [0, design.count - 1].map(|end| {
                let rational = &projection.rational[end * design.stride..];
                rational.iter().zip(scaled).map(|(r, q)| r * q).sum()
            });
        }
        let right = self.of_ends.as_flattened_mut();
        solve_lower(&projection.factor, free, right, 2);
        solve_lower_transposed(&projection.factor, free, right, 2);
        design.to_bernstein(right, 2);
        for (row, weight) in self.of_ends.iter_mut().zip(&projection.weights[1..]) {
            *row = row.map(|number| number / weight);
        }
    }
}

//! Sums for the least-squares fit over a grid of samples, row by row, and the equations that follow
//! from them.
//!
//! Along a row of the grid, the vertical position is one number. A row is summed, in lanes, into
//! moments of the horizontal position. These are then multiplied by the powers of the vertical one.

use super::samples::{Row, Samples};
use super::{GRID, TERMS};
use lariat_portable::{Simd, WithSimd};

/// Powers of u and v in each term of the surface: 1, u, v, u², uv, v².
const POWERS: [[usize; 2]; TERMS] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];

/// Sums over the samples within `limit` of the surface, in `N` channels.
pub(super) struct Sum<'a, const N: usize> {
    pub(super) samples: Samples<'a, N>,
    pub(super) limit: f32,
}

impl<const N: usize> WithSimd for Sum<'_, N> {
    type Output = Moments<N>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Moments<N> {
        let zero = simd.splat_f32s(0.0);
        let mut sums = Sums {
            powers: [[zero; 5]; 5],
            levels: [[zero; TERMS]; N],
        };
        // The padding of the rows does not count.
        let mut limits = [-1.0; GRID];
        limits[..self.samples.columns.min(GRID)].fill(self.limit);
        let limits = S::as_simd_f32s(&limits).0;
        for (j, &v) in self.samples.rows() {
            let row = self.samples.row(simd, j, v);
            sums.add(simd, &RowSums::of(simd, &row, limits), v);
        }
        sums.moments(simd)
    }
}

/// Sums along a row of the grid over the samples that count as table, in lanes: of uᵏ, k = 0…4, and
/// of each channel's level times uᵏ, k = 0…2.
struct RowSums<S: Simd, const N: usize> {
    powers: [S::f32s; 5],
    levels: [[S::f32s; 3]; N],
}

impl<S: Simd, const N: usize> RowSums<S, N> {
    /// Sums over the samples within `limits` of the surface.
    #[inline(always)]
    fn of(simd: S, row: &Row<S, N>, limits: &[S::f32s]) -> Self {
        let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
        let mut sums = Self {
            powers: [zero; 5],
            levels: [[zero; 3]; N],
        };
        for (i, (&u, &limit)) in row.u.iter().zip(limits).enumerate() {
            let (colors, residual) = row.at(i);
            let is_table = simd.less_than_or_equal_f32s(residual, limit);
            let mut power = simd.select_f32s(is_table, one, zero);
            for k in 0..5 {
                sums.powers[k] = simd.add_f32s(sums.powers[k], power);
                if k < 3 {
                    for (levels, &color) in sums.levels.iter_mut().zip(&colors) {
                        levels[k] = simd.mul_add_f32s(power, color, levels[k]);
                    }
                }
                power = simd.mul_f32s(power, u);
            }
        }
        sums
    }
}

/// Sums over the whole grid, in lanes: of uᵃvᵇ at `[a][b]`, and of each channel's level times each
/// term.
struct Sums<S: Simd, const N: usize> {
    powers: [[S::f32s; 5]; 5],
    levels: [[S::f32s; TERMS]; N],
}

impl<S: Simd, const N: usize> Sums<S, N> {
    #[inline(always)]
    fn add(&mut self, simd: S, row: &RowSums<S, N>, v: f32) {
        let powers = [1.0, v, v * v, v * v * v, v * v * v * v];
        let mut weights = [simd.splat_f32s(0.0); 5];
        for (weight, power) in weights.iter_mut().zip(powers) {
            *weight = simd.splat_f32s(power);
        }
        for a in 0..5 {
            let sums = self.powers[a].iter_mut().zip(weights).take(5 - a);
            for (sum, weight) in sums {
                *sum = simd.mul_add_f32s(weight, row.powers[a], *sum);
            }
        }
        for (sums, levels) in self.levels.iter_mut().zip(&row.levels) {
            for (sum, [a, b]) in sums.iter_mut().zip(POWERS) {
                *sum = simd.mul_add_f32s(weights[b], levels[a], *sum);
            }
        }
    }

    /// The sums of all lanes.
    #[inline(always)]
    fn moments(&self, simd: S) -> Moments<N> {
        let mut moments = Moments {
            powers: [[0.0; 5]; 5],
            levels: [[0.0; TERMS]; N],
        };
        for a in 0..5 {
            for b in 0..5 - a {
                moments.powers[a][b] = f64::from(simd.reduce_sum_f32s(self.powers[a][b]));
            }
        }
        for (totals, sums) in moments.levels.iter_mut().zip(&self.levels) {
            for (total, &sum) in totals.iter_mut().zip(sums) {
                *total = f64::from(simd.reduce_sum_f32s(sum));
            }
        }
        moments
    }
}

/// Sums over the whole grid: of uᵃvᵇ at `[a][b]`, and of each channel's level times each term.
pub(super) struct Moments<const N: usize> {
    powers: [[f64; 5]; 5],
    pub(super) levels: [[f64; TERMS]; N],
}

impl<const N: usize> Moments<N> {
    pub(super) fn gram(&self) -> [[f64; TERMS]; TERMS] {
        let term = |i: usize, j: usize| {
            let ([a, b], [c, d]) = (POWERS[i], POWERS[j]);
            self.powers[a + c][b + d]
        };
        std::array::from_fn(|i| std::array::from_fn(|j| term(i, j)))
    }
}

/// The lower Cholesky factor; `None` if the matrix is not clearly positive definite.
pub(super) fn cholesky(mut a: [[f64; TERMS]; TERMS]) -> Option<[[f64; TERMS]; TERMS]> {
    let floor = 1e-6 * a[0][0];
    for i in 0..TERMS {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            let rest = a[i][j] - dot;
            if i == j {
                if rest <= floor {
                    return None;
                }
                a[i][i] = rest.sqrt();
            } else {
                a[i][j] = rest / a[j][j];
            }
        }
    }
    Some(a)
}

pub(super) fn solve(factor: &[[f64; TERMS]; TERMS], mut b: [f64; TERMS]) -> [f64; TERMS] {
    for i in 0..TERMS {
        let dot: f64 = (0..i).map(|k| factor[i][k] * b[k]).sum();
        b[i] = (b[i] - dot) / factor[i][i];
    }
    for i in (0..TERMS).rev() {
        let dot: f64 = (i + 1..TERMS).map(|k| factor[k][i] * b[k]).sum();
        b[i] = (b[i] - dot) / factor[i][i];
    }
    b
}

//! The sums of the least squares, over a grid of samples row by row, and the equations that they make.
//!
//! Along a row of the grid the vertical position is one number: a row is summed into moments of the horizontal one,
//! [`LANES`] samples side by side, and those are spread over the powers of the other.

use super::{LANES, Lanes, TERMS};
use pulp::{Simd, WithSimd};

/// The terms of the surface are 1, u, v, u², uv, v²: of each the powers of u and v.
const POWERS: [[usize; 2]; TERMS] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];

/// Sums over the samples within `limit` of the surface.
pub(super) struct Sum<'a> {
    /// Rows of the grid from one that counts to the next.
    pub(super) stride: usize,
    pub(super) u: &'a [Lanes],
    pub(super) v: &'a [f32],
    pub(super) colors: &'a [Vec<Lanes>; 3],
    pub(super) residuals: &'a [Lanes],
    pub(super) limit: f32,
}

impl WithSimd for Sum<'_> {
    type Output = Moments;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Moments {
        let mut moments = Moments::default();
        for (j, &v) in self.v.iter().enumerate().step_by(self.stride) {
            moments.add(simd, &Row::sum(simd, &self, j), v);
        }
        moments
    }
}

/// Sums along a row of the grid over what is taken for table, in lanes: of uᵏ, k = 0…4, and of each channel's level
/// times uᵏ, k = 0…2.
struct Row {
    powers: [Lanes; 5],
    levels: [[Lanes; 3]; 3],
}

impl Row {
    #[inline(always)]
    fn sum<S: Simd>(simd: S, sum: &Sum, j: usize) -> Self {
        let mut row = Self {
            powers: [[0.0; LANES]; 5],
            levels: [[[0.0; LANES]; 3]; 3],
        };
        let groups = sum.u.len();
        for (group, u) in sum.u.iter().enumerate() {
            let at = j * groups + group;
            let mut power = [0.0; LANES];
            each(simd, &mut power, &sum.residuals[at], u, |_, residual, _| {
                let is_table = simd.less_than_or_equal_f32s(residual, simd.splat_f32s(sum.limit));
                simd.select_f32s(is_table, simd.splat_f32s(1.0), simd.splat_f32s(0.0))
            });
            for k in 0..5 {
                each(simd, &mut row.powers[k], &power, u, |sum, power, _| {
                    simd.add_f32s(sum, power)
                });
                if k < 3 {
                    for (levels, samples) in row.levels.iter_mut().zip(sum.colors) {
                        each(simd, &mut levels[k], &power, &samples[at], |sum, a, b| {
                            simd.add_f32s(sum, simd.mul_f32s(a, b))
                        });
                    }
                }
                each(simd, &mut power, u, u, |power, u, _| {
                    simd.mul_f32s(power, u)
                });
            }
        }
        row
    }
}

/// Makes `out` what `rule` says of it, `a` and `b`, as many lanes at a time as the machine has.
#[inline(always)]
fn each<S: Simd>(
    _: S,
    out: &mut Lanes,
    a: &Lanes,
    b: &Lanes,
    rule: impl Fn(S::f32s, S::f32s, S::f32s) -> S::f32s,
) {
    let (a, b) = (S::as_simd_f32s(a).0, S::as_simd_f32s(b).0);
    for ((out, &a), &b) in S::as_mut_simd_f32s(out).0.iter_mut().zip(a).zip(b) {
        *out = rule(*out, a, b);
    }
}

/// Sums over the whole grid, in lanes: of uᵃvᵇ at `[a][b]`, and of each channel's level times each term.
pub(super) struct Moments {
    powers: [[Lanes; 5]; 5],
    levels: [[Lanes; TERMS]; 3],
}

impl Default for Moments {
    fn default() -> Self {
        Self {
            powers: [[[0.0; LANES]; 5]; 5],
            levels: [[[0.0; LANES]; TERMS]; 3],
        }
    }
}

impl Moments {
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, row: &Row, v: f32) {
        let v = [1.0, v, v * v, v * v * v, v * v * v * v];
        let add = |sum: &mut Lanes, of: &Lanes, b: usize| {
            let weight = simd.splat_f32s(v[b]);
            each(simd, sum, of, of, |sum, of, _| {
                simd.add_f32s(sum, simd.mul_f32s(weight, of))
            });
        };
        for a in 0..5 {
            for b in 0..5 - a {
                add(&mut self.powers[a][b], &row.powers[a], b);
            }
        }
        for (sums, levels) in self.levels.iter_mut().zip(&row.levels) {
            for (sum, [a, b]) in sums.iter_mut().zip(POWERS) {
                add(sum, &levels[a], b);
            }
        }
    }

    pub(super) fn gram(&self) -> [[f64; TERMS]; TERMS] {
        let term = |i: usize, j: usize| {
            let ([a, b], [c, d]) = (POWERS[i], POWERS[j]);
            total(&self.powers[a + c][b + d])
        };
        std::array::from_fn(|i| std::array::from_fn(|j| term(i, j)))
    }

    pub(super) fn right(&self, channel: usize) -> [f64; TERMS] {
        self.levels[channel].each_ref().map(total)
    }
}

fn total(lanes: &Lanes) -> f64 {
    lanes.iter().map(|&lane| f64::from(lane)).sum()
}

/// The lower Cholesky factor, or nothing when the matrix is not clearly positive definite.
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

//! The three loops of a fit, in vectors as wide as the machine has (pulp chooses at run time):
//!
//! ```text
//! fold_points   cᵢ                 → cᵢ ± c₍N₋₁₋ᵢ₎
//! project       rows · points      → one pair of numbers a row      (the small product)
//! residuals     rows · projections → how far the curve is from the points
//! ```
//!
//! The tests hold each of them to the plain definition.

use crate::folded::{FoldedPoints, FoldedRows};
use pulp::{Simd, WithSimd};

/// Folds points. Answers whether every coordinate is below `bound` in size, to the last bit but one; NaN is
/// not.
pub(crate) struct FoldPoints<'a> {
    pub(crate) points: &'a [[f64; 2]],
    pub(crate) bound: f64,
    pub(crate) folded: &'a mut FoldedPoints,
}

impl WithSimd for FoldPoints<'_> {
    type Output = bool;

    // Plain code: the compiler makes vectors of it for the machine that pulp has chosen.
    #[inline(always)]
    #[allow(
        clippy::neg_cmp_op_on_partial_ord,
        reason = "not below the limit, so that NaN is refused too"
    )]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let half = self.points.len().div_ceil(2);
        let second = &self.points[self.points.len() - half..];
        let [sum_x, sum_y] = self.folded.sums.each_mut().map(|axis| &mut axis[..half]);
        let [difference_x, difference_y] = self
            .folded
            .differences
            .each_mut()
            .map(|axis| &mut axis[..half]);
        let twice = 2.0 * self.bound;
        // A number and not a bool: the compiler then keeps one flag in each lane.
        let mut outside = 0u64;
        for i in 0..half {
            // An odd middle point meets itself: sum 2c, difference 0.
            let (c, m) = (self.points[i], second[half - 1 - i]);
            let (s_x, s_y) = (c[0] + m[0], c[1] + m[1]);
            let (d_x, d_y) = (c[0] - m[0], c[1] - m[1]);
            // |c + m| + |c − m| is twice the larger of |c| and |m|. Not `>=`: NaN must be outside.
            outside |= u64::from(!(s_x.abs() + d_x.abs() < twice));
            outside |= u64::from(!(s_y.abs() + d_y.abs() < twice));
            (sum_x[i], sum_y[i]) = (s_x, s_y);
            (difference_x[i], difference_y[i]) = (d_x, d_y);
        }
        outside == 0
    }
}

/// `even[j] = Σᵢ rows.even[j][i] · sums[i]`, and `odd` from the differences alike.
pub(crate) struct Project<'a> {
    pub(crate) rows: &'a FoldedRows,
    pub(crate) points: &'a FoldedPoints,
    pub(crate) even: &'a mut [[f64; 2]],
    pub(crate) odd: &'a mut [[f64; 2]],
}

impl WithSimd for Project<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let stride = self.rows.stride;
        products(simd, &self.rows.even, stride, &self.points.sums, self.even);
        products(
            simd,
            &self.rows.odd,
            stride,
            &self.points.differences,
            self.odd,
        );
    }
}

/// Rows times columns, as many rows at once as keep the multipliers busy: each row has two running sums, a
/// multiply-add takes four cycles, and two of them start in each.
#[inline(always)]
fn products<S: Simd>(
    simd: S,
    mut rows: &[f64],
    stride: usize,
    columns: &[Vec<f64>; 2],
    mut out: &mut [[f64; 2]],
) {
    while !out.is_empty() {
        let count = match out.len() {
            5 => 5,
            3 | 6 => 3,
            2 => 2,
            1 => 1,
            _ => 4,
        };
        let (block, rows_after) = rows.split_at(count * stride);
        let (block_out, out_after) = out.split_at_mut(count);
        match count {
            1 => product_block::<S, 1>(simd, block, columns, block_out),
            2 => product_block::<S, 2>(simd, block, columns, block_out),
            3 => product_block::<S, 3>(simd, block, columns, block_out),
            4 => product_block::<S, 4>(simd, block, columns, block_out),
            _ => product_block::<S, 5>(simd, block, columns, block_out),
        }
        (rows, out) = (rows_after, out_after);
    }
}

#[inline(always)]
fn product_block<S: Simd, const ROWS: usize>(
    simd: S,
    rows: &[f64],
    [xs, ys]: &[Vec<f64>; 2],
    out: &mut [[f64; 2]],
) {
    // Rows and columns are padded to whole vectors, so nothing is left over.
    let (xs, ys) = (S::as_simd_f64s(xs).0, S::as_simd_f64s(ys).0);
    let rows = S::as_simd_f64s(rows).0;
    let length = xs.len();
    let rows: [&[S::f64s]; ROWS] =
        std::array::from_fn(|row| &rows[row * length..(row + 1) * length]);
    let mut sum_x = [simd.splat_f64s(0.0); ROWS];
    let mut sum_y = [simd.splat_f64s(0.0); ROWS];
    for (i, (&x, &y)) in xs.iter().zip(ys).enumerate() {
        for row in 0..ROWS {
            let m = rows[row][i];
            sum_x[row] = simd.mul_add_f64s(m, x, sum_x[row]);
            sum_y[row] = simd.mul_add_f64s(m, y, sum_y[row]);
        }
    }
    for row in 0..ROWS {
        out[row] = [
            simd.reduce_sum_f64s(sum_x[row]),
            simd.reduce_sum_f64s(sum_y[row]),
        ];
    }
}

/// The squared distances between points and curve: their sum and the largest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SquaredResiduals {
    pub(crate) sum: f64,
    pub(crate) max: f64,
}

/// How far the curve is from the folded points; `even` and `odd` are its folded control points, negated.
///
/// With `u` the sum and `v` the difference of two mirrored points' residuals, the residuals are `(u ± v)/2`.
pub(crate) struct Residuals<'a> {
    pub(crate) rows: &'a FoldedRows,
    pub(crate) points: &'a FoldedPoints,
    pub(crate) even: &'a [[f64; 2]],
    pub(crate) odd: &'a [[f64; 2]],
    /// How many points there are, folded two by two.
    pub(crate) count: usize,
}

impl WithSimd for Residuals<'_> {
    type Output = SquaredResiduals;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> SquaredResiduals {
        let [sum_x, sum_y] = self.points.sums.each_ref().map(|a| pairs::<S>(a));
        let [difference_x, difference_y] =
            self.points.differences.each_ref().map(|a| pairs::<S>(a));
        let (even, odd) = (pairs::<S>(&self.rows.even), pairs::<S>(&self.rows.odd));
        let mut total = [simd.splat_f64s(0.0); 2];
        let mut largest = [simd.splat_f64s(0.0); 2];
        for i in 0..sum_x.len() {
            let (u_x, u_y) = minus_curve(simd, even, i, self.even, (sum_x, sum_y));
            let (v_x, v_y) = minus_curve(simd, odd, i, self.odd, (difference_x, difference_y));
            for k in 0..2 {
                // |u ± v|² = |u|² + |v|² ± 2 u·v, and both signs occur.
                let mut squares = simd.mul_f64s(u_x[k], u_x[k]);
                squares = simd.mul_add_f64s(u_y[k], u_y[k], squares);
                squares = simd.mul_add_f64s(v_x[k], v_x[k], squares);
                squares = simd.mul_add_f64s(v_y[k], v_y[k], squares);
                let mixed = simd.mul_f64s(u_x[k], v_x[k]);
                let mixed = simd.abs_f64s(simd.mul_add_f64s(u_y[k], v_y[k], mixed));
                total[k] = simd.add_f64s(total[k], squares);
                let larger = simd.mul_add_f64s(simd.splat_f64s(2.0), mixed, squares);
                largest[k] = simd.max_f64s(largest[k], larger);
            }
        }
        let total = simd.add_f64s(total[0], total[1]);
        let largest = simd.max_f64s(largest[0], largest[1]);
        let mut sum = 0.5 * simd.reduce_sum_f64s(total);
        if self.count % 2 == 1 {
            sum -= self.middle_squared();
        }
        SquaredResiduals {
            sum: sum.max(0.0),
            max: 0.25 * simd.reduce_max_f64s(largest),
        }
    }
}

impl Residuals<'_> {
    /// The squared residual of the middle point of an odd number, which the loop has counted twice.
    #[inline(always)]
    fn middle_squared(&self) -> f64 {
        let middle = self.count / 2;
        let mut squared = 0.0;
        for axis in 0..2 {
            let mut u = self.points.sums[axis][middle];
            for (row, e) in self.rows.even.chunks_exact(self.rows.stride).zip(self.even) {
                u += row[middle] * e[axis];
            }
            squared += 0.25 * u * u;
        }
        squared
    }
}

/// Two vectors at a time: a coefficient is loaded once for both.
type Pair<S> = [<S as Simd>::f64s; 2];

#[inline(always)]
fn pairs<S: Simd>(numbers: &[f64]) -> &[Pair<S>] {
    // Padded to whole pairs, so nothing is left over.
    S::as_simd_f64s(numbers).0.as_chunks().0
}

/// `points[i] + Σⱼ negated[j] · rows[j][i]`, x and y.
#[inline(always)]
fn minus_curve<S: Simd>(
    simd: S,
    rows: &[Pair<S>],
    i: usize,
    negated: &[[f64; 2]],
    (points_x, points_y): (&[Pair<S>], &[Pair<S>]),
) -> (Pair<S>, Pair<S>) {
    let (mut x, mut y) = (points_x[i], points_y[i]);
    let length = points_x.len();
    for (row, c) in negated.iter().enumerate() {
        let b = rows[row * length + i];
        let (c_x, c_y) = (simd.splat_f64s(c[0]), simd.splat_f64s(c[1]));
        for k in 0..2 {
            x[k] = simd.mul_add_f64s(b[k], c_x, x[k]);
            y[k] = simd.mul_add_f64s(b[k], c_y, y[k]);
        }
    }
    (x, y)
}

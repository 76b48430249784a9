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

/// Folds `points` into `folded`. Returns whether every coordinate is below `bound` in size; NaN is not.
pub(crate) fn fold_points(points: &[[f64; 2]], bound: f64, folded: &mut FoldedPoints) -> bool {
    let half = points.len().div_ceil(2);
    let [sum_x, sum_y] = folded.sums.each_mut().map(|axis| &mut axis[..half]);
    let [difference_x, difference_y] = folded.differences.each_mut().map(|axis| &mut axis[..half]);
    let mut inside = true;
    // An odd middle point meets itself: sum 2c, difference 0.
    for (i, (c, m)) in points[..half].iter().zip(points.iter().rev()).enumerate() {
        inside &= (c[0].abs() < bound) & (c[1].abs() < bound);
        inside &= (m[0].abs() < bound) & (m[1].abs() < bound);
        sum_x[i] = c[0] + m[0];
        sum_y[i] = c[1] + m[1];
        difference_x[i] = c[0] - m[0];
        difference_y[i] = c[1] - m[1];
    }
    inside
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

/// How far the curve with the folded control points `even` and `odd` is from the folded points.
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
        let vectors = self.rows.stride / S::F64_LANES;
        let even_rows = S::as_simd_f64s(&self.rows.even).0;
        let odd_rows = S::as_simd_f64s(&self.rows.odd).0;
        let [sum_x, sum_y] = self.points.sums.each_ref().map(|a| S::as_simd_f64s(a).0);
        let [diff_x, diff_y] = self
            .points
            .differences
            .each_ref()
            .map(|a| S::as_simd_f64s(a).0);

        let mut total = simd.splat_f64s(0.0);
        let mut largest = simd.splat_f64s(0.0);
        for i in 0..vectors {
            let (u_x, u_y) =
                minus_products(simd, even_rows, vectors, i, self.even, (sum_x[i], sum_y[i]));
            let (v_x, v_y) =
                minus_products(simd, odd_rows, vectors, i, self.odd, (diff_x[i], diff_y[i]));
            for (r_x, r_y) in [
                (simd.add_f64s(u_x, v_x), simd.add_f64s(u_y, v_y)),
                (simd.sub_f64s(u_x, v_x), simd.sub_f64s(u_y, v_y)),
            ] {
                let squared = simd.mul_add_f64s(r_x, r_x, simd.mul_f64s(r_y, r_y));
                total = simd.add_f64s(total, squared);
                largest = simd.max_f64s(largest, squared);
            }
        }
        // Twice the residuals were squared.
        let mut sum = 0.25 * simd.reduce_sum_f64s(total);
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
                u -= row[middle] * e[axis];
            }
            squared += 0.25 * u * u;
        }
        squared
    }
}

/// `(x, y) − Σⱼ coefficients[j] · rows[j][i]`.
#[inline(always)]
fn minus_products<S: Simd>(
    simd: S,
    rows: &[S::f64s],
    vectors: usize,
    i: usize,
    coefficients: &[[f64; 2]],
    (mut x, mut y): (S::f64s, S::f64s),
) -> (S::f64s, S::f64s) {
    for (row, c) in rows.chunks_exact(vectors).zip(coefficients) {
        x = simd.negate_mul_add_f64s(row[i], simd.splat_f64s(c[0]), x);
        y = simd.negate_mul_add_f64s(row[i], simd.splat_f64s(c[1]), y);
    }
    (x, y)
}

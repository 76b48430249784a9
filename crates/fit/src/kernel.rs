//! The three loops of a fit, in vectors as wide as the machine has (pulp chooses at run time):
//!
//! ```text
//! load        cᵢ                 → cᵢ ± c₍N₋₁₋ᵢ₎, or cᵢ, each axis by itself
//! project     rows · points      → D numbers a row                  (the small product)
//! residuals   rows · projections → how far the curve is from the points
//! ```
//!
//! The crate's tests hold each of them to the plain definition.

use crate::folded::{Points, Rows};
use pulp::{Simd, WithSimd};

/// Loads points. Answers whether every coordinate is below `bound` in size, to the last bit but one; NaN is
/// not.
pub(crate) struct Load<'a, const D: usize> {
    pub(crate) points: &'a [[f64; D]],
    pub(crate) bound: f64,
    pub(crate) into: &'a mut Points<D>,
}

impl<const D: usize> WithSimd for Load<'_, D> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        // Plain code: the compiler makes vectors of it for the machine that pulp has chosen.
        if self.into.folded {
            fold(self.points, self.bound, self.into)
        } else {
            split(self.points, self.bound, self.into)
        }
    }
}

#[inline(always)]
#[allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "not below the limit, so that NaN is refused too"
)]
fn fold<const D: usize>(points: &[[f64; D]], bound: f64, into: &mut Points<D>) -> bool {
    let half = points.len().div_ceil(2);
    let second = &points[points.len() - half..];
    let sums = into.sums.each_mut().map(|axis| &mut axis[..half]);
    let differences = into.differences.each_mut().map(|axis| &mut axis[..half]);
    let twice = 2.0 * bound;
    // A number and not a bool: the compiler then keeps one flag in each lane.
    let mut outside = 0u64;
    for i in 0..half {
        // An odd middle point meets itself: sum 2c, difference 0.
        let (c, m) = (&points[i], &second[half - 1 - i]);
        for axis in 0..D {
            let (sum, difference) = (c[axis] + m[axis], c[axis] - m[axis]);
            // |c + m| + |c − m| is twice the larger of |c| and |m|. Not `>=`: NaN must be outside.
            outside |= u64::from(!(sum.abs() + difference.abs() < twice));
            sums[axis][i] = sum;
            differences[axis][i] = difference;
        }
    }
    outside == 0
}

#[inline(always)]
#[allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "not below the limit, so that NaN is refused too"
)]
fn split<const D: usize>(points: &[[f64; D]], bound: f64, into: &mut Points<D>) -> bool {
    let mut outside = 0u64;
    let sums = into.sums.each_mut().map(|axis| &mut axis[..points.len()]);
    for (i, c) in points.iter().enumerate() {
        for axis in 0..D {
            outside |= u64::from(!(c[axis].abs() < bound));
            sums[axis][i] = c[axis];
        }
    }
    outside == 0
}

/// `even[j] = Σᵢ rows.even[j][i] · sums[i]`, and `odd` from the differences alike.
pub(crate) struct Project<'a, const D: usize> {
    pub(crate) rows: &'a Rows,
    pub(crate) points: &'a Points<D>,
    pub(crate) even: &'a mut [[f64; D]],
    pub(crate) odd: &'a mut [[f64; D]],
}

impl<const D: usize> WithSimd for Project<'_, D> {
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

/// Rows times columns, as many rows at once as keep the multipliers busy: each row has a running sum for each
/// axis, a multiply-add takes four cycles, and two of them start in each.
#[inline(always)]
fn products<S: Simd, const D: usize>(
    simd: S,
    mut rows: &[f64],
    stride: usize,
    columns: &[Vec<f64>; D],
    mut out: &mut [[f64; D]],
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
            1 => product_block::<S, D, 1>(simd, block, columns, block_out),
            2 => product_block::<S, D, 2>(simd, block, columns, block_out),
            3 => product_block::<S, D, 3>(simd, block, columns, block_out),
            4 => product_block::<S, D, 4>(simd, block, columns, block_out),
            _ => product_block::<S, D, 5>(simd, block, columns, block_out),
        }
        (rows, out) = (rows_after, out_after);
    }
}

#[inline(always)]
fn product_block<S: Simd, const D: usize, const ROWS: usize>(
    simd: S,
    rows: &[f64],
    columns: &[Vec<f64>; D],
    out: &mut [[f64; D]],
) {
    // Rows and columns are padded to whole vectors, so nothing is left over.
    let length = S::as_simd_f64s(&columns[0]).0.len();
    let columns = vectors::<S, D>(columns, length);
    let mut rest = S::as_simd_f64s(rows).0;
    let mut rows: [&[S::f64s]; ROWS] = [&[]; ROWS];
    for row in &mut rows {
        (*row, rest) = rest.split_at(length);
    }
    let mut sums = [[simd.splat_f64s(0.0); D]; ROWS];
    for i in 0..length {
        for row in 0..ROWS {
            let m = rows[row][i];
            for axis in 0..D {
                sums[row][axis] = simd.mul_add_f64s(m, columns[axis][i], sums[row][axis]);
            }
        }
    }
    for row in 0..ROWS {
        for axis in 0..D {
            out[row][axis] = simd.reduce_sum_f64s(sums[row][axis]);
        }
    }
}

/// The squared distances between points and curve: their sum and the largest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SquaredResiduals {
    pub(crate) sum: f64,
    pub(crate) max: f64,
}

/// Takes the curve from the points; `even` and `odd` are the control points' halves, negated. With `u` the
/// sum and `v` the difference of two mirrored points' residuals, the residuals are `(u ± v)/2`; not folded, they
/// are `u`.
pub(crate) struct Residuals<'a, const D: usize> {
    pub(crate) rows: &'a Rows,
    pub(crate) points: &'a Points<D>,
    pub(crate) even: &'a [[f64; D]],
    pub(crate) odd: &'a [[f64; D]],
}

impl<const D: usize> WithSimd for Residuals<'_, D> {
    type Output = SquaredResiduals;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> SquaredResiduals {
        if self.points.folded {
            self.folded(simd)
        } else {
            self.whole(simd)
        }
    }
}

impl<const D: usize> Residuals<'_, D> {
    #[inline(always)]
    fn folded<S: Simd>(self, simd: S) -> SquaredResiduals {
        let sums = pairs_of::<S, D>(&self.points.sums);
        let differences = pairs_of::<S, D>(&self.points.differences);
        let (even, odd) = (pairs::<S>(&self.rows.even), pairs::<S>(&self.rows.odd));
        let mut total = [simd.splat_f64s(0.0); 2];
        let mut largest = [simd.splat_f64s(0.0); 2];
        for i in 0..sums[0].len() {
            let u = minus_curve(simd, even, i, self.even, &sums);
            let v = minus_curve(simd, odd, i, self.odd, &differences);
            for k in 0..2 {
                // |u ± v|² = |u|² + |v|² ± 2 u·v, and both signs occur.
                let mut squares = simd.mul_f64s(u[0][k], u[0][k]);
                squares = simd.mul_add_f64s(v[0][k], v[0][k], squares);
                let mut mixed = simd.mul_f64s(u[0][k], v[0][k]);
                for axis in 1..D {
                    squares = simd.mul_add_f64s(u[axis][k], u[axis][k], squares);
                    squares = simd.mul_add_f64s(v[axis][k], v[axis][k], squares);
                    mixed = simd.mul_add_f64s(u[axis][k], v[axis][k], mixed);
                }
                let mixed = simd.abs_f64s(mixed);
                total[k] = simd.add_f64s(total[k], squares);
                let larger = simd.mul_add_f64s(simd.splat_f64s(2.0), mixed, squares);
                largest[k] = simd.max_f64s(largest[k], larger);
            }
        }
        let total = simd.add_f64s(total[0], total[1]);
        let largest = simd.max_f64s(largest[0], largest[1]);
        let mut sum = 0.5 * simd.reduce_sum_f64s(total);
        if self.points.count % 2 == 1 {
            sum -= self.middle_squared();
        }
        SquaredResiduals {
            sum: sum.max(0.0),
            max: 0.25 * simd.reduce_max_f64s(largest),
        }
    }

    #[inline(always)]
    fn whole<S: Simd>(self, simd: S) -> SquaredResiduals {
        let points = pairs_of::<S, D>(&self.points.sums);
        let rows = pairs::<S>(&self.rows.even);
        let mut total = [simd.splat_f64s(0.0); 2];
        let mut largest = [simd.splat_f64s(0.0); 2];
        for i in 0..points[0].len() {
            let u = minus_curve(simd, rows, i, self.even, &points);
            for k in 0..2 {
                let mut squares = simd.mul_f64s(u[0][k], u[0][k]);
                for u in &u[1..] {
                    squares = simd.mul_add_f64s(u[k], u[k], squares);
                }
                total[k] = simd.add_f64s(total[k], squares);
                largest[k] = simd.max_f64s(largest[k], squares);
            }
        }
        SquaredResiduals {
            sum: simd.reduce_sum_f64s(simd.add_f64s(total[0], total[1])),
            max: simd.reduce_max_f64s(simd.max_f64s(largest[0], largest[1])),
        }
    }

    /// The squared residual of the middle point of an odd number, which the loop has counted twice.
    #[inline(always)]
    fn middle_squared(&self) -> f64 {
        let middle = self.points.count / 2;
        let mut squared = 0.0;
        for axis in 0..D {
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

// No `map` and no `from_fn` here: they are not compiled for the kernel's machine.
#[inline(always)]
fn pairs_of<S: Simd, const D: usize>(columns: &[Vec<f64>; D]) -> [&[Pair<S>]; D] {
    let mut out: [&[Pair<S>]; D] = [&[]; D];
    for (out, column) in out.iter_mut().zip(columns) {
        *out = pairs::<S>(column);
    }
    out
}

/// The first `length` vectors of each column.
#[inline(always)]
fn vectors<S: Simd, const D: usize>(columns: &[Vec<f64>; D], length: usize) -> [&[S::f64s]; D] {
    let mut out: [&[S::f64s]; D] = [&[]; D];
    for (out, column) in out.iter_mut().zip(columns) {
        *out = &S::as_simd_f64s(column).0[..length];
    }
    out
}

/// `points[i] + Σⱼ negated[j] · rows[j][i]`, each axis.
#[inline(always)]
fn minus_curve<S: Simd, const D: usize>(
    simd: S,
    rows: &[Pair<S>],
    i: usize,
    negated: &[[f64; D]],
    points: &[&[Pair<S>]; D],
) -> [Pair<S>; D] {
    let length = points[0].len();
    let mut rest = [points[0][i]; D];
    for axis in 1..D {
        rest[axis] = points[axis][i];
    }
    for (row, c) in rows.chunks_exact(length).zip(negated) {
        let b = row[i];
        for axis in 0..D {
            let c = simd.splat_f64s(c[axis]);
            for k in 0..2 {
                rest[axis][k] = simd.mul_add_f64s(b[k], c, rest[axis][k]);
            }
        }
    }
    rest
}

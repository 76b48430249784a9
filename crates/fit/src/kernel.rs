//! The three loops of a fit, in the machine's widest registers:
//!
//! ```text
//! load        cᵢ                 → cᵢ ± c₍N₋₁₋ᵢ₎, or cᵢ, each axis by itself
//! project     rows · points      → D numbers a row                  (the small product)
//! residuals   rows · projections → how far the curve is from the points
//! ```
//!
//! The crate's tests compare each of them with the plain definition.

use crate::folded::{BLOCK, Points, Rows};
use lariat_portable::{Simd, WithSimd};

/// Loads points. Returns whether the absolute value of every coordinate is below `bound`; `false`
/// for NaN. The result is unreliable for values within rounding of `bound`.
pub(crate) struct Load<'a, const D: usize> {
    pub(crate) points: &'a [[f64; D]],
    pub(crate) bound: f64,
    pub(crate) into: &'a mut Points<D>,
}

impl<const D: usize> WithSimd for Load<'_, D> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        // Plain code, which the compiler vectorizes for the selected registers.
        if self.into.folded {
            fold(self.points, self.bound, self.into)
        } else {
            split(self.points, self.bound, self.into)
        }
    }
}

#[inline(always)]
fn fold<const D: usize>(points: &[[f64; D]], bound: f64, into: &mut Points<D>) -> bool {
    let half = points.len().div_ceil(2);
    let (first, second) = (&points[..half], &points[points.len() - half..]);
    let mut largest = [0; BLOCK];
    match half.checked_sub(BLOCK) {
        Some(last) => {
            let mut at = 0;
            while at < last {
                fold_block(first, second, at, into, &mut largest);
                at += BLOCK;
            }
            // The last block overlaps the one before.
            fold_block(first, second, last, into, &mut largest);
        }
        None => largest[0] = fold_each(first, second, into),
    }
    let mut most = 0;
    for largest in largest {
        most = largest.max(most);
    }
    // If |c| + |m| is not below the bound everywhere, check each number.
    most < bound.to_bits() || points.as_flattened().iter().all(|c| c.abs() < bound)
}

/// Folds a block. `largest` are the largest |c ± m| as bits, which sort like the numbers, with NaN
/// above all.
#[inline(always)]
fn fold_block<const D: usize>(
    first: &[[f64; D]],
    second: &[[f64; D]],
    at: usize,
    into: &mut Points<D>,
    largest: &mut [u64; BLOCK],
) {
    let c = &first[at..][..BLOCK];
    let m = &second[second.len() - BLOCK - at..][..BLOCK];
    let (mut sums, mut differences) = ([[0.0; BLOCK]; D], [[0.0; BLOCK]; D]);
    for axis in 0..D {
        for i in 0..BLOCK {
            // With an odd number, the middle point is paired with itself: sum 2c, difference 0.
            let (c, m) = (c[i][axis], m[BLOCK - 1 - i][axis]);
            sums[axis][i] = c + m;
            differences[axis][i] = c - m;
        }
        for i in 0..BLOCK {
            let larger = sums[axis][i]
                .abs()
                .to_bits()
                .max(differences[axis][i].abs().to_bits());
            largest[i] = largest[i].max(larger);
        }
    }
    for axis in 0..D {
        into.sums[axis][at..][..BLOCK].copy_from_slice(&sums[axis]);
        into.differences[axis][at..][..BLOCK].copy_from_slice(&differences[axis]);
    }
}

/// Like [`fold_block`], for fewer points than a block has.
fn fold_each<const D: usize>(first: &[[f64; D]], second: &[[f64; D]], into: &mut Points<D>) -> u64 {
    let mut largest = 0;
    for (i, (c, m)) in first.iter().zip(second.iter().rev()).enumerate() {
        for axis in 0..D {
            let (sum, difference) = (c[axis] + m[axis], c[axis] - m[axis]);
            largest = largest
                .max(sum.abs().to_bits())
                .max(difference.abs().to_bits());
            into.sums[axis][i] = sum;
            into.differences[axis][i] = difference;
        }
    }
    largest
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

/// Computes `even[j] = Σᵢ rows.even[j][i] · sums[i]`, and `odd` from the differences.
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
        let (rows, points) = (self.rows, self.points);
        products(simd, &rows.even, &points.sums, self.even);
        products(simd, &rows.odd, &points.differences, self.odd);
    }
}

/// Multiplies rows by columns, with enough rows at once to keep the multipliers busy. Each row has
/// a running sum for each axis. A multiply-add takes four cycles, and two of them start in each
/// cycle.
#[inline(always)]
fn products<S: Simd, const D: usize>(
    simd: S,
    rows: &[f64],
    columns: &[Vec<f64>; D],
    out: &mut [[f64; D]],
) {
    let all = out.len();
    let mut from = 0;
    while from < all {
        let out = &mut out[from..];
        from += match all - from {
            5 => product_block::<S, D, 5>(simd, rows, all, from, columns, out),
            3 | 6 => product_block::<S, D, 3>(simd, rows, all, from, columns, out),
            2 => product_block::<S, D, 2>(simd, rows, all, from, columns, out),
            1 => product_block::<S, D, 1>(simd, rows, all, from, columns, out),
            _ => product_block::<S, D, 4>(simd, rows, all, from, columns, out),
        };
    }
}

/// Multiplies `ROWS` rows, beginning at row `from`.
#[inline(always)]
fn product_block<S: Simd, const D: usize, const ROWS: usize>(
    simd: S,
    rows: &[f64],
    all: usize,
    from: usize,
    columns: &[Vec<f64>; D],
    out: &mut [[f64; D]],
) -> usize {
    let mut sums = [[simd.splat_f64s(0.0); D]; ROWS];
    let blocks = rows.chunks_exact(BLOCK * all);
    for (block, rows) in blocks.enumerate() {
        let mut c: [&[S::f64s]; D] = [&[]; D];
        for axis in 0..D {
            c[axis] = S::as_simd_f64s(&columns[axis][BLOCK * block..][..BLOCK]).0;
        }
        let rows = &rows[BLOCK * from..][..BLOCK * ROWS];
        for row in 0..ROWS {
            let row_block = S::as_simd_f64s(&rows[BLOCK * row..][..BLOCK]).0;
            for (i, &m) in row_block.iter().enumerate() {
                for axis in 0..D {
                    sums[row][axis] = simd.mul_add_f64s(m, c[axis][i], sums[row][axis]);
                }
            }
        }
    }
    for row in 0..ROWS {
        for axis in 0..D {
            out[row][axis] = simd.reduce_sum_f64s(sums[row][axis]);
        }
    }
    ROWS
}

/// Computes the control points of `points` by one product: load and project at once.
pub(crate) struct Describe<'a, const D: usize> {
    pub(crate) points: &'a [[f64; D]],
    pub(crate) bound: f64,
    pub(crate) into: &'a mut Points<D>,
    pub(crate) rows: &'a Rows,
    pub(crate) even: &'a mut [[f64; D]],
    pub(crate) odd: &'a mut [[f64; D]],
    pub(crate) control_points: &'a mut [[f64; D]],
}

impl<const D: usize> Describe<'_, D> {
    /// Returns the same as [`Load`].
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) -> bool {
        let load = Load {
            points: self.points,
            bound: self.bound,
            into: self.into,
        };
        if !load.with_simd(simd) {
            return false;
        }
        let project = Project {
            rows: self.rows,
            points: self.into,
            even: self.even,
            odd: self.odd,
        };
        project.with_simd(simd);
        self.rows.unfold(self.even, self.odd, self.control_points);
        true
    }
}

impl<const D: usize> WithSimd for Describe<'_, D> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> bool {
        self.run(simd)
    }
}

/// Like [`Describe`], with residuals; `None` if a point is not a valid position.
pub(crate) struct Fit<'a, const D: usize> {
    pub(crate) describe: Describe<'a, D>,
    pub(crate) curve: &'a Rows,
}

impl<const D: usize> WithSimd for Fit<'_, D> {
    type Output = Option<SquaredResiduals>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Option<SquaredResiduals> {
        if !self.describe.run(simd) {
            return None;
        }
        let Describe {
            into, even, odd, ..
        } = self.describe;
        // The product's folded result is the curve's folded input.
        for half in [&mut *even, &mut *odd] {
            for number in half.as_flattened_mut() {
                *number = -*number;
            }
        }
        let residuals = Residuals {
            rows: self.curve,
            points: into,
            even,
            odd,
        };
        Some(residuals.with_simd(simd))
    }
}

/// Squared distances between points and curve: their sum and the largest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SquaredResiduals {
    pub(crate) sum: f64,
    pub(crate) max: f64,
}

/// Subtracts the curve from the points. `even` and `odd` are the control points' halves, negated.
/// With `u` the sum and `v` the difference of two mirrored points' residuals, the residuals are `(u
/// ± v)/2`. If the points are not folded, they are `u`.
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
        let Points {
            sums, differences, ..
        } = self.points;
        let mut total = simd.splat_f64s(0.0);
        let mut largest = simd.splat_f64s(0.0);
        let even = self.rows.even.chunks_exact(BLOCK * self.even.len().max(1));
        for (block, even) in even.enumerate() {
            let odd = &self.rows.odd[BLOCK * self.odd.len() * block..][..BLOCK * self.odd.len()];
            let vectors = BLOCK / S::F64_LANES;
            let mut k = 0;
            while k < vectors {
                let u = minus_curve(simd, even, block, k, self.even, sums);
                let v = minus_curve(simd, odd, block, k, self.odd, differences);
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
                    total = simd.add_f64s(total, squares);
                    let larger = simd.mul_add_f64s(simd.splat_f64s(2.0), mixed, squares);
                    largest = simd.max_f64s(largest, larger);
                }
                k += 2;
            }
        }
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
        let mut total = simd.splat_f64s(0.0);
        let mut largest = simd.splat_f64s(0.0);
        let rows = self.rows.even.chunks_exact(BLOCK * self.even.len().max(1));
        for (block, rows) in rows.enumerate() {
            let mut k = 0;
            while k < BLOCK / S::F64_LANES {
                let u = minus_curve(simd, rows, block, k, self.even, &self.points.sums);
                for k in 0..2 {
                    let mut squares = simd.mul_f64s(u[0][k], u[0][k]);
                    for u in &u[1..] {
                        squares = simd.mul_add_f64s(u[k], u[k], squares);
                    }
                    total = simd.add_f64s(total, squares);
                    largest = simd.max_f64s(largest, squares);
                }
                k += 2;
            }
        }
        SquaredResiduals {
            sum: simd.reduce_sum_f64s(total),
            max: simd.reduce_max_f64s(largest),
        }
    }

    /// Squared residual of the middle one of an odd number of points. The loop has counted it
    /// twice.
    #[inline(always)]
    fn middle_squared(&self) -> f64 {
        let middle = self.points.count / 2;
        let (block, at) = (middle / BLOCK, middle % BLOCK);
        let rows = &self.rows.even[BLOCK * self.even.len() * block..];
        let mut squared = 0.0;
        for axis in 0..D {
            let mut u = self.points.sums[axis][middle];
            for (row, e) in rows.chunks_exact(BLOCK).zip(self.even) {
                u += row[at] * e[axis];
            }
            squared += 0.25 * u * u;
        }
        squared
    }
}

/// Two vectors at a time, so that a coefficient is loaded once for both.
type Pair<S> = [<S as Simd>::f64s; 2];

/// `points + Σⱼ negated[j] · rows[j]`, for each axis, for the pair of vectors from the `k`-th of a
/// block.
#[inline(always)]
fn minus_curve<S: Simd, const D: usize>(
    simd: S,
    rows: &[f64],
    block: usize,
    k: usize,
    negated: &[[f64; D]],
    points: &[Vec<f64>; D],
) -> [Pair<S>; D] {
    let from = k * S::F64_LANES;
    let mut rest = [[simd.splat_f64s(0.0); 2]; D];
    for axis in 0..D {
        let pair = S::as_simd_f64s(&points[axis][BLOCK * block + from..][..2 * S::F64_LANES]).0;
        rest[axis] = [pair[0], pair[1]];
    }
    for (row, c) in rows.chunks_exact(BLOCK).zip(negated) {
        let b = S::as_simd_f64s(&row[from..][..2 * S::F64_LANES]).0;
        for axis in 0..D {
            let c = simd.splat_f64s(c[axis]);
            for k in 0..2 {
                rest[axis][k] = simd.mul_add_f64s(b[k], c, rest[axis][k]);
            }
        }
    }
    rest
}

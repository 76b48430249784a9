//! A matrix by columns, each padded to whole registers and aligned to a cache line. Five loops over
//! all points use the machine's widest registers:
//!
//! ```text
//! transpose    rows, point by point        → columns
//! triangular   columns · an upper triangle → columns      (B R⁻¹, and A L⁻ᵀ)
//! gram         columnsᵀ · columns          → the sums of products of two columns
//! residuals    columns · coefficients      → squared distances of the points from the curve
//! gains        columns                     → squared lengths of the rows
//! ```
//!
//! The padding after the last point is zero in all columns, with weight 0.

use super::ends::Ends;
use lariat_portable::{Simd, WithSimd};

/// Columns are padded to a multiple of this many numbers: one of the widest registers, and one
/// cache line.
pub(super) const LANES: usize = 8;

/// `count` rounded up to whole registers.
pub(super) fn padded(count: usize) -> usize {
    count.div_ceil(LANES) * LANES
}

/// Columns of equal length, one after the other.
pub(crate) struct Columns {
    /// Length of a column, padded.
    stride: usize,
    /// Start of the first complete cache line.
    start: usize,
    end: usize,
    numbers: Vec<f64>,
}

impl Columns {
    /// Creates `count` columns of `length` zeros.
    pub(super) fn new(count: usize, length: usize) -> Self {
        let stride = padded(length);
        let numbers = vec![0.0; count * stride + LANES - 1];
        // The offset is in numbers, and below LANES. If it cannot be determined, the columns are
        // unaligned, which is only slower.
        let start = numbers
            .as_ptr()
            .align_offset(LANES * size_of::<f64>())
            .min(LANES - 1);
        Self {
            stride,
            start,
            end: start + count * stride,
            numbers,
        }
    }

    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    /// All columns, one after the other.
    pub(crate) fn all(&self) -> &[f64] {
        &self.numbers[self.start..self.end]
    }

    /// All columns, one after the other.
    pub(crate) fn all_mut(&mut self) -> &mut [f64] {
        &mut self.numbers[self.start..self.end]
    }
}

/// Transposes `rows`, `width` numbers for each point, to columns.
pub(super) struct Transpose<'a> {
    pub(super) rows: &'a [f64],
    pub(super) width: usize,
    pub(super) columns: &'a mut [f64],
    pub(super) stride: usize,
}

impl WithSimd for Transpose<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (width, stride, columns) = (self.width, self.stride, self.columns);
        // Four points at a time, to store half a register at once without bounds checks.
        let blocks = self.rows.chunks_exact(4 * width);
        let (whole, rest) = (blocks.len() * 4, blocks.remainder());
        for (block, rows) in blocks.enumerate() {
            let (first, rows) = rows.split_at(width);
            let (second, rows) = rows.split_at(width);
            let (third, fourth) = rows.split_at(width);
            let numbers = first.iter().zip(second).zip(third).zip(fourth);
            let columns = columns.chunks_exact_mut(stride);
            for ((((&a, &b), &c), &d), column) in numbers.zip(columns) {
                column[4 * block..4 * block + 4].copy_from_slice(&[a, b, c, d]);
            }
        }
        for (i, row) in rest.chunks_exact(width).enumerate() {
            for (j, &number) in row.iter().enumerate() {
                columns[j * stride + whole + i] = number;
            }
        }
    }
}

/// Computes `to[j] = Σ_{k ≤ j} lower[j][k] from[k]`: the columns times the upper triangle whose
/// transpose is `lower`.
///
/// Row `j` of `lower` begins at `j · lower_stride` and is zero beyond its diagonal.
pub(super) struct Triangular<'a> {
    pub(super) from: &'a [f64],
    pub(super) lower: &'a [f64],
    pub(super) lower_stride: usize,
    pub(super) count: usize,
    pub(super) stride: usize,
    pub(super) to: &'a mut [f64],
}

impl WithSimd for Triangular<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let length = S::as_simd_f64s(&self.from[..self.stride]).0.len();
        let mut i = 0;
        // Two registers of points at a time, so that a coefficient is loaded once for both.
        while i + 2 <= length {
            self.slab::<S, 2>(simd, i, length);
            i += 2;
        }
        if i < length {
            self.slab::<S, 1>(simd, i, length);
        }
    }
}

impl Triangular<'_> {
    /// Computes all columns of `WIDE` registers of points.
    #[inline(always)]
    fn slab<S: Simd, const WIDE: usize>(&mut self, simd: S, i: usize, length: usize) {
        let mut j = 0;
        while j < self.count {
            match self.count - j {
                1 => self.block::<S, 1, WIDE>(simd, i, j, length),
                2 => self.block::<S, 2, WIDE>(simd, i, j, length),
                3 => self.block::<S, 3, WIDE>(simd, i, j, length),
                _ => self.block::<S, 4, WIDE>(simd, i, j, length),
            }
            j += 4;
        }
    }

    #[inline(always)]
    fn block<S: Simd, const ROWS: usize, const WIDE: usize>(
        &mut self,
        simd: S,
        i: usize,
        j: usize,
        length: usize,
    ) {
        let from = S::as_simd_f64s(self.from).0;
        let to = S::as_mut_simd_f64s(self.to).0;
        let rows: [&[f64]; ROWS] =
            std::array::from_fn(|row| &self.lower[(j + row) * self.lower_stride..][..j + ROWS]);
        let mut sums = [[simd.splat_f64s(0.0); WIDE]; ROWS];
        for k in 0..j + ROWS {
            let column: &[S::f64s] = &from[k * length + i..][..WIDE];
            for row in 0..ROWS {
                let coefficient = simd.splat_f64s(rows[row][k]);
                for wide in 0..WIDE {
                    sums[row][wide] = simd.mul_add_f64s(coefficient, column[wide], sums[row][wide]);
                }
            }
        }
        for (row, sums) in sums.iter().enumerate() {
            to[(j + row) * length + i..][..WIDE].copy_from_slice(sums);
        }
    }
}

/// Computes `sums[j][k] = left[j] · right[k]`. For symmetric sums, it computes those with `k ≥ j`
/// (and a few with smaller `k`). Row `j` of `sums` begins at `j · sums_stride`.
pub(super) struct Gram<'a> {
    pub(super) left: &'a [f64],
    pub(super) right: &'a [f64],
    pub(super) stride: usize,
    pub(super) symmetric: bool,
    pub(super) sums: &'a mut [f64],
    pub(super) sums_stride: usize,
}

impl WithSimd for Gram<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let rows = self.left.len() / self.stride;
        let columns = self.right.len() / self.stride;
        let mut j = 0;
        while j < rows {
            if rows - j >= 3 {
                self.strip::<S, 3>(simd, j, columns);
                j += 3;
            } else {
                self.strip::<S, 1>(simd, j, columns);
                j += 1;
            }
        }
    }
}

impl Gram<'_> {
    /// Computes several rows of sums. Three by four products keep the multipliers busy.
    #[inline(always)]
    fn strip<S: Simd, const ROWS: usize>(&mut self, simd: S, j: usize, columns: usize) {
        let mut k = if self.symmetric { j } else { 0 };
        while k < columns {
            match columns - k {
                1 => self.block::<S, ROWS, 1>(simd, j, k),
                2 => self.block::<S, ROWS, 2>(simd, j, k),
                3 => self.block::<S, ROWS, 3>(simd, j, k),
                _ => self.block::<S, ROWS, 4>(simd, j, k),
            }
            k += 4;
        }
    }

    #[inline(always)]
    fn block<S: Simd, const ROWS: usize, const COLUMNS: usize>(
        &mut self,
        simd: S,
        j: usize,
        k: usize,
    ) {
        let column = |numbers, at: usize| -> &[S::f64s] {
            let numbers: &[f64] = numbers;
            S::as_simd_f64s(&numbers[at * self.stride..(at + 1) * self.stride]).0
        };
        let left: [&[S::f64s]; ROWS] = std::array::from_fn(|row| column(self.left, j + row));
        let right: [&[S::f64s]; COLUMNS] = std::array::from_fn(|at| column(self.right, k + at));
        let length = left[0].len();
        let left = left.map(|column| &column[..length]);
        let right = right.map(|column| &column[..length]);
        let mut sums = [[simd.splat_f64s(0.0); COLUMNS]; ROWS];
        for i in 0..length {
            for row in 0..ROWS {
                for at in 0..COLUMNS {
                    sums[row][at] = simd.mul_add_f64s(left[row][i], right[at][i], sums[row][at]);
                }
            }
        }
        for (row, sums) in sums.iter().enumerate() {
            let out = &mut self.sums[(j + row) * self.sums_stride + k..][..COLUMNS];
            for (out, &sum) in out.iter_mut().zip(sums) {
                *out = simd.reduce_sum_f64s(sum);
            }
        }
    }
}

/// Computes the residuals `cᵢ − Σⱼ aⱼ Aᵢⱼ`, and their squared lengths. Returns the largest of those
/// whose weight is not 0, and the weighted sum.
pub(super) struct Residuals<'a, const D: usize> {
    /// Columns of `A`.
    pub(super) basis: &'a [f64],
    /// Columns of the points, and of the residuals.
    pub(super) points: &'a [f64],
    pub(super) left: &'a mut [f64],
    pub(super) coefficients: &'a [[f64; D]],
    pub(super) weights: &'a [f64],
    pub(super) squared: &'a mut [f64],
}

impl<const D: usize> WithSimd for Residuals<'_, D> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 2] {
        let (basis, points) = (
            S::as_simd_f64s(self.basis).0,
            S::as_simd_f64s(self.points).0,
        );
        let (left, squared) = (
            S::as_mut_simd_f64s(self.left).0,
            S::as_mut_simd_f64s(self.squared).0,
        );
        let length = squared.len();
        for (i, squared) in squared.iter_mut().enumerate() {
            let mut sums: [S::f64s; D] = std::array::from_fn(|axis| points[axis * length + i]);
            for (column, a) in basis.chunks_exact(length).zip(self.coefficients) {
                for axis in 0..D {
                    sums[axis] =
                        simd.mul_add_f64s(simd.splat_f64s(-a[axis]), column[i], sums[axis]);
                }
            }
            let mut square = simd.splat_f64s(0.0);
            for (axis, &sum) in sums.iter().enumerate() {
                left[axis * length + i] = sum;
                square = simd.mul_add_f64s(sum, sum, square);
            }
            *squared = square;
        }
        largest_and_sum(self.squared, self.weights)
    }
}

/// The largest of `squared` whose weight is not 0, and the weighted sum of all.
#[inline(always)]
fn largest_and_sum(squared: &[f64], weights: &[f64]) -> [f64; 2] {
    let (mut largest, mut sum) = ([0.0f64; LANES], [0.0f64; LANES]);
    let (squared, weights) = (
        squared.as_chunks::<LANES>().0,
        weights.as_chunks::<LANES>().0,
    );
    for (squared, weights) in squared.iter().zip(weights) {
        for lane in 0..LANES {
            let counted = if weights[lane] > 0.0 {
                squared[lane]
            } else {
                0.0
            };
            largest[lane] = if counted > largest[lane] {
                counted
            } else {
                largest[lane]
            };
            sum[lane] += weights[lane] * counted;
        }
    }
    [
        largest.into_iter().fold(0.0, f64::max),
        sum.into_iter().sum(),
    ]
}

/// Multiplies the columns by weights: `to[j][i] = wᵢ from[j][i]`.
#[inline(always)]
pub(super) fn weigh(from: &[f64], weights: &[f64], to: &mut [f64]) {
    let stride = weights.len();
    for (to, from) in to.chunks_exact_mut(stride).zip(from.chunks_exact(stride)) {
        for ((to, from), weight) in to.iter_mut().zip(from).zip(weights) {
            *to = weight * from;
        }
    }
}

/// Number of `weights` above 0; `None` if one is negative, infinite or NaN.
#[inline(always)]
pub(super) fn count_seen(weights: &[f64]) -> Option<usize> {
    let (mut seen, mut bad) = (0u64, 0u64);
    for weight in weights {
        seen += u64::from(*weight > 0.0);
        bad |= u64::from(!(0.0..f64::INFINITY).contains(weight));
    }
    (bad == 0).then_some(seen as usize)
}

/// Sets points of weight 0 to 0, whatever their values.
#[inline(always)]
pub(super) fn hide(columns: &mut [f64], weights: &[f64]) {
    for column in columns.chunks_exact_mut(weights.len()) {
        for (number, &weight) in column.iter_mut().zip(weights) {
            *number = if weight > 0.0 { *number } else { 0.0 };
        }
    }
}

/// Computes the squared lengths `|zᵢ|²` of the rows of `columns`. If ends are pinned, adds the form
/// `uᵀJu` of `u = Vᵀzᵢ` (see `ends`). Returns the largest.
pub(super) struct Gains<'a> {
    pub(super) columns: &'a [f64],
    pub(super) stride: usize,
    pub(super) pinned: Option<&'a Ends>,
}

impl WithSimd for Gains<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let columns = S::as_simd_f64s(self.columns).0;
        let length = S::as_simd_f64s(&self.columns[..self.stride]).0.len();
        let zero = simd.splat_f64s(0.0);
        let mut largest = zero;
        let pinned = self.pinned.map(|ends| (&ends.v, ends.j()));
        for i in 0..length {
            let mut square = zero;
            for column in columns.chunks_exact(length) {
                square = simd.mul_add_f64s(column[i], column[i], square);
            }
            if let Some((v, j)) = &pinned {
                let mut u = [zero; 2];
                for (column, v) in columns.chunks_exact(length).zip(*v) {
                    for end in 0..2 {
                        u[end] = simd.mul_add_f64s(simd.splat_f64s(v[end]), column[i], u[end]);
                    }
                }
                for (row, &along) in j.iter().zip(&u) {
                    let mut ju = simd.mul_f64s(simd.splat_f64s(row[0]), u[0]);
                    ju = simd.mul_add_f64s(simd.splat_f64s(row[1]), u[1], ju);
                    square = simd.mul_add_f64s(along, ju, square);
                }
            }
            largest = simd.max_f64s(largest, square);
        }
        simd.reduce_max_f64s(largest)
    }
}

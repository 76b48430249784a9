//! Halves the work by symmetry. If the grid of ρ and the basis are symmetric, a reversed centerline
//! has reversed control points. Sums and differences of mirrored points, `cᵢ ± c₍N₋₁₋ᵢ₎`, then
//! decouple: the sums alone give `pⱼ + p₍ₙ₋ⱼ₎`, and the differences alone give `pⱼ − p₍ₙ₋ⱼ₎`. Two
//! problems with half the points and half the control points need half the multiply-adds of the
//! whole. Other bases are not folded: their points are all "sums", and there are no differences.

use crate::solve::Halves;
use faer::MatRef;

/// Points per block. On every machine, this is a whole number of vector pairs.
pub(crate) const BLOCK: usize = 16;

/// `count` rounded up to whole blocks.
fn padded(count: usize) -> usize {
    count.div_ceil(BLOCK) * BLOCK
}

/// Points, each axis by itself; folded at the middle if the basis is symmetric.
pub(crate) struct Points<const D: usize> {
    /// Number of points.
    pub(crate) count: usize,
    /// True if they are folded.
    pub(crate) folded: bool,
    /// `cᵢ + c₍N₋₁₋ᵢ₎`, or `cᵢ` if not folded.
    pub(crate) sums: [Vec<f64>; D],
    /// `cᵢ − c₍N₋₁₋ᵢ₎`, or empty.
    pub(crate) differences: [Vec<f64>; D],
}

impl<const D: usize> Points<D> {
    /// Allocates for `count` points.
    pub(crate) fn new(count: usize, folded: bool) -> Self {
        let zeros = |length: usize| std::array::from_fn(|_| vec![0.0; padded(length)]);
        Self {
            count,
            folded,
            sums: zeros(if folded { count.div_ceil(2) } else { count }),
            differences: zeros(if folded { count.div_ceil(2) } else { 0 }),
        }
    }
}

/// Folding of a matrix's rows and of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fold {
    /// Neither is folded.
    Whole,
    /// Both are folded: half of the work.
    Mirrored,
    /// The points are folded, but the rows have no symmetry.
    Apart,
}

/// A matrix for the sums and one for the differences, in blocks of columns, each row by row, and
/// padded with zeros to whole blocks.
pub(crate) struct Rows {
    /// Number of rows of the matrix when not folded.
    count: usize,
    fold: Fold,
    pub(crate) even: Vec<f64>,
    pub(crate) odd: Vec<f64>,
}

impl Rows {
    /// Converts `m`, m × N, so that the rows times the points are `p = m c`. When folded,
    /// `mⱼᵢ = m₍ₙ₋ⱼ₎₍N₋₁₋ᵢ₎` must hold, and the results are `pⱼ + p₍ₙ₋ⱼ₎` and `pⱼ − p₍ₙ₋ⱼ₎`. A row
    /// or point that is its own mirror image counts twice in the sums.
    pub(crate) fn of_product(m: MatRef<'_, f64>, folded: bool) -> Self {
        if !folded {
            return Self::whole(m);
        }
        let (rows, points) = (m.nrows(), m.ncols());
        Self::folded(m, |row, i, sign| {
            let value = m[(row, i)] + sign * m[(rows - 1 - row, i)];
            if 2 * i + 1 == points {
                0.5 * value
            } else {
                value
            }
        })
    }

    /// Converts any `m`, m × N, for points that are folded or not.
    pub(crate) fn of_any(m: MatRef<'_, f64>, folded: bool) -> Self {
        if !folded {
            return Self::whole(m);
        }
        let (count, points) = m.shape();
        let value = |row: usize, i: usize, sign: f64| {
            let value = 0.5 * (m[(row, i)] + sign * m[(row, points - 1 - i)]);
            if 2 * i + 1 == points {
                0.5 * value
            } else {
                value
            }
        };
        let half = points.div_ceil(2);
        Self {
            count,
            fold: Fold::Apart,
            even: rows(count, half, |row, i| value(row, i, 1.0)),
            odd: rows(count, half, |row, i| value(row, i, -1.0)),
        }
    }

    /// Converts `m`, the transpose of `B`, so that control points times the rows are the points on
    /// the curve. When folded, `pⱼ ± p₍ₙ₋ⱼ₎` times the rows are the sums and the differences of
    /// mirrored points on the curve.
    pub(crate) fn of_curve(m: MatRef<'_, f64>, folded: bool) -> Self {
        if !folded {
            return Self::whole(m);
        }
        let rows = m.nrows();
        Self::folded(m, |row, i, sign| {
            let value = m[(row, i)] + sign * m[(rows - 1 - row, i)];
            if 2 * row + 1 == rows {
                0.5 * value
            } else {
                value
            }
        })
    }

    fn whole(m: MatRef<'_, f64>) -> Self {
        Self {
            count: m.nrows(),
            fold: Fold::Whole,
            even: rows(m.nrows(), m.ncols(), |row, i| m[(row, i)]),
            odd: Vec::new(),
        }
    }

    fn folded(m: MatRef<'_, f64>, value: impl Fn(usize, usize, f64) -> f64) -> Self {
        let half = m.ncols().div_ceil(2);
        Self {
            count: m.nrows(),
            fold: Fold::Mirrored,
            even: rows(m.nrows().div_ceil(2), half, |row, i| value(row, i, 1.0)),
            odd: rows(m.nrows() / 2, half, |row, i| value(row, i, -1.0)),
        }
    }

    /// Combines folded halves: `pⱼ = (eⱼ + oⱼ)/2`, `p₍ₙ₋ⱼ₎ = (eⱼ − oⱼ)/2`.
    #[inline(always)]
    pub(crate) fn unfold<const D: usize>(
        &self,
        even: &[[f64; D]],
        odd: &[[f64; D]],
        out: &mut [[f64; D]],
    ) {
        match self.fold {
            Fold::Whole => {
                out.copy_from_slice(even);
                return;
            }
            Fold::Apart => {
                for (out, (e, o)) in out.iter_mut().zip(even.iter().zip(odd)) {
                    for axis in 0..D {
                        out[axis] = e[axis] + o[axis];
                    }
                }
                return;
            }
            Fold::Mirrored => {}
        }
        let last = out.len().saturating_sub(1);
        let (pairs, middle) = even.split_at(odd.len());
        for (j, (e, o)) in pairs.iter().zip(odd).enumerate() {
            for axis in 0..D {
                out[j][axis] = 0.5 * (e[axis] + o[axis]);
                out[last - j][axis] = 0.5 * (e[axis] - o[axis]);
            }
        }
        // With an odd number, the middle one has no difference.
        for e in middle {
            for axis in 0..D {
                out[last / 2][axis] = 0.5 * e[axis];
            }
        }
    }

    /// Folds control points into negated halves. Adding the curve of the result subtracts the
    /// original curve.
    #[inline(always)]
    pub(crate) fn fold_negated<const D: usize>(
        &self,
        control_points: &[[f64; D]],
        even: &mut [[f64; D]],
        odd: &mut [[f64; D]],
    ) {
        debug_assert!(self.fold != Fold::Apart, "a curve's rows have its symmetry");
        if self.fold == Fold::Whole {
            for (e, p) in even.iter_mut().zip(control_points) {
                for axis in 0..D {
                    e[axis] = -p[axis];
                }
            }
            return;
        }
        let last = control_points.len() - 1;
        for (j, e) in even.iter_mut().enumerate() {
            let (p, mirrored) = (control_points[j], control_points[last - j]);
            for axis in 0..D {
                e[axis] = -p[axis] - mirrored[axis];
            }
            if let Some(o) = odd.get_mut(j) {
                for axis in 0..D {
                    o[axis] = mirrored[axis] - p[axis];
                }
            }
        }
    }
}

impl<const D: usize> Halves<D> {
    /// Slices of the size that these rows need.
    #[inline(always)]
    pub(crate) fn of(&mut self, rows: &Rows) -> (&mut [[f64; D]], &mut [[f64; D]]) {
        let (even, odd) = match rows.fold {
            Fold::Whole => (rows.count, 0),
            Fold::Mirrored => (rows.count.div_ceil(2), rows.count / 2),
            Fold::Apart => (rows.count, rows.count),
        };
        (&mut self.even[..even], &mut self.odd[..odd])
    }
}

fn rows(count: usize, length: usize, value: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut numbers = vec![0.0; count * padded(length)];
    for row in 0..count {
        for i in 0..length {
            numbers[BLOCK * (i / BLOCK * count + row) + i % BLOCK] = value(row, i);
        }
    }
    numbers
}

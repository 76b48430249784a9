//! Half the work by symmetry. The grid of ρ is uniform, so a centerline read backwards has the control
//! points read backwards. Sums and differences of mirrored points, `cᵢ ± c₍N₋₁₋ᵢ₎`, then decouple: the sums
//! alone give `pⱼ + p₍ₙ₋ⱼ₎`, the differences alone give `pⱼ − p₍ₙ₋ⱼ₎`. Two problems of half the points and
//! half the control points cost half the multiply-adds of the whole.

use faer::MatRef;

/// Rows are padded with zeros to a multiple of this many numbers: two of the widest vector registers.
const LANES: usize = 16;

/// `count` rounded up to whole vector registers.
fn padded(count: usize) -> usize {
    count.div_ceil(LANES) * LANES
}

/// Points folded at the middle: sums and differences of mirrored points, each axis by itself.
pub(crate) struct FoldedPoints {
    /// `cᵢ + c₍N₋₁₋ᵢ₎`: x, then y.
    pub(crate) sums: [Vec<f64>; 2],
    /// `cᵢ − c₍N₋₁₋ᵢ₎`: x, then y.
    pub(crate) differences: [Vec<f64>; 2],
}

impl FoldedPoints {
    /// Room for `points` points.
    pub(crate) fn new(points: usize) -> Self {
        let zeros = || vec![0.0; padded(points.div_ceil(2))];
        Self {
            sums: [zeros(), zeros()],
            differences: [zeros(), zeros()],
        }
    }
}

/// Two matrices, one for the sums and one for the differences, row by row, each row padded.
pub(crate) struct FoldedRows {
    pub(crate) stride: usize,
    pub(crate) even: Vec<f64>,
    pub(crate) odd: Vec<f64>,
}

impl FoldedRows {
    /// Folds `m`, (n+1) × N with `mⱼᵢ = m₍ₙ₋ⱼ₎₍N₋₁₋ᵢ₎`, so that the folded rows times the folded points are
    /// `pⱼ + p₍ₙ₋ⱼ₎` and `pⱼ − p₍ₙ₋ⱼ₎` of `p = m c`. A row or point that is its own mirror image counts
    /// twice in the sums.
    pub(crate) fn of_product(m: MatRef<'_, f64>) -> Self {
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

    /// Folds `m`, the transpose of `B`, so that `pⱼ ± p₍ₙ₋ⱼ₎` times the folded rows are the sums and the
    /// differences of mirrored points on the curve.
    pub(crate) fn of_curve(m: MatRef<'_, f64>) -> Self {
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

    fn folded(m: MatRef<'_, f64>, value: impl Fn(usize, usize, f64) -> f64) -> Self {
        let half = m.ncols().div_ceil(2);
        let stride = padded(half);
        let fold = |rows: usize, sign: f64| {
            let mut folded = vec![0.0; rows * stride];
            for (row, numbers) in folded.chunks_exact_mut(stride).enumerate() {
                for (i, number) in numbers[..half].iter_mut().enumerate() {
                    *number = value(row, i, sign);
                }
            }
            folded
        };
        Self {
            stride,
            even: fold(m.nrows().div_ceil(2), 1.0),
            odd: fold(m.nrows() / 2, -1.0),
        }
    }
}

/// Control points from their folded halves: `pⱼ = (eⱼ + oⱼ)/2`, `p₍ₙ₋ⱼ₎ = (eⱼ − oⱼ)/2`.
pub(crate) fn unfold(even: &[[f64; 2]], odd: &[[f64; 2]], control_points: &mut [[f64; 2]]) {
    let last = control_points.len() - 1;
    for (j, &e) in even.iter().enumerate() {
        // The middle one of an odd number has no difference.
        let o = odd.get(j).copied().unwrap_or([0.0; 2]);
        control_points[last - j] = [0.5 * (e[0] - o[0]), 0.5 * (e[1] - o[1])];
        control_points[j] = [0.5 * (e[0] + o[0]), 0.5 * (e[1] + o[1])];
    }
}

/// The folded halves of control points, negated, so that adding their curve takes it away.
pub(crate) fn fold_negated(
    control_points: &[[f64; 2]],
    even: &mut [[f64; 2]],
    odd: &mut [[f64; 2]],
) {
    let last = control_points.len() - 1;
    for (j, e) in even.iter_mut().enumerate() {
        let (p, mirrored) = (control_points[j], control_points[last - j]);
        *e = [-p[0] - mirrored[0], -p[1] - mirrored[1]];
        if let Some(o) = odd.get_mut(j) {
            *o = [mirrored[0] - p[0], mirrored[1] - p[1]];
        }
    }
}

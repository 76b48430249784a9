//! Small dense matrices, row by row, in whole vectors of four; and the filter's three loops, each a
//! sum of rows times numbers:
//!
//! ```text
//! eliminate            [S | X]  → [U | U⁻ᵀX],  UᵀU = S      Cholesky, and all triangular solves with it
//! transposed_product   A, B     → AᵀB
//! congruence           T, P     → TᵀPT
//! ```
//!
//! This is plain code, inlined into functions that are compiled for each instruction set. Running
//! sums stay in registers over all rows, four vectors at a time.

/// Numbers in a vector: rows are padded with zeros to a multiple of this. It is four instead of
/// eight because nine control points fill three vectors of four to 75 %, but two of eight only to
/// 56 %.
pub(super) const LANES: usize = 4;

/// A vector.
pub(super) type Lanes = [f64; LANES];

/// A matrix of padded rows.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    /// Vectors per row.
    pub(super) width: usize,
    pub(super) vectors: Vec<Lanes>,
}

/// Number of vectors for `columns` numbers.
pub(super) fn vectors(columns: usize) -> usize {
    columns.div_ceil(LANES)
}

impl Rows {
    /// Allocates a matrix of `rows` rows of `width` vectors of zeros.
    pub(super) fn new(rows: usize, width: usize) -> Self {
        Self {
            width,
            vectors: vec![[0.0; LANES]; rows * width],
        }
    }

    /// Creates a square matrix of zeros.
    pub(super) fn square(count: usize) -> Self {
        Self::new(count, vectors(count))
    }

    /// Resizes to a matrix of zeros. The size must be within the original memory, so that nothing
    /// is allocated.
    pub(super) fn reshape(&mut self, rows: usize, width: usize) {
        self.width = width;
        self.vectors.clear();
        self.vectors.resize(rows * width, [0.0; LANES]);
    }

    #[inline(always)]
    pub(super) fn get(&self, row: usize, column: usize) -> f64 {
        self.vectors[row * self.width + column / LANES][column % LANES]
    }

    #[inline(always)]
    pub(super) fn set(&mut self, row: usize, column: usize, value: f64) {
        self.vectors[row * self.width + column / LANES][column % LANES] = value;
    }

    #[inline(always)]
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.vectors[row * self.width + column / LANES][column % LANES] += value;
    }

    #[inline(always)]
    pub(super) fn row(&self, row: usize) -> &[Lanes] {
        &self.vectors[row * self.width..(row + 1) * self.width]
    }

    /// The first `count` numbers of a row.
    #[inline(always)]
    pub(super) fn numbers(&self, row: usize, count: usize) -> &[f64] {
        &self.row(row).as_flattened()[..count]
    }

    /// Replaces a square matrix that is symmetric up to rounding by the mean of it and its
    /// transpose.
    #[inline(always)]
    pub(super) fn symmetrize(&mut self, count: usize) {
        for i in 0..count {
            for j in 0..i {
                let mean = 0.5 * (self.get(i, j) + self.get(j, i));
                self.set(i, j, mean);
                self.set(j, i, mean);
            }
        }
    }
}

/// Rows that are summed: the vectors from the `first`-th, in rows that are `stride` vectors apart.
#[derive(Clone, Copy)]
struct Terms<'a> {
    vectors: &'a [Lanes],
    stride: usize,
    first: usize,
}

/// `out += Σₖ factor(k) · row k` over the first `count` rows.
#[inline(always)]
fn add_rows(out: &mut [Lanes], count: usize, factor: impl Fn(usize) -> f64, terms: Terms<'_>) {
    let (blocks, rest) = out.as_chunks_mut::<4>();
    let mut first = terms.first;
    for block in blocks {
        add_block(block, count, &factor, Terms { first, ..terms });
        first += 4;
    }
    let terms = Terms { first, ..terms };
    match rest {
        [a, b, c] => {
            let mut block = [*a, *b, *c];
            add_block(&mut block, count, &factor, terms);
            [*a, *b, *c] = block;
        }
        [a, b] => {
            let mut block = [*a, *b];
            add_block(&mut block, count, &factor, terms);
            [*a, *b] = block;
        }
        [a] => {
            let mut block = [*a];
            add_block(&mut block, count, &factor, terms);
            [*a] = block;
        }
        _ => {}
    }
}

#[inline(always)]
fn add_block<const W: usize>(
    out: &mut [Lanes; W],
    count: usize,
    factor: &impl Fn(usize) -> f64,
    terms: Terms<'_>,
) {
    let mut sum = *out;
    for k in 0..count {
        let start = k * terms.stride + terms.first;
        let row = &terms.vectors[start..start + W];
        let f = factor(k);
        for (sum, row) in sum.iter_mut().zip(row) {
            for lane in 0..LANES {
                sum[lane] += f * row[lane];
            }
        }
    }
    *out = sum;
}

/// Cholesky elimination of the symmetric matrix `S` in the first `count` rows and columns. Only its
/// upper triangle is read. It becomes `U` with `UᵀU = S`, and every further column `x` becomes
/// `U⁻ᵀx`. Entries left of the diagonal are meaningless afterwards.
///
/// Returns false, with all entries meaningless, if `S` is not positive definite.
#[inline(always)]
pub(super) fn eliminate(matrix: &mut Rows, count: usize) -> bool {
    let width = matrix.width;
    for k in 0..count {
        let (done, rest) = matrix.vectors.split_at_mut(k * width);
        let (vector, lane) = (k / LANES, k % LANES);
        let row = &mut rest[vector..width];
        let terms = Terms {
            vectors: done,
            stride: width,
            first: vector,
        };
        add_rows(row, k, |p| -done[p * width + vector][lane], terms);
        let pivot = row[0][lane];
        // Also rejects NaN.
        if !(pivot > 0.0 && pivot < f64::INFINITY) {
            return false;
        }
        let scale = 1.0 / pivot.sqrt();
        for number in row.as_flattened_mut() {
            *number *= scale;
        }
    }
    true
}

/// `out ← out + sign · AᵀB`, where `A` and `B` are the `count` columns from the `a`-th and the
/// `b`-th vector of the first `count` rows of `of`.
#[inline(always)]
pub(super) fn transposed_product(
    out: &mut Rows,
    sign: f64,
    of: &Rows,
    [a, b]: [usize; 2],
    count: usize,
) {
    let (stride, width) = (of.width, out.width);
    let terms = Terms {
        vectors: &of.vectors,
        stride,
        first: b,
    };
    for (i, row) in out.vectors.chunks_exact_mut(width).take(count).enumerate() {
        let (vector, lane) = (a + i / LANES, i % LANES);
        let factor = |k: usize| sign * of.vectors[k * stride + vector][lane];
        add_rows(row, count, factor, terms);
    }
}

/// `out ← TᵀPT` for a symmetric `P`, all `count` × `count`. The result is exactly symmetric. `half`
/// is scratch memory.
#[inline(always)]
pub(super) fn congruence(t: &Rows, p: &Rows, half: &mut Rows, out: &mut Rows, count: usize) {
    let width = vectors(count);
    half.reshape(count, width);
    out.reshape(count, width);
    for (i, row) in half.vectors.chunks_exact_mut(width).enumerate() {
        let terms = Terms {
            vectors: &p.vectors,
            stride: width,
            first: 0,
        };
        add_rows(row, count, |k| t.get(k, i), terms);
    }
    for (i, row) in out.vectors.chunks_exact_mut(width).enumerate() {
        let terms = Terms {
            vectors: &t.vectors,
            stride: width,
            first: 0,
        };
        add_rows(row, count, |k| half.get(i, k), terms);
    }
    out.symmetrize(count);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A matrix filled by repeating these numbers.
    fn filled(rows: usize, columns: usize, numbers: &[f64]) -> Rows {
        let mut matrix = Rows::new(rows, vectors(columns));
        for i in 0..rows {
            for j in 0..columns {
                matrix.set(i, j, numbers[(i * columns + j) % numbers.len()]);
            }
        }
        matrix
    }

    fn any_numbers() -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(-1f64..1.0, 61)
    }

    proptest! {
        #[test]
        fn elimination_is_cholesky_and_forward_substitution(
            count in 1usize..=32, further in 0usize..70, numbers in any_numbers(),
        ) {
            let (width, first) = (vectors(count), vectors(count) * LANES);
            let mut matrix = filled(count, first + further, &numbers);
            for i in 0..count {
                for j in 0..count {
                    // Positive definite by Gershgorin: the diagonal dominates.
                    let value = numbers[(i + j) % 61] + if i == j { 40.0 } else { 0.0 };
                    matrix.set(i, j, value);
                }
            }
            let before = matrix.clone();
            prop_assert!(eliminate(&mut matrix, count));
            for i in 0..count {
                for j in (i..count).chain(first..width * LANES + further) {
                    let product: f64 = (0..=i).map(|k| matrix.get(k, i) * matrix.get(k, j)).sum();
                    prop_assert!((product - before.get(i, j)).abs() < 1e-12, "{i} {j}");
                }
            }
        }

        #[test]
        fn what_is_not_positive_definite_is_not_eliminated(
            count in 1usize..=32, at in 0usize..32, numbers in any_numbers(),
        ) {
            for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                let mut matrix = Rows::square(count);
                for (i, number) in numbers[..count].iter().enumerate() {
                    matrix.set(i, i, 1.0 + number.abs());
                }
                matrix.set(at % count, at % count, bad);
                prop_assert!(!eliminate(&mut matrix, count));
            }
        }

        #[test]
        fn products_are_their_definitions(count in 1usize..=32, numbers in any_numbers()) {
            let width = vectors(count);
            let of = filled(count, 2 * width * LANES, &numbers);
            let mut out = filled(count, count, &numbers[7..]);
            let before = out.clone();
            transposed_product(&mut out, -1.0, &of, [width, 0], count);
            for i in 0..count {
                for j in 0..count {
                    let product: f64 =
                        (0..count).map(|k| of.get(k, width * LANES + i) * of.get(k, j)).sum();
                    prop_assert!((before.get(i, j) - product - out.get(i, j)).abs() < 1e-12);
                }
            }
            let t = filled(count, count, &numbers);
            let mut p = filled(count, count, &numbers[13..]);
            p.symmetrize(count);
            let (mut half, mut found) = (Rows::square(32), Rows::square(32));
            congruence(&t, &p, &mut half, &mut found, count);
            for i in 0..count {
                for j in 0..count {
                    let mut sum = 0.0;
                    for k in 0..count {
                        for l in 0..count {
                            sum += t.get(k, i) * p.get(k, l) * t.get(l, j);
                        }
                    }
                    prop_assert!((found.get(i, j) - sum).abs() < 1e-11);
                    prop_assert_eq!(found.get(i, j), found.get(j, i));
                }
            }
        }
    }
}

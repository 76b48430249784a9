//! Inner products of the rational fit, in the machine's widest registers. They process three rows
//! by three at a time, so that every loaded number is used three times.
//!
//! ```text
//! products   out[a][b] = Σᵢ left[a][i] · right[b][i]
//! ```

use lariat_portable::Simd;

/// Rows are padded with zeros to a multiple of this many numbers: the widest vector register.
const LANES: usize = 8;

/// `count` rounded up to whole vector registers.
pub(super) fn padded(count: usize) -> usize {
    count.next_multiple_of(LANES)
}

/// Rows of a matrix: row `a` is the `length` numbers from `a · stride`.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) numbers: &'a [f64],
    pub(super) stride: usize,
    pub(super) count: usize,
}

/// Products to compute.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Part {
    All,
    /// Products with `b ≤ a`. Some of the others are written too.
    Lower,
}

/// Computes `out[a · out_stride + b] = left[a] · right[b]` over rows of `length` numbers, a
/// multiple of [`LANES`].
#[inline(always)]
pub(super) fn products<S: Simd>(
    simd: S,
    [left, right]: [Rows<'_>; 2],
    length: usize,
    part: Part,
    out: &mut [f64],
    out_stride: usize,
) {
    for a in (0..left.count).step_by(3) {
        let columns = match part {
            Part::All => right.count,
            Part::Lower => right.count.min(a + 3),
        };
        for b in (0..columns).step_by(3) {
            let starts = [a, b];
            let rows = [left, right];
            match ((left.count - a).min(3), (right.count - b).min(3)) {
                (3, 3) => tile::<S, 3, 3>(simd, rows, starts, length, out, out_stride),
                (3, 2) => tile::<S, 3, 2>(simd, rows, starts, length, out, out_stride),
                (3, _) => tile::<S, 3, 1>(simd, rows, starts, length, out, out_stride),
                (2, 3) => tile::<S, 2, 3>(simd, rows, starts, length, out, out_stride),
                (2, 2) => tile::<S, 2, 2>(simd, rows, starts, length, out, out_stride),
                (2, _) => tile::<S, 2, 1>(simd, rows, starts, length, out, out_stride),
                (_, 3) => tile::<S, 1, 3>(simd, rows, starts, length, out, out_stride),
                (_, 2) => tile::<S, 1, 2>(simd, rows, starts, length, out, out_stride),
                (_, _) => tile::<S, 1, 1>(simd, rows, starts, length, out, out_stride),
            }
        }
    }
}

/// Computes an `A` × `B` block of these products.
#[inline(always)]
fn tile<S: Simd, const A: usize, const B: usize>(
    simd: S,
    [left, right]: [Rows<'_>; 2],
    [a, b]: [usize; 2],
    length: usize,
    out: &mut [f64],
    out_stride: usize,
) {
    let vectors = length / S::F64_LANES;
    let row = |rows: Rows<'_>, k: usize| k * rows.stride..k * rows.stride + length;
    let lefts: [&[S::f64s]; A] =
        std::array::from_fn(|k| &S::as_simd_f64s(&left.numbers[row(left, a + k)]).0[..vectors]);
    let rights: [&[S::f64s]; B] =
        std::array::from_fn(|k| &S::as_simd_f64s(&right.numbers[row(right, b + k)]).0[..vectors]);
    let mut sums = [[simd.splat_f64s(0.0); B]; A];
    for i in 0..vectors {
        for (sums, left) in sums.iter_mut().zip(&lefts) {
            for (sum, right) in sums.iter_mut().zip(&rights) {
                *sum = simd.mul_add_f64s(left[i], right[i], *sum);
            }
        }
    }
    for (k, sums) in sums.iter().enumerate() {
        for (l, &sum) in sums.iter().enumerate() {
            out[(a + k) * out_stride + b + l] = simd.reduce_sum_f64s(sum);
        }
    }
}

/// `to += factor · from`.
#[inline(always)]
pub(super) fn add_multiple(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += factor * from;
    }
}

/// `to = factor · a · b`.
#[inline(always)]
pub(super) fn multiply(to: &mut [f64], factor: f64, a: &[f64], b: &[f64]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to = factor * a * b;
    }
}

/// `to = a − b`.
#[inline(always)]
pub(super) fn subtract(to: &mut [f64], a: &[f64], b: &[f64]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to = a - b;
    }
}

/// Rows without padding between them.
#[inline(always)]
pub(super) fn rows(numbers: &[f64], stride: usize) -> Rows<'_> {
    Rows {
        numbers,
        stride,
        count: numbers.len() / stride,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_portable::WithSimd;
    use proptest::prelude::*;

    struct Products<'a>([Rows<'a>; 2], usize, Part, &'a mut [f64], usize);

    impl WithSimd for Products<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            products(simd, self.0, self.1, self.2, self.3, self.4);
        }
    }

    proptest! {
        #[test]
        fn products_are_the_sums_they_stand_for(
            counts in prop::array::uniform2(1usize..10),
            length in (1usize..6).prop_map(|vectors| vectors * LANES),
            gap in 0usize..20,
            lower in any::<bool>(),
            seed in prop::collection::vec(-1.0f64..1.0, 600),
        ) {
            let stride = length + gap;
            let rows = counts.map(|count| Rows { numbers: &seed[..count * stride], stride, count });
            let mut out = vec![f64::NAN; counts[0] * (counts[1] + 2)];
            let part = if lower { Part::Lower } else { Part::All };
            lariat_portable::Arch::new().dispatch(Products(rows, length, part, &mut out, counts[1] + 2));
            for a in 0..counts[0] {
                for b in 0..if lower { counts[1].min(a + 1) } else { counts[1] } {
                    let defined: f64 = (0..length)
                        .map(|i| seed[a * stride + i] * seed[b * stride + i])
                        .sum();
                    prop_assert!((out[a * (counts[1] + 2) + b] - defined).abs() < 1e-13);
                }
            }
        }
    }
}

//! Cost of a fit, next to the bare multiply-adds of its product.
//!
//! Run it with `cargo bench --manifest-path bench/Cargo.toml --bench fit`.
//!
//! For order 8 and 120 points, the product takes 9 × 120 × 2 = 2,160 multiply-adds. "bare" performs
//! the same number in registers, with the same vector width, and reads no memory. "pinv, control
//! points alone" is that product, including reading and checking the points. A fit also computes
//! every point's residual, a second product of the same size.
#![allow(missing_docs)] // criterion's macros generate undocumented functions.

use criterion::{Criterion, criterion_group, criterion_main};
use lariat_fit::{Fitter, Options, Solver};
use pulp::{Arch, Simd, WithSimd};
use std::hint::black_box;

/// Number of running sums: enough to keep two multipliers with a latency of four cycles busy.
const SUMS: usize = 10;

struct Bare {
    multiply_adds: usize,
    factor: f64,
    /// Initial values of the sums. They are opaque to the compiler, which would otherwise merge
    /// equal sums into one.
    sums: [f64; SUMS],
}

impl WithSimd for Bare {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let factor = simd.splat_f64s(self.factor);
        let mut sums = self.sums.map(|sum| simd.splat_f64s(sum));
        for _ in 0..self.multiply_adds / (SUMS * S::F64_LANES) {
            for sum in &mut sums {
                *sum = simd.mul_add_f64s(factor, factor, *sum);
            }
        }
        sums.iter().map(|&sum| simd.reduce_sum_f64s(sum)).sum()
    }
}

fn rope(points: usize) -> Vec<[f64; 2]> {
    (0..points)
        .map(|i| {
            let t = i as f64 / (points - 1) as f64;
            [50.0 + 540.0 * t, 240.0 + 150.0 * (5.0 * t).sin()]
        })
        .collect()
}

fn fits(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("fit, order 8, 120 points");
    let arch = Arch::new();
    group.bench_function("bare multiply-adds", |bencher| {
        bencher.iter(|| {
            arch.dispatch(Bare {
                multiply_adds: 9 * 120 * 2,
                factor: black_box(0.5),
                sums: black_box([1.0; SUMS]),
            })
        })
    });
    let rope = rope(120);
    for solver in [Solver::Pinv, Solver::Cholesky, Solver::Qr] {
        let options = Options::bezier(8).points(120).solver(solver);
        let mut fitter = Fitter::new(options).expect("order 8 with 120 points is well conditioned");
        group.bench_function(solver.to_string(), |bencher| {
            bencher.iter(|| fitter.fit(black_box(&rope)).map(|fit| fit.rms_px))
        });
    }
    let mut fitter = Fitter::new(Options::default()).expect("the default is well conditioned");
    group.bench_function("pinv, control points alone", |bencher| {
        bencher.iter(|| {
            fitter
                .control_points(black_box(&rope))
                .map(|points| points[0])
        })
    });
    group.bench_function("pinv, eight curves", |bencher| {
        bencher.iter(|| {
            for _ in 0..8 {
                black_box(fitter.fit(black_box(&rope)).map(|fit| fit.rms_px)).ok();
            }
        })
    });
    group.finish();
}

fn making(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("making a fitter");
    for (order, points) in [(8, 120), (31, 256)] {
        let options = Options::bezier(order).points(points).solver(Solver::Pinv);
        group.bench_function(format!("order {order}, {points} points"), |bencher| {
            bencher.iter(|| Fitter::new(black_box(options)).map(|fitter| fitter.last().condition))
        });
    }
    group.finish();
}

criterion_group!(benches, fits, making);
criterion_main!(benches);

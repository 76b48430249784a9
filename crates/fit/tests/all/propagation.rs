//! Pixel noise through a tilted plane and resampling to the control points: predicted and empirical
//! covariances.

use lariat_fit::{Fitter, MAX_CONTROL_POINTS, Options, Resampler, Square};
use lariat_portable::SplitMix64;

/// A plane seen at a slant. Along the ropes below, a pixel at one end is some two and a half times
/// as long as at the other.
const H: [[f64; 3]; 3] = [
    [0.8, 0.05, -260.0],
    [-0.03, 1.1, -180.0],
    [1e-4, -1.3e-3, 1.0],
];

/// Standard deviation of the noise. It is large enough that the approximation error of the curves
/// is small in comparison. It is small enough, compared to the steps of 5 px, that the squares of
/// their slopes do not add to the arc length.
const SIGMA_PX: f64 = 0.02;

fn place([x, y]: [f64; 2]) -> ([f64; 2], Square<2>) {
    let [u, v, w] = H.map(|row| row[0] * x + row[1] * y + row[2]);
    let point = [u / w, v / w];
    let j = [0, 1].map(|i| [0, 1].map(|k| (H[i][k] - point[i] * H[2][k]) / w));
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    (point, j.map(|row| j.map(|other| dot(row, other))))
}

/// Equal steps in the picture along a wave, or around a ring.
fn rope(closed: bool) -> Vec<[f64; 2]> {
    let at = |t: f64| {
        if closed {
            let (sin, cos) = (std::f64::consts::TAU * t).sin_cos();
            [320.0 + 150.0 * cos, 250.0 + 120.0 * sin]
        } else {
            [60.0 + 500.0 * t, 420.0 - 300.0 * t + 40.0 * (3.0 * t).sin()]
        }
    };
    let fine: Vec<[f64; 2]> = (0..=20_000).map(|i| at(f64::from(i) / 20_000.0)).collect();
    let mut arcs = vec![0.0];
    for pair in fine.windows(2) {
        arcs.push(arcs[arcs.len() - 1] + (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]));
    }
    let steps = if closed { 120.0 } else { 119.0 };
    (0..120)
        .map(|k| {
            let target = arcs[20_000] * f64::from(k) / steps;
            fine[arcs.partition_point(|&arc| arc < target).min(20_000)]
        })
        .collect()
}

struct Trial {
    /// Mean of the predicted covariances, and variance of the pixels estimated from the residuals.
    foretold: Vec<[f64; 3]>,
    sigma2: f64,
    /// Empirical covariances.
    found: Vec<[f64; 3]>,
}

fn three([[xx, xy], [_, yy]]: [[f64; 2]; 2]) -> [f64; 3] {
    [xx, xy, yy]
}

fn trial(options: Options, closed: bool, sigma_px: f64, seed: u64) -> Trial {
    const RUNS: usize = 4000;
    let truth = rope(closed);
    let mut fitter = Fitter::new(options).unwrap();
    let mut line = Resampler::new();
    let count = options.basis.control_points();
    let mut random = SplitMix64::new(seed);
    let (mut sums, mut products) = (vec![[0.0; 2]; count], vec![[0.0; 3]; count]);
    let (mut foretold, mut sigma2) = (vec![[0.0; 3]; count], 0.0);
    let mut shape = Vec::new();
    for run in 0..RUNS {
        let seen = truth
            .iter()
            .map(|p| p.map(|c| c + sigma_px * random.normal()));
        let (points, squares): (Vec<_>, Vec<_>) = seen.map(place).unzip();
        let even = line.resample(&points, closed).unwrap();
        let control_points = fitter.fit(even).unwrap().control_points.clone();
        let mut covariances = [[[0.0; 2]; 2]; MAX_CONTROL_POINTS];
        sigma2 += fitter.propagate(&line, &squares, &mut covariances) / RUNS as f64;
        if run == 0 {
            shape.clone_from(&control_points);
        }
        for j in 0..count {
            // Relative to the first run's, to avoid cancellation.
            let [x, y] = [0, 1].map(|axis| control_points[j][axis] - shape[j][axis]);
            sums[j] = [sums[j][0] + x, sums[j][1] + y];
            for (sum, product) in products[j].iter_mut().zip([x * x, x * y, y * y]) {
                *sum += product;
            }
            for (sum, c) in foretold[j].iter_mut().zip(three(covariances[j])) {
                *sum += c / RUNS as f64;
            }
        }
    }
    let n = RUNS as f64;
    let found = products.iter().zip(&sums).map(|(p, s)| {
        [
            (p[0], s[0] * s[0]),
            (p[1], s[0] * s[1]),
            (p[2], s[1] * s[1]),
        ]
        .map(|(product, sums)| (product - sums / n) / (n - 1.0))
    });
    Trial {
        foretold,
        sigma2,
        found: found.collect(),
    }
}

/// Checks that predictions and results agree within `tolerance` of each control point's larger
/// variance. A variance of 4000 runs is itself accurate to 2.2 % (one standard deviation), and the
/// worst of 27 numbers to some 7 %.
fn agree(trial: &Trial, sigma_px: f64, tolerance: f64) {
    let share = trial.sigma2 / (sigma_px * sigma_px);
    assert!(
        (share - 1.0).abs() < 0.05,
        "σ² by the residuals: {share} of the true one"
    );
    for (j, (foretold, found)) in trial.foretold.iter().zip(&trial.found).enumerate() {
        let size = found[0].max(found[2]);
        for k in 0..3 {
            assert!(
                (foretold[k] - found[k]).abs() < tolerance * size,
                "control point {j}: foretold {foretold:.4?}, found {found:.4?}"
            );
        }
    }
}

#[test]
fn noise_of_pixels_comes_out_as_foretold() {
    let options = Options::bezier(8).points(120);
    let trial = trial(options, false, SIGMA_PX, 1);
    agree(&trial, SIGMA_PX, 0.1);
    // The variances along and across the rope differ, which one number could not express.
    let middle = trial.found[4];
    let spread = ((middle[0] - middle[2]).powi(2) + 4.0 * middle[1] * middle[1]).sqrt();
    assert!(spread > 0.5 * (middle[0] + middle[2]), "{middle:?}");
}

#[test]
fn of_a_ring_too() {
    let options = Options::bezier(8)
        .basis(lariat_fit::Basis::Fourier { harmonics: 12 })
        .points(120);
    let trial = trial(options, true, SIGMA_PX, 2);
    agree(&trial, SIGMA_PX, 0.1);
}

#[test]
fn lines_of_another_number_of_points_are_no_business_of_a_fitter() {
    let mut fitter = Fitter::new(Options::bezier(3).points(50)).unwrap();
    let mut line = Resampler::new();
    let points: Vec<[f64; 2]> = (0..40).map(|i| [f64::from(i), 0.0]).collect();
    line.resample(&points, false).unwrap();
    let mut covariances = [[[7.0; 2]; 2]; MAX_CONTROL_POINTS];
    assert_eq!(
        fitter.propagate(&line, &[[[1.0; 2]; 2]; 40], &mut covariances),
        0.0
    );
    assert_eq!(covariances[0], [[7.0; 2]; 2]);
}

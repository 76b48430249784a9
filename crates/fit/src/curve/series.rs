//! The Fourier series of a closed curve, its derivatives, and a bound on the deviation of an arc
//! from its chord.

use std::f64::consts::TAU;

/// Derivatives 0 to `K − 1` at `rho` of `a₀ + Σ aₖ cos 2πkρ + bₖ sin 2πkρ`. The `coefficients` are
/// `a₀, a₁, b₁, …`.
pub(crate) fn jet<const D: usize, const K: usize>(
    coefficients: &[[f64; D]],
    rho: f64,
) -> [[f64; D]; K] {
    let mut jet = [[0.0; D]; K];
    let Some((constant, harmonics)) = coefficients.split_first() else {
        return jet;
    };
    // Reduces ρ, so that a full turn ends exactly where it began.
    let (sin, cos) = libm::sincos(TAU * (rho - rho.floor()));
    let (mut s, mut c) = (sin, cos);
    for (before, pair) in harmonics.chunks_exact(2).enumerate() {
        let frequency = TAU * (before + 1) as f64;
        let (mut even, mut odd) = (c, s);
        for derivative in &mut jet {
            for axis in 0..D {
                derivative[axis] += pair[0][axis] * even + pair[1][axis] * odd;
            }
            (even, odd) = (-frequency * odd, frequency * even);
        }
        // There are at most 15 harmonics, so the error of repeated rotation is at most that many
        // ulp.
        (s, c) = (s * cos + c * sin, c * cos - s * sin);
    }
    if let Some(point) = jet.first_mut() {
        for axis in 0..D {
            point[axis] += constant[axis];
        }
    }
    jet
}

/// A bound on the second derivative with respect to ρ: `Σ (2πk)² √(|aₖ|² + |bₖ|²)`.
pub(crate) fn second_bound<const D: usize>(coefficients: &[[f64; D]]) -> f64 {
    let harmonics = coefficients.get(1..).unwrap_or(&[]);
    harmonics
        .chunks_exact(2)
        .enumerate()
        .map(|(before, pair)| {
            let squared: f64 = pair.iter().flatten().map(|c| c * c).sum();
            (TAU * (before + 1) as f64).powi(2) * squared.sqrt()
        })
        .sum()
}

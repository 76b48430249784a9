//! Damped least squares (Y. Nakamura, H. Hanafusa, *Inverse kinematic solutions with singularity
//! robustness*, ASME J. Dyn. Sys. Meas. Control 108, 1986; C. Wampler, IEEE SMC 16, 1986).
//!
//! ```text
//! v = λ (A + μ²I)⁻¹ b,      A = JᵀWJ,  b = JᵀW (s* − s)
//! ```
//!
//! The solution uses the eigenvectors of `A`. Its eigenvalues are the squares of the singular
//! values `σᵢ`, the shape's responses to independent motions, and show how near `A` is to singular.
//! The component along an eigenvector is `λ uᵢ·b/(σᵢ² + μ²)`. μ grows once the smallest `σ` is
//! below a share of the largest:
//!
//! ```text
//! μ² = σ₁² (μ₀² + ε² (1 − (σₚ/εσ₁)²)),     ε = SINGULAR, the second term only for σₚ < εσ₁
//! ```

use crate::eigen::{Eigen, eigen};
use crate::jacobian::{Jacobian, square};
use crate::weighing::Weighing;
use crate::{Coordinates, Features, INPUTS};

/// Ratio of singular values below which damping grows. Otherwise, the law would command a motion
/// with this ratio twenty times as fast as the others, based on a `J` that is accurate to a few
/// hundredths.
const SINGULAR: f64 = 0.05;

/// Velocity that the law requests.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wish {
    /// Velocity before any limit, px-like per second.
    pub(crate) velocity: Coordinates,
    /// `σ₁/σₚ`; infinite if nothing responds.
    pub(crate) condition: f64,
}

/// The normal equations, to be solved for different sets of inputs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Law {
    matrix: [Coordinates; INPUTS],
    right: Coordinates,
    gain: f64,
    damping: f64,
}

impl Law {
    /// Sets up the equations for a shape that is to change by `error`.
    pub(crate) fn new(
        jacobian: &Jacobian,
        weighing: &Weighing,
        error: &Features,
        gain: f64,
        damping: f64,
    ) -> Self {
        let (matrix, right) = weighing.normal(&jacobian.columns, error);
        Self {
            matrix,
            right,
            gain,
            damping,
        }
    }

    /// Solves for the velocity, with these inputs only.
    pub(crate) fn solve(&self, free: &[bool; INPUTS]) -> Wish {
        let mut matrix = self.matrix;
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                // Inputs that are not free are decoupled, with an eigenvalue of −1, which no other
                // has.
                if !(free[i] && free[j]) {
                    *entry = if i == j { -1.0 } else { 0.0 };
                }
            }
        }
        let Eigen { values, vectors } = eigen(matrix);
        let kept = |i: &usize| {
            vectors[*i]
                .iter()
                .zip(free)
                .all(|(v, free)| *free || *v == 0.0)
        };
        let squares = (0..INPUTS).filter(kept).map(|i| values[i].max(0.0));
        let (least, greatest) =
            squares.fold((f64::INFINITY, 0.0f64), |(a, b), s| (a.min(s), b.max(s)));
        let nothing = Wish {
            velocity: [0.0; INPUTS],
            condition: f64::INFINITY,
        };
        // False if the shape does not respond, or if numbers overflow.
        let answers = greatest > 1e-12 && greatest.is_finite();
        if !answers {
            return nothing;
        }
        let near = least / (greatest * SINGULAR * SINGULAR);
        let more = SINGULAR * SINGULAR * (1.0 - near).max(0.0);
        let damping = greatest * (self.damping * self.damping + more);
        let mut velocity = [0.0; INPUTS];
        for i in (0..INPUTS).filter(kept) {
            let along: f64 = vectors[i].iter().zip(&self.right).map(|(u, b)| u * b).sum();
            let below = values[i].max(0.0) + damping;
            // A motion without damping and without a response is not requested.
            if below > 1e-14 * greatest {
                for (v, u) in velocity.iter_mut().zip(&vectors[i]) {
                    *v += self.gain * along / below * u;
                }
            }
        }
        if !square(&velocity).is_finite() {
            return nothing;
        }
        Wish {
            velocity,
            condition: (greatest / least).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{coordinates, features};
    use crate::{Metric, Weights};
    use lariat_portable::SplitMix64;

    const SIZE: usize = 30;

    fn problem(random: &mut SplitMix64) -> (Jacobian, Weighing, Features, [[f64; 3]; SIZE / 2]) {
        let mut jacobian = Jacobian::ZERO;
        for column in &mut jacobian.columns {
            *column = features(random, SIZE);
        }
        let covariances = [(); SIZE / 2].map(|()| {
            let [a, b, c] = [(); 3].map(|()| random.uniform(-1.0, 1.0));
            [a * a + 0.5, a * b, b * b + c * c + 0.5]
        });
        let mut weighing = Weighing::new(&Metric::default(), SIZE / 2, 2);
        let taken = weighing.take(Weights::Covariances(&covariances), 1.0);
        assert!(taken.is_ok());
        (jacobian, weighing, features(random, SIZE), covariances)
    }

    /// The normal equations written out with the inverses of the covariances, solved by Gaussian
    /// elimination.
    fn reference(
        jacobian: &Jacobian,
        error: &Features,
        covariances: &[[f64; 3]; SIZE / 2],
        free: &[bool; INPUTS],
        damping: f64,
    ) -> Coordinates {
        let largest = covariances
            .iter()
            .map(|[xx, _, yy]| xx + yy)
            .fold(0.0, f64::max);
        let mut w = [[0.0; SIZE]; SIZE];
        let mut trace = 0.0;
        for (j, [xx, xy, yy]) in covariances.iter().enumerate() {
            let (xx, yy) = (xx + 0.005 * largest, yy + 0.005 * largest);
            let det = xx * yy - xy * xy;
            (w[2 * j][2 * j], w[2 * j + 1][2 * j + 1]) = (yy / det, xx / det);
            (w[2 * j][2 * j + 1], w[2 * j + 1][2 * j]) = (-xy / det, -xy / det);
            trace += (xx + yy) / det;
        }
        // The mean weight of a coordinate is 1, and there are SIZE / 2 points.
        let scale = SIZE as f64 / trace / (SIZE / 2) as f64;
        let j = |k: usize, i: usize| if free[i] { jacobian.columns[i][k] } else { 0.0 };
        let mut a = [[0.0; INPUTS + 1]; INPUTS];
        for (i, row) in a.iter_mut().enumerate() {
            for (k, w) in w.iter().enumerate() {
                for (l, w) in w.iter().enumerate() {
                    for (c, entry) in row[..INPUTS].iter_mut().enumerate() {
                        *entry += scale * j(k, i) * w * j(l, c);
                    }
                    row[INPUTS] += scale * j(k, i) * w * error[l];
                }
            }
            row[i] += if free[i] { damping } else { 1.0 };
        }
        gauss(a)
    }

    fn gauss(mut a: [[f64; INPUTS + 1]; INPUTS]) -> Coordinates {
        for k in 0..INPUTS {
            let pivot = (k..INPUTS).max_by(|i, j| a[*i][k].abs().total_cmp(&a[*j][k].abs()));
            a.swap(k, pivot.expect("not empty"));
            for i in (0..INPUTS).filter(|i| *i != k) {
                let from = a[k];
                let factor = a[i][k] / from[k];
                a[i].iter_mut()
                    .zip(from)
                    .for_each(|(a, from)| *a -= factor * from);
            }
        }
        std::array::from_fn(|i| a[i][INPUTS] / a[i][i])
    }

    /// The largest eigenvalue by power iteration, independent of the code under test.
    fn greatest(law: &Law, free: &[bool; INPUTS]) -> f64 {
        let mut vector = [1.0; INPUTS];
        let mut size = 0.0;
        for _ in 0..2000 {
            let next: Coordinates = std::array::from_fn(|i| {
                let row = law.matrix[i].iter().zip(&vector).map(|(a, v)| a * v);
                if free[i] { row.sum() } else { 0.0 }
            });
            size = square(&next).sqrt();
            vector = next.map(|v| v / size);
        }
        size
    }

    #[test]
    fn the_law_is_that_of_the_normal_equations_written_out() {
        let mut random = SplitMix64::new(3);
        for case in 0..100 {
            let (jacobian, weighing, error, covariances) = problem(&mut random);
            let mut free = [true; INPUTS];
            free[case % INPUTS] = case % 3 == 0;
            let law = Law::new(&jacobian, &weighing, &error, 2.0, 0.1);
            let wish = law.solve(&free);
            // Ensures that all damping is the requested one.
            assert!(wish.condition < 1.0 / SINGULAR, "well conditioned");
            let damping = 0.01 * greatest(&law, &free);
            let wanted = reference(&jacobian, &error, &covariances, &free, damping);
            for (given, wanted) in wish.velocity.into_iter().zip(wanted) {
                assert!((given - 2.0 * wanted).abs() < 1e-8, "{given} {wanted}");
            }
        }
    }

    #[test]
    fn without_damping_the_error_of_what_can_be_reached_falls_by_the_gain() {
        let mut random = SplitMix64::new(4);
        let (jacobian, weighing, ..) = problem(&mut random);
        let way = coordinates(&mut random);
        let law = Law::new(&jacobian, &weighing, &jacobian.times(&way), 3.0, 0.0);
        let wish = law.solve(&[true; INPUTS]);
        for (v, way) in wish.velocity.into_iter().zip(way) {
            assert!((v - 3.0 * way).abs() < 1e-9, "{v} {way}");
        }
    }

    #[test]
    fn near_a_singularity_damping_bounds_the_speed() {
        let mut random = SplitMix64::new(5);
        let (mut jacobian, weighing, error, _) = problem(&mut random);
        let plain = Law::new(&jacobian, &weighing, &error, 1.0, 0.0).solve(&[true; INPUTS]);
        for entry in &mut jacobian.columns[5] {
            *entry *= 1e-6;
        }
        let wish = Law::new(&jacobian, &weighing, &error, 1.0, 0.0).solve(&[true; INPUTS]);
        assert!(wish.condition > 1e5, "{}", wish.condition);
        let bound = square(&plain.velocity).sqrt() / SINGULAR;
        assert!(square(&wish.velocity).sqrt() < bound);
        assert!(wish.velocity[5].abs() < 1e-3, "{:?}", wish.velocity);
    }

    #[test]
    fn inputs_that_are_not_free_stand_still_and_the_others_do_their_work() {
        let mut random = SplitMix64::new(6);
        let (jacobian, weighing, ..) = problem(&mut random);
        let mut way = coordinates(&mut random);
        way.iter_mut().skip(1).step_by(3).for_each(|way| *way = 0.0);
        let free = std::array::from_fn(|input| input % 3 != 1);
        let law = Law::new(&jacobian, &weighing, &jacobian.times(&way), 1.0, 0.0);
        for (v, way) in law.solve(&free).velocity.into_iter().zip(way) {
            assert!((v - way).abs() < 1e-9, "{v} {way}");
        }
    }

    #[test]
    fn a_shape_that_does_not_answer_asks_for_nothing() {
        let weighing = Weighing::new(&Metric::default(), 3, 2);
        let error = features(&mut SplitMix64::new(7), 6);
        let law = Law::new(&Jacobian::ZERO, &weighing, &error, 1.0, 0.0);
        let wish = law.solve(&[true; INPUTS]);
        assert_eq!(wish.velocity, [0.0; INPUTS]);
        assert_eq!(wish.condition, f64::INFINITY);
    }
}

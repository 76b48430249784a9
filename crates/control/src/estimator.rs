//! Keeps `J` up to date by one of two rules.

use crate::jacobian::{Jacobian, square};
use crate::kalman::Kalman;
use crate::options::Estimator;
use crate::{Coordinates, Features, INPUTS, broyden};

/// The difference of two shapes, and of the grippers' positions at their exposures.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    /// Difference of the positions, px-like.
    pub(crate) dr: Coordinates,
    /// Difference of the shapes, px.
    pub(crate) ds: Features,
    /// Mean square distance caused by noise alone in `ds`, px².
    pub(crate) noise_px2: f64,
}

/// The rule and its state.
#[derive(Debug, Clone)]
pub(crate) enum Learner {
    Broyden { share: f64 },
    Kalman(Box<Kalman>),
}

impl Learner {
    pub(crate) fn new(estimator: Estimator) -> Self {
        match estimator {
            Estimator::Broyden { share } => Self::Broyden { share },
            Estimator::Kalman { drift } => Self::Kalman(Box::new(Kalman::new(drift))),
        }
    }

    /// Records that a column was measured again, with this variance ([`Pair::noise_px2`], a mean
    /// square, per px²).
    pub(crate) fn measured(&mut self, input: usize, variance: f64) {
        if let Self::Kalman(kalman) = self {
            kalman.measured(input, variance);
        }
    }

    /// Learns from a pair. A pair that would make an entry of `J` infinite or NaN has no effect.
    pub(crate) fn learn(&mut self, jacobian: &mut Jacobian, pair: &Pair) {
        let gain = match self {
            Self::Broyden { share } => broyden::gain(*share, &pair.dr),
            Self::Kalman(kalman) => kalman.gain(&pair.dr, pair.noise_px2),
        };
        let surprise = jacobian.surprise(&pair.dr, &pair.ds);
        // If any term is NaN, the sum is NaN and the comparison fails.
        let size: f64 = surprise.iter().map(|s| s * s).sum();
        if (size * square(&gain)).sqrt() < MOST_CHANGE {
            jacobian.add(&surprise, &gain);
        }
    }
}

/// Largest plausible change of `J`, px per px. A larger one means that the whole shape jumped
/// during a step of a few px.
const MOST_CHANGE: f64 = 100.0;

/// Zero for all inputs.
pub(crate) const NONE: Coordinates = [0.0; INPUTS];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::features;
    use lariat_portable::SplitMix64;

    const SIZE: usize = 18;

    fn truth(random: &mut SplitMix64) -> Jacobian {
        Jacobian {
            columns: [(); INPUTS].map(|()| features(random, SIZE)),
        }
    }

    fn error(a: &Jacobian, b: &Jacobian) -> f64 {
        let pairs = a
            .columns
            .as_flattened()
            .iter()
            .zip(b.columns.as_flattened());
        pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }

    /// Moves along one input after the other in steps of 5 px, with noise of this standard
    /// deviation in each coordinate of `δs`.
    fn steps(
        learner: &mut Learner,
        truth: &Jacobian,
        count: usize,
        noise_px: f64,
    ) -> Vec<Jacobian> {
        let mut random = SplitMix64::new(11);
        let mut jacobian = Jacobian::ZERO;
        let mut way = Vec::new();
        for step in 0..count {
            let mut dr = NONE;
            dr[step % INPUTS] = 5.0;
            let mut ds = truth.times(&dr);
            ds[..SIZE]
                .iter_mut()
                .for_each(|ds| *ds += noise_px * random.normal());
            // Noise per point: the mean of the squares of x and y together.
            let noise_px2 = 2.0 * noise_px * noise_px;
            learner.learn(&mut jacobian, &Pair { dr, ds, noise_px2 });
            way.push(jacobian.clone());
        }
        way
    }

    /// The error along each input falls by a factor of 1 − γ whenever the input moves.
    #[test]
    fn broydens_rule_converges_on_a_linear_map_as_its_share_says() {
        let truth = truth(&mut SplitMix64::new(1));
        let mut learner = Learner::new(Estimator::Broyden { share: 0.5 });
        let way = steps(&mut learner, &truth, 10 * INPUTS, 0.0);
        let begun = error(&Jacobian::ZERO, &truth);
        for turns in 1..=10 {
            let left = error(&way[turns * INPUTS - 1], &truth) / begun;
            assert!((left - 0.5f64.powi(turns as i32)).abs() < 1e-12, "{left}");
        }
    }

    /// Each entry follows `e ← (1 − γ)e + γ n/‖δr‖`, which has a variance of γ/(2 − γ) (σ/‖δr‖)².
    /// The mean is over 108 entries and 50 turns.
    #[test]
    fn noise_leaves_in_broydens_rule_what_it_must() {
        let truth = truth(&mut SplitMix64::new(1));
        let (share, sigma) = (0.5, 0.3);
        let mut learner = Learner::new(Estimator::Broyden { share });
        let way = steps(&mut learner, &truth, 70 * INPUTS, sigma);
        let late = &way[20 * INPUTS..];
        let mean = late.iter().map(|j| error(j, &truth).powi(2)).sum::<f64>()
            / (late.len() * SIZE * INPUTS) as f64;
        let wanted = share / (2.0 - share) * (sigma / 5.0f64).powi(2);
        // Some 108 · 50 · ⅓ independent squares have a standard deviation of 2.4 %. The bound is
        // five of these.
        assert!((mean / wanted - 1.0).abs() < 0.12, "{}", mean / wanted);
    }

    /// Without drift, the filter is least squares over all steps. The initial entries are 0 ± 1/√m
    /// (the mean square of a rope's response is 1). After k steps of 5 px along an input, the error
    /// has the variance σ²/(25 k), apart from the pull of the initial values.
    #[test]
    fn the_filter_converges_on_a_linear_map_as_least_squares_do() {
        let truth = truth(&mut SplitMix64::new(2));
        let mut learner = Learner::new(Estimator::Kalman { drift: 0.0 });
        let exact = steps(&mut learner, &truth, 2 * INPUTS, 0.0);
        assert!(error(&exact[2 * INPUTS - 1], &truth) < 1e-9);

        let sigma = 0.3;
        let mut learner = Learner::new(Estimator::Kalman { drift: 0.0 });
        let turns = 40;
        let way = steps(&mut learner, &truth, turns * INPUTS, sigma);
        let mean = error(&way[turns * INPUTS - 1], &truth).powi(2) / (SIZE * INPUTS) as f64;
        let wanted = sigma * sigma / (25.0 * turns as f64);
        // 108 squares have a standard deviation of 14 %. The bound is three of these, plus some
        // hundredths for the pull of the initial values.
        assert!((mean / wanted - 1.0).abs() < 0.45, "{}", mean / wanted);
    }

    #[test]
    fn the_filter_follows_a_rope_that_answers_otherwise_later() {
        let mut random = SplitMix64::new(3);
        let (before, after) = (truth(&mut random), truth(&mut random));
        let mut learner = Learner::new(Estimator::Kalman { drift: 0.3 });
        let mut jacobian = Jacobian::ZERO;
        for step in 0..80 * INPUTS {
            let truth = if step < 20 * INPUTS { &before } else { &after };
            let mut dr = NONE;
            dr[step % INPUTS] = 5.0;
            let mut ds = truth.times(&dr);
            ds[..SIZE]
                .iter_mut()
                .for_each(|ds| *ds += 0.1 * random.normal());
            let noise_px2 = 0.02;
            learner.learn(&mut jacobian, &Pair { dr, ds, noise_px2 });
        }
        assert!(error(&jacobian, &after) < 0.05 * error(&before, &after));
    }

    #[test]
    fn a_jump_of_the_shape_is_no_answer() {
        for estimator in [Estimator::BROYDEN, Estimator::default()] {
            let mut learner = Learner::new(estimator);
            let mut jacobian = Jacobian::ZERO;
            let mut dr = NONE;
            dr[0] = 2.0;
            for ds in [1e6, f64::INFINITY, f64::NAN] {
                let pair = Pair {
                    dr,
                    ds: [ds; crate::MAX_FEATURES],
                    noise_px2: 0.1,
                };
                learner.learn(&mut jacobian, &pair);
            }
            assert_eq!(jacobian, Jacobian::ZERO);
        }
    }
}

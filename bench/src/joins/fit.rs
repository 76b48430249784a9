//! The most likely weights.

use lariat_extract::FEATURES;

/// Number of features.
const COUNT: usize = FEATURES.len();
/// Features with weights that are set by hand. Stills have too few touching strands, ends, rings and
/// priors to learn from: with fitted weights, more films are wrong. Shadows, which differ from their
/// ropes in color, are not in the true masks.
const HELD: [&str; 9] = [
    "color",
    "sides",
    "prior",
    "prior end",
    "end",
    "two in narrow",
    "ring",
    "end of one",
    "S-bend",
];
/// Cost of a change of all weights by themselves, which keeps a weight that no picture depends on.
const RIDGE: f64 = 0.003;
/// Steps of the descent (Adam, Kingma and Ba 2015, with its usual constants), and its first rate
/// relative to each weight.
const STEPS: i32 = 2000;
const RATE: f64 = 0.02;
/// Minimum scale of a weight.
const SCALE: f64 = 0.5;

pub(super) fn is_held(feature: usize) -> bool {
    HELD.contains(&FEATURES[feature].0)
}

/// Alternatives of one cluster: sums of features, and numbers of errors.
pub(super) struct Cluster {
    pub(super) name: &'static str,
    pub(super) seed: u64,
    alternatives: Vec<([f32; COUNT], usize)>,
}

impl Cluster {
    pub(super) fn new(name: &'static str, seed: u64) -> Self {
        Self {
            name,
            seed,
            alternatives: Vec::new(),
        }
    }

    /// Adds an alternative. If features cannot distinguish two, the better one counts.
    pub(super) fn push(&mut self, features: [f32; COUNT], errors: usize) {
        let is_same =
            |of: &[f32; COUNT]| of.iter().zip(features).all(|(a, b)| (a - b).abs() < 1e-4);
        match (self.alternatives.iter_mut()).find(|(of, _)| is_same(of)) {
            Some((_, least)) => *least = errors.min(*least),
            None => self.alternatives.push((features, errors)),
        }
    }

    /// True if the right assignment is among the alternatives.
    pub(super) fn is_solvable(&self) -> bool {
        self.alternatives.iter().any(|(_, errors)| *errors == 0)
    }
}

#[derive(Clone)]
pub(super) struct Weights(pub(super) [f64; COUNT]);

impl Weights {
    /// The weights in use.
    pub(super) fn now() -> Self {
        Self(FEATURES.map(|(_, weight)| f64::from(weight)))
    }

    fn cost(&self, features: &[f32; COUNT]) -> f64 {
        let terms = self.0.iter().zip(features);
        terms
            .map(|(weight, value)| weight * f64::from(*value))
            .sum()
    }

    /// True if the cheapest alternative is right.
    pub(super) fn resolves(&self, cluster: &Cluster) -> bool {
        let cost = |of: &&([f32; COUNT], usize)| self.cost(&of.0);
        (cluster.alternatives.iter())
            .min_by(|a, b| cost(a).total_cmp(&cost(b)))
            .is_some_and(|(_, errors)| *errors == 0)
    }

    /// Maximizes the probability of the right alternatives. No weight gets negative: each feature
    /// speaks against.
    pub(super) fn fit(&self, clusters: &[&Cluster]) -> Self {
        let solvable: Vec<_> = clusters.iter().filter(|of| of.is_solvable()).collect();
        let mut weights = self.clone();
        let (mut mean, mut square) = ([0.0; COUNT], [0.0; COUNT]);
        for step in 1..=STEPS {
            let mut gradient = [0.0; COUNT];
            solvable
                .iter()
                .for_each(|of| weights.slope(of, &mut gradient));
            let rate = RATE * (1.0 - f64::from(step - 1) / f64::from(STEPS));
            for k in (0..COUNT).filter(|&k| !is_held(k)) {
                let scale = self.0[k].max(SCALE);
                let ridge = 2.0 * RIDGE * (weights.0[k] - self.0[k]) / scale;
                let slope = scale * gradient[k] / solvable.len() as f64 + ridge;
                mean[k] = 0.9 * mean[k] + 0.1 * slope;
                square[k] = 0.999 * square[k] + 0.001 * slope * slope;
                let ahead = mean[k] / (1.0 - 0.9_f64.powi(step));
                let size = (square[k] / (1.0 - 0.999_f64.powi(step))).sqrt();
                let weight = &mut weights.0[k];
                *weight = (*weight - rate * scale * ahead / (size + 1e-9)).max(0.0);
            }
        }
        weights
    }

    /// Adds a cluster's derivative of −log(probability that the alternative taken is right).
    fn slope(&self, cluster: &Cluster, gradient: &mut [f64; COUNT]) {
        let costs: Vec<f64> = (cluster.alternatives.iter())
            .map(|(features, _)| self.cost(features))
            .collect();
        let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
        let odds = |k: usize| (least - costs[k]).exp();
        let is_right = |k: usize| cluster.alternatives[k].1 == 0;
        let all: f64 = (0..costs.len()).map(odds).sum();
        let right: f64 = (0..costs.len()).filter(|&k| is_right(k)).map(odds).sum();
        for (k, (features, _)) in cluster.alternatives.iter().enumerate() {
            let share = if is_right(k) {
                odds(k) / right.max(1e-12)
            } else {
                0.0
            };
            let excess = share - odds(k) / all;
            for (sum, value) in gradient.iter_mut().zip(features) {
                *sum += excess * f64::from(*value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feature_of_wrong_alternatives_gains_weight() {
        let feature = (0..COUNT).find(|&k| !is_held(k)).unwrap();
        let mut cluster = Cluster::new("drawn", 0);
        let mut wrong = [0.0; COUNT];
        wrong[feature] = 1.0;
        cluster.push(wrong, 1);
        cluster.push([0.0; COUNT], 0);
        let fitted = Weights::now().fit(&[&cluster]);
        assert!(fitted.0[feature] > Weights::now().0[feature]);
        assert!(fitted.resolves(&cluster) && cluster.is_solvable());
    }
}

//! Logistic regression by Newton's method, and the reliability of its probabilities.

use lariat_extract::Evidence;
use std::fmt::Write;

use crate::reliability::Reliability;

const CLUES: usize = Evidence::MEANINGS.len();
/// Regularization of the weights. A clue without influence gets a weight of 0.
const RIDGE: f64 = 0.1;
const ROUNDS: usize = 30;

/// A judged curve.
pub(super) struct Example {
    pub(super) evidence: Evidence,
    pub(super) is_right: bool,
    pub(super) is_fitted: bool,
}

/// One weight per clue.
pub(super) struct Weights([f64; CLUES]);

impl Weights {
    /// Fits the most likely weights. A clue whose weight would contradict its sign in
    /// [`Evidence::MEANINGS`] gets a weight of 0.
    pub(super) fn fit(examples: &[&Example]) -> Self {
        let mut is_silent = [false; CLUES];
        loop {
            let weights = Self::fit_those(examples, is_silent);
            let signs = weights.0.iter().zip(Evidence::MEANINGS);
            let is_opposite = |(weight, (_, sign)): (&f64, (_, i8))| weight * f64::from(sign) < 0.0;
            let opposite: Vec<bool> = signs.map(is_opposite).collect();
            if !opposite.contains(&true) {
                return weights;
            }
            let all = is_silent.iter_mut().zip(opposite);
            all.for_each(|(is_silent, is_opposite)| *is_silent |= is_opposite);
        }
    }

    fn fit_those(examples: &[&Example], is_silent: [bool; CLUES]) -> Self {
        let mut weights = Self([0.0; CLUES]);
        for _ in 0..ROUNDS {
            let mut bend = [[0.0; CLUES]; CLUES];
            let mut slope = weights.0.map(|weight| -RIDGE * weight);
            (0..CLUES).for_each(|i| bend[i][i] = RIDGE);
            for example in examples {
                let mut terms = example.evidence.clues.map(f64::from);
                let p = weights.probability(example);
                let silent = terms.iter_mut().zip(is_silent).filter(|(_, is)| *is);
                silent.for_each(|(term, _)| *term = 0.0);
                let off = f64::from(u8::from(example.is_right)) - p;
                for i in 0..CLUES {
                    slope[i] += off * terms[i];
                    for j in 0..CLUES {
                        bend[i][j] += p * (1.0 - p) * terms[i] * terms[j];
                    }
                }
            }
            let step = solve(bend, slope);
            (0..CLUES).for_each(|i| weights.0[i] += step[i]);
        }
        weights
    }

    fn probability(&self, example: &Example) -> f64 {
        let clues = example.evidence.clues.iter().zip(&self.0);
        let sum: f64 = clues.map(|(&clue, weight)| f64::from(clue) * weight).sum();
        1.0 / (1.0 + libm::exp(-sum))
    }

    /// Formats the weights as source code of the extractor.
    pub(super) fn as_rust(&self, name: &str) -> String {
        let mut text = format!("pub(super) const {name}: [f32; CLUES] = [\n");
        for (weight, (clue, _)) in self.0.iter().zip(Evidence::MEANINGS) {
            let _ = writeln!(text, "    {weight:.3}, // {clue}");
        }
        text + "];\n"
    }

    /// Returns the reliability of the probabilities for these examples.
    pub(super) fn reliability(&self, examples: &[&Example]) -> Reliability {
        let mut reliability = Reliability::default();
        for example in examples {
            reliability.add(self.probability(example), example.is_right);
        }
        reliability
    }
}

/// Solves `matrix · x = right` by elimination. The matrix is symmetric and positive definite.
fn solve(mut matrix: [[f64; CLUES]; CLUES], mut right: [f64; CLUES]) -> [f64; CLUES] {
    for i in 0..CLUES {
        let pivot = matrix[i];
        for k in i + 1..CLUES {
            let share = matrix[k][i] / pivot[i];
            (i..CLUES).for_each(|j| matrix[k][j] -= share * pivot[j]);
            right[k] -= share * right[i];
        }
    }
    for i in (0..CLUES).rev() {
        let known: f64 = (i + 1..CLUES).map(|j| matrix[i][j] * right[j]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_extract::Maker;

    /// Returns the index of a clue that can only support a curve.
    fn speaks_for() -> usize {
        let only_for = |meaning: &(&str, i8)| meaning.1 == 1;
        Evidence::MEANINGS.iter().position(only_for).unwrap()
    }

    /// Returns twenty curves with a clue that can only support them, and twenty without. The
    /// arguments are the numbers of right curves among them.
    fn examples([with, without]: [usize; 2]) -> Vec<Example> {
        let example = |clue: f32, is_right: bool| {
            let mut clues = [0.0; CLUES];
            (clues[0], clues[speaks_for()]) = (1.0, clue);
            Example {
                evidence: Evidence {
                    clues,
                    maker: Maker::Own,
                },
                is_right,
                is_fitted: true,
            }
        };
        let of = |i: usize| match i % 2 {
            0 => example(1.0, i / 2 % 20 < with),
            _ => example(0.0, i / 2 % 20 < without),
        };
        (0..2000).map(of).collect()
    }

    #[test]
    fn probabilities_of_a_known_law_are_found_again() {
        let examples = examples([18, 6]);
        let examples: Vec<_> = examples.iter().collect();
        let weights = Weights::fit(&examples);
        assert!((weights.probability(examples[0]) - 0.9).abs() < 0.01);
        assert!((weights.probability(examples[1]) - 0.3).abs() < 0.01);
        assert!(weights.reliability(&examples).error() < 0.005);
    }

    #[test]
    fn a_clue_never_says_the_opposite_of_what_it_is_for() {
        let examples = examples([6, 18]);
        let examples: Vec<_> = examples.iter().collect();
        let weights = Weights::fit(&examples);
        assert_eq!(weights.0[speaks_for()], 0.0);
        for example in &examples[..2] {
            assert!((weights.probability(example) - 0.6).abs() < 0.01);
        }
    }
}

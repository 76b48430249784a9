//! Logistic regression by Newton's method, and how true its probabilities are.

use lariat_extract::Evidence;
use std::fmt::Write;

use crate::reliability::Reliability;

const CLUES: usize = Evidence::NAMES.len();
/// What is fitted: a weight for each clue, and how much seldomer right curves are in labelled pictures than in drawn ones, which says nothing
/// of a curve.
const TERMS: usize = CLUES + 1;
/// The weights' own cost: a clue that nothing depends on has none.
const RIDGE: f64 = 0.1;
const ROUNDS: usize = 30;

/// A curve that was judged.
pub(super) struct Example {
    pub(super) evidence: Evidence,
    pub(super) is_right: bool,
    pub(super) is_fitted: bool,
    /// Whether its picture came with a label, from pictures that may be easier or harder than drawn ones.
    pub(super) is_labelled: bool,
}

impl Example {
    fn terms(&self) -> [f64; TERMS] {
        let mut terms = [0.0; TERMS];
        for (term, &clue) in terms.iter_mut().zip(&self.evidence.clues) {
            *term = clue.into();
        }
        terms[CLUES] = u8::from(self.is_labelled).into();
        terms
    }
}

/// A weight for each clue.
pub(super) struct Weights([f64; TERMS]);

impl Weights {
    /// The most likely ones.
    pub(super) fn fit(examples: &[&Example]) -> Self {
        let mut weights = Self([0.0; TERMS]);
        for _ in 0..ROUNDS {
            let mut bend = [[0.0; TERMS]; TERMS];
            let mut slope = weights.0.map(|weight| -RIDGE * weight);
            (0..TERMS).for_each(|i| bend[i][i] = RIDGE);
            for example in examples {
                let (terms, p) = (example.terms(), weights.probability(example));
                let off = f64::from(u8::from(example.is_right)) - p;
                for i in 0..TERMS {
                    slope[i] += off * terms[i];
                    for j in 0..TERMS {
                        bend[i][j] += p * (1.0 - p) * terms[i] * terms[j];
                    }
                }
            }
            let step = solve(bend, slope);
            (0..TERMS).for_each(|i| weights.0[i] += step[i]);
        }
        weights
    }

    fn probability(&self, example: &Example) -> f64 {
        let sum: f64 = example
            .terms()
            .iter()
            .zip(&self.0)
            .map(|(x, w)| x * w)
            .sum();
        1.0 / (1.0 + libm::exp(-sum))
    }

    /// As the extractor has them.
    pub(super) fn as_rust(&self, name: &str) -> String {
        let mut text = format!("pub(super) const {name}: [f32; CLUES] = [\n");
        for (weight, clue) in self.0.iter().zip(Evidence::NAMES) {
            let _ = writeln!(text, "    {weight:.3}, // {clue}");
        }
        text + "];\n"
    }

    /// How true what it says is of these.
    pub(super) fn reliability(&self, examples: &[&Example]) -> Reliability {
        let mut reliability = Reliability::default();
        for example in examples {
            reliability.add(self.probability(example), example.is_right);
        }
        reliability
    }
}

/// The solution of `matrix · x = right`, by elimination: the matrix is symmetric and positive.
fn solve(mut matrix: [[f64; TERMS]; TERMS], mut right: [f64; TERMS]) -> [f64; TERMS] {
    for i in 0..TERMS {
        let pivot = matrix[i];
        for k in i + 1..TERMS {
            let share = matrix[k][i] / pivot[i];
            (i..TERMS).for_each(|j| matrix[k][j] -= share * pivot[j]);
            right[k] -= share * right[i];
        }
    }
    for i in (0..TERMS).rev() {
        let known: f64 = (i + 1..TERMS).map(|j| matrix[i][j] * right[j]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_extract::Maker;

    #[test]
    fn probabilities_of_a_known_law_are_found_again() {
        // Of curves with the first clue nine of ten are right, of those without three of ten.
        let example = |clue: f32, is_right: bool| {
            let mut clues = [0.0; CLUES];
            (clues[0], clues[1]) = (1.0, clue);
            Example {
                evidence: Evidence {
                    clues,
                    maker: Maker::Own,
                },
                is_right,
                is_fitted: true,
                is_labelled: false,
            }
        };
        let examples: Vec<_> = (0..2000)
            .map(|i| match i % 2 {
                0 => example(1.0, i % 20 != 0),
                _ => example(0.0, i % 20 < 6),
            })
            .collect();
        let examples: Vec<_> = examples.iter().collect();
        let weights = Weights::fit(&examples);
        assert!((weights.probability(examples[0]) - 0.9).abs() < 0.01);
        assert!((weights.probability(examples[1]) - 0.3).abs() < 0.01);
        assert!(weights.reliability(&examples).error() < 0.005);
    }
}

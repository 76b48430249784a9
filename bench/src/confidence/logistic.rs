//! Multinomial logistic regression by Newton's method, with classes that may be known in part, and
//! the reliability of its probabilities.

use lariat_extract::{Class, Evidence, Maker};
use std::fmt::Write;

use crate::reliability::Reliability;

const CLUES: usize = Evidence::MEANINGS.len();
/// Number of classes, with [`Class::Rope`] first.
const CLASSES: usize = 1 + Class::OTHERS.len();
/// Regularization of the weights. A clue without influence gets a weight of 0.
const RIDGE: f64 = 0.1;
const ROUNDS: usize = 60;
/// Number of times that a step is halved until it makes the examples more likely.
const HALVINGS: usize = 12;
/// Minimum value of a clue for a thing to have this property.
const SOME: f32 = 0.3;
/// Minimum gain of log-likelihood per round.
const GAIN: f64 = 1e-3;

/// The classes that a judged curve may have, as far as known: a rope, then [`Class::OTHERS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Label([bool; CLASSES]);

impl Label {
    /// Returns the label of a class.
    pub(super) fn of(class: Class) -> Self {
        let mut label = [class == Class::Rope; CLASSES];
        label[1..]
            .iter_mut()
            .zip(Class::OTHERS)
            .for_each(|(is, other)| *is = other == class);
        Self(label)
    }

    /// Returns the label of a thing: a curve off every rope. Only a round one may be a rim, only a
    /// straight one a pen or an edge, and only a dim one a shadow.
    pub(super) fn of_thing(evidence: &Evidence) -> Self {
        let clue = |name: &str| {
            let found = Evidence::MEANINGS.iter().position(|clue| clue.0 == name);
            evidence.clues[found.expect("a clue of this name")]
        };
        let is_straight = clue("straight") > SOME;
        let mut label = [false; CLASSES];
        for (is, other) in label[1..].iter_mut().zip(Class::OTHERS) {
            *is = match other {
                Class::Mark => true,
                Class::Shadow => {
                    let is_dim = clue("the table in less light") > SOME;
                    is_dim || clue("a copy of the ropes in less light") > SOME
                }
                Class::Pen => is_straight,
                Class::Edge => is_straight || clue("along the border") > SOME,
                Class::Rim => clue("an arc of a circle") > SOME,
                Class::Rope | Class::Fragment => false,
            };
        }
        Self(label)
    }

    /// Returns the label with only the classes of a maker's masks.
    pub(super) fn for_maker(self, maker: Maker) -> Self {
        match self {
            Self([false, rest @ ..]) if !maker.others().iter().zip(rest).any(|(_, is)| is) => {
                Self::of(Class::Fragment)
            }
            _ => self,
        }
    }

    /// Returns whether the curve is a rope.
    pub(super) fn is_right(self) -> bool {
        self.0[0]
    }

    /// Returns the names of the possible classes.
    pub(super) fn name(self) -> String {
        let classes = [Class::Rope].into_iter().chain(Class::OTHERS);
        let possible = classes.zip(self.0).filter(|(_, is)| *is);
        let names: Vec<_> = possible.map(|(class, _)| format!("{class:?}")).collect();
        names.join("|")
    }
}

/// A judged curve.
pub(super) struct Example {
    pub(super) evidence: Evidence,
    pub(super) label: Label,
    pub(super) is_fitted: bool,
}

impl Example {
    pub(super) fn is_right(&self) -> bool {
        self.label.is_right()
    }
}

/// One weight per clue for each class but the rope: its odds against a rope are the exponential of
/// the weighted sum of clues.
pub(super) struct Weights(Vec<[f64; CLUES]>);

impl Weights {
    /// Fits the most likely weights. A weight that would contradict its clue's sign in
    /// [`Evidence::MEANINGS`] becomes 0.
    pub(super) fn fit(examples: &[&Example], classes: usize) -> Self {
        let mut is_silent = vec![[false; CLUES]; classes];
        loop {
            let weights = Self::fit_those(examples, &is_silent);
            let mut found = false;
            for (row, silent) in weights.0.iter().zip(&mut is_silent) {
                let clues = row.iter().zip(Evidence::MEANINGS).zip(silent);
                for ((weight, (_, sign)), is_silent) in clues {
                    // Evidence for a rope is evidence against each other class.
                    if weight * f64::from(sign) > 0.0 {
                        (*is_silent, found) = (true, true);
                    }
                }
            }
            if !found {
                return weights;
            }
        }
    }

    fn fit_those(examples: &[&Example], is_silent: &[[bool; CLUES]]) -> Self {
        let classes = is_silent.len();
        let size = classes * CLUES;
        let mut weights = Self(vec![[0.0; CLUES]; classes]);
        let mut likelihood = weights.likelihood(examples);
        for _ in 0..ROUNDS {
            let mut bend = vec![vec![0.0; size]; size];
            let mut slope: Vec<f64> = weights
                .0
                .iter()
                .flatten()
                .map(|weight| -RIDGE * weight)
                .collect();
            (0..size).for_each(|i| bend[i][i] = RIDGE);
            for example in examples {
                let p = weights.probabilities(example);
                let known: f64 = p
                    .iter()
                    .zip(example.label.0)
                    .map(|(p, is)| if is { *p } else { 0.0 })
                    .sum();
                let terms = example.evidence.clues.map(f64::from);
                for a in 0..classes {
                    // The class's probability, given what is known.
                    let goal = match example.label.0[1 + a] {
                        true => p[1 + a] / known.max(1e-12),
                        false => 0.0,
                    };
                    let off = goal - p[1 + a];
                    for i in 0..CLUES {
                        slope[a * CLUES + i] += off * terms[i];
                    }
                    for b in 0..=a {
                        let same = if a == b { p[1 + a] } else { 0.0 };
                        let share = same - p[1 + a] * p[1 + b];
                        if share.abs() < 1e-7 {
                            continue;
                        }
                        for i in 0..CLUES {
                            let row = &mut bend[a * CLUES + i][b * CLUES..(b + 1) * CLUES];
                            let by = share * terms[i];
                            row.iter_mut()
                                .zip(&terms)
                                .for_each(|(sum, term)| *sum += by * term);
                        }
                    }
                }
            }
            for (i, is_silent) in is_silent.iter().flatten().enumerate() {
                if *is_silent {
                    bend[i].fill(0.0);
                    bend[i..].iter_mut().for_each(|row| row[i] = 0.0);
                    (bend[i][i], slope[i]) = (1.0, 0.0);
                }
            }
            let step = solve(bend, slope);
            let mut share = 1.0;
            let mut gain = 0.0;
            for _ in 0..HALVINGS {
                let rows = weights.0.iter().zip(step.chunks(CLUES));
                let tried = Self(
                    rows.map(|(row, step)| std::array::from_fn(|i| row[i] + share * step[i]))
                        .collect(),
                );
                let now = tried.likelihood(examples);
                if now > likelihood {
                    gain = now - likelihood;
                    (weights, likelihood) = (tried, now);
                    break;
                }
                share *= 0.5;
            }
            if gain < GAIN {
                break;
            }
        }
        weights
    }

    /// Returns the logarithm of the probability of the examples' labels, less the regularization.
    fn likelihood(&self, examples: &[&Example]) -> f64 {
        let of_one = |example: &&Example| {
            let p = self.probabilities(example);
            let known = p.iter().zip(example.label.0).filter(|(_, is)| *is);
            libm::log(known.map(|(p, _)| p).sum::<f64>().max(1e-300))
        };
        let squares: f64 = self.0.iter().flatten().map(|weight| weight * weight).sum();
        examples.iter().map(of_one).sum::<f64>() - 0.5 * RIDGE * squares
    }

    /// Returns the probability of each class.
    fn probabilities(&self, example: &Example) -> [f64; CLASSES] {
        let mut odds = [0.0; CLASSES];
        odds[0] = 1.0;
        for (odds, row) in odds[1..].iter_mut().zip(&self.0) {
            let clues = example.evidence.clues.iter().zip(row);
            let sum: f64 = clues.map(|(&clue, weight)| f64::from(clue) * weight).sum();
            *odds = libm::exp(sum.min(300.0));
        }
        let all: f64 = odds.iter().sum();
        odds.map(|odds| odds / all)
    }

    /// Formats the weights as source code of the extractor.
    pub(super) fn as_rust(&self, name: &str) -> String {
        let count = self.0.len();
        let mut text =
            format!("\n#[rustfmt::skip]\npub(super) const {name}: [[f32; CLUES]; {count}] = [\n");
        for (row, class) in self.0.iter().zip(Class::OTHERS) {
            let _ = writeln!(text, "    // {class:?}\n    [");
            for (weight, (clue, _)) in row.iter().zip(Evidence::MEANINGS) {
                let _ = writeln!(text, "        {weight:.3}, // {clue}");
            }
            text += "    ],\n";
        }
        text + "];\n"
    }

    /// Returns the reliability of the probabilities for these examples.
    pub(super) fn reliability(&self, examples: &[&Example]) -> Reliability {
        let mut reliability = Reliability::default();
        for example in examples {
            reliability.add(self.probabilities(example)[0], example.is_right());
        }
        reliability
    }
}

/// Solves `matrix · x = right` by elimination. The matrix is symmetric and positive definite; only
/// its lower triangle is read.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let size = right.len();
    // Cholesky: L · Lᵀ in place.
    for i in 0..size {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            let rest = matrix[i][j] - sum;
            matrix[i][j] = match i == j {
                true => rest.max(1e-12).sqrt(),
                false => rest / matrix[j][j],
            };
        }
    }
    for i in 0..size {
        let known: f64 = (0..i).map(|k| matrix[i][k] * right[k]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    for i in (0..size).rev() {
        let known: f64 = (i + 1..size).map(|k| matrix[k][i] * right[k]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the index of a clue that can only support a curve.
    fn speaks_for() -> usize {
        let only_for = |meaning: &(&str, i8)| meaning.1 == 1;
        Evidence::MEANINGS.iter().position(only_for).unwrap()
    }

    fn example(clue: f32, label: Label) -> Example {
        let mut clues = [0.0; CLUES];
        (clues[0], clues[speaks_for()]) = (1.0, clue);
        Example {
            evidence: Evidence {
                clues,
                maker: Maker::Own,
            },
            label,
            is_fitted: true,
        }
    }

    /// Returns twenty curves with a clue that can only support them, and twenty without. The
    /// arguments are the numbers of right curves among them.
    fn examples([with, without]: [usize; 2]) -> Vec<Example> {
        let of_class = |is_right| match is_right {
            true => Label::of(Class::Rope),
            false => Label::of(Class::Fragment),
        };
        let of = |i: usize| match i % 2 {
            0 => example(1.0, of_class(i / 2 % 20 < with)),
            _ => example(0.0, of_class(i / 2 % 20 < without)),
        };
        (0..2000).map(of).collect()
    }

    #[test]
    fn probabilities_of_a_known_law_are_found_again() {
        let examples = examples([18, 6]);
        let examples: Vec<_> = examples.iter().collect();
        let weights = Weights::fit(&examples, 1);
        assert!((weights.probabilities(examples[0])[0] - 0.9).abs() < 0.01);
        assert!((weights.probabilities(examples[1])[0] - 0.3).abs() < 0.01);
        assert!(weights.reliability(&examples).error() < 0.005);
    }

    #[test]
    fn a_clue_never_says_the_opposite_of_what_it_is_for() {
        let examples = examples([6, 18]);
        let examples: Vec<_> = examples.iter().collect();
        let weights = Weights::fit(&examples, 1);
        assert_eq!(weights.0[0][speaks_for()], 0.0);
        for example in &examples[..2] {
            assert!((weights.probabilities(example)[0] - 0.6).abs() < 0.01);
        }
    }

    /// A thing of unknown kind is likely of the kind that has its looks.
    #[test]
    fn a_class_that_is_known_in_part_is_learned_from_those_that_are_known() {
        let at = |i: usize| f32::from(u8::from(i.is_multiple_of(2)));
        let mut straight = example(0.0, Label::of(Class::Pen));
        let clue = Evidence::MEANINGS
            .iter()
            .position(|(name, _)| *name == "straight");
        straight.evidence.clues[clue.expect("a clue")] = 1.0;
        let label = |i: usize| match (i % 10 < 4, i % 2) {
            (true, 0) => Label::of(Class::Pen),
            (true, _) => Label::of(Class::Mark),
            (false, _) => Label::of_thing(&straight.evidence),
        };
        let border = Evidence::MEANINGS
            .iter()
            .position(|(name, _)| *name == "ends at the border");
        let border = border.expect("a clue without a sign");
        let examples: Vec<_> = (0..2000)
            .map(|i| {
                let mut example = example(0.0, label(i));
                example.evidence.clues[border] = at(i);
                example
            })
            .collect();
        let examples: Vec<_> = examples.iter().collect();
        let weights = Weights::fit(&examples, Class::OTHERS.len());
        let place = |class| {
            1 + Class::OTHERS
                .iter()
                .position(|other| *other == class)
                .unwrap()
        };
        let p = [0, 1].map(|i| weights.probabilities(examples[i]));
        assert!(p[0][place(Class::Pen)] > 0.9, "{p:?}");
        assert!(p[1][place(Class::Mark)] > 0.9, "{p:?}");
    }
}

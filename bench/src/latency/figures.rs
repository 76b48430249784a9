//! Results: the figures of each measured item, round by round, and all its durations together.

use lariat_plot::spread::quantile;
use lariat_sink::Times;

/// Kinds of measured items.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    /// A lower bound for every chain on this machine.
    Floor,
    /// lariat.
    Chain,
    /// Another system with the same task.
    Rival,
}

impl Group {
    /// Returns the name in `summary.json`.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Floor => "floor",
            Self::Chain => "chain",
            Self::Rival => "rival",
        }
    }
}

/// Result of one round of one item.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    /// Figures by name. The name ends in the unit.
    pub(super) figures: Vec<(&'static str, f64)>,
    /// All durations.
    pub(super) times: Option<Times>,
    /// Versions of the measured software.
    pub(super) versions: String,
}

impl Outcome {
    /// Creates an outcome from durations and their percentiles.
    pub(super) fn of_times(times: Times) -> Self {
        let mut outcome = Self::default();
        outcome.add_percentiles(WHOLE, &times);
        outcome.times = Some(times);
        outcome
    }

    /// Adds percentiles under these names. Omits a percentile with no duration beyond it, which
    /// would only repeat the maximum.
    pub(super) fn add_percentiles<const N: usize>(
        &mut self,
        names: [(&'static str, f64); N],
        times: &Times,
    ) {
        for (name, quantile) in names {
            let beyond = (1.0 - quantile) * times.count() as f64;
            // In floating point, 0.1 % of 1000 is 0.9999….
            if quantile == 1.0 || beyond > 0.999 {
                self.figures
                    .extend(times.quantile_us(quantile).map(|us| (name, us)));
            }
        }
    }
}

/// The percentiles of the whole duration.
const WHOLE: [(&str, f64); 4] = [
    ("p50_us", 0.5),
    ("p99_us", 0.99),
    ("p999_us", 0.999),
    ("max_us", 1.0),
];

/// A figure, round by round.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figure {
    pub name: String,
    pub rounds: Vec<f64>,
}

impl Figure {
    /// Returns the median of the rounds. If their number is even, this is the mean of the two in
    /// the middle.
    pub(super) fn median(&self) -> f64 {
        let mut sorted = self.rounds.clone();
        sorted.sort_by(f64::total_cmp);
        quantile(&sorted, 0.5)
    }

    /// Returns the lowest and the highest value among the rounds.
    pub(super) fn range(&self) -> (f64, f64) {
        let fold = |f: fn(f64, f64) -> f64| self.rounds.iter().copied().reduce(f);
        (
            fold(f64::min).unwrap_or(f64::NAN),
            fold(f64::max).unwrap_or(f64::NAN),
        )
    }
}

/// A measured item.
#[derive(Debug)]
pub(super) struct Item {
    /// Name for programs, the same in every run: `chain.640x480@120`.
    pub(super) id: String,
    pub(super) group: Group,
    /// Name for people.
    pub(super) title: String,
    /// Basis of the comparison: bytes, hops, copies.
    pub(super) note: &'static str,
    pub(super) figures: Vec<Figure>,
    /// The durations of all rounds.
    pub(super) times: Option<Times>,
    pub(super) versions: String,
    /// The reason why figures are missing.
    pub(super) missing: Option<String>,
}

impl Item {
    pub(super) fn new(id: String, group: Group, title: String, note: &'static str) -> Self {
        Self {
            id,
            group,
            title,
            note,
            figures: Vec::new(),
            times: None,
            versions: String::new(),
            missing: None,
        }
    }

    /// Adds one round.
    pub(super) fn add(&mut self, outcome: Outcome) {
        for (name, value) in outcome.figures {
            self.add_figure(name, value);
        }
        if let Some(times) = outcome.times {
            self.times.get_or_insert_default().merge(&times);
        }
        self.versions = outcome.versions;
    }

    pub(super) fn add_figure(&mut self, name: &str, value: f64) {
        match self.figures.iter_mut().find(|figure| figure.name == name) {
            Some(figure) => figure.rounds.push(value),
            None => self.figures.push(Figure {
                name: name.to_owned(),
                rounds: vec![value],
            }),
        }
    }

    pub(super) fn figure(&self, name: &str) -> Option<&Figure> {
        self.figures.iter().find(|figure| figure.name == name)
    }

    /// Returns a figure's median.
    pub(super) fn median(&self, name: &str) -> Option<f64> {
        self.figure(name).map(Figure::median)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(rounds: &[f64]) -> Figure {
        Figure {
            name: "p50_us".to_owned(),
            rounds: rounds.to_vec(),
        }
    }

    #[test]
    fn a_round_that_was_disturbed_does_not_move_the_median() {
        assert_eq!(figure(&[3.0, 900.0, 2.0]).median(), 3.0);
        assert_eq!(figure(&[1.0, 2.0, 4.0, 900.0]).median(), 3.0);
        assert_eq!(figure(&[3.0, 900.0, 2.0]).range(), (2.0, 900.0));
        assert!(figure(&[]).median().is_nan());
    }

    #[test]
    fn rounds_add_up_to_one_heap_and_keep_their_own_figures() {
        let mut item = Item::new("floor.x".into(), Group::Floor, "x".into(), "");
        for us in [10, 30, 20] {
            let mut times = Times::default();
            (0..100).for_each(|_| times.add(us * 1000));
            item.add(Outcome::of_times(times));
        }
        assert_eq!(item.median("p50_us"), Some(20.0));
        let heap = item.times.as_ref().expect("durations");
        assert_eq!(heap.count(), 300);
        assert_eq!(heap.quantile_us(1.0), Some(30.0));
        assert_eq!(item.median("nothing"), None);
        // A hundred durations have a p99, but no p999.
        assert_eq!(item.median("p99_us"), Some(20.0));
        assert_eq!(item.median("p999_us"), None);
    }
}

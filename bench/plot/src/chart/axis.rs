//! An axis: its scale, its range and its ticks.

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use std::ops::Range;

use crate::words::{digits, raised};

#[derive(Debug, Clone, PartialEq)]
enum Scale {
    Linear {
        step: f64,
    },
    Log,
    /// Places a quantile q at 1/(1 − q), logarithmically.
    Nines,
    Names(Vec<String>),
}

/// An axis of numbers, on a linear or logarithmic scale, or of names.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    label: String,
    scale: Scale,
    first: f64,
    last: f64,
}

impl Axis {
    /// Creates a linear axis from `first` to `last` with a tick every `step`.
    pub fn linear(label: &str, [first, last]: [f64; 2], step: f64) -> Self {
        Self {
            label: label.to_owned(),
            scale: Scale::Linear { step },
            first,
            last,
        }
    }

    /// Creates a logarithmic axis from `first` to `last`, both positive.
    pub fn log(label: &str, [first, last]: [f64; 2]) -> Self {
        Self {
            label: label.to_owned(),
            scale: Scale::Log,
            first,
            last,
        }
    }

    /// Creates an axis of quantiles q, placed at 1/(1 − q) on a logarithmic scale. The median is at
    /// 2, and each of the `nines` decades adds another nine.
    pub fn nines(label: &str, nines: u32) -> Self {
        Self {
            scale: Scale::Nines,
            ..Self::log(label, [1.0, 10f64.powi(nines as i32)])
        }
    }

    /// Creates a logarithmic axis that includes every positive number in `numbers`.
    pub fn log_around(label: &str, numbers: impl IntoIterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, 0.0f64);
        for number in numbers {
            if number > 0.0 && number.is_finite() {
                low = low.min(number);
                high = high.max(number);
            }
        }
        if high <= 0.0 {
            return Self::log(label, [0.1, 10.0]);
        }
        // Both ends are extended to the next 1, 2 or 5 times a power of ten. The axis spans at
        // least one decade.
        let down = |x: f64| nice(x, &[1.0, 2.0, 5.0], false);
        let up = |x: f64| nice(x, &[1.0, 2.0, 5.0, 10.0], true);
        let (low, high) = (down(low / 1.05), up(high * 1.05));
        let spare = (10.0 * low / high).max(1.0).sqrt();
        Self::log(label, [low / spare, high * spare])
    }

    /// Creates an axis of names. On a vertical axis the first is at the top.
    pub fn names(label: &str, names: Vec<String>) -> Self {
        Self {
            label: label.to_owned(),
            // The axis grows upwards, so the last name has the highest value.
            first: names.len() as f64 - 0.5,
            last: -0.5,
            scale: Scale::Names(names),
        }
    }

    /// Returns the label of the axis.
    pub fn label(&self) -> &str {
        &self.label
    }

    pub(super) fn first(&self) -> f64 {
        self.first
    }

    pub(super) fn last(&self) -> f64 {
        self.last
    }

    /// Returns a number's position on the axis, clamped to its range.
    pub(super) fn place(&self, number: f64) -> f64 {
        let (low, high) = (self.low(), self.high());
        let place = match self.scale {
            Scale::Linear { .. } => number,
            Scale::Log | Scale::Nines => number.max(f64::MIN_POSITIVE).log10(),
            Scale::Names(_) => -number,
        };
        place.clamp(low, high)
    }

    fn free_place(&self, number: f64) -> f64 {
        match self.scale {
            Scale::Linear { .. } => number,
            Scale::Log | Scale::Nines => number.log10(),
            Scale::Names(_) => -number,
        }
    }

    pub(super) fn low(&self) -> f64 {
        self.free_place(self.first)
    }

    pub(super) fn high(&self) -> f64 {
        self.free_place(self.last)
    }

    /// Returns whether a number is within the range of the axis.
    pub(super) fn holds(&self, number: f64) -> bool {
        let place = self.free_place(number);
        let slack = 1e-9 * (self.high() - self.low());
        place.is_finite() && place >= self.low() - slack && place <= self.high() + slack
    }

    /// Converts the axis for the plotting library.
    pub(super) fn ruler(&self) -> Ruler {
        Ruler {
            low: self.low(),
            high: self.high(),
            places: self.places(),
        }
    }

    /// Returns the positions of the ticks.
    pub(super) fn places(&self) -> Vec<f64> {
        let slack = 1e-9 * (self.high() - self.low());
        match &self.scale {
            Scale::Linear { step } => {
                let from = (self.first / step - 1e-9).ceil() as i64;
                let to = (self.last / step + 1e-9).floor() as i64;
                (from..=to).map(|k| k as f64 * step).collect()
            }
            Scale::Log => {
                let decades = self.high() - self.low();
                let each = if decades > 8.5 { 2 } else { 1 };
                let mantissas: &[f64] = if decades < 2.6 {
                    &[1.0, 2.0, 5.0]
                } else {
                    &[1.0]
                };
                let powers = self.low().floor() as i32..=self.high().ceil() as i32;
                powers
                    .filter(|power| power.rem_euclid(each) == 0)
                    .flat_map(|power| mantissas.iter().map(move |m| f64::from(power) + m.log10()))
                    .filter(|p| (self.low() - slack..=self.high() + slack).contains(p))
                    .collect()
            }
            Scale::Nines => (0..=self.last.log10().round() as i32)
                .map(f64::from)
                .collect(),
            Scale::Names(names) => (0..names.len()).map(|i| -(i as f64)).collect(),
        }
    }

    /// Returns the numbers between ticks that get a faint line: only for logarithmic axes that span
    /// few decades.
    pub(super) fn minor(&self) -> Vec<f64> {
        if self.scale != Scale::Log || self.high() - self.low() > 5.5 {
            return Vec::new();
        }
        let powers = self.low().floor() as i32..=self.high().ceil() as i32;
        powers
            .flat_map(|power| (2..10).map(move |m| f64::from(m) * 10f64.powi(power)))
            .filter(|&number| self.holds(number))
            .collect()
    }

    /// Returns the text of a tick.
    pub(super) fn text(&self, place: f64) -> String {
        match &self.scale {
            Scale::Linear { step } => {
                let decimals = (-step.log10()).ceil().max(0.0) as usize;
                format!("{place:.decimals$}")
            }
            Scale::Log => {
                let number = 10f64.powf(place);
                if (0.9e-3..1.1e4).contains(&number) {
                    plain(number)
                } else if (place - place.round()).abs() < 1e-9 {
                    format!("10{}", raised(place.round() as i32))
                } else {
                    digits(number)
                }
            }
            Scale::Nines => match place.round() as usize {
                0 => "0 %".to_owned(),
                1 => "90 %".to_owned(),
                2 => "99 %".to_owned(),
                nines => format!("99.{} %", "9".repeat(nines - 2)),
            },
            Scale::Names(names) => {
                let index = (-place).round().max(0.0) as usize;
                names.get(index).cloned().unwrap_or_default()
            }
        }
    }
}

/// Range of positions along an axis, and its ticks.
#[derive(Clone)]
pub(super) struct Ruler {
    low: f64,
    high: f64,
    places: Vec<f64>,
}

impl Ranged for Ruler {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, limit: (i32, i32)) -> i32 {
        let share = (place - self.low) / (self.high - self.low);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            Vec::new()
        } else {
            self.places.clone()
        }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

/// Formats a tick of 1, 2 or 5 times a power of ten without superfluous digits.
fn plain(number: f64) -> String {
    let decimals = (-number.log10().floor()).max(0.0) as usize;
    format!("{number:.decimals$}")
}

/// Returns the next number up or down whose first digit is one of `mantissas`.
fn nice(number: f64, mantissas: &[f64], is_up: bool) -> f64 {
    let power = 10f64.powf(number.log10().floor());
    let mantissa = number / power;
    let mut candidates = mantissas.iter();
    let found = if is_up {
        candidates.find(|&&m| m >= mantissa * (1.0 - 1e-9))
    } else {
        candidates.rfind(|&&m| m <= mantissa * (1.0 + 1e-9))
    };
    found.copied().unwrap_or(1.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis) -> Vec<String> {
        axis.places().iter().map(|&p| axis.text(p)).collect()
    }

    #[test]
    fn ticks_say_round_numbers() {
        assert_eq!(
            texts(&Axis::nines("", 4)),
            ["0 %", "90 %", "99 %", "99.9 %", "99.99 %"]
        );
        assert_eq!(
            texts(&Axis::linear("", [0.0, 1.0], 0.5)),
            ["0.0", "0.5", "1.0"]
        );
        assert_eq!(
            texts(&Axis::log("", [0.5, 20.0])),
            ["0.5", "1", "2", "5", "10", "20"]
        );
        assert_eq!(texts(&Axis::log("", [0.01, 1e5])).last().unwrap(), "10⁵");
        let named = Axis::names("", vec!["a".into(), "b".into()]);
        assert_eq!(texts(&named), ["a", "b"]);
        // The first name is at the top.
        assert!(named.place(0.0) > named.place(1.0));
    }

    #[test]
    fn a_logarithmic_axis_has_room_for_what_is_on_it() {
        let axis = Axis::log_around("", [0.013, 7.0, f64::NAN, 0.0]);
        assert!(axis.holds(0.013) && axis.holds(7.0));
        assert!(!axis.holds(0.005) && !axis.holds(11.0));
        let narrow = Axis::log_around("", [3.0]);
        assert!(narrow.high() - narrow.low() > 0.99);
    }
}

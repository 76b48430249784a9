//! Finds where two messages differ that should be equal.

use lariat_wire::fields::{Field, Meaning, Message, Value, is_hidden};
use lariat_wire::{Centerlines, Descriptors};
use std::fmt;

/// Required precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rule {
    /// Equal bit for bit.
    Bits,
    /// Positions within this many pixels; other numbers within the same fraction of their value.
    Within(f64),
}

/// A number that differs from the recorded one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Difference {
    /// Name of the field, such as `rope 2, point 17, x`.
    pub(super) field: String,
    pub(super) recorded: String,
    pub(super) now: String,
    /// Distance between the two numbers.
    pub(super) distance: f64,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            field,
            recorded,
            now,
            distance,
        } = self;
        write!(
            f,
            "{field}: recorded {recorded}, now {now}, {distance:e} apart"
        )
    }
}

/// Compares field by field, up to the first difference.
#[derive(Debug)]
pub(super) struct Comparer {
    rule: Rule,
    found: Option<Difference>,
    /// Largest distance between two positions so far.
    pub(super) largest: f64,
}

impl Comparer {
    pub(super) fn new(rule: Rule) -> Self {
        Self {
            rule,
            found: None,
            largest: 0.0,
        }
    }

    /// Returns the first field in which extract's message differs.
    pub(super) fn centerlines(
        &mut self,
        recorded: &Centerlines,
        now: &Centerlines,
    ) -> Option<Difference> {
        self.message("", recorded, now);
        self.found.take()
    }

    /// Returns the first field in which fit's message differs.
    pub(super) fn descriptors(
        &mut self,
        recorded: &Descriptors,
        now: &Descriptors,
    ) -> Option<Difference> {
        self.message("", recorded, now);
        self.found.take()
    }

    /// Compares integers first, then positions, then other numbers, then nested messages.
    fn message(&mut self, place: &str, recorded: &dyn Message, now: &dyn Message) {
        let (recorded, now) = (recorded.fields(), now.fields());
        let pairs = || recorded.iter().zip(&now);
        for ((field, recorded), (_, now)) in pairs() {
            self.wholes(place, field, *recorded, *now);
        }
        for ((field, recorded), (_, now)) in pairs() {
            self.numbers(true, place, field, *recorded, *now);
        }
        for ((field, recorded), (_, now)) in pairs() {
            self.numbers(false, place, field, *recorded, *now);
        }
        for ((field, recorded), (_, now)) in pairs() {
            if let (Value::Messages(recorded), Value::Messages(now)) = (recorded, now) {
                let kind = match field.name {
                    "crossings" => "crossing",
                    _ => "rope",
                };
                for (i, (recorded, now)) in recorded.iter().zip(now.iter()).enumerate() {
                    self.message(&format!("{kind} {}", i + 1), recorded, now);
                }
            }
        }
    }

    fn wholes(&mut self, place: &str, field: &Field, recorded: Value, now: Value) {
        let name = || match field.meaning {
            Meaning::Count(list) => named(place, &format!("number of {}", list.replace('_', " "))),
            _ => named(place, field.name),
        };
        match (recorded, now) {
            (Value::U32(recorded), Value::U32(now)) => self.whole(name, recorded, now),
            (Value::U64(recorded), Value::U64(now)) => self.whole(name, recorded, now),
            (Value::Hidden(recorded, count), Value::Hidden(now, _)) => {
                for i in 0..count {
                    let name = || named(place, &format!("whether point {i} is hidden"));
                    let [recorded, now] = [recorded, now].map(|mask| is_hidden(mask, i));
                    self.whole(name, recorded, now);
                }
            }
            _ => {}
        }
    }

    /// Compares the numbers of a field. `positions`: whether they are coordinates.
    fn numbers(
        &mut self,
        positions: bool,
        place: &str,
        field: &Field,
        recorded: Value,
        now: Value,
    ) {
        let is_position = matches!(
            (&field.meaning, recorded),
            (Meaning::Points, _) | (_, Value::Point(_))
        );
        if is_position != positions {
            return;
        }
        let (recorded, now) = (Numbers(recorded), Numbers(now));
        for i in 0..recorded.count().min(now.count()) {
            let name = || named(place, &entry_name(field, i));
            if is_position {
                self.position(name, recorded.at(i), now.at(i));
            } else {
                self.number(name, recorded.at(i), now.at(i));
            }
        }
    }

    fn whole<N: Into<u64>>(&mut self, name: impl FnOnce() -> String, recorded: N, now: N) {
        let (recorded, now) = (recorded.into(), now.into());
        if recorded != now {
            let distance = recorded.abs_diff(now) as f64;
            self.report(name, recorded.to_string(), now.to_string(), distance);
        }
    }

    /// Compares a coordinate.
    fn position(&mut self, name: impl FnOnce() -> String, recorded: f64, now: f64) {
        let distance = (recorded - now).abs();
        // `max` ignores NaN.
        self.largest = self.largest.max(distance);
        let equal = match self.rule {
            Rule::Bits => recorded.to_bits() == now.to_bits(),
            Rule::Within(px) => distance <= px || recorded.to_bits() == now.to_bits(),
        };
        if !equal {
            self.report(name, recorded.to_string(), now.to_string(), distance);
        }
    }

    /// Compares any other number. The tolerance is relative, with the same value that positions
    /// have in pixels.
    fn number(&mut self, name: impl FnOnce() -> String, recorded: f64, now: f64) {
        let distance = (recorded - now).abs();
        let equal = match self.rule {
            Rule::Bits => false,
            Rule::Within(px) => distance <= px * recorded.abs().max(1.0),
        };
        if !equal && recorded.to_bits() != now.to_bits() {
            self.report(name, recorded.to_string(), now.to_string(), distance);
        }
    }

    fn report(
        &mut self,
        name: impl FnOnce() -> String,
        recorded: String,
        now: String,
        distance: f64,
    ) {
        if self.found.is_none() {
            self.found = Some(Difference {
                field: name(),
                recorded,
                now,
                distance,
            });
        }
    }
}

/// Numbers of a field, if it has any. 32-bit numbers convert to 64 bits without loss.
struct Numbers<'a>(Value<'a>);

impl Numbers<'_> {
    fn count(&self) -> usize {
        match self.0 {
            Value::F32(_) | Value::F64(_) => 1,
            Value::Point(at) => at.len(),
            Value::F32s(numbers, _) => numbers.len(),
            Value::F64s(numbers, _) => numbers.len(),
            _ => 0,
        }
    }

    fn at(&self, i: usize) -> f64 {
        match self.0 {
            Value::F32(number) => number.into(),
            Value::F64(number) => number,
            Value::Point(at) => at[i].into(),
            Value::F32s(numbers, _) => numbers[i].into(),
            Value::F64s(numbers, _) => numbers[i],
            _ => f64::NAN,
        }
    }
}

/// Name of a property of a rope, of a crossing, or of the whole message.
fn named(place: &str, what: &str) -> String {
    if place.is_empty() {
        format!("the {what}")
    } else {
        format!("{place}, {what}")
    }
}

/// Name of number `i` of a field: `control point 3, y`, `weight 2`, or `rms`.
fn entry_name(field: &Field, i: usize) -> String {
    let axis = ["x", "y"][i % 2];
    let one = match field.name.strip_suffix("ies") {
        Some(stem) => format!("{stem}y"),
        None => field.name.trim_end_matches('s').replace('_', " "),
    };
    match (&field.meaning, field.of.element().1.len()) {
        (Meaning::Points, _) => format!("{one} {}, {axis}", i / 2),
        (Meaning::List, _) if field.name.starts_with("widths") => format!("width at point {i}"),
        (Meaning::List, _) => format!("{one} {i}"),
        (_, 1) => axis.to_owned(),
        _ => field.name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_field_that_differs_is_named() {
        let mut recorded = Box::new(Descriptors::EMPTY);
        recorded.count = 2;
        recorded.curves[1].count = 4;
        let mut now = recorded.clone();
        // Unused entries may have any value.
        now.curves[1].control_points[4] = [7.0; 2];
        now.curves[2].rms = 1.0;
        let mut comparer = Comparer::new(Rule::Bits);
        assert_eq!(comparer.descriptors(&recorded, &now), None);
        now.curves[1].control_points[3][1] = 1e-12;
        now.curves[1].rms = 1.0;
        let found = comparer.descriptors(&recorded, &now).unwrap();
        assert_eq!(
            found.to_string(),
            "rope 2, control point 3, y: recorded 0, now 0.000000000001, 1e-12 apart"
        );
        let mut comparer = Comparer::new(Rule::Within(1e-9));
        let found = comparer.descriptors(&recorded, &now).unwrap();
        assert_eq!(found.field, "rope 2, rms");
        assert_eq!(comparer.largest, 1e-12);
    }

    #[test]
    fn zeros_of_both_signs_differ_to_the_bit_and_what_is_no_number_is_itself() {
        let mut recorded = Box::new(Centerlines::EMPTY);
        recorded.count = 1;
        recorded.curves[0].count = 1;
        let mut now = recorded.clone();
        now.curves[0].points[0][0] = -0.0;
        assert!(
            Comparer::new(Rule::Bits)
                .centerlines(&recorded, &now)
                .is_some()
        );
        let within = Rule::Within(1e-9);
        assert!(Comparer::new(within).centerlines(&recorded, &now).is_none());
        now.curves[0].points[0][0] = f32::NAN;
        assert!(Comparer::new(within).centerlines(&recorded, &now).is_some());
        recorded.curves[0].points[0][0] = f32::NAN;
        assert!(
            Comparer::new(Rule::Bits)
                .centerlines(&recorded, &now)
                .is_none()
        );
        assert!(Comparer::new(within).centerlines(&recorded, &now).is_none());
    }
}

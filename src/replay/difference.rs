//! Where two messages differ that should be the same.

use lariat_wire::{CenterlinePoints, Centerlines, Crossing, Curve, Descriptor, Descriptors};
use std::fmt;

/// How equal numbers must be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rule {
    /// To the bit.
    Bits,
    /// Positions to so many pixels; what else there is, to as much of itself.
    Within(f64),
}

/// A number that is another than it was.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Difference {
    /// Which, such as `rope 2, point 17, x`.
    pub(super) field: String,
    pub(super) recorded: String,
    pub(super) now: String,
    /// How far apart they are.
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

/// Compares field by field, until one differs.
#[derive(Debug)]
pub(super) struct Comparer {
    rule: Rule,
    found: Option<Difference>,
    /// The largest distance of two positions so far.
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

    /// The first field in which what extract said differs, if one does.
    pub(super) fn centerlines(
        &mut self,
        recorded: &Centerlines,
        now: &Centerlines,
    ) -> Option<Difference> {
        self.whole(|| "the image's width".into(), recorded.width, now.width);
        self.whole(|| "the image's height".into(), recorded.height, now.height);
        self.whole(|| "the number of ropes".into(), recorded.count, now.count);
        for (i, (recorded, now)) in recorded.curves().iter().zip(now.curves()).enumerate() {
            self.curve(i + 1, recorded, now);
        }
        let counts = [recorded.crossing_count, now.crossing_count];
        self.whole(|| "the number of crossings".into(), counts[0], counts[1]);
        for (i, (recorded, now)) in recorded.crossings().iter().zip(now.crossings()).enumerate() {
            self.crossing(i + 1, recorded, now);
        }
        self.found.take()
    }

    /// The first field in which what fit said differs, if one does.
    pub(super) fn descriptors(
        &mut self,
        recorded: &Descriptors,
        now: &Descriptors,
    ) -> Option<Difference> {
        self.whole(|| "the image's width".into(), recorded.width, now.width);
        self.whole(|| "the image's height".into(), recorded.height, now.height);
        self.whole(|| "the unit".into(), recorded.unit, now.unit);
        self.whole(|| "the number of ropes".into(), recorded.count, now.count);
        for (i, (recorded, now)) in recorded.curves().iter().zip(now.curves()).enumerate() {
            self.descriptor(i + 1, recorded, now);
        }
        let points = recorded.centerlines().iter().zip(now.centerlines());
        for (i, (recorded, now)) in points.enumerate() {
            self.points_of(i + 1, recorded, now);
        }
        self.found.take()
    }

    fn curve(&mut self, rope: usize, recorded: &Curve, now: &Curve) {
        let words = |curve: &Curve| {
            [
                ("track", u64::from(curve.track)),
                ("status", curve.status.into()),
                ("closed", curve.closed.into()),
                ("border", curve.border.into()),
                ("number of points", curve.count.into()),
                ("age_ns", curve.age_ns),
            ]
        };
        for ((name, recorded), (_, now)) in words(recorded).into_iter().zip(words(now)) {
            self.whole(|| format!("rope {rope}, {name}"), recorded, now);
        }
        self.single(rope, "length_px", recorded.length_px, now.length_px);
        self.single(rope, "width_px", recorded.width_px, now.width_px);
        let hidden = [recorded, now].map(|curve| curve.hidden);
        self.hidden(rope, recorded.points().len(), hidden);
        self.points(rope, recorded.points(), now.points());
        self.widths(rope, recorded.widths_px(), now.widths_px());
    }

    fn points_of(&mut self, rope: usize, recorded: &CenterlinePoints, now: &CenterlinePoints) {
        let name = || format!("rope {rope}, number of points");
        self.whole(name, recorded.count, now.count);
        let name = || format!("rope {rope}, whether its points are closed");
        self.whole(name, recorded.closed, now.closed);
        let hidden = [recorded, now].map(|points| points.hidden);
        self.hidden(rope, recorded.points().len(), hidden);
        self.points(rope, recorded.points(), now.points());
        self.widths(rope, recorded.widths(), now.widths());
    }

    fn hidden(&mut self, rope: usize, count: usize, [recorded, now]: [[u32; 8]; 2]) {
        for i in 0..count {
            let name = || format!("rope {rope}, whether point {i} is hidden");
            let [recorded, now] = [recorded, now].map(|mask| mask[i / 32] >> (i % 32) & 1);
            self.whole(name, recorded, now);
        }
    }

    fn points(&mut self, rope: usize, recorded: &[[f32; 2]], now: &[[f32; 2]]) {
        for (i, (recorded, now)) in recorded.iter().zip(now).enumerate() {
            for (axis, name) in ["x", "y"].into_iter().enumerate() {
                let name = || format!("rope {rope}, point {i}, {name}");
                self.position32(name, recorded[axis], now[axis]);
            }
        }
    }

    fn widths(&mut self, rope: usize, recorded: &[f32], now: &[f32]) {
        for (i, (recorded, now)) in recorded.iter().zip(now).enumerate() {
            let name = || format!("rope {rope}, width at point {i}");
            self.number32(name, *recorded, *now);
        }
    }

    fn crossing(&mut self, place: usize, recorded: &Crossing, now: &Crossing) {
        let words = |crossing: &Crossing| [("over", crossing.over), ("under", crossing.under)];
        for ((name, recorded), (_, now)) in words(recorded).into_iter().zip(words(now)) {
            self.whole(|| format!("crossing {place}, {name}"), recorded, now);
        }
        for (axis, name) in ["x", "y"].into_iter().enumerate() {
            let name = || format!("crossing {place}, {name}");
            self.position32(name, recorded.at[axis], now.at[axis]);
        }
        let numbers = |crossing: &Crossing| {
            [
                ("over_rho", crossing.over_rho),
                ("under_rho", crossing.under_rho),
                ("confidence", crossing.confidence),
            ]
        };
        for ((name, recorded), (_, now)) in numbers(recorded).into_iter().zip(numbers(now)) {
            self.number32(|| format!("crossing {place}, {name}"), recorded, now);
        }
    }

    fn descriptor<'a>(&mut self, rope: usize, recorded: &'a Descriptor, now: &'a Descriptor) {
        let words = |of: &Descriptor| {
            [
                ("track", u64::from(of.track)),
                ("status", of.status.into()),
                ("basis", of.basis.into()),
                ("order", of.order.into()),
                ("number of control points", of.count.into()),
                ("samples", of.samples.into()),
                ("closed", of.closed.into()),
                ("border", of.border.into()),
                ("hidden", of.hidden.into()),
                ("filtered", of.filtered.into()),
                ("fit", of.fit.into()),
                ("age_ns", of.age_ns),
            ]
        };
        for ((name, recorded), (_, now)) in words(recorded).into_iter().zip(words(now)) {
            self.whole(|| format!("rope {rope}, {name}"), recorded, now);
        }
        let points = recorded.control_points().iter().zip(now.control_points());
        for (i, (recorded, now)) in points.enumerate() {
            for (axis, name) in ["x", "y"].into_iter().enumerate() {
                let name = || format!("rope {rope}, control point {i}, {name}");
                self.position(name, recorded[axis], now[axis]);
            }
        }
        let numbers = |of: &Descriptor| {
            [
                ("rms", of.rms),
                ("max", of.max),
                ("residual_variance", of.residual_variance),
                ("condition", of.condition),
                ("length", of.length),
                ("width", of.width),
            ]
        };
        for ((name, recorded), (_, now)) in numbers(recorded).into_iter().zip(numbers(now)) {
            self.number(|| format!("rope {rope}, {name}"), recorded, now);
        }
        let lists = |of: &'a Descriptor| {
            [
                ("weight", of.weights()),
                ("knot", of.inner_knots()),
                ("covariance", of.covariances().as_flattened()),
                ("velocity", of.velocities().as_flattened()),
            ]
        };
        for ((name, recorded), (_, now)) in lists(recorded).into_iter().zip(lists(now)) {
            for (i, (recorded, now)) in recorded.iter().zip(now).enumerate() {
                self.number(|| format!("rope {rope}, {name} {i}"), *recorded, *now);
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

    /// A coordinate.
    fn position(&mut self, name: impl FnOnce() -> String, recorded: f64, now: f64) {
        let distance = (recorded - now).abs();
        // What is no number is not larger than anything.
        self.largest = self.largest.max(distance);
        let equal = match self.rule {
            Rule::Bits => recorded.to_bits() == now.to_bits(),
            Rule::Within(px) => distance <= px || recorded.to_bits() == now.to_bits(),
        };
        if !equal {
            self.report(name, recorded.to_string(), now.to_string(), distance);
        }
    }

    /// Any other number: to as much of itself as positions to a pixel.
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

    fn single(&mut self, rope: usize, name: &str, recorded: f32, now: f32) {
        self.number32(|| format!("rope {rope}, {name}"), recorded, now);
    }

    // A number of 32 bits has an exact twin of 64, so that nothing is lost in these.
    fn position32(&mut self, name: impl FnOnce() -> String, recorded: f32, now: f32) {
        self.position(name, recorded.into(), now.into());
    }

    fn number32(&mut self, name: impl FnOnce() -> String, recorded: f32, now: f32) {
        self.number(name, recorded.into(), now.into());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_field_that_differs_is_named() {
        let mut recorded = Box::new(Descriptors::EMPTY);
        recorded.count = 2;
        recorded.curves[1].count = 4;
        let mut now = recorded.clone();
        // What is not meant may be anything.
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

//! Formats numbers for people.

use std::fmt::{self, Write};

/// A number with three significant digits and no exponent: `0.123`, `4.56`, `78.9`, `1230`. `None`
/// is shown as `–`.
#[derive(Debug, Clone, Copy)]
pub struct Figure(pub Option<f64>);

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = Short::default();
        text.write_fmt(format_args!("{}", Unpadded(self.0)))?;
        f.pad(text.as_str())
    }
}

struct Unpadded(Option<f64>);

impl fmt::Display for Unpadded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(value) = self.0.filter(|value| value.is_finite()) else {
            return f.write_str("–");
        };
        if value == 0.0 {
            return f.write_str("0");
        }
        // Round first, so that 9.996 has two digits before the point.
        let digits_before = value.abs().max(0.1).log10().floor() as i32 + 1;
        let unit = 10f64.powi(digits_before - 3);
        let value = (value / unit).round() * unit;
        let digits_before = value.abs().max(0.1).log10().floor() as i32 + 1;
        let decimals = (3 - digits_before).clamp(0, 3) as usize;
        write!(f, "{value:.decimals$}")
    }
}

/// Limit above which a time is shown in milliseconds, so that microseconds have at most five
/// digits.
const IN_MS_FROM_US: f64 = 1e5;

/// A time in a table of microseconds: a [`Figure`] of at most six characters. From 100,000 µs on it
/// is shown in milliseconds, from one second on in seconds, with the unit: `373`, `50400`,
/// `134 ms`, `1.58 s`.
#[derive(Debug, Clone, Copy)]
pub struct Micros(pub Option<f64>);

impl Micros {
    /// Returns the time for a sentence, where microseconds are named, too: `373 µs`.
    pub fn named(self) -> impl fmt::Display {
        Named(self)
    }

    /// Returns the number, and its unit unless that is microseconds.
    fn scaled(self) -> (Figure, &'static str) {
        let in_unit = |unit_us| Figure(self.0.map(|us| us / unit_us));
        // Choose the unit after rounding: 99,960 µs are 100 ms.
        match self.0.map(|us| us * (1.0 + 0.5e-3)) {
            Some(us) if us >= 1e6 => (in_unit(1e6), " s"),
            Some(us) if us >= IN_MS_FROM_US => (in_unit(1e3), " ms"),
            _ => (in_unit(1.0), ""),
        }
    }
}

impl fmt::Display for Micros {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = Short::default();
        let (figure, unit) = self.scaled();
        text.write_fmt(format_args!("{figure}{unit}"))?;
        f.pad(text.as_str())
    }
}

struct Named(Micros);

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (figure, unit) = self.0.scaled();
        let unit = if unit.is_empty() { " µs" } else { unit };
        let mut text = Short::default();
        text.write_fmt(format_args!("{figure}{unit}"))?;
        f.pad(text.as_str())
    }
}

/// Text of a number on the stack, so that it can be padded without an allocation. The longest
/// finite f64 has 309 digits before the point. A longer text is not a figure.
struct Short {
    bytes: [u8; 320],
    len: usize,
}

impl Default for Short {
    fn default() -> Self {
        Self {
            bytes: [0; 320],
            len: 0,
        }
    }
}

impl Short {
    fn as_str(&self) -> &str {
        std::str::from_utf8(&self.bytes[..self.len]).unwrap_or("?")
    }
}

impl Write for Short {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let end = self.len + text.len();
        let place = self.bytes.get_mut(self.len..end).ok_or(fmt::Error)?;
        place.copy_from_slice(text.as_bytes());
        self.len = end;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_are_shown_wherever_the_point_is() {
        let shown = |value| Figure(Some(value)).to_string();
        assert_eq!(shown(0.0), "0");
        assert_eq!(shown(0.0123), "0.012");
        assert_eq!(shown(0.123), "0.123");
        assert_eq!(shown(1.2345), "1.23");
        assert_eq!(shown(9.996), "10.0");
        assert_eq!(shown(99.96), "100");
        assert_eq!(shown(1234.5), "1230");
        assert_eq!(shown(123_456.0), "123000");
    }

    #[test]
    fn a_long_time_names_its_unit_and_no_time_is_wider_than_six_characters() {
        let shown = |us| Micros(Some(us)).to_string();
        assert_eq!(shown(0.0), "0");
        assert_eq!(shown(372.9), "373");
        assert_eq!(shown(99_900.0), "99900");
        assert_eq!(shown(99_960.0), "100 ms");
        assert_eq!(shown(134_200.0), "134 ms");
        assert_eq!(shown(998_000.0), "998 ms");
        assert_eq!(shown(999_600.0), "1.00 s");
        assert_eq!(shown(1_580_000.0), "1.58 s");
        assert_eq!(shown(1e8), "100 s");
        for exponent in 0..=320 {
            let us = 10f64.powf(f64::from(exponent) / 40.0);
            assert!(shown(us).chars().count() <= 6, "{us}: {}", shown(us));
        }
        assert_eq!(format!("[{:>6}]", Micros(None)), "[     –]");
    }

    #[test]
    fn in_a_sentence_every_time_has_its_unit() {
        assert_eq!(Micros(Some(263.4)).named().to_string(), "263 µs");
        assert_eq!(Micros(Some(134_200.0)).named().to_string(), "134 ms");
        assert_eq!(format!("{:>7}", Micros(None).named()), "   – µs");
    }

    #[test]
    fn no_figure_is_a_dash_and_takes_its_place() {
        assert_eq!(format!("[{:>6}]", Figure(None)), "[     –]");
        assert_eq!(format!("[{:>6}]", Figure(Some(41.23))), "[  41.2]");
    }
}

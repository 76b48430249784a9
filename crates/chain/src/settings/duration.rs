//! Durations as people write them: `10s`, `500ms`, `2m`, or plain seconds.

use std::time::Duration;

/// The units and their lengths in seconds.
const UNITS_S: [(&str, f64); 8] = [
    ("us", 1e-6),
    ("µs", 1e-6),
    ("ms", 1e-3),
    ("s", 1.0),
    ("min", 60.0),
    ("m", 60.0),
    ("h", 3600.0),
    ("", 1.0),
];

/// Parses a positive duration, or returns why `text` is not one.
pub fn parse(text: &str) -> Result<Duration, String> {
    from_s(seconds(text)?)
}

/// Parses a number of seconds, whether it is a valid duration or not.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let split = text
        .find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+')))
        .unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let unit = unit.trim();
    let Ok(number) = number.parse::<f64>() else {
        return Err("a time is a number with a unit, such as 10s, 500ms or 2m".to_owned());
    };
    let Some((_, unit_s)) = UNITS_S.iter().find(|(name, _)| *name == unit) else {
        return Err(format!(
            "\"{unit}\" is not a unit of time here: use us, ms, s, m or h"
        ));
    };
    Ok(number * unit_s)
}

/// Converts seconds to a duration. It must be more than 0 and at most a year, which is longer than
/// any chain is meant to run.
pub(super) fn from_s(seconds: f64) -> Result<Duration, String> {
    const YEAR_S: f64 = 365.0 * 24.0 * 3600.0;
    if !(seconds > 0.0 && seconds <= YEAR_S) {
        return Err("a time must be longer than 0 and at most a year".to_owned());
    }
    let duration = Duration::from_secs_f64(seconds);
    if duration.is_zero() {
        return Err("a time must be at least a nanosecond".to_owned());
    }
    Ok(duration)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_is_understood() {
        for (text, expected_us) in [
            ("10s", 10_000_000),
            ("10 s", 10_000_000),
            ("500ms", 500_000),
            ("33us", 33),
            ("33µs", 33),
            ("2m", 120_000_000),
            ("1.5min", 90_000_000),
            ("1h", 3_600_000_000),
            ("7", 7_000_000),
            ("0.25", 250_000),
        ] {
            assert_eq!(
                parse(text),
                Ok(Duration::from_micros(expected_us)),
                "{text}"
            );
        }
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for text in [
            "",
            "s",
            "ten",
            "10 parsecs",
            "-3s",
            "0",
            "0ms",
            "1e400s",
            "NaN",
            "9999999h",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}

//! Numbers as people read them.

use std::fmt::{self, Write};

/// Three significant digits, and no exponent: `0.123`, `4.56`, `78.9`, `1230`. Nothing is `–`.
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
        // Rounded first, so that 9.996 has two digits before the point and not one.
        let digits_before = value.abs().max(0.1).log10().floor() as i32 + 1;
        let unit = 10f64.powi(digits_before - 3);
        let value = (value / unit).round() * unit;
        let digits_before = value.abs().max(0.1).log10().floor() as i32 + 1;
        let decimals = (3 - digits_before).clamp(0, 3) as usize;
        write!(f, "{value:.decimals$}")
    }
}

/// A number's text on the stack, so that it can be padded without an allocation. The longest finite f64 has 309 digits
/// before the point; what does not fit is not a figure.
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
    fn no_figure_is_a_dash_and_takes_its_place() {
        assert_eq!(format!("[{:>6}]", Figure(None)), "[     –]");
        assert_eq!(format!("[{:>6}]", Figure(Some(41.23))), "[  41.2]");
    }
}

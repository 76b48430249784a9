//! Tables of text.

use std::fmt;

use lariat_chain::layout::{self, Column};

/// Rows under a header. The first column is text, the others are figures. The width is not limited.
#[derive(Debug, Clone)]
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Creates an empty table with this header.
    pub fn new(head: &[&str]) -> Self {
        let words = head.iter().take(1).map(|&heading| Column::words(heading));
        let figures = head.iter().skip(1).map(|&heading| Column::figures(heading));
        Self {
            columns: words.chain(figures).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn push<I: IntoIterator<Item = String>>(&mut self, row: I) {
        self.rows.push(row.into_iter().collect());
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.columns.clone();
        f.write_str(&layout::Table::text(columns, &self.rows, usize::MAX))
    }
}

/// Formats nanoseconds as microseconds.
pub fn micros(ns: f64) -> String {
    format!("{:.1}", ns / 1e3)
}

/// Formats nanoseconds as milliseconds.
pub fn millis(ns: f64) -> String {
    format!("{:.3}", ns / 1e6)
}

/// Formats `value / unit` with three digits. A dash if `unit` is not positive.
pub fn times(value: f64, unit: f64) -> String {
    if unit > 0.0 {
        multiple(value / unit)
    } else {
        "-".into()
    }
}

/// Formats a ratio with three digits.
pub fn multiple(ratio: f64) -> String {
    let decimals = match ratio {
        r if r < 9.995 => 2,
        r if r < 99.95 => 1,
        _ => 0,
    };
    format!("{ratio:.decimals$}×")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let mut table = Table::new(&["work", "µs", "÷ read"]);
        table.push(["cold".into(), micros(123_456.0), times(123_456.0, 11_000.0)]);
        table.push(["graph".into(), micros(7.0), times(7.0, 11_000.0)]);
        let expected = "work      µs  ÷ read\n\
                        cold   123.5   11.2×\n\
                        graph    0.0   0.00×\n";
        assert_eq!(table.to_string(), expected);
    }

    #[test]
    fn a_ratio_has_three_digits() {
        let shown = [0.126, 9.99, 9.996, 12.34, 99.96, 1234.5].map(|r| times(r, 1.0));
        assert_eq!(shown, ["0.13×", "9.99×", "10.0×", "12.3×", "100×", "1234×"]);
        assert_eq!(times(1.0, 0.0), "-");
    }

    #[test]
    fn times_are_in_the_unit_that_is_named() {
        assert_eq!(
            [micros(1_234_567.0), millis(1_234_567.0)],
            ["1234.6", "1.235"]
        );
    }
}

//! The numbers behind a figure as comma-separated values (RFC 4180).

use std::fmt::Write;

/// A table with a header, as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Csv {
    /// File name with its extension.
    pub name: &'static str,
    /// Content of the file.
    pub text: String,
    columns: usize,
}

impl Csv {
    pub(crate) fn new(name: &'static str, header: &[&str]) -> Self {
        let mut text = header.join(",");
        text.push('\n');
        Self {
            name,
            text,
            columns: header.len(),
        }
    }

    /// Adds a row, which must be as long as the header.
    pub(crate) fn row(&mut self, cells: &[Cell]) {
        debug_assert_eq!(cells.len(), self.columns, "{}", self.name);
        for (i, cell) in cells.iter().enumerate() {
            if i > 0 {
                self.text.push(',');
            }
            cell.write(&mut self.text);
        }
        self.text.push('\n');
    }
}

/// One value.
pub(crate) enum Cell<'a> {
    /// Text.
    Text(&'a str),
    /// A number with six significant digits. NaN is left empty.
    Number(f64),
    /// An integer.
    Count(usize),
}

impl Cell<'_> {
    fn write(&self, text: &mut String) {
        match self {
            Self::Text(words) if words.contains([',', '"', '\n', '\r']) => {
                let _ = write!(text, "\"{}\"", words.replace('"', "\"\""));
            }
            Self::Text(words) => text.push_str(words),
            Self::Number(number) if !number.is_finite() => {}
            Self::Number(number) => text.push_str(&six_digits(*number)),
            Self::Count(count) => {
                let _ = write!(text, "{count}");
            }
        }
    }
}

impl From<f64> for Cell<'_> {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<usize> for Cell<'_> {
    fn from(count: usize) -> Self {
        Self::Count(count)
    }
}

impl<'a> From<&'a str> for Cell<'a> {
    fn from(words: &'a str) -> Self {
        Self::Text(words)
    }
}

fn six_digits(number: f64) -> String {
    let size = number.abs();
    if size != 0.0 && !(1e-4..1e9).contains(&size) {
        return format!("{number:.5e}");
    }
    // Enough decimal places for six digits in all.
    let whole = if size < 1.0 {
        0
    } else {
        size.log10() as usize + 1
    };
    let text = format!("{number:.*}", 6usize.saturating_sub(whole));
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_six_digits_and_words_are_quoted_where_they_must() {
        let mut csv = Csv::new("a.csv", &["what", "px", "n"]);
        csv.row(&["a, \"b\"".into(), (2.0 / 3.0).into(), 8.into()]);
        csv.row(&["plain".into(), f64::NAN.into(), 0.into()]);
        csv.row(&["plain".into(), 12345.678.into(), 0.into()]);
        csv.row(&["plain".into(), 1.5e-7.into(), 0.into()]);
        assert_eq!(
            csv.text,
            "what,px,n\n\"a, \"\"b\"\"\",0.666667,8\nplain,,0\nplain,12345.7,0\nplain,1.50000e-7,0\n"
        );
    }
}

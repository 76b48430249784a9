//! Formats text for a terminal: tables and paragraphs that fit its width.
//!
//! If standard output is not a terminal, a line has `COLUMNS` columns, or 80 if that is not set.
//! Pipes and logs are kept that narrow because people read them; programs can use `--json`.

use crate::messages;
use rustix::termios::tcgetwinsize;
use std::borrow::Cow;
use std::io::stdout;

/// Number of columns if the terminal's width is unknown.
const USUAL_WIDTH: usize = 80;
/// Minimum number of columns. A narrower terminal wraps the lines.
const LEAST_WIDTH: usize = 40;

/// Returns the number of columns on standard output.
pub fn width() -> usize {
    let said = std::env::var("COLUMNS")
        .ok()
        .and_then(|text| text.parse().ok());
    let seen = || {
        let size = tcgetwinsize(stdout()).ok()?;
        Some(usize::from(size.ws_col)).filter(|&columns| columns > 0)
    };
    said.or_else(seen).unwrap_or(USUAL_WIDTH).max(LEAST_WIDTH)
}

/// Returns true if colors may be written to a stream: it is a terminal, and `NO_COLOR` is not set.
pub fn has_colours(is_terminal: bool) -> bool {
    let is_unwanted = std::env::var_os("NO_COLOR").is_some_and(|text| !text.is_empty());
    is_terminal && !is_unwanted
}

/// Makes a text yellow on a terminal.
pub fn yellow(text: &str) -> String {
    format!("\x1b[33m{text}\x1b[0m")
}

/// Wraps a paragraph to lines of at most `width` columns, unless a single word is longer.
pub fn wrapped(text: &str, width: usize) -> String {
    flowed(text.split_whitespace(), width)
}

/// Folds the long lines of a message if standard error is a terminal, which would break them within
/// words.
pub fn said(text: &str) -> Cow<'_, str> {
    if !messages::is_terminal() {
        return text.into();
    }
    let width = width();
    let lines = text.lines().map(|line| match columns(line) > width {
        true => hanging(line, 2, width),
        false => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n").into()
}

/// Wraps a paragraph and indents every line but the first by `indent` columns.
pub fn hanging(text: &str, indent: usize, width: usize) -> String {
    let lines = wrapped(text, width.saturating_sub(indent));
    lines.replace('\n', &format!("\n{:indent$}", ""))
}

/// Puts as many items on each line as fit. Items are not broken.
pub fn flowed<T: AsRef<str>>(items: impl IntoIterator<Item = T>, width: usize) -> String {
    let mut lines = String::new();
    let mut column = 0;
    for item in items {
        let item = item.as_ref();
        let length = columns(item);
        if column > 0 && column + 1 + length > width {
            lines.push('\n');
            column = 0;
        } else if column > 0 {
            lines.push(' ');
            column += 1;
        }
        lines += item;
        column += length;
    }
    lines
}

/// Shortens a text to its last `width` columns. The end of a path distinguishes it from its
/// neighbors.
fn end_of(text: &str, width: usize) -> Cow<'_, str> {
    let excess = columns(text).saturating_sub(width);
    match excess {
        0 => text.into(),
        _ => format!("…{}", text.chars().skip(excess + 1).collect::<String>()).into(),
    }
}

/// Returns the number of columns that a text takes. Color escape codes, `ESC [ … m`, take none.
fn columns(text: &str) -> usize {
    let mut parts = text.split("\x1b[");
    let first = parts.next().map_or(0, |part| part.chars().count());
    let shown = |part: &str| {
        part.split_once('m')
            .map_or(0, |(_, rest)| rest.chars().count())
    };
    first + parts.map(shown).sum::<usize>()
}

/// A column of a table.
#[derive(Debug, Clone)]
pub struct Column {
    heading: String,
    is_words: bool,
    /// If there is too little room, columns of the highest rank are left out first. Rank 0 always
    /// stays.
    rank: u8,
    width: usize,
}

impl Column {
    /// Creates a right-aligned column of figures. The heading may have several lines.
    pub fn figures(heading: impl Into<String>) -> Self {
        let heading = heading.into();
        Self {
            width: heading.lines().map(columns).max().unwrap_or(0),
            heading,
            is_words: false,
            rank: 0,
        }
    }

    /// Creates a left-aligned column of words. If necessary, the first and the last column of a
    /// table are shortened.
    pub fn words(heading: impl Into<String>) -> Self {
        Self {
            is_words: true,
            ..Self::figures(heading)
        }
    }

    /// Sets the expected width of the cells, for rows that are not known yet.
    pub fn wide(mut self, width: usize) -> Self {
        self.width = self.width.max(width);
        self
    }

    /// Sets the rank. If there is too little room, a column is left out before those of lower rank.
    pub fn rank(mut self, rank: u8) -> Self {
        self.rank = rank;
        self
    }

    fn cell(&self, text: &str) -> String {
        let width = self.width;
        match self.is_words {
            true => format!("{:<width$}", end_of(text, width)),
            false => format!("{text:>width$}"),
        }
    }
}

/// Colors a text, as [`yellow`] does.
pub type Paint = fn(&str) -> String;

/// A table that is written row by row and fits a width.
#[derive(Debug)]
pub struct Table {
    columns: Vec<Column>,
    is_shown: Vec<bool>,
}

impl Table {
    /// Number of spaces between two columns.
    const GAP: usize = 2;
    /// Minimum width to which a column of words is shortened.
    const LEAST_WORDS: usize = 14;

    /// Creates a table for rows that come one by one. Each column keeps the width it was given.
    pub fn new(columns: Vec<Column>, width: usize) -> Self {
        let is_shown = vec![true; columns.len()];
        let mut table = Self { columns, is_shown };
        table.narrow(width);
        table
    }

    /// Formats a complete table with its heading.
    pub fn text(mut columns: Vec<Column>, rows: &[Vec<String>], width: usize) -> String {
        for row in rows {
            for (column, cell) in columns.iter_mut().zip(row) {
                column.width = column.width.max(self::columns(cell));
            }
        }
        let table = Self::new(columns, width);
        rows.iter()
            .fold(table.head(), |text, row| text + &table.row(row))
    }

    /// Returns the headings, in as many lines as the longest heading has.
    pub fn head(&self) -> String {
        let shown = self
            .columns
            .iter()
            .zip(&self.is_shown)
            .filter(|(_, is_shown)| **is_shown);
        let lines = shown
            .map(|(column, _)| column.heading.lines().count())
            .max()
            .unwrap_or(0);
        let line = |line: usize| {
            // Headings are aligned at their last lines.
            let of = |column: &Column| {
                let above = lines.saturating_sub(column.heading.lines().count());
                let part = line
                    .checked_sub(above)
                    .and_then(|line| column.heading.lines().nth(line));
                part.unwrap_or_default().to_owned()
            };
            self.row(self.columns.iter().map(of))
        };
        (0..lines).map(line).collect()
    }

    /// Formats one row.
    pub fn row<T: AsRef<str>>(&self, cells: impl IntoIterator<Item = T>) -> String {
        self.painted_row(cells.into_iter().map(|cell| (cell, None)))
    }

    /// Formats one row of painted cells. Colors do not count towards a cell's width.
    pub fn painted_row<T: AsRef<str>>(
        &self,
        cells: impl IntoIterator<Item = (T, Option<Paint>)>,
    ) -> String {
        let cells = self.columns.iter().zip(cells).zip(&self.is_shown);
        let shown = cells.filter(|(_, is_shown)| **is_shown);
        let cells: Vec<String> = shown
            .map(|((column, (cell, paint)), _)| {
                let cell = column.cell(cell.as_ref());
                paint.map_or(cell.clone(), |paint| paint(&cell))
            })
            .collect();
        let gap = " ".repeat(Self::GAP);
        cells.join(&gap).trim_end().to_owned() + "\n"
    }

    /// Leaves out columns and shortens words until the table fits, as far as possible.
    fn narrow(&mut self, width: usize) {
        let ends = [0, self.columns.len().saturating_sub(1)];
        let least = |place: usize, column: &Column| match column.is_words && ends.contains(&place) {
            true => column
                .width
                .min(Self::LEAST_WORDS.max(columns(&column.heading))),
            false => column.width,
        };
        loop {
            let shown = || (0..self.columns.len()).filter(|&place| self.is_shown[place]);
            let gaps = Self::GAP * shown().count().saturating_sub(1);
            let needed: usize = shown()
                .map(|place| least(place, &self.columns[place]))
                .sum();
            let last = shown().max_by_key(|&place| self.columns[place].rank);
            match last.filter(|&place| self.columns[place].rank > 0 && needed + gaps > width) {
                Some(place) => self.is_shown[place] = false,
                None => {
                    let mut spare = width.saturating_sub(needed + gaps);
                    for place in shown().collect::<Vec<_>>() {
                        let column = &mut self.columns[place];
                        let least = least(place, column);
                        let more = spare.min(column.width - least);
                        column.width = least + more;
                        spare -= more;
                    }
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_never_wider_than_it_may_be() {
        let text = "a rope that lies over itself, in one sentence";
        for width in 10..50 {
            let lines = hanging(text, 2, width);
            assert!(lines.lines().all(|line| columns(line) <= width), "{lines}");
            assert_eq!(lines.split_whitespace().collect::<Vec<_>>().join(" "), text);
        }
        assert_eq!(wrapped("unbreakable", 3), "unbreakable");
    }

    #[test]
    fn a_painted_cell_has_the_width_of_a_plain_one() {
        let columns = vec![Column::figures("conf.").wide(6), Column::words("status")];
        let table = Table::new(columns, 80);
        let painted = table.painted_row([("0.31", Some(yellow as Paint)), ("ok", None)]);
        assert_eq!(painted, "\x1b[33m  0.31\x1b[0m  ok\n");
        assert_eq!(table.row(["0.31", "ok"]), "  0.31  ok\n");
    }

    #[test]
    fn what_matters_least_goes_first_and_the_end_of_a_long_name_stays() {
        let columns = || {
            vec![
                Column::words("image"),
                Column::figures("length"),
                Column::figures("time").rank(1),
                Column::figures("size").rank(2),
            ]
        };
        let rows = [["a/long/way/to/rope.png", "451.7", "3.9", "640"]
            .map(String::from)
            .to_vec()];
        let wide = Table::text(columns(), &rows, 80);
        assert_eq!(
            wide,
            "image                   length  time  size\na/long/way/to/rope.png   451.7   3.9   640\n"
        );
        let narrow = Table::text(columns(), &rows, 30);
        assert_eq!(
            narrow,
            "image             length  time\n…way/to/rope.png   451.7   3.9\n"
        );
        let least = Table::text(columns(), &rows, 22);
        assert!(
            least.lines().all(|line| line.chars().count() <= 22),
            "{least}"
        );
    }
}

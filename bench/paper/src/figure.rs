//! A figure as shown on the page: drawing, text, table, and the numbers behind it.

use crate::Csv;

/// A section of the page.
#[derive(Debug, Clone)]
pub(crate) struct Section {
    pub(crate) heading: &'static str,
    /// The topic of the section and the paper's statement about it.
    pub(crate) text: String,
    pub(crate) figures: Vec<Figure>,
}

/// A figure.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    /// Figure number. The first three figures keep the paper's numbers.
    pub(crate) number: usize,
    pub(crate) title: String,
    pub(crate) svg: String,
    /// Description of the drawing.
    pub(crate) shows: String,
    /// The findings, generated from the numbers of this run.
    pub(crate) found: String,
    pub(crate) table: Option<Table>,
    /// Parameters of the figure in addition to those of the whole page.
    pub(crate) parameters: String,
    pub(crate) csv: Csv,
}

/// A table. The first column names the row; the others hold numbers or text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Table {
    pub(crate) head: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn new(head: &[&str]) -> Self {
        Self {
            head: head.iter().map(|&cell| cell.to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    pub(crate) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }
}
